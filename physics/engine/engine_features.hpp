#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/physics/scene/dynamic_scene.hpp"

namespace touchstone::physics {

/// Features that a scene may ask of an engine beyond free bodies that are boxes of one friction, on the
/// ground.
enum class EngineFeature : std::uint8_t {
  hulls,             ///< hexahedra that are no boxes
  kinematic_bodies,  ///< bodies that follow their motion whatever they meet
  mixed_friction,    ///< friction that differs by pair (EngineScene::friction())
  restitution,  ///< by pair (EngineScene::restitution()), for approaches faster than the scene's bounce speed
  exempt_parts,     ///< pairs that are not checked though others of the same two bodies are
  arms,             ///< mechanisms: revolute, prismatic and fixed joints
  joint_stops,      ///< limits of joints' values
  torque_drives,    ///< torques and forces of joints, cut to their limits
  rate_drives,      ///< rates that a joint follows with at most its limit
  brakes,           ///< joints held with at most a limit
  latches,          ///< objects that move as one, at the start or from an action on
  set_joints,       ///< joints put at a value and rate by an action
  joint_losses,     ///< friction and damping of joints, whatever drives them
  rotors,           ///< inertia that turns with a joint alone
  position_drives,  ///< drives of a stiffness and damping
  body_joints,      ///< joints between bodies, links and the ground, loops closed, let go by actions
  come_and_go,      ///< bodies brought in and taken out by actions
  rounded_solids,   ///< spheres, capsules and other hexahedra with a radius
};
/// How many there are.
inline constexpr int kEngineFeatures = 18;
/// In words: "rate drives".
std::string_view to_string(EngineFeature feature);

/// A set of them.
class EngineFeatures {
 public:
  EngineFeatures() = default;
  EngineFeatures(std::initializer_list<EngineFeature> features) {
    for (const EngineFeature feature : features) bits_ |= bit(feature);
  }
  /// Up to `latches`: expected of every engine with arms. Each engine declares later ones itself.
  static EngineFeatures usual() {
    EngineFeatures out;
    out.bits_ = 2U * bit(EngineFeature::latches) - 1U;
    return out;
  }
  static EngineFeatures all() {
    EngineFeatures out;
    out.bits_ = (1U << kEngineFeatures) - 1U;
    return out;
  }
  EngineFeatures with(EngineFeature feature) const {
    EngineFeatures out = *this;
    out.bits_ |= bit(feature);
    return out;
  }
  EngineFeatures without(EngineFeature feature) const {
    EngineFeatures out = *this;
    out.bits_ &= ~bit(feature);
    return out;
  }
  bool has(EngineFeature feature) const { return (bits_ & bit(feature)) != 0; }

 private:
  static std::uint32_t bit(EngineFeature feature) { return 1U << static_cast<unsigned>(feature); }
  std::uint32_t bits_ = 0;
};

/// A feature that a scene asks for, and the first that does: "object 'x'", "joint 'arm.elbow'".
struct EngineNeed {
  EngineFeature feature;
  std::string who;
};

/// Each feature once. @pre the scene is valid.
std::vector<EngineNeed> needs_of(const DynamicScene& scene);

/// The parts of it that an engine with these features lacks, in words: "brakes (joint 'arm.shoulder')".
/// Empty: nothing.
std::vector<std::string> unsupported(const EngineFeatures& features, const DynamicScene& scene);
/// The same of one action. @pre the action is valid
std::vector<std::string> unsupported(const EngineFeatures& features, const DynamicScene& scene,
                                     const SceneAction& action);

}  // namespace touchstone::physics

#include "touchstone/physics/engine/engine_features.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/physics/engine/engine_scene.hpp"

namespace touchstone::physics {
namespace {

class Needs {
 public:
  void add(EngineFeature feature, const std::string& who) {
    const auto is_same = [&](const EngineNeed& need) { return need.feature == feature; };
    if (std::none_of(needs_.begin(), needs_.end(), is_same)) needs_.push_back({feature, who});
  }
  void add_drive(const SceneDrive& drive, const std::string& who) {
    using Mode = JointDrive::Mode;
    if (drive.drive.mode == Mode::rate) add(EngineFeature::rate_drives, who);
    if (drive.drive.mode == Mode::brake) add(EngineFeature::brakes, who);
    if (drive.drive.mode == Mode::position) add(EngineFeature::position_drives, who);
    const bool has_torque = drive.drive.torque != 0.0 || drive.ramp != 0.0;
    if (drive.drive.mode == Mode::torque && has_torque) add(EngineFeature::torque_drives, who);
  }
  std::vector<EngineNeed> take() { return std::move(needs_); }

 private:
  std::vector<EngineNeed> needs_;
};

std::string joint_name(const DynamicScene& scene, const JointAddress& joint) {
  return "joint '" + name_of(scene, joint) + "'";
}

void add_bodies(const DynamicScene& scene, Needs& needs) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    for (const PlacedHexahedron& placed : scene.scene.objects[i].tree.solids()) {
      if (!placed.solid.is_box()) needs.add(EngineFeature::hulls, object_name(scene, i));
      if (placed.solid.is_rounded()) needs.add(EngineFeature::rounded_solids, object_name(scene, i));
    }
    if (body.kind == BodyKind::kinematic) needs.add(EngineFeature::kinematic_bodies, object_name(scene, i));
    if (body.surface.friction != scene.bodies[0].surface.friction)
      needs.add(EngineFeature::mixed_friction, object_name(scene, i));
    if (body.surface.restitution != 0.0) needs.add(EngineFeature::restitution, object_name(scene, i));
  }
}

std::string pair_name(const DynamicScene& scene, const ScenePair& pair) {
  return object_name(scene, pair.a) + " and " + object_name(scene, pair.b);
}

/// Whose surfaces meet by other rules than the usual ones.
void add_pairs(const DynamicScene& scene, Needs& needs) {
  for (const ScenePair& pair : scene.pairs) {
    if (pair.friction) needs.add(EngineFeature::mixed_friction, pair_name(scene, pair));
    if (pair.restitution.value_or(0.0) != 0.0) needs.add(EngineFeature::restitution, pair_name(scene, pair));
  }
  // Of equal figures all other rules make the same.
  if (scene.friction_rule == Combination::product && !scene.bodies.empty())
    needs.add(EngineFeature::mixed_friction, "the rule 'product'");
}

void add_mechanisms(const DynamicScene& scene, Needs& needs) {
  for (std::size_t m = 0; m < scene.mechanisms.size(); ++m) {
    const SceneMechanism& mechanism = scene.mechanisms[m];
    needs.add(EngineFeature::arms, "mechanism '" + mechanism.name + "'");
    for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
      const SceneJoint& joint = mechanism.joints[j];
      const std::string who = joint_name(scene, {m, j});
      if (std::isfinite(joint.lower) || std::isfinite(joint.upper))
        needs.add(EngineFeature::joint_stops, who);
      needs.add_drive(joint.drive, who);
      if (joint.losses.friction > 0.0 || joint.losses.damping > 0.0)
        needs.add(EngineFeature::joint_losses, who);
      if (joint.rotor > 0.0) needs.add(EngineFeature::rotors, who);
    }
  }
}

void add_action(const DynamicScene& scene, const SceneAction& action, Needs& needs) {
  using Kind = SceneAction::Kind;
  if (action.kind == Kind::set_joint) needs.add(EngineFeature::set_joints, joint_name(scene, action.joint));
  if (action.kind == Kind::add || action.kind == Kind::remove)
    needs.add(EngineFeature::come_and_go, object_name(scene, action.carried));
  if (action.kind == Kind::drive) needs.add_drive(action.drive, joint_name(scene, action.joint));
  if (action.kind == Kind::latch || action.kind == Kind::release)
    needs.add(EngineFeature::latches, object_name(scene, action.carried));
}

std::vector<std::string> lacking_of(const EngineFeatures& features, const std::vector<EngineNeed>& needs) {
  std::vector<std::string> lacking;
  for (const EngineNeed& need : needs)
    if (!features.has(need.feature))
      lacking.push_back(std::string(to_string(need.feature)) + " (" + need.who + ")");
  return lacking;
}

}  // namespace

std::string_view to_string(EngineFeature feature) {
  constexpr std::array<std::string_view, kEngineFeatures> kNames{"hexahedra that are no boxes",
                                                                 "kinematic bodies",
                                                                 "friction that differs between objects",
                                                                 "restitution",
                                                                 "exemptions of parts of bodies",
                                                                 "arms",
                                                                 "stops of joints",
                                                                 "torque drives",
                                                                 "rate drives",
                                                                 "brakes",
                                                                 "latches",
                                                                 "joints put at values mid-run",
                                                                 "friction and damping of joints",
                                                                 "inertia of rotors",
                                                                 "drives of a stiffness",
                                                                 "joints between bodies",
                                                                 "bodies that come and go",
                                                                 "rounded solids"};
  return kNames[static_cast<std::size_t>(feature)];
}

std::vector<EngineNeed> needs_of(const DynamicScene& scene) {
  Needs needs;
  add_bodies(scene, needs);
  add_pairs(scene, needs);
  add_mechanisms(scene, needs);
  // Joints between bodies need stops, drives and losses where they have them.
  for (const SceneBodyJoint& joint : scene.joints) {
    const std::string who = "joint '" + joint.name + "'";
    needs.add(EngineFeature::body_joints, who);
    if (std::isfinite(joint.lower) || std::isfinite(joint.upper)) needs.add(EngineFeature::joint_stops, who);
    needs.add_drive(joint.drive, who);
    if (joint.losses.friction > 0.0 || joint.losses.damping > 0.0)
      needs.add(EngineFeature::joint_losses, who);
  }
  // Latches and actions need the features that they use.
  if (!scene.scene.latches.empty())
    needs.add(EngineFeature::latches, "object '" + scene.scene.latches[0].carried + "'");
  for (const SceneLatchOption& option : scene.latch_options)
    needs.add(EngineFeature::latches, object_name(scene, option.carried));
  for (const SceneAction& action : scene.actions) add_action(scene, action, needs);
  // A pair of bodies that is exempt only in part is a need as well.
  const std::string partly = EngineScene(scene).partly_exempt();
  if (!partly.empty()) needs.add(EngineFeature::exempt_parts, partly);
  return needs.take();
}

std::vector<std::string> unsupported(const EngineFeatures& features, const DynamicScene& scene) {
  return lacking_of(features, needs_of(scene));
}

std::vector<std::string> unsupported(const EngineFeatures& features, const DynamicScene& scene,
                                     const SceneAction& action) {
  Needs needs;
  add_action(scene, action, needs);
  return lacking_of(features, needs.take());
}

}  // namespace touchstone::physics

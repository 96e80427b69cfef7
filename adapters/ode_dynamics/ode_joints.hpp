#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "touchstone/adapters/ode/ode_library.hpp"
#include "touchstone/physics/engine/engine_scene.hpp"

namespace touchstone::physics::ode_dynamics {

/// Where a body is and how it moves, to the bit: ODE's own setters round what they are given.
struct BodyBits {
  std::array<dReal, 3> p, v, w;
  std::array<dReal, 4> q;
  std::array<dReal, 12> R;
};
BodyBits bits_of(dBodyID body);
void set_bits(dBodyID body, const BodyBits& bits);

/// A joint of a mechanism as a hinge or a slider, the child as ODE's first body.
class OdeJoint {
 public:
  /// Where both bodies stand as at the scene's start. @param parent may be null: the ground.
  /// @throws InputError: stops of a hinge further than pi from its start.
  OdeJoint(dWorldID world, const EngineScene::Joint& joint, dBodyID child, dBodyID parent);
  OdeJoint(const OdeJoint&) = delete;
  OdeJoint& operator=(const OdeJoint&) = delete;

  /// Holds both as they stand, the value as at the scene's start.
  void place(const Vector3& p_W, const Vector3& axis_W);
  dJointID id() const { return joint_; }
  void set_drive(const JointDrive& drive);
  /// Before each step: torques are gone after one.
  void apply();
  /// After it. Follows turns beyond half a revolution.
  void read();

  /// The value that read() continues from.
  struct Count {
    double value, last_angle;
  };
  Count count() const { return {value_, last_angle_}; }
  void set_count(const Count& count) { value_ = count.value, last_angle_ = count.last_angle; }

  double value() const { return value_; }
  double rate() const;
  /// The drive's, over the last step; what a stop gave within.
  double torque() const;

 private:
  bool is_hinge() const { return source_->kind == JointKind::revolute; }
  void set(int parameter, double value);

  const SceneJoint* source_;
  dJointID joint_;
  dBodyID child_;
  dJointFeedback feedback_{};
  JointDrive drive_;
  double value_, last_angle_ = 0.0;
};

/// A joint between bodies, the child as ODE's first body.
class OdeBodyJoint {
 public:
  /// Where both bodies stand as at the scene's start. @param parent may be null: the ground.
  /// @throws InputError: as OdeJoint; a child that is the ground.
  OdeBodyJoint(dWorldID world, const EngineScene::BodyJoint& joint, dBodyID child, dBodyID parent);
  OdeBodyJoint(const OdeBodyJoint&) = delete;
  OdeBodyJoint& operator=(const OdeBodyJoint&) = delete;

  /// Lets go, or holds the bodies as they stand: the joint's frame is then where the parent has it.
  void switch_to(bool is_on);
  /// Of hinges and sliders; of others nothing.
  OdeJoint* axis() { return axis_ ? &*axis_ : nullptr; }
  const OdeJoint* axis() const { return axis_ ? &*axis_ : nullptr; }
  bool is_on() const { return is_on_; }

  /// Whether it holds, and as its bodies stood when that was last changed.
  struct Placing {
    bool is_on;
    std::uint64_t number;  ///< no other of this joint has it
    BodyBits child, parent;
  };
  const Placing& placing() const { return placing_; }
  /// As it then was. Bodies may be moved. Nothing where it has not changed since.
  void place_again(const Placing& placing);

 private:
  const SceneBodyJoint* source_;
  SceneJoint as_joint_;  // with its axis
  dJointID joint_ = nullptr;
  dBodyID child_, parent_;
  Placing placing_{};
  std::uint64_t placings_ = 0;  // made so far
  Vector3 p_P_, axis_P_;        // in the parent's frame
  std::optional<OdeJoint> axis_;
  bool is_on_ = true;
};

}  // namespace touchstone::physics::ode_dynamics

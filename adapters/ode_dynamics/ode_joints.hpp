#pragma once

#include <vector>

#include "touchstone/adapters/ode/ode_library.hpp"
#include "touchstone/physics/engine/engine_scene.hpp"

namespace touchstone::physics::ode_dynamics {

/// A joint of a mechanism as a hinge or a slider, the child as ODE's first body.
class OdeJoint {
 public:
  /// Where both bodies stand as at the scene's start. @param parent may be null: the ground.
  /// @throws InputError: stops of a hinge further than pi from its start.
  OdeJoint(dWorldID world, const EngineScene::Joint& joint, dBodyID child, dBodyID parent);
  OdeJoint(const OdeJoint&) = delete;
  OdeJoint& operator=(const OdeJoint&) = delete;

  void set_drive(const JointDrive& drive);
  /// Before each step: torques are gone after one.
  void apply();
  /// After it. Follows turns beyond half a revolution.
  void read();

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

}  // namespace touchstone::physics::ode_dynamics

#pragma once

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <memory>

#include "touchstone/adapters/bullet/engine.hpp"
#include "touchstone/physics/engine/engine_scene.hpp"

namespace touchstone::physics::bullet_dynamics {

/// A joint between rigid bodies as one of Bullet's constraints, the parent as its first body.
class BodyJoint {
 public:
  /// Where both bodies stand as at the scene's start. @param parent may be null: the ground.
  /// @throws InputError: stops of a hinge further than pi from its start, a child that is the ground.
  BodyJoint(btDiscreteDynamicsWorld& world, const SceneBodyJoint& source, btRigidBody* child,
            btRigidBody* parent, double step);
  ~BodyJoint();
  BodyJoint(const BodyJoint&) = delete;
  BodyJoint& operator=(const BodyJoint&) = delete;

  /// Lets go, or holds the bodies as they stand: the joint's frame is then where the parent has it.
  void switch_to(bool is_on);
  void set_drive(const JointDrive& drive);
  /// Before each step: torques are gone after one.
  void apply();
  /// After it. Follows turns beyond half a revolution.
  void read();

  /// As it holds its bodies, and counts.
  struct Hold {
    bool is_on = false;
    Pose X_CJ = {};  ///< the joint's frame in the child
    double value = 0.0, last_angle = 0.0;
  };
  Hold hold() const { return {constraint_ != nullptr, X_CJ_, value_, last_angle_}; }
  /// Made anew so, as the bodies then stand.
  void set_hold(const Hold& hold);

  double value() const { return value_; }
  double rate() const;
  /// The drive's torque over the last step, as commanded; NaN of motors: Bullet does not report their share
  /// of the joint's impulses.
  double torque() const;

 private:
  bool is_hinge() const { return source_.kind == BodyJointKind::hinge; }
  bool is_slider() const { return source_.kind == BodyJointKind::slider; }
  Pose X_WJ() const;
  void make();
  void make_at(const Pose& X_CJ);
  void apply_motor();
  void take_out();

  btDiscreteDynamicsWorld& world_;
  const SceneBodyJoint& source_;
  btRigidBody &child_, &parent_;
  double step_;
  Pose X_PJ_;  // its axis is x of a slider, else z
  Pose X_CJ_;  // of the last make()
  std::unique_ptr<btTypedConstraint> constraint_;
  JointDrive drive_ = {};
  double value_ = 0.0, last_angle_ = 0.0;
};

}  // namespace touchstone::physics::bullet_dynamics

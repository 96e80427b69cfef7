#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <string>
#include <vector>

#include "touchstone/physics/engine/engine_scene.hpp"

namespace touchstone::physics::mujoco_dynamics {

/// Points of a joint between bodies that its bodies share: one of a ball, two of a hinge, three of a fixed
/// one. Each is an equality constraint `connect`. [m], in the world, at the start; on a circle of the child's
/// radius of gyration about the joint's origin, or along its axis.
/// @throws InputError: what such constraints do not hold (sliders), or do not give (stops, motors, losses).
std::vector<Vector3> shared_points(const EngineScene& scene, const EngineScene::BodyJoint& joint);

/// The name of constraint `point` of joint `joint`.
std::string connect_name(std::size_t joint, std::size_t point);

/// A joint between bodies as MuJoCo holds it.
class BodyJoint {
 public:
  /// A side's frame and motion in the world; the ground's are the default.
  struct Side {
    Pose X_WB;
    Vector3 w_W = Vector3::Zero();
  };

  /// @param joint of EngineScene::body_joints(), in a model of model_text()
  BodyJoint(const EngineScene& scene, std::size_t joint, const mjModel& model);

  std::size_t child() const { return source_->child; }
  std::size_t parent() const { return source_->parent; }
  /// Lets go, or holds the bodies as they stand, the points where the parent has them.
  void switch_to(bool is_on, mjModel& model, mjData& data, const Side& child, const Side& parent);
  bool is_on() const { return state_.is_on; }
  void set_torque(double torque) { torque_ = torque; }
  double torque() const { return state_.is_on ? torque_ : 0.0; }
  /// In the world now.
  Vector3 axis_W(const Side& parent) const { return rotate(parent.X_WB.R, axis_P_); }
  bool has_axis() const { return source_->source->kind == BodyJointKind::hinge; }
  /// After a step. Follows turns beyond half a revolution.
  void read(const Side& child, const Side& parent);
  double value() const { return state_.value; }
  double rate() const { return rate_; }

  /// All of it that changes, MuJoCo's tables apart.
  struct State {
    bool is_on = true;
    double value = 0.0, last_angle = 0.0;
    Matrix3 R_PC = Matrix3::Identity();         ///< of the child in the parent at value 0
    std::vector<std::array<mjtNum, 6>> points;  ///< eq_data: in the child, in the parent
  };
  const State& state() const { return state_; }
  void set_state(const State& state, mjModel& model, mjData& data);

 private:
  void tell(mjModel& model, mjData& data) const;

  const EngineScene::BodyJoint* source_;
  std::vector<int> ids_;  // of the constraints
  Vector3 axis_P_;
  State state_;
  double torque_ = 0.0, rate_ = 0.0;
};

}  // namespace touchstone::physics::mujoco_dynamics

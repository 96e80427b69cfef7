#include "touchstone/physics/scene/scene_simulation.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/scene/motion.hpp"

namespace touchstone::physics {
namespace {

/// The angular velocity that turns one attitude into another in `h`, by the smaller angle.
Vector3 rate_between(const Quaternion& from, const Quaternion& to, double h) {
  const AxisAngle turn = axis_angle_of(to * conjugate(from));
  return (turn.angle / h) * turn.axis;
}

}  // namespace

SceneSimulation::SceneSimulation(const DynamicScene& scene, MakeContacts make)
    : scene_(&scene), make_(std::move(make)), touches_(scene.scene.contact_gap) {
  validate(scene);
  build_world();
}

bool SceneSimulation::is_due(const SceneAction& action) const {
  return static_cast<double>(steps_) >= action.time / scene_->step * (1.0 - 0x1p-40);
}

void SceneSimulation::set_drive(const JointAddress& joint, const SceneDrive& drive) {
  if (joint.is_of_bodies()) {
    body_drives_[joint.joint] = drive;
    body_drives_since_[joint.joint] = time();
    apply_body_drive(joint.joint);
    return;
  }
  Arm& arm = *arms_[joint.mechanism];
  arm.drives[joint.joint] = drive;
  arm.drives_since[joint.joint] = time();
  apply_drive(joint);
}

void SceneSimulation::apply_drive(const JointAddress& joint) {
  const Arm& arm = *arms_[joint.mechanism];
  const std::uint32_t value = arm.value_of[joint.joint];
  if (value == Mechanism::kNone) return;
  SceneDrive drive = arm.drives[joint.joint];
  drive.drive.limit =
      std::min(drive.drive.limit, scene_->mechanisms[joint.mechanism].joints[joint.joint].effort);
  // Constant over the step: as in its middle.
  drive.drive.torque += drive.ramp * ((time() + 0.5 * scene_->step) - arm.drives_since[joint.joint]);
  world_->set_drive(static_cast<std::uint32_t>(joint.mechanism), value, drive.drive);
}

void SceneSimulation::apply_body_drive(std::size_t joint) {
  const SceneBodyJoint& source = scene_->joints[joint];
  if (source.kind != BodyJointKind::hinge && source.kind != BodyJointKind::slider) return;
  SceneDrive drive = body_drives_[joint];
  drive.drive.limit = std::min(drive.drive.limit, source.effort);
  drive.drive.torque += drive.ramp * ((time() + 0.5 * scene_->step) - body_drives_since_[joint]);
  world_->set_joint_drive(static_cast<std::uint32_t>(joint), drive.drive);
}

/// So that it is where it is commanded at the step's end, from where it is: rounding errors do not add up.
void SceneSimulation::move_kinematic(std::size_t object) {
  const SceneObject& source = scene_->scene.objects[object];
  const std::uint32_t index = pieces_[object].root_mover.index;
  const Pose X = pose_at(source.motion, source.X_WO, static_cast<double>(steps_ + 1) * scene_->step);
  const RigidBodyState& state = world_->state(index);
  world_->set_velocity(index, (X.p - state.p_W) / scene_->step,
                       rate_between(state.q_WB, quaternion_of(X.R), scene_->step));
}

void SceneSimulation::begin_step() {
  bool any_change = false;
  for (; next_action_ < scene_->actions.size() && is_due(scene_->actions[next_action_]); ++next_action_) {
    const SceneAction& action = scene_->actions[next_action_];
    if (action.kind == SceneAction::Kind::drive) {
      set_drive(action.joint, action.drive);
      continue;
    }
    if (action.kind == SceneAction::Kind::set_joint) {
      set_joint(action.joint, action.value, action.rate);
      continue;
    }
    is_refused_ = !carry_out(action, scene_->scene.latches.size() + next_action_);
    if (is_refused_) break;
    any_change = true;
  }
  if (any_change) change_contacts();
  for (std::size_t m = 0; m < arms_.size(); ++m)
    for (std::size_t j = 0; j < arms_[m]->drives.size(); ++j)
      if (arms_[m]->drives[j].ramp != 0.0) apply_drive({m, j});
  for (std::size_t j = 0; j < body_drives_.size(); ++j)
    if (body_drives_[j].ramp != 0.0) apply_body_drive(j);
  for (std::size_t i = 0; i < pieces_.size(); ++i)
    if (kind_of(i) == BodyKind::kinematic) move_kinematic(i);
}

std::span<const Contact> SceneSimulation::find_contacts() {
  found_ = contacts_->find(*world_, scene_->step);
  forces_.assign(found_.size(), ContactForce{Vector3::Zero(), Vector3::Zero()});
  return found_;
}

StepReport SceneSimulation::advance() {
  if (is_refused_) {
    StepReport refused;
    refused.failure = StepFailure::latch;
    refused.failed_index = index_of(scene_->actions[next_action_].carried);
    return refused;
  }
  const StepReport report = world_->step(scene_->step, found_, std::span(forces_).first(found_.size()));
  if (report.failure == StepFailure::none) ++steps_;
  if (is_watched_ && report.failure == StepFailure::none) take_touches();
  return report;
}

// ---- state

Pose SceneSimulation::object_pose(std::size_t object) const {
  const Piece& piece = pieces_[object];
  if (piece.mover.kind == Mover::Kind::body) return compose(world_->pose(piece.mover.index), piece.X_FO);
  if (piece.mover.kind == Mover::Kind::link)
    return compose(world_->link_pose(piece.mover.index, piece.mover.link), piece.X_FO);
  return compose(pieces_[piece.root].X_WF, piece.X_FO);
}

std::optional<std::uint32_t> SceneSimulation::dynamic_body(std::size_t object) const {
  const Piece& piece = pieces_[pieces_[object].root];
  if (!piece.body || piece.is_out) return std::nullopt;
  return piece.mover.index;
}

std::optional<Vector3> SceneSimulation::velocity(std::size_t object) const {
  const auto body = dynamic_body(object);
  return body ? std::optional(world_->velocity(*body)) : std::nullopt;
}

std::optional<Vector3> SceneSimulation::angular_velocity(std::size_t object) const {
  const auto body = dynamic_body(object);
  return body ? std::optional(world_->angular_velocity(*body)) : std::nullopt;
}

std::span<const ExemptPair> SceneSimulation::allowed_with(std::size_t object) const {
  const std::size_t latch = pieces_[object].latch;
  return latch == kNoLatch ? std::span<const ExemptPair>() : allowed_by(*scene_, latch);
}

double SceneSimulation::joint_value(const JointAddress& joint) const {
  if (joint.is_of_bodies()) return body_joint(joint.joint).value;
  const std::uint32_t value = arms_[joint.mechanism]->value_of[joint.joint];
  if (value == Mechanism::kNone) return 0.0;
  return world_->joint_values(static_cast<std::uint32_t>(joint.mechanism))[value];
}

double SceneSimulation::joint_rate(const JointAddress& joint) const {
  if (joint.is_of_bodies()) return body_joint(joint.joint).rate;
  const std::uint32_t value = arms_[joint.mechanism]->value_of[joint.joint];
  if (value == Mechanism::kNone) return 0.0;
  return world_->joint_rates(static_cast<std::uint32_t>(joint.mechanism))[value];
}

double SceneSimulation::joint_torque(const JointAddress& joint) const {
  if (joint.is_of_bodies()) return body_joint(joint.joint).torque;
  const std::uint32_t value = arms_[joint.mechanism]->value_of[joint.joint];
  if (value == Mechanism::kNone) return 0.0;
  return world_->joint_torques(static_cast<std::uint32_t>(joint.mechanism))[value];
}

std::string SceneSimulation::failed_name(const StepReport& report) const {
  switch (report.failure) {
    case StepFailure::bad_contact: {
      const SolidPair pair = contacts_->origins()[report.failed_index].solids;
      return "'" + solid_names_[pair.a] + "' and '" + solid_names_[pair.b] + "'";
    }
    case StepFailure::mechanism:
      return "mechanism '" + scene_->mechanisms[report.failed_index].name + "'";
    case StepFailure::latch:
      return "object '" + name_of(report.failed_index) + "'";
    case StepFailure::body:
    case StepFailure::turn:
      for (std::size_t i = 0; i < pieces_.size(); ++i)
        if (pieces_[i].mover == Mover::of_body(report.failed_index)) return "object '" + name_of(i) + "'";
      return "";
    case StepFailure::none:
    case StepFailure::bad_step:
      break;
  }
  return "";
}

}  // namespace touchstone::physics

// Joints between movers: a world's settings of them, and its reports.

#include <algorithm>
#include <cmath>
#include <string>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/world/groups/sleep.hpp"
#include "touchstone/physics/world/rows/held_joints.hpp"
#include "touchstone/physics/world/step/world_parts.hpp"

namespace touchstone::physics {
namespace {

using stepping::HeldJoint;
using stepping::Movers;

constexpr double kMostAngle = 64.0 * 6.283185307179586;  // [rad], either way

std::string name_of(std::size_t joint) { return "joint " + std::to_string(joint); }

[[noreturn]] void refuse(std::size_t joint, const char* why) {
  throw InputError(name_of(joint) + ": " + why);
}

bool is_at_least_0(double value) { return value >= 0.0 && std::isfinite(value); }

void validate_drive(std::size_t joint, const JointDrive& drive) {
  if (!(drive.limit >= 0.0)) refuse(joint, "a torque limit below 0");
  if (!std::isfinite(drive.torque) || !std::isfinite(drive.rate) || !std::isfinite(drive.position))
    refuse(joint, "torque, rate or position is not finite");
  if (!is_at_least_0(drive.stiffness) || !is_at_least_0(drive.damping))
    refuse(joint, "stiffness and damping must be >= 0 and finite");
}

bool has_drive(const JointDrive& drive) {
  return drive.mode != JointDrive::Mode::torque || drive.torque != 0.0;
}

void validate_axis(std::size_t index, const WorldJoint& joint) {
  if (!(joint.lower <= joint.upper)) refuse(index, "the limits are crossed or not numbers");
  validate_drive(index, joint.drive);
  if (!is_at_least_0(joint.losses.friction) || !is_at_least_0(joint.losses.damping))
    refuse(index, "friction and damping must be >= 0 and finite");
  const bool is_limited = std::isfinite(joint.lower) || std::isfinite(joint.upper);
  const bool asks =
      is_limited || has_drive(joint.drive) || joint.losses.friction > 0.0 || joint.losses.damping > 0.0;
  if (asks && !joint.joint.has_axis())
    refuse(index, "limits, drives and losses are of hinges and sliders alone");
  if (joint.joint.kind == BodyJointKind::hinge &&
      ((std::isfinite(joint.lower) && std::abs(joint.lower) > kMostAngle) ||
       (std::isfinite(joint.upper) && std::abs(joint.upper) > kMostAngle)))
    refuse(index, "limits beyond 64 turns");
}

void wake_sides(Movers& movers, const WorldJoint& joint) {
  for (const Mover* mover : {&joint.a, &joint.b})
    if (mover->kind == Mover::Kind::body) wake(movers, mover->index);
}

HeldJoint& held_at(Movers& movers, std::uint32_t joint) {
  if (joint >= movers.joints.size()) throw InputError("no " + name_of(joint));
  return movers.joints[joint];
}

/// In the world's present state, which the last step left.
FrameMotion motion_of(const Mover& mover, const Movers& movers) {
  if (mover.kind != Mover::Kind::body) return stepping::motion_now(mover, movers);
  const stepping::Body& body = movers.bodies[mover.index];
  FrameMotion out;
  out.X_WM = body.body.pose(body.state);
  out.w_W = body.is_kinematic ? body.commanded_w_W : body.body.angular_velocity(body.state);
  const Vector3 v = body.is_kinematic ? body.commanded_v_W : body.body.velocity(body.state);
  out.v_W = v + cross(out.w_W, Vector3(out.X_WM.p - body.state.p_W));
  return out;
}

}  // namespace

std::uint32_t DynamicsWorld::add_joint(const WorldJoint& joint) {
  Movers& movers = parts_->movers;
  const std::size_t index = movers.joints.size();
  if (!movers.is_known(joint.a) || !movers.is_known(joint.b)) refuse(index, "no such body or link");
  if (joint.a == joint.b) refuse(index, "it joins a mover with itself");
  const auto is_free = [&](const Mover& mover) {
    return mover.kind == Mover::Kind::link ||
           (mover.kind == Mover::Kind::body && !movers.bodies[mover.index].is_kinematic);
  };
  if (!is_free(joint.a) && !is_free(joint.b)) refuse(index, "neither side moves freely");
  validate(joint.joint, name_of(index));
  validate_axis(index, joint);
  HeldJoint& held = movers.joints.emplace_back();
  held.joint = joint;
  wake_sides(movers, joint);
  return static_cast<std::uint32_t>(index);
}

void DynamicsWorld::switch_joint(std::uint32_t joint, bool is_on) {
  HeldJoint& held = held_at(parts_->movers, joint);
  if (is_on && !held.joint.is_on) held.last = {}, held.turns = 0.0;
  held.joint.is_on = is_on;
  wake_sides(parts_->movers, held.joint);
}

void DynamicsWorld::join_as_they_stand(std::uint32_t joint) {
  HeldJoint& held = held_at(parts_->movers, joint);
  const Pose X_WA = motion_of(held.joint.a, parts_->movers).X_WM,
             X_WB = motion_of(held.joint.b, parts_->movers).X_WM;
  held.joint.joint.X_BJ = compose(inverse(X_WB), compose(X_WA, held.joint.joint.X_AJ));
  held.last = {}, held.turns = 0.0;
  held.joint.is_on = true;
  wake_sides(parts_->movers, held.joint);
}

void DynamicsWorld::set_joint_drive(std::uint32_t joint, const JointDrive& drive) {
  HeldJoint& held = held_at(parts_->movers, joint);
  if (!held.joint.joint.has_axis()) refuse(joint, "only hinges and sliders have a drive");
  validate_drive(joint, drive);
  held.joint.drive = drive;
  wake_sides(parts_->movers, held.joint);
}

std::size_t DynamicsWorld::joint_count() const { return parts_->movers.joints.size(); }

const WorldJoint& DynamicsWorld::world_joint(std::uint32_t joint) const {
  return parts_->movers.joints[joint].joint;
}

WorldJointState DynamicsWorld::joint_state(std::uint32_t joint) const {
  const HeldJoint& held = parts_->movers.joints[joint];
  const BodyJoint::Placed placed = held.joint.joint.place(motion_of(held.joint.a, parts_->movers),
                                                          motion_of(held.joint.b, parts_->movers));
  WorldJointState out;
  out.value = placed.value + held.turns;
  out.rate = placed.rate;
  for (std::size_t i = 0; i < placed.count; ++i)
    out.error = std::max(out.error, std::abs(placed.rows[i].error));
  out.torque = held.torque;
  if (held.duration > 0.0) {
    out.force_W = held.impulse_W / held.duration;
    out.moment_W = held.twist_W / held.duration;
  }
  return out;
}

}  // namespace touchstone::physics

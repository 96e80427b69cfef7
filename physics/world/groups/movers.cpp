#include "touchstone/physics/world/groups/movers.hpp"

#include <algorithm>

namespace touchstone::physics::stepping {

bool Movers::is_known(const Mover& mover) const {
  if (mover.kind == Mover::Kind::body) return mover.index < bodies.size();
  if (mover.kind == Mover::Kind::link)
    return mover.index < arms.size() && mover.link < arms[mover.index].dynamics->mechanism().links().size();
  return true;
}

bool Movers::holds(const HeldJoint& held) const {
  const auto is_awake = [&](const Mover& mover) {
    const std::uint32_t unit = unit_of(mover);
    return unit != kNoUnit && !(is_body(unit) && bodies[unit].is_asleep);
  };
  return held.joint.is_on && (is_awake(held.joint.a) || is_awake(held.joint.b));
}

void Movers::update_motions(std::span<const std::uint32_t> which) {
  for (const std::uint32_t i : which) {
    Body& body = bodies[i];
    body.X_WB = body.body.pose(body.state);
    body.v_W = body.is_kinematic ? body.commanded_v_W : body.body.velocity(body.state);
    body.w_W = body.is_kinematic ? body.commanded_w_W
                                 : body.body.angular_velocity(body.X_WB.R, body.state.angular_W);
  }
}

void Movers::place_kinematics(std::span<const std::uint32_t> kinematics, double elapsed) {
  for (const std::uint32_t i : kinematics) {
    Body& body = bodies[i];
    if (body.commanded_v_W == Vector3::Zero() && body.commanded_w_W == Vector3::Zero()) continue;
    body.state.p_W = body.kept.p_W + elapsed * body.commanded_v_W;
    body.state.q_WB = normalized(quaternion_of_turn(elapsed * body.commanded_w_W) * body.kept.q_WB);
  }
}

Pose Movers::pose_of(const Mover& mover) const {
  if (mover.kind == Mover::Kind::body) return bodies[mover.index].X_WB;
  if (mover.kind == Mover::Kind::link) {
    const Arm& arm = arms[mover.index];
    return arm.dynamics->link_pose(mover.link, arm.placed);
  }
  return {};
}

Vector3 Movers::point_velocity(const Mover& mover, const Vector3& p_W) const {
  if (mover.kind == Mover::Kind::body) {
    const Body& body = bodies[mover.index];
    return body.v_W + cross(body.w_W, p_W - body.state.p_W);
  }
  if (mover.kind == Mover::Kind::link) {
    const Arm& arm = arms[mover.index];
    return arm.dynamics->point_velocity(mover.link, p_W, arm.placed);
  }
  return Vector3::Zero();
}

void Movers::keep() {
  for (Body& body : bodies) body.kept = body.state;
  for (Arm& arm : arms) {
    arm.kept_q = arm.q, arm.kept_qd = arm.qd;
    arm.kept_torque = arm.torque, arm.kept_last_torque = arm.last_torque;
  }
  for (HeldJoint& joint : joints) joint.kept_last = joint.last, joint.kept_turns = joint.turns;
}

void Movers::undo() {
  for (Body& body : bodies) body.state = body.kept, body.is_met = false;
  for (Arm& arm : arms) {
    arm.q = arm.kept_q, arm.qd = arm.kept_qd;
    arm.torque = arm.kept_torque, arm.last_torque = arm.kept_last_torque;
    arm.place();
  }
  for (HeldJoint& joint : joints) joint.last = joint.kept_last, joint.turns = joint.kept_turns;
}

void Movers::forget_pushes() {
  if (!is_pushed) return;
  for (Body& body : bodies) body.push_W = body.push_moment_W = Vector3::Zero();
  for (Arm& arm : arms) std::fill(arm.push.begin(), arm.push.end(), 0.0);
  is_pushed = false;
}

}  // namespace touchstone::physics::stepping

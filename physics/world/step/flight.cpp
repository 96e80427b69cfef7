#include "touchstone/physics/world/step/flight.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/bodies/compensated_sum.hpp"
#include "touchstone/physics/world/rows/held_joints.hpp"

namespace touchstone::physics::stepping {
namespace {

// Of the contact gap: what rests moves by less, and is kept where it is until that has come together. Poses
// that keep their bits keep their contacts (NarrowphaseContacts).
constexpr double kKeptBack = 1e-3;

double cut_torque(const JointDrive& drive) {
  return std::min(std::max(drive.torque, -drive.limit), drive.limit);
}

StepFailure check_turn(const Body& body, const RigidBodyState& state, double t) {
  const double turn = norm(body.body.angular_velocity(state)) * t;
  if (!std::isfinite(turn)) return StepFailure::body;
  return turn > RigidBody::kMostTurn ? StepFailure::turn : StepFailure::none;
}

/// Under gravity and pushes. Returns why it cannot. @param kept_back as RigidBody::fly()
StepFailure fly_body(const Body& body, const Vector3& gravity_W, bool is_pushed, RigidBodyState& state,
                     double t, double kept_back = 0.0) {
  // Its state is unchanged where it fails.
  if (!body.body.fly(state, t, gravity_W, kept_back)) {
    const StepFailure why = check_turn(body, state, t);
    return why == StepFailure::none ? StepFailure::body : why;
  }
  if (!is_pushed || (body.push_W == Vector3::Zero() && body.push_moment_W == Vector3::Zero()))
    return StepFailure::none;
  const Vector3 impulse = t * body.push_W, twist = t * body.push_moment_W;
  add_compensated(state.p_W, state.p_low_W, (0.5 * t / body.body.inertia().mass) * impulse);
  add_compensated(state.momentum_W, state.low_W, impulse);
  state.angular_W += twist;
  const StepFailure why = check_turn(body, state, t);
  if (why != StepFailure::none) return why;
  RigidBody::turn_by(state, rotate(body.body.inverse_inertia_W(state), Vector3((0.5 * t) * twist)),
                     body.body.least_turn(kept_back));
  return is_finite(state) ? StepFailure::none : StepFailure::body;
}

void commit_body(double t, double gap, const RowUnit& unit, Body& body) {
  RigidBodyState& state = body.flown;
  if (unit.impulse_W != Vector3::Zero() || (unit.is_jointed && unit.moment_W != Vector3::Zero())) {
    // About the mean of where the body was and is: so that the angular momentum of all stays.
    add_compensated(state.p_W, state.p_low_W, (0.5 * t / body.body.inertia().mass) * unit.impulse_W);
    // Of a jointed body, which is not accelerated evenly, the rows' middle is that mean already.
    const Vector3 middle = unit.is_jointed ? unit.middle_W : Vector3(0.5 * (body.state.p_W + state.p_W));
    const Vector3 twist = unit.moment_W - cross(middle - unit.middle_W, unit.impulse_W);
    const Vector3 turn = rotate(unit.inverse_inertia_W, (0.5 * t) * twist);
    add_compensated(state.momentum_W, state.low_W, unit.impulse_W);
    state.angular_W += twist;
    const double kept_back = unit.is_jointed ? 0.0 : kKeptBack * gap;  // joints hold to rounding
    RigidBody::turn_by(state, turn, body.body.least_turn(kept_back));
    body.body.keep_place(state, body.state, kept_back);
  }
  body.state = state;
}

void commit_arm(double t, double h, Arm& arm) {
  for (std::size_t i = 0; i < arm.q.size(); ++i) {
    arm.q[i] = arm.flown_q[i] + (0.5 * t) * arm.change[i];
    arm.qd[i] = arm.flown_qd[i] + arm.change[i];
    arm.torque[i] += (arm.tau[i] - arm.push[i]) * (t / h);
  }
  arm.place();
}

}  // namespace

bool begin_flight(const Group& group, StepContext& step, Movers& movers) {
  for (const std::uint32_t m : group.mechanisms) {
    Arm& arm = movers.arms[m];
    for (std::size_t k = 0; k < arm.q.size(); ++k) {
      const JointDrive& drive = arm.drives[k];
      arm.tau[k] = (drive.mode == JointDrive::Mode::torque ? cut_torque(drive) : 0.0) + arm.push[k];
    }
    if (!arm.dynamics->begin_flight(step.settings.gravity_W, arm.tau, arm.qd, arm.placed, arm.scratch))
      return step.fail(StepFailure::mechanism, m);
  }
  return true;
}

bool fly(const Group& group, double t, StepContext& step, Movers& movers) {
  const Vector3& gravity_W = step.settings.gravity_W;
  if (!group.joints.empty() && !fly_jointed(group, t, step, movers)) return false;
  for (const std::uint32_t i : group.bodies) {
    Body& body = movers.bodies[i];
    if (body.is_jointed) continue;
    body.flown = body.state;
    const double kept_back = kKeptBack * step.settings.contact_gap;
    const StepFailure why = fly_body(body, gravity_W, movers.is_pushed, body.flown, t, kept_back);
    if (why != StepFailure::none) return step.fail(why, i);
  }
  for (const std::uint32_t m : group.mechanisms) {
    Arm& arm = movers.arms[m];
    if (arm.is_jointed) continue;
    arm.flown_q = arm.q;
    arm.flown_qd = arm.qd;
    if (!arm.dynamics->fly(arm.X_WBase, gravity_W, arm.tau, t, t / step.h, arm.flown_q, arm.flown_qd,
                           arm.scratch))
      return step.fail(StepFailure::mechanism, m);
  }
  return true;
}

bool fly_loose(std::span<const std::uint32_t> bodies, StepContext& step, Movers& movers) {
  for (const std::uint32_t i : bodies) {
    Body& body = movers.bodies[i];
    const StepFailure why = fly_body(body, step.settings.gravity_W, movers.is_pushed, body.state, step.h);
    if (why != StepFailure::none) return step.fail(why, i);
  }
  return true;
}

void take_joint_impulse(HeldJoint& held, const ContactRows::Joint& row, double impulse, double t, double h) {
  if (!row.is_axis) {
    const BodyJointRow& direction = held.placed.rows[row.held];
    held.impulse_W += impulse * direction.force_W;
    held.twist_W += impulse * direction.moment_W;
    if (t > 0.0) held.last[row.held] = impulse / t;
    return;
  }
  if (row.is_stop) {
    const bool turns = held.joint.joint.kind == BodyJointKind::hinge;
    (turns ? held.twist_W : held.impulse_W) += (row.sign * impulse) * held.placed.axis_W;
    return;
  }
  if (row.torque == Torque::drive) held.torque += row.share * impulse / h;
  if (t > 0.0) held.last[BodyJoint::kMostRows + static_cast<std::size_t>(row.torque)] = impulse / t;
}

void keep_forces(double t, const ContactRows& rows, GroupState& group) {
  for (GroupPoint& point : group.points) point.last_force_W = Vector3::Zero();
  for (std::size_t i = 0; i < rows.contacts.size(); ++i)
    group.points[rows.contacts[i].point].last_force_W = rows.impulse_of(i) / t;
}

void commit(double t, const StepContext& step, GroupState& group, Movers& movers, ContactRows& rows) {
  // Where all are at the end, and how fast.
  sum_impulses(rows);
  for (const std::uint32_t i : group.members.bodies)
    commit_body(t, step.settings.contact_gap, rows.units[i], movers.bodies[i]);
  for (const std::uint32_t m : group.members.mechanisms) commit_arm(t, step.h, movers.arms[m]);
  // The forces and torques that made it so.
  for (const std::uint32_t j : group.members.joints) {
    HeldJoint& held = movers.joints[j];
    held.impulse_W += held.flown.impulse_W;
    held.twist_W += held.flown.twist_W;
  }
  keep_forces(t, rows, group);
  for (std::size_t i = 0; i < rows.contacts.size(); ++i)
    group.points[rows.contacts[i].point].impulse_W += rows.impulse_of(i);
  for (std::size_t j = 0; j < rows.joints.size(); ++j) {
    const ContactRows::Joint& joint = rows.joints[j];
    if (joint.unit == kNoUnit) {
      take_joint_impulse(movers.joints[joint.value], joint, rows.joint_impulse(j), t, step.h);
      continue;
    }
    if (joint.is_stop) continue;
    Arm& arm = movers.arm_of(joint.unit);
    const double impulse = rows.joint_impulse(j);
    if (joint.torque == Torque::drive) arm.torque[joint.value] += joint.share * impulse / step.h;
    arm.last_torque[static_cast<std::size_t>(joint.torque) * arm.q.size() + joint.value] = impulse / t;
  }
}

}  // namespace touchstone::physics::stepping

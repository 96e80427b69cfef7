#include "touchstone/physics/world/step/impacts.hpp"

#include <algorithm>

#include "touchstone/physics/bodies/compensated_sum.hpp"
#include "touchstone/physics/world/rows/held_joints.hpp"
#include "touchstone/physics/world/step/flight.hpp"

namespace touchstone::physics::stepping {

bool needs_impact(const GroupState& group, const Movers& movers, const StepContext& step) {
  const DynamicsWorld::Settings& settings = step.settings;
  // An impact at what unfinished forces leave would spend the work of the forces, which it thus leaves
  // unfinished again: what rests would be solved anew in each step, for ever.
  const double solved = 10.0 * settings.solver.tolerance;  // a solve leaves less
  const double least = step.is_bounded()
                           ? std::max(solved, std::min(settings.contact_gap / step.h, settings.bounce_speed))
                           : solved;
  if (group.joint_speed > least || meets_end(group.members, movers, settings.contact_gap, least)) return true;
  // In one piece contacts that do not bounce are stopped with the forces.
  if (group.is_coarse)
    return std::any_of(group.points.begin(), group.points.end(), [&](const GroupPoint& point) {
      return point.separation <= settings.contact_gap && point.approach_v < -settings.bounce_speed &&
             point.contact->restitution > 0.0;
    });
  for (const GroupPoint& point : group.points)
    if (point.separation <= settings.contact_gap && point.approach_v < -least) return true;
  for (const std::uint32_t m : group.members.mechanisms) {
    const Arm& arm = movers.arms[m];
    for (const Mechanism::Joint& joint : arm.dynamics->mechanism().joints()) {
      const std::uint32_t i = joint.value;
      if (i == Mechanism::kNone) continue;
      if (arm.q[i] - joint.lower <= settings.contact_gap && arm.qd[i] < -least) return true;
      if (joint.upper - arm.q[i] <= settings.contact_gap && arm.qd[i] > least) return true;
    }
  }
  return false;
}

void impact(GroupState& group, StepContext& step, Movers& movers, ContactRows& rows, IslandSolver& solver) {
  // The impact's rows are gathered and solved.
  gather({Phase::impact, 0.0, false, true}, group, step, movers, rows);
  solver.solve(rows, step);
  // Velocities jump.
  sum_impulses(rows);
  for (const std::uint32_t i : group.members.bodies) {
    RigidBodyState& state = movers.bodies[i].state;
    add_compensated(state.momentum_W, state.low_W, rows.units[i].impulse_W);
    state.angular_W += rows.units[i].moment_W;
  }
  for (const std::uint32_t m : group.members.mechanisms) {
    Arm& arm = movers.arms[m];
    for (std::size_t i = 0; i < arm.q.size(); ++i) arm.qd[i] += arm.change[i];
    arm.place();
  }
  // Impulses count among the step's forces and torques.
  for (std::size_t i = 0; i < rows.contacts.size(); ++i) {
    GroupPoint& point = group.points[rows.contacts[i].point];
    const Vector3 impulse = rows.impulse_of(i);
    point.impulse_W += impulse;
    point.impact_W += impulse;
  }
  for (std::size_t j = 0; j < rows.joints.size(); ++j) {
    const ContactRows::Joint& joint = rows.joints[j];
    if (joint.unit == kNoUnit)
      take_joint_impulse(movers.joints[joint.value], joint, rows.joint_impulse(j), 0.0, step.h);
    else if (!joint.is_stop)
      movers.arm_of(joint.unit).torque[joint.value] += rows.joint_impulse(j) / step.h;
  }
  // Motions and speeds follow from the new velocities.
  update_motions(group, movers);
  update_speeds(movers, group);
  group.joint_speed = refresh_joints(group.members, movers);
}

}  // namespace touchstone::physics::stepping

#include "touchstone/physics/world/rows/held_joints.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/solver/contact_laws.hpp"

namespace touchstone::physics::stepping {
namespace {

using Side = JointSystem::Side;

bool is_commanded(const Mover& mover, const Movers& movers) {
  return mover.kind == Mover::Kind::body && movers.bodies[mover.index].is_kinematic;
}

FrameMotion motion_of(const RigidBody& body, const RigidBodyState& state) {
  const Pose X_WB = body.pose(state);
  const Vector3 w_W = body.angular_velocity(state);
  return {X_WB, body.velocity(state) + cross(w_W, Vector3(X_WB.p - state.p_W)), w_W};
}

FrameMotion motion_of(const Arm& arm, std::uint32_t link, const MechanismDynamics::Workspace& placed) {
  const Pose X_WL = arm.dynamics->link_pose(link, placed);
  return {X_WL, arm.dynamics->point_velocity(link, X_WL.p, placed),
          arm.dynamics->angular_velocity(link, placed)};
}

/// The value of a hinge nearest to `near`, as its angle does not count turns.
double unwrapped(const HeldJoint& held, double value, double near) {
  if (held.joint.joint.kind != BodyJointKind::hinge) return value;
  const double turn = 2.0 * std::numbers::pi;
  return value + turn * std::round((near - value) / turn);
}

/// The group's joints and the units that they hold, each once. @param of the state of a body, values of a
/// mechanism.
template <class StateOf, class ArmOf>
void fill_system(const Group& group, Movers& movers, const StateOf& state_of, const ArmOf& arm_of) {
  JointSystem& system = movers.system;
  system.clear();
  movers.system_index.resize(movers.unit_count());
  // Jointed bodies and mechanisms enter the system.
  for (const std::uint32_t i : group.bodies) {
    Body& body = movers.bodies[i];
    if (!body.is_jointed) continue;
    movers.system_index[i] = static_cast<std::uint32_t>(system.bodies.size());
    system.bodies.push_back({&body.body, state_of(body), body.push_W, body.push_moment_W});
  }
  for (const std::uint32_t m : group.mechanisms) {
    if (!movers.arms[m].is_jointed) continue;
    movers.system_index[movers.unit_of_arm(m)] = static_cast<std::uint32_t>(system.arms.size());
    system.arms.push_back(arm_of(movers.arms[m]));
  }
  // A joint's side is the ground, a kinematic body or a unit of the system.
  const auto side_of = [&](const Mover& mover) -> Side {
    if (mover.kind == Mover::Kind::ground) return {};
    if (is_commanded(mover, movers)) {
      const Body& body = movers.bodies[mover.index];
      const FrameMotion motion = motion_now(mover, movers);
      system.kinematic.push_back({body.X_WB, motion.v_W, motion.w_W});
      return {Side::Kind::kinematic, static_cast<std::uint32_t>(system.kinematic.size() - 1), 0};
    }
    const std::uint32_t index = movers.system_index[movers.unit_of(mover)];
    return {mover.kind == Mover::Kind::body ? Side::Kind::body : Side::Kind::arm, index, mover.link};
  };
  // The group's joints connect their sides.
  for (const std::uint32_t j : group.joints) {
    const WorldJoint& joint = movers.joints[j].joint;
    const Side a = side_of(joint.a), b = side_of(joint.b);
    system.joints.push_back({&joint.joint, a, b});
  }
}

/// Back to the movers.
void take_states(const Group& group, Movers& movers, bool as_flown) {
  for (const std::uint32_t i : group.bodies) {
    Body& body = movers.bodies[i];
    if (!body.is_jointed) continue;
    (as_flown ? body.flown : body.state) = movers.system.bodies[movers.system_index[i]].state;
  }
}

}  // namespace

FrameMotion motion_now(const Mover& mover, const Movers& movers) {
  if (mover.kind == Mover::Kind::ground) return {};
  if (mover.kind == Mover::Kind::link)
    return motion_of(movers.arms[mover.index], mover.link, movers.arms[mover.index].placed);
  const Body& body = movers.bodies[mover.index];
  return {body.X_WB, body.v_W + cross(body.w_W, Vector3(body.X_WB.p - body.state.p_W)), body.w_W};
}

FrameMotion motion_flown(const Mover& mover, const Movers& movers, double t) {
  if (mover.kind == Mover::Kind::ground) return {};
  if (mover.kind == Mover::Kind::link)
    return motion_of(movers.arms[mover.index], mover.link, movers.arms[mover.index].scratch);
  const Body& body = movers.bodies[mover.index];
  if (!body.is_kinematic) return motion_of(body.body, body.flown);
  FrameMotion out = motion_now(mover, movers);
  out.X_WM.p += t * out.v_W;
  out.X_WM.R = product(rotation_matrix(quaternion_of_turn(t * out.w_W)), out.X_WM.R);
  return out;
}

void mark_jointed(const Group& group, Movers& movers) {
  for (const std::uint32_t i : group.bodies) movers.bodies[i].is_jointed = false;
  for (const std::uint32_t m : group.mechanisms) movers.arms[m].is_jointed = false;
  for (const std::uint32_t j : group.joints)
    for (const Mover* mover : {&movers.joints[j].joint.a, &movers.joints[j].joint.b}) {
      if (mover->kind == Mover::Kind::body) movers.bodies[mover->index].is_jointed = true;
      if (mover->kind == Mover::Kind::link) movers.arms[mover->index].is_jointed = true;
    }
}

double refresh_joints(const Group& group, Movers& movers) {
  double worst = 0.0;
  for (const std::uint32_t j : group.joints) {
    HeldJoint& held = movers.joints[j];
    const FrameMotion a = motion_now(held.joint.a, movers), b = motion_now(held.joint.b, movers);
    const BodyJoint::Placed placed = held.joint.joint.place(a, b);
    held.value = unwrapped(held, placed.value, placed.value + held.turns);
    held.rate = placed.rate;
    const Vector3 v = (b.v_W + cross(b.w_W, Vector3(placed.at_W - b.X_WM.p))) -
                      (a.v_W + cross(a.w_W, Vector3(placed.at_W - a.X_WM.p)));
    for (std::size_t i = 0; i < placed.count; ++i)
      worst = worse_of(worst, std::abs(dot(placed.rows[i].force_W, v) +
                                       dot(placed.rows[i].moment_W, Vector3(b.w_W - a.w_W))));
  }
  return worst;
}

bool meets_end(const Group& group, const Movers& movers, double gap, double least) {
  return std::any_of(group.joints.begin(), group.joints.end(), [&](std::uint32_t j) {
    const HeldJoint& held = movers.joints[j];
    return (held.value - held.joint.lower <= gap && held.rate < -least) ||
           (held.joint.upper - held.value <= gap && held.rate > least);
  });
}

bool fly_jointed(const Group& group, double t, StepContext& step, Movers& movers) {
  // Mechanisms fly in copies of their values and rates.
  fill_system(
      group, movers, [](const Body& body) { return body.state; },
      [](Arm& arm) -> JointSystem::Arm {
        arm.flown_q = arm.q;
        arm.flown_qd = arm.qd;
        return {arm.dynamics, arm.X_WBase, arm.tau, arm.flown_q, arm.flown_qd, &arm.scratch};
      });
  // A failure is reported of the first jointed unit.
  if (!movers.system.fly(t, step.settings.gravity_W)) {
    const bool is_body = !movers.system.bodies.empty();
    const auto jointed = [&](std::uint32_t i) {
      return is_body ? movers.bodies[i].is_jointed : movers.arms[i].is_jointed;
    };
    const std::span<const std::uint32_t> all = is_body ? group.bodies : group.mechanisms;
    return step.fail(is_body ? StepFailure::body : StepFailure::mechanism,
                     *std::find_if(all.begin(), all.end(), jointed));
  }
  // The flown states and the joints' reactions are taken over.
  take_states(group, movers, true);
  for (const std::uint32_t m : group.mechanisms) {
    Arm& arm = movers.arms[m];
    if (arm.is_jointed) arm.dynamics->place(arm.X_WBase, arm.flown_q, arm.flown_qd, arm.scratch);
  }
  for (std::size_t k = 0; k < group.joints.size(); ++k)
    movers.joints[group.joints[k]].flown = movers.system.reactions()[k];
  return true;
}

double value_now(const HeldJoint& held, const Movers& movers) {
  const BodyJoint::Placed placed =
      held.joint.joint.place(motion_now(held.joint.a, movers), motion_now(held.joint.b, movers));
  return unwrapped(held, placed.value, held.value);
}

void finish_joints(const Group& group, StepContext& step, Movers& movers) {
  if (group.joints.empty()) return;
  fill_system(
      group, movers, [](const Body& body) { return body.state; },
      [](Arm& arm) -> JointSystem::Arm {
        return {arm.dynamics, arm.X_WBase, arm.tau, arm.q, arm.qd, &arm.scratch};
      });
  const double left = movers.system.pull_together(step.settings.part_speed * step.h);
  take_states(group, movers, false);
  for (const std::uint32_t m : group.mechanisms)
    if (movers.arms[m].is_jointed) movers.arms[m].place();
  movers.update_motions(group.bodies);
  step.report.worst_joint_error = worse_of(step.report.worst_joint_error, left);
  for (const std::uint32_t j : group.joints) {
    HeldJoint& held = movers.joints[j];
    held.duration = step.h;
    if (!held.joint.joint.has_axis()) continue;
    const BodyJoint::Placed placed =
        held.joint.joint.place(motion_now(held.joint.a, movers), motion_now(held.joint.b, movers));
    held.turns = unwrapped(held, placed.value, held.value) - placed.value;
  }
}

}  // namespace touchstone::physics::stepping

#include "touchstone/physics/guarded/joint_follower.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/no_index.hpp"

namespace touchstone::physics {
namespace {

/// Errors below are left to dynamics: rounding, and what its flight of order 6 leaves [m] [rad].
constexpr double kSmall = 1e-12;
/// No error is larger: a joint's bodies were together at the step's start.
constexpr double kAnyWay = 1e3;

bool is_free(const SceneSimulation& simulation, const Mover& mover) {
  return mover.kind == Mover::Kind::link ||
         (mover.kind == Mover::Kind::body && !simulation.world().is_kinematic(mover.index));
}

}  // namespace

JointFollower::JointFollower(const SceneSimulation& simulation)
    : joints_(simulation.world().joint_count()), bodies_(simulation.world().body_count()) {
  const std::size_t mechanisms = simulation.scene().mechanisms.size();
  group_.resize(bodies_ + mechanisms);
  place_.resize(group_.size());
  is_cut_.resize(group_.size());
  units_.reserve(group_.size());
  if (joints_ == 0) return;
  std::size_t widest = 0;
  for (std::size_t m = 0; m < mechanisms; ++m) {
    const MechanismDynamics& dynamics = simulation.dynamics_of(m);
    const std::vector<double> zeros(dynamics.size(), 0.0);
    arms_.push_back({zeros, zeros, zeros, dynamics.make_workspace()});
    widest = std::max<std::size_t>(widest, dynamics.size());
  }
  system_.reserve(bodies_, mechanisms, joints_, widest);
}

std::uint32_t JointFollower::unit_of(const SceneSimulation& simulation, const Mover& mover) const {
  if (!is_free(simulation, mover)) return kNoIndex;
  return mover.kind == Mover::Kind::body ? mover.index : static_cast<std::uint32_t>(bodies_) + mover.index;
}

/// Units that holding joints connect get one number.
void JointFollower::find_groups(const SceneSimulation& simulation) {
  for (std::uint32_t unit = 0; unit < group_.size(); ++unit) group_[unit] = unit;
  const DynamicsWorld& world = simulation.world();
  for (std::uint32_t j = 0; j < joints_; ++j) {
    const WorldJoint& joint = world.world_joint(j);
    const std::uint32_t a = unit_of(simulation, joint.a), b = unit_of(simulation, joint.b);
    if (!joint.is_on || a == kNoIndex || b == kNoIndex) continue;
    const std::uint32_t from = std::max(group_[a], group_[b]), to = std::min(group_[a], group_[b]);
    std::replace(group_.begin(), group_.end(), from, to);
  }
}

JointSystem::Side JointFollower::side(SceneSimulation& simulation, const Mover& mover,
                                      std::span<const std::uint8_t> is_held) {
  using Kind = JointSystem::Side::Kind;
  if (mover.kind == Mover::Kind::ground) return {};
  const DynamicsWorld& world = simulation.world();
  const std::uint32_t unit = unit_of(simulation, mover);
  if (unit == kNoIndex || is_held[unit] != 0) {
    const Pose X =
        mover.kind == Mover::Kind::body ? world.pose(mover.index) : world.link_pose(mover.index, mover.link);
    system_.kinematic.push_back({X, Vector3::Zero(), Vector3::Zero()});
    return {Kind::kinematic, static_cast<std::uint32_t>(system_.kinematic.size() - 1), 0};
  }
  if (mover.kind == Mover::Kind::body) return {Kind::body, place_[unit], 0};
  return {Kind::arm, place_[unit], mover.link};
}

/// The groups that is_cut_ names.
void JointFollower::fill(SceneSimulation& simulation, std::span<const std::uint8_t> is_held) {
  const DynamicsWorld& world = simulation.world();
  system_.clear();
  units_.clear();
  // A unit takes part if its group was cut, it is not held and a joint acts on it.
  const auto is_jointed = [&](std::uint32_t unit) {
    if (is_cut_[group_[unit]] == 0 || is_held[unit] != 0) return false;
    for (std::uint32_t j = 0; j < joints_; ++j) {
      const WorldJoint& joint = world.world_joint(j);
      if (joint.is_on && (unit_of(simulation, joint.a) == unit || unit_of(simulation, joint.b) == unit))
        return true;
    }
    return false;
  };
  // Bodies and mechanisms enter the system in their present states.
  for (std::uint32_t unit = 0; unit < group_.size(); ++unit) {
    if (!is_jointed(unit)) continue;
    units_.push_back(unit);
    if (unit < bodies_) {
      place_[unit] = static_cast<std::uint32_t>(system_.bodies.size());
      system_.bodies.push_back({&world.body(unit), world.state(unit), Vector3::Zero(), Vector3::Zero()});
      continue;
    }
    const auto mechanism = static_cast<std::uint32_t>(unit - bodies_);
    Arm& arm = arms_[mechanism];
    std::copy_n(world.joint_values(mechanism).begin(), arm.q.size(), arm.q.begin());
    std::copy_n(world.joint_rates(mechanism).begin(), arm.qd.size(), arm.qd.begin());
    place_[unit] = static_cast<std::uint32_t>(system_.arms.size());
    system_.arms.push_back({&simulation.dynamics_of(mechanism), {}, arm.tau, arm.q, arm.qd, &arm.workspace});
  }
  // Joints with at least one side that may move become its constraints.
  for (std::uint32_t j = 0; j < joints_; ++j) {
    const WorldJoint& joint = world.world_joint(j);
    const auto moves = [&](const Mover& mover) {
      const std::uint32_t unit = unit_of(simulation, mover);
      return unit != kNoIndex && is_cut_[group_[unit]] != 0 && is_held[unit] == 0;
    };
    if (!joint.is_on || !(moves(joint.a) || moves(joint.b))) continue;
    const JointSystem::Side a = side(simulation, joint.a, is_held), b = side(simulation, joint.b, is_held);
    system_.joints.push_back({&joint.joint, a, b});
  }
}

void JointFollower::give(SceneSimulation& simulation) {
  DynamicsWorld& world = simulation.world_to_set();
  for (const std::uint32_t unit : units_) {
    if (unit < bodies_) {
      world.set_state(unit, system_.bodies[place_[unit]].state);
      continue;
    }
    const auto mechanism = static_cast<std::uint32_t>(unit - bodies_);
    Arm& arm = arms_[mechanism];
    for (const Mechanism::Joint& joint : simulation.dynamics_of(mechanism).mechanism().joints())
      if (joint.value != Mechanism::kNone)
        arm.q[joint.value] = std::clamp(arm.q[joint.value], joint.lower, joint.upper);
    world.set_joints(mechanism, arm.q, arm.qd);
  }
}

bool JointFollower::follow(SceneSimulation& simulation, std::span<const std::uint8_t> is_held) {
  find_groups(simulation);
  std::fill(is_cut_.begin(), is_cut_.end(), std::uint8_t{0});
  for (std::uint32_t unit = 0; unit < group_.size(); ++unit)
    if (is_held[unit] != 0) is_cut_[group_[unit]] = 1;
  fill(simulation, is_held);
  if (system_.joints.empty() || !(system_.worst_error() > kSmall)) return false;
  system_.pull_together(kAnyWay);
  give(simulation);
  return true;
}

double JointFollower::worst_error(SceneSimulation& simulation) {
  double worst = 0.0;
  for (std::uint32_t j = 0; j < joints_; ++j)
    if (simulation.world().world_joint(j).is_on) worst = std::max(worst, simulation.body_joint(j).error);
  return worst;
}

}  // namespace touchstone::physics

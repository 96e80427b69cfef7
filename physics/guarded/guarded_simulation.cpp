#include "touchstone/physics/guarded/guarded_simulation.hpp"

#include <algorithm>
#include <cmath>

namespace touchstone::physics {
namespace {

/// Frames of one step in which jointed bodies follow a cut one; each cuts one more mover at least.
constexpr int kMostFollows = 4;

}  // namespace

std::uint32_t GuardedSimulation::unit_of(std::size_t object) const {
  const Mover& mover = simulation_.mover_of(object);
  if (mover.kind == Mover::Kind::body) return mover.index;
  return static_cast<std::uint32_t>(simulation_.world().body_count()) + mover.index;  // @pre not the ground
}

Vector3 GuardedSimulation::hand_point(std::size_t hand) const {
  return transform(simulation_.object_pose(hands_[hand].setting.link), hands_[hand].setting.p_O);
}

/// Joint rates for the hands' commands, from where the arms are; drives follow as their torques allow.
void GuardedSimulation::drive_hands() {
  DynamicsWorld& world = simulation_.world_to_set();
  for (Hand& hand : hands_) {
    const Mechanism& mechanism = hand.control.mechanism();
    mechanism.link_poses({}, world.joint_values(hand.mechanism), hand.X_WL);
    hand.control.solve(hand.X_WL, transform(simulation_.object_pose(hand.setting.link), hand.setting.p_O),
                       hand.wanted_W, hand.rates);
    for (const Mechanism::Joint& joint : mechanism.joints()) {
      if (joint.value == Mechanism::kNone) continue;
      JointDrive drive;
      drive.mode = JointDrive::Mode::rate;
      drive.rate = hand.rates[joint.value];
      drive.limit = joint.effort;
      world.set_drive(hand.mechanism, joint.value, drive);
    }
  }
}

/// Where dynamics has led, as commands.
void GuardedSimulation::propose() {
  commands_.clear();
  movers_.clear();
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (simulation_.mover_of(i).kind != Mover::Kind::body || simulation_.root_of(i) != i) continue;
    const Pose X_WO = simulation_.object_pose(i);
    if (is_same(X_WO, shown_pose(i))) continue;
    commands_.push_back({objects_[i], RigidPath::between(shown_pose(i), X_WO)});
    movers_.push_back(i);
  }
  for (std::size_t m = 0; m < mechanisms_.size(); ++m)
    joint_commands_[m].values = simulation_.world().joint_values(static_cast<std::uint32_t>(m));
}

void GuardedSimulation::mark(ObjectHandle object) {
  const std::size_t i = object_of(object);
  if (simulation_.mover_of(i).kind == Mover::Kind::ground) return;
  const std::uint32_t unit = unit_of(i);
  standing_[unit] = is_cut_[unit];
}

/// Of those that were cut: by a pair that holds or advances.
void GuardedSimulation::mark_standing() {
  std::fill(standing_.begin(), standing_.end(), std::uint8_t{0});
  for (const ContactEvent& event : frame_.events) {
    if (event.kind != EventKind::blocked) continue;
    const GuardPolicy rule = policy(object_of(event.a), object_of(event.b));
    if (rule == GuardPolicy::slide || rule == GuardPolicy::push) continue;
    mark(event.a);
    mark(event.b);
  }
}

/// Points within the gap; and where a pair stopped its movers further apart, since the check gave up on it,
/// its witness points: approaching there would go on for ever.
std::span<const Contact> GuardedSimulation::cut_contacts() {
  const std::span<const Contact> touching = touching_->find(simulation_.world());
  cut_contacts_.assign(
      touching.begin(),
      touching.begin() + static_cast<std::ptrdiff_t>(std::min(touching.size(), CutImpulses::kMostContacts)));
  for (const ContactEvent& event : frame_.events) {
    if (event.kind != EventKind::blocked || cut_contacts_.size() == CutImpulses::kMostContacts) continue;
    const std::size_t a = object_of(event.a), b = object_of(event.b);
    const bool goes_along = policy(a, b) == GuardPolicy::slide || policy(a, b) == GuardPolicy::push;
    if (!goes_along || !(event.geometry_at_end.separation > settings_.gap)) continue;
    Contact contact;
    contact.a = simulation_.mover_of(a), contact.b = simulation_.mover_of(b);
    contact.n_AB_W = event.geometry_at_end.n_AB_W;
    contact.p_A_W = event.geometry_at_end.p_A_W, contact.p_B_W = event.geometry_at_end.p_B_W;
    contact.restitution = surfaces_
                              .between(static_cast<std::uint32_t>(a), scene_->bodies[a].surface,
                                       static_cast<std::uint32_t>(b), scene_->bodies[b].surface)
                              .restitution;
    cut_contacts_.push_back(contact);
  }
  return cut_contacts_;
}

/// The object's pose, its velocities as they were, to be judged by impulses.
bool GuardedSimulation::cut_body(std::size_t object, GuardedStep& report) {
  DynamicsWorld& world = simulation_.world_to_set();
  const std::uint32_t body = simulation_.mover_of(object).index;
  const Pose proposed = simulation_.object_pose(object);
  const Pose& X_WO = shown_pose(object);
  if (is_same(proposed, X_WO)) return false;
  report.held_back = std::max(report.held_back, norm(X_WO.p - proposed.p));
  const RigidBodyState& now = world.state(body);
  RigidBodyState state = world.body(body).state(X_WO, Vector3::Zero(), Vector3::Zero());
  state.momentum_W = now.momentum_W, state.low_W = now.low_W;
  state.angular_W = now.angular_W;
  world.set_state(body, state);
  is_cut_[body] = 1;
  return true;
}

bool GuardedSimulation::cut_mechanism(std::uint32_t mechanism, GuardedStep& report) {
  DynamicsWorld& world = simulation_.world_to_set();
  const std::span<const double> q = world_.joint_values(mechanisms_[mechanism]);
  const std::span<const double> proposed = world.joint_values(mechanism);
  if (std::equal(q.begin(), q.end(), proposed.begin())) return false;
  for (std::size_t i = 0; i < objects_.size(); ++i)
    if (simulation_.mover_of(i) == Mover::of_link(mechanism, simulation_.mover_of(i).link))
      report.held_back = std::max(report.held_back, norm(shown_pose(i).p - simulation_.object_pose(i).p));
  world.set_joints(mechanism, q, world.joint_rates(mechanism));
  is_cut_[world.body_count() + mechanism] = 1;
  return true;
}

bool GuardedSimulation::find_cuts(GuardedStep& report) {
  const std::uint32_t before = report.cut;
  for (const std::size_t object : movers_) report.cut += cut_body(object, report) ? 1 : 0;
  for (std::size_t m = 0; m < mechanisms_.size(); ++m)
    report.cut += cut_mechanism(static_cast<std::uint32_t>(m), report) ? 1 : 0;
  return report.cut > before;
}

/// Bodies that joints hold to a cut one follow it, frame by frame, as far as the world lets them.
void GuardedSimulation::bring_joints_together(GuardedStep& report) {
  if (!follower_.any()) return;
  events_.assign(frame_.events.begin(), frame_.events.end());
  for (int i = 0; i < kMostFollows && follower_.follow(simulation_, is_cut_); ++i) {
    propose();
    const FrameReport further = world_.frame(commands_, joint_commands_);
    report.slides_ended += static_cast<std::uint32_t>(further.cut_off.size());
    for (const ContactEvent& event : further.events)
      if (event.kind != EventKind::near && event.kind != EventKind::persists) events_.push_back(event);
    if (!find_cuts(report)) break;
  }
  frame_.events = events_;
  report.joint_error = follower_.worst_error(simulation_);
}

std::pair<Vector3, Vector3> GuardedSimulation::momentum() const {
  const DynamicsWorld& world = simulation_.world();
  Vector3 linear = Vector3::Zero(), angular = Vector3::Zero();
  for (std::uint32_t body = 0; body < world.body_count(); ++body) {
    if (world.is_kinematic(body)) continue;
    const RigidBodyState& state = world.state(body);
    linear += state.momentum_W;
    angular += cross(state.p_W, state.momentum_W) + state.angular_W;
  }
  return {linear, angular};
}

/// Standing units lose their rates and momenta; kinematic bodies that were cut stand until commanded again.
void GuardedSimulation::stand(GuardedStep& report) {
  DynamicsWorld& world = simulation_.world_to_set();
  const Vector3 before = momentum().first;
  for (std::uint32_t unit = 0; unit < standing_.size(); ++unit) {
    const bool is_body = unit < world.body_count();
    if (is_body && world.is_kinematic(unit)) {
      impulses_.held()[unit] = is_cut_[unit];
      continue;
    }
    if (!stands(unit)) continue;
    ++report.standing;
    impulses_.held()[unit] = 1;
    if (is_body) {
      RigidBodyState state = world.state(unit);
      state.momentum_W = state.angular_W = state.low_W = Vector3::Zero();
      world.set_state(unit, state);
    } else {
      const auto mechanism = static_cast<std::uint32_t>(unit - world.body_count());
      world.set_rates(mechanism, std::span(still_).first(world.joint_rates(mechanism).size()));
    }
  }
  report.held_W = before - momentum().first;
}

/// Puts movers that were cut where the world shows them; their velocities no longer lead on.
void GuardedSimulation::take_back(GuardedStep& report) {
  DynamicsWorld& world = simulation_.world_to_set();
  const auto [linear, angular] = momentum();
  const double energy = world.energy();
  std::fill(is_cut_.begin(), is_cut_.end(), std::uint8_t{0});
  if (!find_cuts(report)) return;
  bring_joints_together(report);
  mark_standing();
  stand(report);
  report.impulses = impulses_.solve(simulation_, cut_contacts(), scene_->bounce_speed);
  const auto [linear_after, angular_after] = momentum();
  report.linear_W = linear_after - linear;
  report.angular_W = angular_after - angular;
  report.energy = world.energy() - energy;
}

GuardedStep GuardedSimulation::step() {
  GuardedStep report;
  drive_hands();
  simulation_.begin_step();
  if (latched_ != simulation_.worlds()) follow_latches();
  simulation_.find_contacts();
  report.dynamics = simulation_.advance();
  if (report.dynamics.failure != StepFailure::none) return report;
  propose();
  frame_ = world_.frame(commands_, joint_commands_);
  report.slides_ended = static_cast<std::uint32_t>(frame_.cut_off.size());
  take_back(report);
  return report;
}

}  // namespace touchstone::physics

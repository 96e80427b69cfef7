// A step: each group for itself, cut into pieces where something of it stops or arrives.

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/physics/solver/contact_laws.hpp"
#include "touchstone/physics/world/groups/fewest_points.hpp"
#include "touchstone/physics/world/groups/sleep.hpp"
#include "touchstone/physics/world/rows/held_joints.hpp"
#include "touchstone/physics/world/step/flight.hpp"
#include "touchstone/physics/world/step/impacts.hpp"
#include "touchstone/physics/world/step/parting.hpp"
#include "touchstone/physics/world/step/step_stops.hpp"
#include "touchstone/physics/world/step/world_parts.hpp"

namespace touchstone::physics::stepping {
namespace {

// Arrivals tried for one piece: each try squares the remaining error.
constexpr int kMostTries = 6;
// Where points stop one by one (a body that turns as it slides) their stops are many and none is sharp: this
// many pieces of a step end at one, each found in a few tries.
constexpr std::uint32_t kMostStops = 4;
constexpr int kStopTries = 2;
// A piece whose forces took more Newton steps, as those of a body that comes to lie flat do, is tried again
// from them. Others start from the last piece's: from forces that just hold they would be off by what the
// solver leaves.
constexpr std::uint32_t kEasySteps = 8;
// Of the rest of the step: after an impact joints move that brakes stop at once.
constexpr double kProbe = 1e-3;
// Of groups too large to be solved to the end at any price.
constexpr std::uint32_t kMostLargePieces = 4;
// Contacts that a group's work is always for, and for each of its bodies at most: overlapped heaps have
// dozens a body. How many a joint counts as.
constexpr std::size_t kLeastShares = 18, kMostSharesABody = 8, kJointShares = 6;
// Of the work of bodies alone of alike masses: with less no piece begins but the last. Pieces of a body that
// rattles cost all of it else, up to 16 of them, and nothing is left for the answer that ends the step.
constexpr double kForLastPiece = 0.9;
// Contacts beyond kFullShares count one in kFurther: large groups that move spend all that they have, step by
// step, each from the last one's impulses. Those of a group that rests count all: impulses that hold it cost
// the steps that follow nothing, and half of the work leaves it to creep and to be solved in each of them.
constexpr std::size_t kFullShares = 64, kFurther = 2;
// As much again for each further kShortStep [s] of the step, as long as kMostShortSteps at most, goes to
// groups that need it, the first ones first: a solve that is left unfinished costs more in later steps.
// Groups of bodies alone of masses up to kUnlike to 1 take as much of it as they have, for the longest steps
// are theirs; none where they are parted, or with more than kFullShares contacts: they move on whatever it
// leaves.
constexpr double kShortStep = 1e-3, kMostShortSteps = 16.0, kUnlike = 4.0;
// Masses that differ by less than 1 / kAlike are alike; beyond, each kWorkBits of their ratio take as much
// work again.
constexpr double kAlike = 0.03, kWorkBits = 4.0;
// The share of that work which few contacts of alike masses have while overlap is parted: the next step goes
// on.
constexpr double kPartedWork = 0.5;
// As much of few contacts of alike masses on which something slides that they do not follow, as a queue on a
// belt: impulses that hold it cost the steps that follow nothing. What is left unfinished creeps, as far as
// its points come and go, and is solved in each of them.
constexpr double kWaitingWork = 4.0;
// As much of many contacts that rest: what a wall's first steps left unfinished let its columns fall on each
// other by 0.3 mm and turn, so that their edges cross elsewhere in each step that follows.
constexpr double kRestingWork = 2.0;
// Joints that a joint between movers counts as, by its rows.
constexpr std::size_t kHeldShares = 3;

/// How far a group is in the step.
struct Clock {
  double left;  // [s]
  std::uint32_t pieces = 0;
  double probe = kInfinity;  // length of the last piece, if something stopped at its end
};

bool check(std::span<const Contact> contacts, const Movers& movers, StepContext& step) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& c = contacts[i];
    const bool is_good =
        movers.is_known(c.a) && movers.is_known(c.b) && touchstone::is_finite(c.p_A_W) &&
        touchstone::is_finite(c.p_B_W) && std::abs(dot(c.n_AB_W, c.n_AB_W) - 1.0) <= kRotationTolerance &&
        c.friction >= 0.0 && std::isfinite(c.friction) && c.restitution >= 0.0 && c.restitution <= 1.0 &&
        c.radius_A >= 0.0 && std::isfinite(c.radius_A) && c.radius_B >= 0.0 && std::isfinite(c.radius_B);
    if (!is_good) return step.fail(StepFailure::bad_contact, i);
  }
  return true;
}

void keep_start(GroupState& group, Movers& movers) {
  for (const std::uint32_t i : group.members.bodies) movers.bodies[i].start = movers.bodies[i].state;
  for (const std::uint32_t m : group.members.mechanisms) {
    Arm& arm = movers.arms[m];
    arm.start_q = arm.q, arm.start_qd = arm.qd, arm.start_torque = arm.torque;
  }
  for (const std::uint32_t j : group.members.joints) {
    HeldJoint& held = movers.joints[j];
    held.start_torque = held.torque;
    held.start_impulse_W = held.impulse_W, held.start_twist_W = held.twist_W;
  }
  for (GroupPoint& point : group.points) point.start_impulse_W = point.impulse_W;
}

/// To the start of the piece.
void go_back(GroupState& group, Movers& movers) {
  for (const std::uint32_t i : group.members.bodies) movers.bodies[i].state = movers.bodies[i].start;
  for (const std::uint32_t m : group.members.mechanisms) {
    Arm& arm = movers.arms[m];
    arm.q = arm.start_q, arm.qd = arm.start_qd, arm.torque = arm.start_torque;
    arm.place();
  }
  for (const std::uint32_t j : group.members.joints) {
    HeldJoint& held = movers.joints[j];
    held.torque = held.start_torque;
    held.impulse_W = held.start_impulse_W, held.twist_W = held.start_twist_W;
  }
  for (GroupPoint& point : group.points) point.impulse_W = point.start_impulse_W;
}

/// Else the step fails.
bool is_group_finite(const Group& group, const Movers& movers, StepContext& step) {
  for (const std::uint32_t i : group.bodies)
    if (!is_finite(movers.bodies[i].state)) return step.fail(StepFailure::body, i);
  for (const std::uint32_t m : group.mechanisms) {
    const Arm& arm = movers.arms[m];
    for (std::size_t k = 0; k < arm.q.size(); ++k)
      if (!std::isfinite(arm.q[k]) || !std::isfinite(arm.qd[k])) return step.fail(StepFailure::mechanism, m);
  }
  return true;
}

/// Returns the residual of these rows alone [m/s].
double solve(ContactRows& rows, StepContext& step, IslandSolver& solver) {
  const double before = step.report.worst_residual;
  step.report.worst_residual = 0.0;
  solver.solve(rows, step);
  const double residual = step.report.worst_residual;
  step.report.worst_residual = worse_of(before, residual);
  return residual;
}

/// Goes on by at most the rest of the step; returns by how much, 0 on failure.
double take_piece(Clock& clock, bool all, StepContext& step, WorldParts& world) {
  GroupState& group = world.group;
  Movers& movers = world.movers;
  ContactRows& rows = world.rows;
  const double left = clock.left, elapsed = step.h - left;
  const auto place = [&](double at) {
    movers.place_kinematics(group.kinematics, at);
    update_motions(group, movers);
  };
  // Impacts at the start.
  place(elapsed);
  refresh(movers, group);
  group.joint_speed = refresh_joints(group.members, movers);
  factor_masses(group.members, movers);
  if (needs_impact(group, movers, step)) {
    impact(group, step, movers, rows, world.solver);
    if (has_brakes(group.members, movers)) clock.probe = std::min(clock.probe, kProbe * left);
    all = all || step.is_work_over();
  }
  keep_start(group, movers);
  if (!begin_flight(group.members, step, movers)) return 0.0;
  // Try lengths until nothing stops or arrives within.
  StopSearch search{!all && clock.pieces <= kMostStops ? kStopTries : 0};
  search.is_probe = search.tries > 0 && clock.probe < left;
  double t = search.is_probe ? clock.probe : left;
  clock.probe = kInfinity;
  for (int attempt = 0;; ++attempt) {
    const bool is_last = all || attempt == kMostTries || (attempt > 0 && step.is_work_over());
    if (is_last && !all) t = left;
    // The piece is flown and solved; a stop within it may shorten it.
    if (!fly(group.members, t, step, movers)) return 0.0;
    gather({Phase::forces, t, is_last, attempt == 0 || is_last}, group, step, movers, rows);
    const std::uint32_t unconverged = step.report.unconverged, newton_steps = step.report.newton_steps;
    const TriedPiece tried{group, movers, rows, step.settings, t, solve(rows, step, world.solver)};
    const Stop stop = first_stop(tried);
    if (!is_last && !step.is_work_over() && seek_stop(tried, stop, left, t, search)) {
      const bool was_hard = step.report.newton_steps - newton_steps > kEasySteps;
      if (was_hard && step.report.unconverged == unconverged) keep_forces(tried.t, rows, group);
      continue;
    }
    if (stop.is_any) step.report.last_stop = std::fmax(step.report.last_stop, elapsed + stop.when);
    if (search.is_aimed && stop.is_any) clock.probe = t;
    // The piece is committed; an arrival within it takes it back and shortens it.
    commit(t, step, group, movers, rows);
    if (is_last) return t;
    place(elapsed + t);
    const double arrival = first_arrival(group, movers, step.settings.contact_gap, t);
    if (arrival >= t) return t;
    go_back(group, movers);
    place(elapsed);
    t = arrival;
    search.is_aimed = false;
  }
}

void finish_group(double h, WorldParts& world) {
  for (const GroupPoint& point : world.group.points) {
    world.warm.keep(point.index, *point.contact, point.p_A, {point.last_force_W, point.parting_W});
    world.forces[point.index] = {point.impulse_W / h, point.impact_W};
  }
  for (const GroupPoint& point : world.group.spare) {
    world.warm.keep(point.index, *point.contact, point.p_A, {});
    world.forces[point.index] = {Vector3::Zero(), Vector3::Zero()};
  }
  for (const std::uint32_t i : world.group.kinematics) world.movers.bodies[i].is_met = false;
}

/// Of the group's heaviest body to its lightest; 0 without bodies.
double mass_ratio(const Group& group, const Movers& movers) {
  double lightest = kInfinity, heaviest = 0.0;
  for (const std::uint32_t i : group.bodies) {
    const double mass = movers.bodies[i].body.inertia().mass;
    lightest = std::min(lightest, mass), heaviest = std::max(heaviest, mass);
  }
  return heaviest / lightest;
}

/// Larger than what ContactSolver takes.
bool is_large(const GroupState& group, const DynamicsWorld::Settings& settings) {
  return 3 * group.points.size() > settings.solver.most_path_rows;
}

/// How the group's points and velocities are taken in this step, and its work. @param spare in: of the
/// step's, beyond its own, that it may have; out: that it has
void choose_methods(const Group& members, double& spare, StepContext& step, WorldParts& world) {
  GroupState& group = world.group;
  const DynamicsWorld::Settings& settings = step.settings;
  // Where bodies overlap, the times of stops and arrivals within the step mean nothing.
  const bool are_bodies = step.is_bounded() && members.mechanisms.empty() && members.joints.empty();
  step.is_soft = are_bodies && is_deep(group, settings);
  const bool is_untimed = are_bodies && overlaps(group, settings);
  step.is_parted = is_untimed && mass_ratio(members, world.movers) <= kUnlike;
  if (step.is_soft) keep_fewest(group);
  const bool is_few = members.contacts.size() <= kFullShares;
  step.is_resting = are_bodies && !is_untimed && !is_few && rests(group, step.slow_speed(), world.movers);
  // Contradictory contacts are stopped with the forces, too: impacts before them would be solved twice.
  group.is_coarse = step.is_bounded() && (is_untimed || is_large(group, settings) ||
                                          (are_bodies && world.solver.is_contradicted(members.bodies)));
  const bool is_waiting = are_bodies && !is_untimed && is_few &&
                          mass_ratio(members, world.movers) <= kUnlike &&
                          waits(group, step.slow_speed(), settings.contact_gap / step.h, world.movers);
  const double share = is_waiting                 ? kWaitingWork
                       : step.is_resting          ? kRestingWork
                       : step.is_parted && is_few ? kPartedWork
                                                  : 1.0;
  if (step.is_parted) spare = 0.0;
  const double work = share * work_of(members, world.movers, step) + spare;
  const bool is_shared = are_bodies && !group.is_coarse && work < WorkBudget::kNoEnd;
  step.for_last_piece =
      is_shared && mass_ratio(members, world.movers) <= kUnlike ? kForLastPiece * work : 0.0;
  step.budget.grant(work);
}

/// Of bodies of alike masses: as much again, of many contacts none.
double most_spare_of(const Group& members, const Movers& movers, const StepContext& step) {
  return members.contacts.size() > kFullShares ? 0.0 : work_of(members, movers, step);
}

bool step_group(const Group& members, std::span<const Contact> contacts, StepContext& step,
                WorldParts& world) {
  GroupState& group = world.group;
  // The group gets its points, its joints and its budget of work.
  step.is_resting = false;  // the spare below is no matter of the group before
  const bool is_alike =
      members.mechanisms.empty() && members.joints.empty() && mass_ratio(members, world.movers) <= kUnlike;
  double spare = is_alike ? std::min(step.spare, most_spare_of(members, world.movers, step)) : step.spare;
  step.unconverged_before = step.report.unconverged;
  attach(members, contacts, world.warm, step, world.movers, group);
  mark_jointed(members, world.movers);
  const DynamicsWorld::Settings& settings = step.settings;
  const std::uint32_t most_pieces =
      is_large(group, settings) ? std::min(kMostLargePieces, settings.most_substeps) : settings.most_substeps;
  choose_methods(members, spare, step, world);
  // Pieces follow each other until the step is over.
  Clock clock{step.h};
  while (clock.left > 0.0) {
    ++clock.pieces;
    const bool to_the_end = group.is_coarse || clock.pieces >= most_pieces || step.is_time_for_last();
    const double t = take_piece(clock, to_the_end, step, world);
    if (step.report.failure != StepFailure::none) return false;
    clock.left = t >= clock.left ? 0.0 : clock.left - t;
  }
  if (step.budget.left() < spare) step.spare -= spare - std::max(step.budget.left(), 0.0);
  // Overlaps are parted, and the results are checked and kept.
  step.report.substeps = std::max(step.report.substeps, clock.pieces);
  part(group, step, world.movers, world.rows, world.solver);
  finish_joints(group.members, step, world.movers);
  if (!is_group_finite(group.members, world.movers, step)) return false;
  finish_group(step.h, world);
  count_stillness(group, step, world.movers);
  return true;
}

/// Bodies that touch nothing; kinematic ones to where they were commanded.
bool step_loose(StepContext& step, WorldParts& world) {
  if (!fly_loose(world.groups.loose(), step, world.movers)) return false;
  std::vector<std::uint32_t>& kinematics = world.group.kinematics;
  kinematics.clear();
  for (std::uint32_t i = 0; i < world.movers.bodies.size(); ++i)
    if (world.movers.bodies[i].is_kinematic) kinematics.push_back(i);
  world.movers.place_kinematics(kinematics, step.h);
  for (const std::uint32_t i : kinematics)
    if (!is_finite(world.movers.bodies[i].state)) return step.fail(StepFailure::body, i);
  return true;
}

/// Contacts between sleepers: as they were when they fell asleep.
void keep_sleepers_forces(std::span<const Contact> contacts, WorldParts& world) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (world.groups.is_grouped(i)) continue;
    world.warm.keep(i, contacts[i], Vector3::Zero(), world.warm.of(i));
    world.forces[i] = {world.warm.of(i).force_W, Vector3::Zero()};
  }
}

}  // namespace

double work_of(const Group& group, const Movers& movers, const StepContext& step) {
  const DynamicsWorld::Settings& settings = step.settings;
  if (settings.accuracy != DynamicsWorld::Accuracy::bounded) return WorkBudget::kNoEnd;
  std::size_t joints = kHeldShares * group.joints.size();
  for (const std::uint32_t m : group.mechanisms) joints += movers.arms[m].q.size();
  std::size_t shares = kJointShares * joints;
  const std::size_t movable = group.bodies.size() + group.mechanisms.size();
  const std::size_t contacts = std::min(group.contacts.size(), kMostSharesABody * movable);
  const std::size_t full = std::min(contacts, kFullShares);
  shares += step.is_resting ? group.contacts.size() : full + (contacts - full) / kFurther;
  // Masses that differ take more rounds.
  const int bits =
      std::ilogb(std::max(1.0, kAlike * mass_ratio(group, movers)));  // same from every C library
  return 1e3 * settings.work * (1.0 + bits / kWorkBits) * static_cast<double>(std::max(shares, kLeastShares));
}

StepReport take_step(double h, std::span<const Contact> contacts, std::span<ContactForce> forces,
                     WorldParts& world) {
  Movers& movers = world.movers;
  StepContext step{world.settings, h, {}};
  // A bad step is refused; a world in which nothing moves stays as it is.
  if (!(h > 0.0) || !std::isfinite(h)) {
    step.report.failure = StepFailure::bad_step;
    return step.report;
  }
  step.report.substeps = 1;
  const double longer = std::clamp(h / kShortStep, 1.0, kMostShortSteps) - 1.0;
  step.spare =
      longer > 0.0 ? 1e3 * world.settings.work * kLeastShares * longer : 0.0;  // work may be infinite
  if (contacts.empty() && movers.restless == 0 && movers.arms.empty()) return step.report;
  if (!check(contacts, movers, step)) return step.report;
  // Before anything moves, sleepers are woken, the state is kept and the last forces are carried over.
  wake_touched(movers, contacts);
  if (step.is_bounded()) step.budget.start(0.0, world.settings.most_microseconds);
  movers.keep();
  world.solver.keep(movers.unit_count());
  for (Arm& arm : movers.arms) std::fill(arm.torque.begin(), arm.torque.end(), 0.0);
  for (HeldJoint& joint : movers.joints)
    joint.torque = 0.0, joint.impulse_W = joint.twist_W = Vector3::Zero();
  world.warm.carry(contacts, movers);
  world.groups.find(contacts, movers);
  world.forces.resize(contacts.size());
  keep_sleepers_forces(contacts, world);
  // Groups, each by a clock of its own, then all that touches nothing.
  bool is_good = true;
  for (std::size_t g = 0; g < world.groups.groups().size() && is_good; ++g)
    is_good = step_group(world.groups.groups()[g], contacts, step, world);
  if (!is_good || !step_loose(step, world)) {
    movers.undo();
    world.warm.undo();
    world.solver.undo();
    return step.report;
  }
  // The step is accepted.
  world.warm.accept();
  movers.forget_pushes();
  std::copy_n(world.forces.begin(), std::min(forces.size(), world.forces.size()), forces.begin());
  return step.report;
}

}  // namespace touchstone::physics::stepping

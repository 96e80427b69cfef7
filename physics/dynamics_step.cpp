// A step: each group for itself, cut into pieces where something of it stops or arrives.

#include <algorithm>
#include <cmath>
#include <limits>

#include "touchstone/physics/dynamics_world.hpp"

namespace touchstone::physics {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Arrivals tried for one piece: each try lands closer by the square of what is left.
constexpr int kMostTries = 6;
// Where points stop one by one (a body that turns as it slides) their stops are many and none is sharp: this
// many pieces of a step end at one, each found in a few tries.
constexpr std::uint32_t kMostStops = 4;
constexpr int kStopTries = 2;
// Of what is left: after an impact joints move that brakes stop at once.
constexpr double kProbe = 1e-3;
// Of groups too large to be solved to the end at any price.
constexpr std::uint32_t kMostLargePieces = 4;
// Contacts that a step's work is always for; how many a joint counts as.
constexpr std::size_t kLeastShares = 12, kJointShares = 4;

}  // namespace

/// Goes on by at most what is left; returns by how much, 0 on failure.
double DynamicsWorld::piece(Clock& clock, double h, bool all, StepReport& report) {
  const double left = clock.left, elapsed = h - left;
  place_kinematics(elapsed);
  update_motions();
  refresh();
  factor_masses();
  if (needs_impact()) {
    impact(h, report);
    if (has_brakes()) clock.probe = std::min(clock.probe, kProbe * left);
  }
  keep_start();
  if (!begin_flight(report)) return 0.0;
  StopSearch search{!all && clock.pieces <= kMostStops ? kStopTries : 0};
  search.is_probe = search.tries > 0 && clock.probe < left;
  double t = search.is_probe ? clock.probe : left;
  clock.probe = kInfinity;
  for (int attempt = 0;; ++attempt) {
    const bool is_last = all || attempt == kMostTries || (attempt > 0 && is_work_over(report));
    if (is_last && !all) t = left;
    if (!fly(t, report)) return 0.0;
    gather(Phase::forces, t, is_last, attempt == 0 || is_last);
    solve(report);
    const Stop stop = first_stop(t);
    if (!is_last && !is_work_over(report) && seek_stop(stop, left, t, search)) continue;
    if (stop.is_any) report.last_stop = std::fmax(report.last_stop, elapsed + stop.when);
    if (search.is_aimed && stop.is_any) clock.probe = t;
    commit(t, h);
    if (is_last) return t;
    place_kinematics(elapsed + t);
    update_motions();
    const double arrival = first_arrival(t);
    if (arrival >= t) return t;
    go_back();
    place_kinematics(elapsed);
    t = arrival;
    search.is_aimed = false;
  }
}

void DynamicsWorld::keep_start() {
  for (const std::uint32_t i : group_.bodies) bodies_[i].start = bodies_[i].state;
  for (const std::uint32_t m : group_.mechanisms) {
    Arm& arm = mechanisms_[m];
    arm.start_q = arm.q, arm.start_qd = arm.qd, arm.start_torque = arm.torque;
  }
  for (Point& point : points_) point.start_impulse_W = point.impulse_W;
}

/// To the start of the piece.
void DynamicsWorld::go_back() {
  for (const std::uint32_t i : group_.bodies) bodies_[i].state = bodies_[i].start;
  for (const std::uint32_t m : group_.mechanisms) {
    Arm& arm = mechanisms_[m];
    arm.q = arm.start_q, arm.qd = arm.start_qd, arm.torque = arm.start_torque;
    arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
  }
  for (Point& point : points_) point.impulse_W = point.start_impulse_W;
}

/// What undo() goes back to.
void DynamicsWorld::keep() {
  for (Body& body : bodies_) body.kept = body.state;
  for (Arm& arm : mechanisms_) {
    arm.kept_q = arm.q, arm.kept_qd = arm.qd;
    arm.kept_torque = arm.torque, arm.kept_last_torque = arm.last_torque;
  }
  kept_patience_.reserve(bodies_.size() + mechanisms_.size());
  kept_patience_ = patience_;
  contradicted_.resize(bodies_.size() + mechanisms_.size(), 0);
  kept_contradicted_ = contradicted_;
}

/// To the start of the step, everything.
void DynamicsWorld::undo() {
  for (Body& body : bodies_) body.state = body.kept, body.is_met = false;
  for (Arm& arm : mechanisms_) {
    arm.q = arm.kept_q, arm.qd = arm.kept_qd;
    arm.torque = arm.kept_torque, arm.last_torque = arm.kept_last_torque;
    arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
  }
  for (Warm& warm : warm_) warm.is_taken = false;
  patience_ = kept_patience_;
  contradicted_ = kept_contradicted_;
}

/// Says why, and of which contact, body or mechanism. Returns false.
bool DynamicsWorld::fail(StepFailure failure, std::size_t index, StepReport& report) {
  report.failure = failure;
  report.failed_index = static_cast<std::uint32_t>(index);
  return false;
}

/// Else says whose state is not.
bool DynamicsWorld::is_group_finite(StepReport& report) const {
  for (const std::uint32_t i : group_.bodies)
    if (!is_finite(bodies_[i].state)) return fail(StepFailure::body, i, report);
  for (const std::uint32_t m : group_.mechanisms) {
    const Arm& arm = mechanisms_[m];
    for (std::size_t k = 0; k < arm.q.size(); ++k)
      if (!std::isfinite(arm.q[k]) || !std::isfinite(arm.qd[k]))
        return fail(StepFailure::mechanism, m, report);
  }
  return true;
}

bool DynamicsWorld::step_group(double h, std::span<const Contact> contacts, StepReport& report) {
  attach(contacts);
  const bool is_large = 3 * points_.size() > settings_.solver.most_path_rows;
  is_coarse_ = is_large && settings_.accuracy == Accuracy::bounded;
  const std::uint32_t most_pieces =
      is_large ? std::min(kMostLargePieces, settings_.most_substeps) : settings_.most_substeps;
  Clock clock{h};
  while (clock.left > 0.0) {
    ++clock.pieces;
    const bool to_the_end = is_coarse_ || clock.pieces >= most_pieces || is_work_over(report);
    const double t = piece(clock, h, to_the_end, report);
    if (report.failure != StepFailure::none) return false;
    clock.left = t >= clock.left ? 0.0 : clock.left - t;
  }
  report.substeps = std::max(report.substeps, clock.pieces);
  part(h, report);
  if (!is_group_finite(report)) return false;
  finish(h);
  count_stillness(h);
  return true;
}

/// From now on, for so many contacts.
WorkBudget DynamicsWorld::budget_of(std::size_t contacts) const {
  WorkBudget budget;
  std::size_t joints = 0;
  for (const Arm& arm : mechanisms_) joints += arm.q.size();
  const auto shares = static_cast<double>(std::max(contacts + kJointShares * joints, kLeastShares));
  if (settings_.accuracy == Accuracy::bounded)
    budget.start(1e3 * settings_.work * shares, settings_.most_microseconds);
  return budget;
}

/// Or contacts contradict each other: pieces and tries would not find more.
bool DynamicsWorld::is_work_over(const StepReport& report) const {
  return settings_.accuracy == Accuracy::bounded && (report.contradictory > 0 || budget_.is_spent());
}

/// Bodies that touch nothing; kinematic ones to where they were told.
bool DynamicsWorld::step_loose(double h, StepReport& report) {
  for (const std::uint32_t i : loose_)
    if (!fly_body(bodies_[i], bodies_[i].state, h)) return fail_flight(bodies_[i], h, i, report);
  kinematics_.clear();
  for (std::uint32_t i = 0; i < bodies_.size(); ++i)
    if (bodies_[i].is_kinematic) kinematics_.push_back(i);
  place_kinematics(h);
  for (const std::uint32_t i : kinematics_)
    if (!is_finite(bodies_[i].state)) return fail(StepFailure::body, i, report);
  return true;
}

StepReport DynamicsWorld::step(double h, std::span<const Contact> contacts, std::span<ContactForce> forces) {
  StepReport report;
  if (!(h > 0.0) || !std::isfinite(h)) {
    report.failure = StepFailure::bad_step;
    return report;
  }
  report.substeps = 1;
  if (contacts.empty() && is_at_rest()) return report;
  if (!check(contacts, report)) return report;
  wake_touched(contacts);
  h_ = h;
  budget_ = budget_of(contacts.size());
  keep();
  for (Arm& arm : mechanisms_) std::fill(arm.torque.begin(), arm.torque.end(), 0.0);
  carry_forces(contacts);
  find_groups(contacts);
  next_warm_.resize(contacts.size());
  forces_.resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (group_of_contact_[i] == kNone) {
      // Between sleepers: as it was when they fell asleep.
      const Contact& contact = contacts[i];
      next_warm_[i] = {contact.key, contact.a, contact.b, Vector3::Zero(), carried_[i].force_W, false};
      forces_[i] = {carried_[i].force_W, Vector3::Zero()};
    }
  bool is_good = true;
  for (std::size_t g = 0; g < groups_.size() && is_good; ++g) {
    group_ = groups_[g];
    is_good = step_group(h, contacts, report);
  }
  if (!is_good || !step_loose(h, report)) {
    undo();
    return report;
  }
  warm_.swap(next_warm_);
  forget_pushes();
  std::copy_n(forces_.begin(), std::min(forces.size(), forces_.size()), forces.begin());
  return report;
}

void DynamicsWorld::finish(double h) {
  for (const Point& point : points_) {
    const Contact& contact = *point.contact;
    next_warm_[point.index] = {contact.key, contact.a, contact.b, point.p_A, point.last_force_W, false};
    forces_[point.index] = {point.impulse_W / h, point.impact_W};
  }
  for (const std::uint32_t i : kinematics_) bodies_[i].is_met = false;
}

}  // namespace touchstone::physics

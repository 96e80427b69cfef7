// A step, cut into pieces where something stops or arrives.

#include <algorithm>

#include "physics/dynamics_world.hpp"

namespace touchstone::physics {
namespace {

// A piece of a step that is this close to its whole is the whole.
constexpr double kWhole = 1.0 - 1e-6;
// Arrivals tried for one piece: each try lands closer by the square of what is left.
constexpr int kMostTries = 6;
// Where points stop one by one (a body that turns as it slides) their stops are many and none is sharp: this
// many pieces of a step end at one, each found in at most two tries.
constexpr std::uint32_t kMostStops = 4;
constexpr int kStopTries = 2;

}  // namespace

/// Goes on by at most `left`; returns by how much, 0 on failure.
double DynamicsWorld::piece(double left, double h, bool all, StepReport& report) {
  refresh();
  factor_masses();
  if (needs_impact()) impact(h, report);
  for (Body& body : bodies_) body.start = body.state;
  for (Arm& arm : mechanisms_) arm.start_q = arm.q, arm.start_qd = arm.qd;
  for (Point& point : points_) {
    point.start_separation = point.separation;
    point.start_speed = dot(point.contact.n_AB_W, relative_velocity(point));
    point.start_impulse_W = point.impulse_W;
  }
  for (Arm& arm : mechanisms_) arm.start_torque = arm.torque;
  double t = left;
  int stop_tries = 0;
  for (int attempt = 0;; ++attempt) {
    const bool is_last = all || attempt == kMostTries;
    if (!fly(t, report)) return 0.0;
    gather(Phase::forces, t, is_last);
    solve(report);
    bool stops = false;
    const double stop = first_stop(t, stops);
    if (!is_last && stop < kWhole * t && report.substeps <= kMostStops && stop_tries < kStopTries) {
      ++stop_tries;
      t = stop;
      continue;
    }
    if (stops) report.last_stop = (h - left) + t;
    commit(t, h);
    if (is_last) return t;
    refresh();
    const double arrival = first_arrival(t);
    if (arrival >= t) return t;
    go_back();
    t = arrival;
  }
}

StepReport DynamicsWorld::step(double h, std::span<const Contact> contacts, std::span<ContactForce> forces) {
  StepReport report;
  if (!check(contacts, report)) return report;
  for (Body& body : bodies_) body.kept = body.state;
  for (Arm& arm : mechanisms_) {
    arm.kept_q = arm.q, arm.kept_qd = arm.qd;
    std::fill(arm.torque.begin(), arm.torque.end(), 0.0);
  }
  attach(contacts);
  double left = h;
  while (left > 0.0) {
    ++report.substeps;
    const double t = piece(left, h, report.substeps >= settings_.most_substeps, report);
    if (report.failure != StepFailure::none) {
      for (Body& body : bodies_) body.state = body.kept;
      for (Arm& arm : mechanisms_) {
        arm.q = arm.kept_q, arm.qd = arm.kept_qd;
        arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
      }
      return report;
    }
    left = t >= left ? 0.0 : left - t;
  }
  finish(h, forces);
  return report;
}

void DynamicsWorld::finish(double h, std::span<ContactForce> forces) {
  warm_.clear();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    warm_.push_back(
        {point.contact.key, point.contact.a, point.contact.b, point.p_A, point.last_force_W, false});
    if (i < forces.size()) forces[i] = {point.impulse_W / h, point.impact_W};
  }
}

}  // namespace touchstone::physics

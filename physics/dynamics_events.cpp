// When within a piece something stops or arrives.

#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/dynamics_world.hpp"

namespace touchstone::physics {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

/// When sliding first ends or a joint first gets to its drive's rate: forces are at their limits until then,
/// so velocities change evenly, and what the rest of the piece took beside what it could have taken says
/// when. Not at once: where friction took nothing, something else ends the sliding, with the piece.
double DynamicsWorld::first_stop(double t, bool& stops) const {
  const double rest = 10.0 * settings_.solver.tolerance;
  double friction = 0.0, most = 0.0;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const Point& point = points_[active_[i]];
    const double slide = std::max(std::abs(dot(point.v_W, point.t1_W)), std::abs(dot(point.v_W, point.t2_W)));
    if (slide <= rest) continue;
    const double* const x = &x_[3 * i];
    const double used = std::sqrt(x[1] * x[1] + x[2] * x[2]), cone = friction_[i] * x[0];
    const bool sticks = std::max(std::abs(u_[3 * i + 1]), std::abs(u_[3 * i + 2])) <= rest;
    if (!sticks || !(cone > 0.0)) continue;
    stops = true;
    friction += used;
    most += cone;
  }
  double first = friction > 0.0 ? std::min(1.0, friction / most) : 1.0;
  for (std::size_t j = 0; j < joint_rows_.size(); ++j) {
    const JointRow& row = joint_rows_[j];
    const std::size_t r = 3 * active_.size() + j;
    if (row.is_stop || !(bounds_[j].upper > 0.0) || bounds_[j].upper == kInfinity) continue;
    const JointDrive& drive = mechanisms_[row.mechanism].drives[row.value];
    const double target = drive.mode == JointDrive::Mode::rate ? drive.rate : 0.0;
    const double before = mechanisms_[row.mechanism].qd[row.value] - target;
    if (std::abs(before) <= rest || std::abs(u_[r]) > rest) continue;
    stops = true;
    // With its drive at the limit all the way the joint would have gone on to another rate.
    const double w = Y_[row.first + row.value], most_x = std::copysign(bounds_[j].upper, -before);
    first = std::min(first, before / (before - (u_[r] + w * (most_x - x_[r]))));
  }
  const double stop = first * t;
  return stop > 0.0 ? stop : t;
}

/// When, in the piece just taken, a point or stop that was apart first came together: on the parabola through
/// its distance and speed before and its distance now. `t` or more: none did.
double DynamicsWorld::first_arrival(double t) const {
  double first = kInfinity;
  const auto arrive = [&](double room, double speed, double room_now) {
    if (room <= settings_.contact_gap || room_now >= -settings_.contact_gap) return;
    const double curve = (room_now - room) / t - speed;  // room + speed s + curve s^2 / t
    const double root = std::sqrt(std::max(0.0, speed * speed - 4.0 * room * curve / t));
    // The first positive root, in the form that does not cancel.
    const double when = 2.0 * room / (root - speed);
    first = std::min(first, when > 0.0 ? std::min(when, t) : t);
  };
  for (const Point& point : points_)
    if (point.separation > settings_.contact_gap)
      arrive(point.separation, point.approach_v, separation_now(point));
  for (const std::uint32_t m : group_.mechanisms) {
    const Arm& arm = mechanisms_[m];
    for (const Mechanism::Joint& joint : arm.dynamics->mechanism().joints()) {
      const std::uint32_t i = joint.value;
      if (i == Mechanism::kNone) continue;
      arrive(arm.start_q[i] - joint.lower, arm.start_qd[i], arm.q[i] - joint.lower);
      arrive(joint.upper - arm.start_q[i], -arm.start_qd[i], joint.upper - arm.q[i]);
    }
  }
  return first;
}

}  // namespace touchstone::physics

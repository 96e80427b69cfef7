// When within a piece something stops or arrives.

#include <algorithm>
#include <cmath>
#include <limits>

#include "touchstone/physics/dynamics_world.hpp"

namespace touchstone::physics {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A piece of a step that is this close to its whole is the whole.
constexpr double kWhole = 1.0 - 1e-6;
// Of the contact gap, the finest way there is: what is off by no more than this share is where it should be.
constexpr double kMostMissed = 1e-3;
// All but a first aim goes beyond the stop, by this share of the correction at most, so that the stop is
// within the piece.
constexpr double kBeyond = 1e-3;
// A stop that was aimed at and missed by less than this is aimed at again.
constexpr double kNear = 1.05;
// Of the speed: what is still moved across where a straight slide has stopped.
constexpr double kStraight = 1e-3;

}  // namespace

/// When sliding first ends or a joint first gets to its drive's rate: forces are at their limits until then,
/// so velocities change evenly, and what the rest of the piece took beside what it could have taken says
/// when. Until the end, what has stopped went on at half its speed on the mean. Not at once: where friction
/// took nothing, something else ends the sliding, with the piece.
DynamicsWorld::Stop DynamicsWorld::first_stop(double t) const {
  const double rest = 10.0 * settings_.solver.tolerance;
  Stop stop{false, t};
  double friction = 0.0, most = 0.0;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const Point& point = points_[active_[i]];
    const double slide = std::max(std::abs(dot(point.v_W, point.t1_W)), std::abs(dot(point.v_W, point.t2_W)));
    if (slide <= rest) continue;
    const double* const x = &x_[3 * i];
    const double used = std::sqrt(x[1] * x[1] + x[2] * x[2]), cone = friction_[i] * x[0];
    const bool sticks = std::max(std::abs(u_[3 * i + 1]), std::abs(u_[3 * i + 2])) <= rest;
    if (!sticks || !(cone > 0.0)) continue;
    stop.speed = std::max(stop.speed, slide);
    friction += used;
    most += cone;
  }
  const auto add = [&](double share, double speed) {
    const double when = std::min(1.0, share) * t;
    if (!(when > 0.0)) return;
    stop.is_any = true;
    stop.when = std::min(stop.when, when);
    stop.speed = std::max(stop.speed, speed);
    stop.missed = std::max(stop.missed, 0.5 * (speed * (t - when)));
  };
  if (friction > 0.0) add(friction / most, stop.speed);
  for (std::size_t j = 0; j < joint_rows_.size(); ++j) {
    if (!can_stop(j)) continue;
    const double before = rate_before(joint_rows_[j]);
    const std::size_t r = 3 * active_.size() + j;
    if (std::abs(before) <= rest || std::abs(u_[r]) > rest) continue;
    // With its drive at the limit all the way the joint would have gone on to another rate.
    const JointRow& row = joint_rows_[j];
    const double w = Y_[row.first + row.value], most_x = std::copysign(bounds_[j].upper, -before);
    add(before / (before - (u_[r] + w * (most_x - x_[r]))), std::abs(before));
  }
  return stop;
}

/// Or drives that follow a rate, with limited torque.
bool DynamicsWorld::has_brakes() const {
  for (const std::uint32_t m : group_.mechanisms)
    for (const JointDrive& drive : mechanisms_[m].drives)
      if (drive.mode != JointDrive::Mode::torque && drive.limit < kInfinity) return true;
  return false;
}

/// A drive that may be overcome.
bool DynamicsWorld::can_stop(std::size_t joint_row) const {
  return !joint_rows_[joint_row].is_stop && bounds_[joint_row].upper > 0.0 &&
         bounds_[joint_row].upper < kInfinity;
}

/// At the start of the piece, beside what it should be.
double DynamicsWorld::rate_before(const JointRow& row) const {
  const Arm& arm = mechanisms_[row.mechanism];
  const JointDrive& drive = arm.drives[row.value];
  return arm.qd[row.value] - (drive.mode == JointDrive::Mode::rate ? drive.rate : 0.0);
}

/// The first stop after a piece in which there was none, if velocities go on changing as they did in it.
DynamicsWorld::Stop DynamicsWorld::coming_stop(double t, double left) const {
  const double rest = 10.0 * settings_.solver.tolerance;
  Stop stop{false, left};
  const auto add = [&](double when, double speed) {
    if (when > t && when < stop.when) stop = {true, when, speed};
  };
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const Point& point = points_[active_[i]];
    const double v1 = dot(point.v_W, point.t1_W), v2 = dot(point.v_W, point.t2_W);
    const double d1 = u_[3 * i + 1] - v1, d2 = u_[3 * i + 2] - v2, squared = d1 * d1 + d2 * d2;
    const double speed = std::sqrt(v1 * v1 + v2 * v2);
    if (speed > rest && std::abs(v1 * d2 - v2 * d1) <= kStraight * (speed * std::sqrt(squared)))
      add(t * (-(v1 * d1 + v2 * d2) / squared), speed);
  }
  for (std::size_t j = 0; j < joint_rows_.size(); ++j) {
    if (!can_stop(j)) continue;
    const double before = rate_before(joint_rows_[j]);
    if (std::abs(before) > rest) add(t * (before / (before - u_[3 * active_.size() + j])), std::abs(before));
  }
  return stop;
}

/// Where the piece should end to be cut at a stop, after it was tried to t. @return whether it should not end
/// at t.
bool DynamicsWorld::seek_stop(const Stop& stop, double left, double& t, StopSearch& search) const {
  if (search.tries == 0) return false;
  const double most = kMostMissed * settings_.contact_gap;
  const bool is_probe = search.is_probe, is_aimed = search.is_aimed;
  const auto aim = [&](const Stop& at) {
    --search.tries;
    const double beyond =
        is_probe || is_aimed ? std::min(kBeyond * std::abs(at.when - t), most / at.speed) : 0.0;
    t = std::min(at.when + beyond, left);
    search.is_aimed = true;
    return true;
  };
  search.is_probe = false;
  if (stop.is_any) return stop.missed > most && stop.when < kWhole * t && aim(stop);
  if (!is_probe && !is_aimed) return false;
  const Stop coming = coming_stop(t, left);
  if (coming.is_any && (is_probe || coming.when <= kNear * t)) return aim(coming);
  if (is_probe) t = left;
  return is_probe;
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

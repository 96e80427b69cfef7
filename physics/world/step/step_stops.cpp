#include "touchstone/physics/world/step/step_stops.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/physics/world/rows/held_joints.hpp"

namespace touchstone::physics::stepping {
namespace {

// A piece of a step that is this close to its whole is the whole.
constexpr double kWhole = 1.0 - 1e-6;
// Of the contact gap, the shortest distance there is: a place that is off by no more than this share is
// right.
constexpr double kMostMissed = 1e-3;
// The same where a step's work is bounded: what residuals there may move things by in a step. The stops of
// what turns as it slides come half as near with each try, and each try is a whole solve.
constexpr double kMostMissedBounded = 0.1;
// All but a first aim goes beyond the stop, by this share of the correction at most, so that the stop is
// within the piece.
constexpr double kBeyond = 1e-3;
// A stop that was aimed at and missed by less than this is aimed at again.
constexpr double kNear = 1.05;
// Of the speed: the speed across that is left where a straight slide has stopped.
constexpr double kStraight = 1e-3;

double speed_at_rest(const TriedPiece& piece) { return 10.0 * piece.settings.solver.tolerance; }

const GroupPoint& point_of(const TriedPiece& piece, std::size_t contact) {
  return piece.group.points[piece.rows.contacts[contact].point];
}

/// Friction of contacts that slid before the piece and stick after it.
struct Stopped {
  double used = 0.0, most = 0.0;  // impulses, and those that friction could have taken [N s]
  double speed = 0.0;             // of the fastest before [m/s]
};

Stopped stopped_slides(const TriedPiece& piece) {
  const double rest = speed_at_rest(piece);
  const ContactRows& rows = piece.rows;
  Stopped stopped;
  for (std::size_t i = 0; i < rows.contacts.size(); ++i) {
    const GroupPoint& point = point_of(piece, i);
    const double slide = std::max(std::abs(dot(point.v_W, point.t1_W)), std::abs(dot(point.v_W, point.t2_W)));
    if (slide <= rest) continue;
    const double* const x = &rows.x[3 * i];
    const double used = std::sqrt(x[1] * x[1] + x[2] * x[2]), cone = rows.friction[i] * x[0];
    const bool sticks = std::max(std::abs(rows.u[3 * i + 1]), std::abs(rows.u[3 * i + 2])) <= rest;
    if (!sticks || !(cone > 0.0)) continue;
    stopped.speed = std::max(stopped.speed, slide);
    stopped.used += used;
    stopped.most += cone;
  }
  return stopped;
}

/// The first stop after a piece in which there was none, if velocities go on changing as they did in it.
Stop coming_stop(const TriedPiece& piece, double left) {
  const double rest = speed_at_rest(piece), t = piece.t;
  const ContactRows& rows = piece.rows;
  Stop stop{false, left};
  const auto add = [&](double when, double speed) {
    if (when > t && when < stop.when) stop = {true, when, speed};
  };
  for (std::size_t i = 0; i < rows.contacts.size(); ++i) {
    const GroupPoint& point = point_of(piece, i);
    const double v1 = dot(point.v_W, point.t1_W), v2 = dot(point.v_W, point.t2_W);
    const double d1 = rows.u[3 * i + 1] - v1, d2 = rows.u[3 * i + 2] - v2, squared = d1 * d1 + d2 * d2;
    const double speed = std::sqrt(v1 * v1 + v2 * v2);
    if (speed > rest && std::abs(v1 * d2 - v2 * d1) <= kStraight * (speed * std::sqrt(squared)))
      add(t * (-(v1 * d1 + v2 * d2) / squared), speed);
  }
  for (std::size_t j = 0; j < rows.joints.size(); ++j) {
    if (!rows.joints[j].stops) continue;
    const double before = rows.joints[j].before;
    if (std::abs(before) > rest)
      add(t * (before / (before - rows.u[3 * rows.contacts.size() + j])), std::abs(before));
  }
  return stop;
}

}  // namespace

/// Forces are at their limits until the stop, so velocities change evenly, and the ratio of the impulse taken
/// to the limit over the piece gives the time. Until the end, a stopped point went on at half its speed on
/// the mean. Not at once: where friction took nothing, something else ends the sliding, with the piece.
Stop first_stop(const TriedPiece& piece) {
  const double rest = speed_at_rest(piece), t = piece.t;
  const ContactRows& rows = piece.rows;
  const Stopped slides = stopped_slides(piece);
  Stop stop{false, t};
  stop.speed = slides.speed;
  // A stop counts by its time, its speed and the travel missed after it.
  const auto add = [&](double share, double speed) {
    const double when = std::min(1.0, share) * t;
    if (!(when > 0.0)) return;
    stop.is_any = true;
    stop.when = std::min(stop.when, when);
    stop.speed = std::max(stop.speed, speed);
    stop.missed = std::max(stop.missed, 0.5 * (speed * (t - when)));
  };
  // Slides stop together, joint rows one by one.
  if (slides.used > 0.0) add(slides.used / slides.most, slides.speed);
  for (std::size_t j = 0; j < rows.joints.size(); ++j) {
    if (!rows.joints[j].stops) continue;
    const ContactRows::Joint& row = rows.joints[j];
    const double before = row.before;
    const std::size_t r = 3 * rows.contacts.size() + j;
    if (std::abs(before) <= rest || std::abs(rows.u[r]) > rest) continue;
    // With its drive at the limit throughout, the joint would have gone on to another rate.
    const double w = rows.own_entry(j), most_x = std::copysign(rows.bounds[j].upper, -before);
    add(before / (before - (rows.u[r] + w * (most_x - rows.x[r]))), std::abs(before));
  }
  return stop;
}

bool has_brakes(const Group& group, const Movers& movers) {
  using Mode = JointDrive::Mode;
  for (const std::uint32_t m : group.mechanisms) {
    for (const JointDrive& drive : movers.arms[m].drives)
      if ((drive.mode == Mode::rate || drive.mode == Mode::brake) && drive.limit < kInfinity) return true;
    for (const JointLosses& losses : movers.arms[m].losses)
      if (losses.friction > 0.0) return true;
  }
  for (const std::uint32_t j : group.joints) {
    const WorldJoint& joint = movers.joints[j].joint;
    const bool is_followed = joint.drive.mode == Mode::rate || joint.drive.mode == Mode::brake;
    if ((is_followed && joint.drive.limit < kInfinity) || joint.losses.friction > 0.0) return true;
  }
  return false;
}

bool seek_stop(const TriedPiece& piece, const Stop& stop, double left, double& t, StopSearch& search) {
  if (search.tries == 0) return false;
  // No finer than velocities are known: a rate that a solve left off by as little is not reached anew.
  const double gap = piece.settings.contact_gap;
  const double left_open =
      piece.residual > speed_at_rest(piece) ? std::min(piece.residual * piece.t, gap) : 0.0;
  const double most = std::max(kMostMissed * gap, left_open);
  const bool is_bounded = piece.settings.accuracy == DynamicsWorld::Accuracy::bounded;
  const double enough = is_bounded ? std::max(most, kMostMissedBounded * gap) : most;
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
  if (stop.is_any) return stop.missed > enough && stop.when < kWhole * t && aim(stop);
  if (!is_probe && !is_aimed) return false;
  const Stop coming = coming_stop(piece, left);
  if (coming.is_any && (is_probe || coming.when <= kNear * t)) return aim(coming);
  if (is_probe) t = left;
  return is_probe;
}

double first_arrival(const GroupState& group, const Movers& movers, double gap, double t) {
  double first = kInfinity;
  // A parabola through both ends of the piece says when the room is used up.
  const auto arrive = [&](double room, double speed, double room_now) {
    if (room <= gap || room_now >= -gap) return;
    const double curve = (room_now - room) / t - speed;  // room + speed s + curve s^2 / t
    const double root = std::sqrt(std::max(0.0, speed * speed - 4.0 * room * curve / t));
    // The first positive root, in the form that does not cancel.
    const double when = 2.0 * room / (root - speed);
    first = std::min(first, when > 0.0 ? std::min(when, t) : t);
  };
  // Contact points close their separation.
  for (const GroupPoint& point : group.points)
    if (point.separation > gap) arrive(point.separation, point.approach_v, separation_now(point, movers));
  // Joints of mechanisms reach their limits.
  for (const std::uint32_t m : group.members.mechanisms) {
    const Arm& arm = movers.arms[m];
    for (const Mechanism::Joint& joint : arm.dynamics->mechanism().joints()) {
      const std::uint32_t i = joint.value;
      if (i == Mechanism::kNone) continue;
      arrive(arm.start_q[i] - joint.lower, arm.start_qd[i], arm.q[i] - joint.lower);
      arrive(joint.upper - arm.start_q[i], -arm.start_qd[i], joint.upper - arm.q[i]);
    }
  }
  // So do joints between movers.
  for (const std::uint32_t j : group.members.joints) {
    const HeldJoint& held = movers.joints[j];
    const WorldJoint& joint = held.joint;
    if (!joint.joint.has_axis() || (std::isinf(joint.lower) && std::isinf(joint.upper))) continue;
    const double now = value_now(held, movers);
    arrive(held.value - joint.lower, held.rate, now - joint.lower);
    arrive(joint.upper - held.value, -held.rate, joint.upper - now);
  }
  return first;
}

}  // namespace touchstone::physics::stepping

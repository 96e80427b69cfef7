// The contact points of a step: what they had in the last one, and where they are now.

#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/dynamics_world.hpp"

namespace touchstone::physics {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Two directions at right angles to n and each other.
void tangents(const Vector3& n, Vector3& t1, Vector3& t2) {
  int least = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(n[i]) < std::abs(n[least])) least = i;
  t1 = cross(n, Vector3(Vector3::Unit(least)));
  t1 = t1 / norm(t1);
  t2 = cross(n, t1);
}

/// Contacts mostly come in the same order: what one had in the last step is looked for a little way on from
/// where the one before was found, so that many of them do not cost their square.
constexpr std::size_t kReach = 64;

}  // namespace

bool DynamicsWorld::is_known(const Mover& mover) const {
  if (mover.kind == Mover::Kind::body) return mover.index < bodies_.size();
  if (mover.kind == Mover::Kind::link)
    return mover.index < mechanisms_.size() &&
           mover.link < mechanisms_[mover.index].dynamics->mechanism().links().size();
  return true;
}

bool DynamicsWorld::check(std::span<const Contact> contacts, StepReport& report) const {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& c = contacts[i];
    const bool is_good = is_known(c.a) && is_known(c.b) && touchstone::is_finite(c.p_A_W) &&
                         touchstone::is_finite(c.p_B_W) &&
                         std::abs(dot(c.n_AB_W, c.n_AB_W) - 1.0) <= kRotationTolerance && c.friction >= 0.0 &&
                         std::isfinite(c.friction) && c.restitution >= 0.0 && c.restitution <= 1.0;
    if (is_good) continue;
    report.failure = StepFailure::bad_contact;
    report.failed_index = static_cast<std::uint32_t>(i);
    return false;
  }
  return true;
}

void DynamicsWorld::attach(std::span<const Contact> contacts) {
  points_.clear();
  std::size_t next = 0;
  for (const Contact& contact : contacts) {
    Point& point = points_.emplace_back();
    point.contact = contact;
    point.p_A = touchstone::transform(inverse(mover_pose(contact.a)), contact.p_A_W);
    point.p_B = touchstone::transform(inverse(mover_pose(contact.b)), contact.p_B_W);
    tangents(contact.n_AB_W, point.t1_W, point.t2_W);
    point.impulse_W = point.impact_W = Vector3::Zero();
    point.is_new = !take_by_key(point, next);
  }
  next = 0;
  for (Point& point : points_) take_nearest(point, next);
}

/// What the contact of this name had in the last step, if there was one.
bool DynamicsWorld::take_by_key(Point& point, std::size_t& next) {
  point.last_force_W = Vector3::Zero();
  if (point.contact.key == 0) return false;
  for (std::size_t i = 0; i < std::min(kReach, warm_.size()); ++i) {
    Warm& warm = warm_[(next + i) % warm_.size()];
    if (warm.key != point.contact.key) continue;
    next = (next + i + 1) % warm_.size();
    point.last_force_W = warm.force_W;
    warm.is_taken = true;
    return true;
  }
  return false;
}

/// Where corners lie on edges, a point's feature is named one way or another as rounding will have it: a
/// point of a new name goes on with what the nearest of the same movers' points had whose name is gone.
void DynamicsWorld::take_nearest(Point& point, std::size_t& next) {
  const auto is_pair = [&](const Warm& warm) {
    return warm.a == point.contact.a && warm.b == point.contact.b;
  };
  if (point.contact.key == 0) return;
  const std::size_t reach = std::min(kReach, warm_.size());
  Warm* nearest = nullptr;
  double least = kInfinity;
  for (std::size_t i = 0; i < reach; ++i) {
    const std::size_t at = (next + i) % warm_.size();
    if (!is_pair(warm_[at])) {
      if (nearest != nullptr) break;
      continue;
    }
    if (!point.is_new) {
      next = at;  // the first of this pair's
      return;
    }
    const double distance = norm(warm_[at].p_A - point.p_A);
    if (!warm_[at].is_taken && distance < least) least = distance, nearest = &warm_[at];
  }
  if (nearest == nullptr) return;
  point.last_force_W = nearest->force_W;
  nearest->is_taken = true;
}

/// Where the points are now, the normal kept as it was.
void DynamicsWorld::refresh() {
  for (Point& point : points_) {
    const Vector3 p_A = touchstone::transform(mover_pose(point.contact.a), point.p_A);
    const Vector3 p_B = touchstone::transform(mover_pose(point.contact.b), point.p_B);
    point.separation = dot(point.contact.n_AB_W, p_B - p_A);
    point.p_W = 0.5 * (p_A + p_B);
  }
}

}  // namespace touchstone::physics

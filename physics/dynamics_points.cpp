// The contact points of a step: what they had in the last one, and where they are now.

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/dynamics_world.hpp"

namespace touchstone::physics {
namespace {

/// Two directions at right angles to n and each other.
void tangents(const Vector3& n, Vector3& t1, Vector3& t2) {
  int least = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(n[i]) < std::abs(n[least])) least = i;
  t1 = cross(n, Vector3(Vector3::Unit(least)));
  t1 = t1 / norm(t1);
  t2 = cross(n, t1);
}

Vector3 transform_back(const Pose& X_WA, const Vector3& p_W) { return rotate_back(X_WA.R, p_W - X_WA.p); }

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
    if (!is_good) return fail(StepFailure::bad_contact, i, report);
  }
  return true;
}

/// What each contact had in the last step.
void DynamicsWorld::carry_forces(std::span<const Contact> contacts) {
  carried_.resize(contacts.size());
  std::size_t next = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) take_by_key(contacts[i], carried_[i], next);
  if (std::all_of(warm_.begin(), warm_.end(), [](const Warm& warm) { return warm.is_taken; })) return;
  next = 0;
  for (std::size_t i = 0, end = 0; i < contacts.size(); i = end) {
    while (end < contacts.size() && contacts[end].a == contacts[i].a && contacts[end].b == contacts[i].b)
      ++end;
    pass_on(contacts.subspan(i, end - i), std::span(carried_).subspan(i, end - i), next);
  }
}

/// What the contact of this name had, if there was one.
void DynamicsWorld::take_by_key(const Contact& contact, Carried& carried, std::size_t& next) {
  carried.force_W = Vector3::Zero();
  if (contact.key == 0) return;
  std::size_t at = next;
  for (std::size_t i = std::min(kReach, warm_.size()); i-- > 0;) {
    Warm& warm = warm_[at];
    if (++at == warm_.size()) at = 0;
    if (warm.key != contact.key) continue;
    next = at;
    carried.force_W = warm.force_W;
    warm.is_taken = true;
    return;
  }
}

/// Where corners lie on edges, a point's feature is named one way or another as rounding will have it, and
/// points come and go in the middle of edges: what a pair's points had whose names are gone goes to the
/// points nearest to them, so that the pair is held as it was. @param contacts all of a pair. @param next
/// where the pairs before it were found.
void DynamicsWorld::pass_on(std::span<const Contact> contacts, std::span<Carried> carried,
                            std::size_t& next) {
  const Contact& first = contacts.front();
  if (first.key == 0) return;
  const auto is_pair = [&](const Warm& warm) { return warm.a == first.a && warm.b == first.b; };
  const std::size_t reach = std::min(kReach, warm_.size());
  std::size_t skipped = 0;
  while (skipped < reach && !is_pair(warm_[(next + skipped) % warm_.size()])) ++skipped;
  if (skipped == reach) return;
  next = (next + skipped) % warm_.size();
  bool is_placed = false;
  for (std::size_t i = 0; i < warm_.size(); ++i) {
    Warm& warm = warm_[(next + i) % warm_.size()];
    if (!is_pair(warm)) return;
    if (warm.is_taken) continue;
    if (!is_placed) {
      const Pose X_WA = first.a.kind == Mover::Kind::body ? pose(first.a.index) : mover_pose(first.a);
      for (std::size_t k = 0; k < contacts.size(); ++k)
        carried[k].p_A = transform_back(X_WA, contacts[k].p_A_W);
      is_placed = true;
    }
    Carried* nearest = &carried.front();
    for (Carried& other : carried)
      if (norm(warm.p_A - other.p_A) < norm(warm.p_A - nearest->p_A)) nearest = &other;
    nearest->force_W += warm.force_W;
    warm.is_taken = true;
  }
}

/// The group's points, and the kinematic bodies among what they touch.
void DynamicsWorld::attach(std::span<const Contact> contacts) {
  kinematics_.clear();
  for (const std::uint32_t i : group_.contacts)
    for (const Mover* mover : {&contacts[i].a, &contacts[i].b}) {
      if (mover->kind != Mover::Kind::body) continue;
      Body& body = bodies_[mover->index];
      if (!body.is_kinematic || body.is_met) continue;
      body.is_met = true;
      kinematics_.push_back(mover->index);
    }
  place_kinematics(0.0);
  update_motions();
  points_.resize(group_.contacts.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    Point& point = points_[i];
    const Contact& contact = contacts[group_.contacts[i]];
    point.contact = &contact;
    point.index = group_.contacts[i];
    point.p_A = transform_back(mover_pose(contact.a), contact.p_A_W);
    point.p_B = transform_back(mover_pose(contact.b), contact.p_B_W);
    tangents(contact.n_AB_W, point.t1_W, point.t2_W);
    point.impulse_W = point.impact_W = Vector3::Zero();
    point.last_force_W = carried_[point.index].force_W;
    point.first_depth = -dot(contact.n_AB_W, contact.p_B_W - contact.p_A_W);
  }
}

/// Of the state as update_motions() left it.
Pose DynamicsWorld::mover_pose(const Mover& mover) const {
  if (mover.kind == Mover::Kind::body) return bodies_[mover.index].X_WB;
  if (mover.kind == Mover::Kind::link) return link_pose(mover.index, mover.link);
  return {};
}

Vector3 DynamicsWorld::point_velocity(const Mover& mover, const Vector3& p_W) const {
  if (mover.kind == Mover::Kind::body) {
    const Body& body = bodies_[mover.index];
    return body.v_W + cross(body.w_W, p_W - body.state.p_W);
  }
  if (mover.kind == Mover::Kind::link) {
    const Arm& arm = mechanisms_[mover.index];
    return arm.dynamics->point_velocity(mover.link, p_W, arm.placed);
  }
  return Vector3::Zero();
}

/// Where the points are now, the normal kept as it was.
void DynamicsWorld::refresh() {
  for (Point& point : points_) {
    const Vector3 p_A = touchstone::transform(mover_pose(point.contact->a), point.p_A);
    const Vector3 p_B = touchstone::transform(mover_pose(point.contact->b), point.p_B);
    point.separation = dot(point.contact->n_AB_W, p_B - p_A);
    point.p_W = 0.5 * (p_A + p_B);
  }
  update_speeds();
}

void DynamicsWorld::update_speeds() {
  for (Point& point : points_) {
    const Vector3 v_A = point_velocity(point.contact->a, point.p_W);
    const Vector3 v_B = point_velocity(point.contact->b, point.p_W);
    point.v_W = v_B - v_A;
    point.mean_v_W = 0.5 * (v_A + v_B);
    point.approach_v = dot(point.contact->n_AB_W, point.v_W);
  }
}

double DynamicsWorld::separation_now(const Point& point) const {
  const Vector3 p_A = touchstone::transform(mover_pose(point.contact->a), point.p_A);
  const Vector3 p_B = touchstone::transform(mover_pose(point.contact->b), point.p_B);
  return dot(point.contact->n_AB_W, p_B - p_A);
}

}  // namespace touchstone::physics

#include "touchstone/physics/world/groups/group_state.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"

namespace touchstone::physics::stepping {
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

/// At the end of a step of h that starts at this depth: less what parts in it. Overlap that the step makes
/// anew is not allowed.
double allowed_depth(double depth, double h, const DynamicsWorld::Settings& settings) {
  if (settings.push_out == 0.0) return std::max(settings.contact_gap, depth);
  const double speed = std::min(std::max(settings.push_out * depth, kLeastPartingSpeed), settings.part_speed);
  return std::max(settings.contact_gap, depth - speed * h);
}

/// Two bodies' points stay together on their mean. What is rounded touches on the normal through a point of
/// its core, and rolls on along with that. @param v_A, v_B of both surfaces at point.p_W
Vector3 path_velocity(const GroupPoint& point, const Movers& movers, const Vector3& v_A, const Vector3& v_B) {
  const Contact& contact = *point.contact;
  if (contact.radius_A == 0.0 && contact.radius_B == 0.0) return 0.5 * (v_A + v_B);
  const Vector3 core_v_A = movers.point_velocity(contact.a, point.p_W - contact.radius_A * contact.n_AB_W),
                core_v_B = movers.point_velocity(contact.b, point.p_W + contact.radius_B * contact.n_AB_W);
  if (contact.radius_B == 0.0) return core_v_A;
  return contact.radius_A == 0.0 ? core_v_B : Vector3(0.5 * (core_v_A + core_v_B));
}

}  // namespace

void attach(const Group& group, std::span<const Contact> contacts, const WarmStart& warm,
            const StepContext& step, Movers& movers, GroupState& state) {
  state.members = group;
  // The kinematic bodies that contacts touch, each once.
  state.kinematics.clear();
  const auto meet = [&](const Mover& mover) {
    if (mover.kind != Mover::Kind::body) return;
    Body& body = movers.bodies[mover.index];
    if (!body.is_kinematic || body.is_met) return;
    body.is_met = true;
    state.kinematics.push_back(mover.index);
  };
  for (const std::uint32_t i : group.contacts)
    for (const Mover* mover : {&contacts[i].a, &contacts[i].b}) meet(*mover);
  for (const std::uint32_t i : group.joints)
    for (const Mover* mover : {&movers.joints[i].joint.a, &movers.joints[i].joint.b}) meet(*mover);
  movers.place_kinematics(state.kinematics, 0.0);
  update_motions(state, movers);
  // The points, in their movers' frames.
  state.spare.clear();
  state.points.resize(group.contacts.size());
  for (std::size_t i = 0; i < state.points.size(); ++i) {
    GroupPoint& point = state.points[i];
    const Contact& contact = contacts[group.contacts[i]];
    point.contact = &contact;
    point.index = group.contacts[i];
    point.p_A = transform_back(movers.pose_of(contact.a), contact.p_A_W);
    point.p_B = transform_back(movers.pose_of(contact.b), contact.p_B_W);
    tangents(contact.n_AB_W, point.t1_W, point.t2_W);
    point.impulse_W = point.impact_W = Vector3::Zero();
    point.last_force_W = warm.of(point.index).force_W;
    point.parting_W = warm.of(point.index).parting_W;
    const double depth = -dot(contact.n_AB_W, contact.p_B_W - contact.p_A_W);
    point.allowed_depth = allowed_depth(depth, step.h, step.settings);
  }
}

void update_motions(const GroupState& state, Movers& movers) {
  movers.update_motions(state.members.bodies);
  movers.update_motions(state.kinematics);
}

void refresh(const Movers& movers, GroupState& state) {
  for (GroupPoint& point : state.points) {
    const Vector3 p_A = touchstone::transform(movers.pose_of(point.contact->a), point.p_A);
    const Vector3 p_B = touchstone::transform(movers.pose_of(point.contact->b), point.p_B);
    point.separation = dot(point.contact->n_AB_W, p_B - p_A);
    point.p_W = 0.5 * (p_A + p_B);
  }
  update_speeds(movers, state);
}

void update_speeds(const Movers& movers, GroupState& state) {
  for (GroupPoint& point : state.points) {
    const Vector3 v_A = movers.point_velocity(point.contact->a, point.p_W);
    const Vector3 v_B = movers.point_velocity(point.contact->b, point.p_W);
    point.v_W = v_B - v_A;
    point.path_v_W = path_velocity(point, movers, v_A, v_B);
    point.approach_v = dot(point.contact->n_AB_W, point.v_W);
  }
}

double separation_now(const GroupPoint& point, const Movers& movers) {
  const Vector3 p_A = touchstone::transform(movers.pose_of(point.contact->a), point.p_A);
  const Vector3 p_B = touchstone::transform(movers.pose_of(point.contact->b), point.p_B);
  return dot(point.contact->n_AB_W, p_B - p_A);
}

}  // namespace touchstone::physics::stepping

#include "touchstone/physics/world/groups/sleep.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"

#include <algorithm>
#include <cmath>

namespace touchstone::physics::stepping {
namespace {

// Of the speed of what is commanded: bodies that leave more than this share of it between them are passed by
// it, those that are carried leave none.
constexpr double kPassed = 0.5;

bool is_still(const Body& body, double speed) {
  const BodyInertia& inertia = body.body.inertia();
  const double trace = (inertia.inertia_B(0, 0) + inertia.inertia_B(1, 1)) + inertia.inertia_B(2, 2);
  const double turning = norm(body.body.angular_velocity(body.state)) * std::sqrt(trace / inertia.mass);
  return norm(body.body.velocity(body.state)) + turning <= speed;
}

/// Something in the group may move by itself or as commanded.
bool is_driven(const GroupState& group, const Movers& movers) {
  return !group.members.mechanisms.empty() ||
         std::any_of(group.kinematics.begin(), group.kinematics.end(),
                     [&](std::uint32_t i) { return moves(movers.bodies[i]); });
}

bool are_still(const GroupState& group, double speed, const Movers& movers) {
  const std::span<const std::uint32_t> bodies = group.members.bodies;
  return std::all_of(bodies.begin(), bodies.end(),
                     [&](std::uint32_t i) { return is_still(movers.bodies[i], speed); });
}

void put_to_sleep(std::span<const std::uint32_t> group, Movers& movers) {
  for (std::size_t i = 0; i < group.size(); ++i) {
    Body& body = movers.bodies[group[i]];
    body.is_asleep = true;
    body.first_sleeper = group[0];
    body.next_sleeper = group[(i + 1) % group.size()];
    for (auto* vector : {&body.state.momentum_W, &body.state.angular_W, &body.state.low_W})
      *vector = Vector3::Zero();
    ++movers.sleepers, --movers.restless;
  }
}

}  // namespace

bool moves(const Body& body) {
  return body.is_kinematic &&
         (body.commanded_v_W != Vector3::Zero() || body.commanded_w_W != Vector3::Zero());
}

bool is_restless(const Movers& movers, const Mover& mover) {
  if (mover.kind == Mover::Kind::link) return true;
  if (mover.kind == Mover::Kind::ground) return false;
  const Body& body = movers.bodies[mover.index];
  return body.is_kinematic ? moves(body) : !body.is_asleep;
}

void count_restless(Movers& movers) {
  movers.restless = movers.sleepers = 0;
  for (const Body& body : movers.bodies) {
    movers.sleepers += body.is_asleep ? 1 : 0;
    movers.restless += (body.is_kinematic ? moves(body) : !body.is_asleep) ? 1 : 0;
  }
}

void wake(Movers& movers, std::uint32_t first) {
  if (!movers.bodies[first].is_asleep) return;
  for (std::uint32_t i = first;;) {
    Body& body = movers.bodies[i];
    body.is_asleep = false;
    body.still_for = 0.0;
    --movers.sleepers, ++movers.restless;
    i = body.next_sleeper;
    if (i == first) return;
  }
}

void wake_all(Movers& movers) {
  for (Body& body : movers.bodies) body.is_asleep = false, body.still_for = 0.0;
  count_restless(movers);
}

void wake_touched(Movers& movers, std::span<const Contact> contacts) {
  if (movers.sleepers == 0) return;
  const auto wake_by = [&](const Mover& mover, const Mover& other) {
    if (other.kind == Mover::Kind::body && movers.bodies[other.index].is_asleep && is_restless(movers, mover))
      wake(movers, other.index);
  };
  for (const HeldJoint& held : movers.joints) {
    if (!held.joint.is_on) continue;
    wake_by(held.joint.a, held.joint.b);
    wake_by(held.joint.b, held.joint.a);
  }
  for (const Contact& contact : contacts) {
    wake_by(contact.a, contact.b);
    wake_by(contact.b, contact.a);
  }
}

bool rests(const GroupState& group, double speed, const Movers& movers) {
  return !is_driven(group, movers) && are_still(group, speed, movers);
}

bool waits(const GroupState& group, double speed, double closing, const Movers& movers) {
  // What is commanded slides along the bodies, and somewhere they do not follow it.
  bool is_passed = false;
  const auto slides = [&](const Mover& mover, const Mover& other, const Contact& contact) {
    if (mover.kind != Mover::Kind::body || !moves(movers.bodies[mover.index])) return true;
    const Body& body = movers.bodies[mover.index];
    const Vector3 v_W = body.commanded_v_W + cross(body.commanded_w_W, contact.p_A_W - body.X_WB.p);
    Vector3 other_v_W = Vector3::Zero();
    if (other.kind == Mover::Kind::body && !movers.bodies[other.index].is_kinematic) {
      const Body& follower = movers.bodies[other.index];
      other_v_W = follower.body.velocity(follower.state) +
                  cross(follower.body.angular_velocity(follower.state), contact.p_A_W - follower.state.p_W);
    }
    is_passed = is_passed || norm(v_W - other_v_W) > kPassed * norm(v_W);
    return std::abs(dot(contact.n_AB_W, v_W)) <= closing;
  };
  return group.members.mechanisms.empty() && is_driven(group, movers) &&
         std::all_of(group.points.begin(), group.points.end(),
                     [&](const GroupPoint& point) {
                       const Contact& contact = *point.contact;
                       return slides(contact.a, contact.b, contact) && slides(contact.b, contact.a, contact);
                     }) &&
         is_passed && are_still(group, speed, movers);
}

void count_stillness(const GroupState& group, const StepContext& step, Movers& movers) {
  if (!(step.settings.sleep_time < kInfinity)) return;
  bool is_due = !is_driven(group, movers);
  for (const std::uint32_t i : group.members.bodies) {
    Body& body = movers.bodies[i];
    body.still_for = is_still(body, step.settings.sleep_speed) ? body.still_for + step.h : 0.0;
    is_due = is_due && body.still_for >= step.settings.sleep_time;
  }
  if (is_due) put_to_sleep(group.members.bodies, movers);
}

}  // namespace touchstone::physics::stepping

// What has come to rest sleeps until something comes near.

#include <algorithm>
#include <cmath>
#include <limits>

#include "touchstone/physics/dynamics_world.hpp"

namespace touchstone::physics {

bool DynamicsWorld::moves(const Body& body) {
  return body.is_kinematic && (body.told_v_W != Vector3::Zero() || body.told_w_W != Vector3::Zero());
}

bool DynamicsWorld::is_restless(const Mover& mover) const {
  if (mover.kind == Mover::Kind::link) return true;
  if (mover.kind == Mover::Kind::ground) return false;
  const Body& body = bodies_[mover.index];
  return body.is_kinematic ? moves(body) : !body.is_asleep;
}

void DynamicsWorld::count_restless() {
  restless_ = sleepers_ = 0;
  for (const Body& body : bodies_) {
    sleepers_ += body.is_asleep ? 1 : 0;
    restless_ += (body.is_kinematic ? moves(body) : !body.is_asleep) ? 1 : 0;
  }
}

void DynamicsWorld::wake(std::uint32_t body) {
  if (!bodies_[body].is_asleep) return;
  for (std::uint32_t i = body;;) {
    bodies_[i].is_asleep = false;
    bodies_[i].still_for = 0.0;
    --sleepers_, ++restless_;
    i = bodies_[i].next_sleeper;
    if (i == body) return;
  }
}

void DynamicsWorld::wake_all() {
  for (Body& body : bodies_) body.is_asleep = false, body.still_for = 0.0;
  count_restless();
}

/// By what is awake, or driven.
void DynamicsWorld::wake_touched(std::span<const Contact> contacts) {
  if (sleepers_ == 0) return;
  const auto wake_by = [&](const Mover& mover, const Mover& other) {
    if (other.kind == Mover::Kind::body && bodies_[other.index].is_asleep && is_restless(mover))
      wake(other.index);
  };
  for (const Contact& contact : contacts) {
    wake_by(contact.a, contact.b);
    wake_by(contact.b, contact.a);
  }
}

bool DynamicsWorld::is_still(std::uint32_t index) const {
  const Body& body = bodies_[index];
  const BodyInertia& inertia = body.body.inertia();
  const double trace = (inertia.inertia_B(0, 0) + inertia.inertia_B(1, 1)) + inertia.inertia_B(2, 2);
  const double turning = norm(body.body.angular_velocity(body.state)) * std::sqrt(trace / inertia.mass);
  return norm(body.body.velocity(body.state)) + turning <= settings_.sleep_speed;
}

/// Of the group, at the end of the step: all its bodies or none.
void DynamicsWorld::count_stillness(double h) {
  if (!(settings_.sleep_time < std::numeric_limits<double>::infinity())) return;
  bool is_due = group_.mechanisms.empty() && std::none_of(kinematics_.begin(), kinematics_.end(),
                                                          [&](std::uint32_t i) { return moves(bodies_[i]); });
  for (const std::uint32_t i : group_.bodies) {
    Body& body = bodies_[i];
    body.still_for = is_still(i) ? body.still_for + h : 0.0;
    is_due = is_due && body.still_for >= settings_.sleep_time;
  }
  if (is_due) put_to_sleep();
}

void DynamicsWorld::put_to_sleep() {
  const std::span<const std::uint32_t> bodies = group_.bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    Body& body = bodies_[bodies[i]];
    body.is_asleep = true;
    body.first_sleeper = bodies[0];
    body.next_sleeper = bodies[(i + 1) % bodies.size()];
    for (auto* vector : {&body.state.momentum_W, &body.state.angular_W, &body.state.low_W})
      *vector = Vector3::Zero();
    ++sleepers_, --restless_;
  }
}

}  // namespace touchstone::physics

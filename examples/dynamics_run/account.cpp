#include "touchstone/examples/dynamics_run/account.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace touchstone::dynamics {
namespace {

using physics::Contact;
using physics::DynamicsWorld;
using physics::Mover;
using physics::SceneSimulation;

bool is_free(const DynamicsWorld& world, const Mover& mover) {
  return mover.kind == Mover::Kind::body && !world.is_kinematic(mover.index);
}

bool is_kinematic(const DynamicsWorld& world, const Mover& mover) {
  return mover.kind == Mover::Kind::body && world.is_kinematic(mover.index);
}

/// Of a kinematic body's point.
Vector3 velocity_at(const DynamicsWorld& world, std::uint32_t body, const Vector3& p_W) {
  return world.velocity(body) + cross(world.angular_velocity(body), p_W - world.state(body).p_W);
}

void join(std::vector<double>& values, const SceneSimulation& simulation) {
  values.clear();
  for (std::uint32_t m = 0; m < simulation.scene().mechanisms.size(); ++m) {
    const auto q = simulation.world().joint_values(m);
    values.insert(values.end(), q.begin(), q.end());
  }
}

}  // namespace

Vector3 body_momentum(const DynamicsWorld& world) {
  Vector3 sum = Vector3::Zero();
  for (std::uint32_t i = 0; i < world.body_count(); ++i)
    if (!world.is_kinematic(i)) sum += world.state(i).momentum_W;
  return sum;
}

Account::Account(const SceneSimulation& simulation)
    : linear_start_(simulation.world().linear_momentum()),
      angular_start_(simulation.world().angular_momentum()),
      energy_start_(simulation.world().energy()),
      momentum_(body_momentum(simulation.world())),
      energy_(energy_start_) {
  const physics::SceneConserved& conserved = simulation.scene().conserved;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const bool any_angular = conserved.angular[0] || conserved.angular[1] || conserved.angular[2];
  linear_drift_ = conserved.linear ? 0.0 : nan;
  angular_drift_ = any_angular ? 0.0 : nan;
  energy_drift_ = conserved.energy ? 0.0 : nan;
  largest_energy_ = std::abs(energy_);
}

void Account::before_begin(const SceneSimulation& simulation) {
  momentum_before_ = body_momentum(simulation.world());
}

void Account::after_begin(const SceneSimulation& simulation) {
  momentum_ += body_momentum(simulation.world()) - momentum_before_;
  energy_ = simulation.world().energy();
  join(q_, simulation);
}

/// Each contact between a free body and what is none, and gravity.
void Account::add_impulses(const SceneSimulation& simulation) {
  const DynamicsWorld& world = simulation.world();
  const double h = simulation.scene().step;
  for (std::uint32_t i = 0; i < world.body_count(); ++i)
    if (!world.is_kinematic(i))
      momentum_ += (h * world.body(i).inertia().mass) * simulation.scene().gravity_W;
  for (std::size_t i = 0; i < simulation.contacts().size(); ++i) {
    const Contact& contact = simulation.contacts()[i];
    const bool a = is_free(world, contact.a), b = is_free(world, contact.b);
    if (a != b) momentum_ += (b ? h : -h) * simulation.forces()[i].force_W;
  }
  unexplained_momentum_ = std::max(unexplained_momentum_, norm(body_momentum(world) - momentum_));
}

/// Of drives, by their mean torque; of kinematic bodies, whose velocity is constant over the step.
void Account::add_step_work(const SceneSimulation& simulation) {
  const DynamicsWorld& world = simulation.world();
  step_work_ = 0.0;
  std::size_t at = 0;
  for (std::uint32_t m = 0; m < simulation.scene().mechanisms.size(); ++m) {
    const auto q = world.joint_values(m), torque = world.joint_torques(m);
    for (std::size_t k = 0; k < q.size(); ++k) step_work_ += torque[k] * (q[k] - q_[at++]);
  }
  for (std::size_t i = 0; i < simulation.contacts().size(); ++i) {
    const Contact& contact = simulation.contacts()[i];
    const Vector3 p_W = 0.5 * (contact.p_A_W + contact.p_B_W);
    const Vector3 impulse = simulation.scene().step * simulation.forces()[i].force_W;  // on B
    if (is_kinematic(world, contact.a)) step_work_ += dot(impulse, velocity_at(world, contact.a.index, p_W));
    if (is_kinematic(world, contact.b)) step_work_ -= dot(impulse, velocity_at(world, contact.b.index, p_W));
  }
  work_ += std::abs(step_work_);
}

void Account::compare_conserved(const SceneSimulation& simulation) {
  const physics::SceneConserved& conserved = simulation.scene().conserved;
  const DynamicsWorld& world = simulation.world();
  if (conserved.linear)
    linear_drift_ = std::max(linear_drift_, norm(world.linear_momentum() - linear_start_));
  if (conserved.energy) energy_drift_ = std::max(energy_drift_, std::abs(world.energy() - energy_start_));
  const Vector3 turned = world.angular_momentum() - angular_start_;
  for (int axis = 0; axis < 3; ++axis)
    if (conserved.angular[static_cast<std::size_t>(axis)])
      angular_drift_ = std::max(angular_drift_, std::abs(turned[axis]));
}

void Account::after_step(const SceneSimulation& simulation) {
  add_impulses(simulation);
  add_step_work(simulation);
  compare_conserved(simulation);
  const double energy = simulation.world().energy(), gain = (energy - energy_) - step_work_;
  (gain > 0.0 ? made_ : lost_) += std::abs(gain);
  largest_energy_ = std::max(largest_energy_, std::abs(energy));
}

}  // namespace touchstone::dynamics

#include "touchstone/examples/dynamics_run/account.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/dynamics_run/results.hpp"

namespace touchstone::dynamics {

using physics::ContactSide;
using physics::DynamicsEngine;
using physics::EngineContact;

namespace {

/// Whether a joint between bodies takes momentum from free ones to the ground, links or kinematic bodies.
bool hold_free_bodies(const physics::DynamicScene& scene) {
  const auto is_free = [&](std::size_t object) {
    return object != kNoObject && scene.bodies[object].kind == physics::BodyKind::dynamic;
  };
  return std::any_of(scene.joints.begin(), scene.joints.end(),
                     [&](const auto& joint) { return is_free(joint.parent) != is_free(joint.child); });
}

}  // namespace

Account::Account(const DynamicsEngine& engine)
    : joints_(moving_joints(engine.scene())),
      linear_start_(engine.linear_momentum()),
      angular_start_(engine.angular_momentum()),
      energy_start_(engine.energy()),
      momentum_(engine.body_momentum()),
      energy_(energy_start_) {
  const physics::SceneConserved& conserved = engine.scene().conserved;
  const double nan = kNaN;
  const bool any_angular = conserved.angular[0] || conserved.angular[1] || conserved.angular[2];
  linear_drift_ = conserved.linear ? 0.0 : nan;
  angular_drift_ = any_angular ? 0.0 : nan;
  energy_drift_ = conserved.energy ? 0.0 : nan;
  largest_energy_ = std::abs(energy_);
  if (hold_free_bodies(engine.scene())) unexplained_momentum_ = nan;
  scale_momenta(engine);
}

void Account::join(const DynamicsEngine& engine) {
  q_.clear();
  for (const physics::JointAddress& joint : joints_) q_.push_back(engine.joint_value(joint));
}

void Account::before_begin(const DynamicsEngine& engine) { momentum_before_ = engine.body_momentum(); }

void Account::after_begin(const DynamicsEngine& engine) {
  momentum_ += engine.body_momentum() - momentum_before_;
  energy_ = engine.energy();
  join(engine);
}

/// Adds the impulses of gravity and of each contact between a free body and one that is not free.
void Account::add_impulses(const DynamicsEngine& engine, std::span<const EngineContact> contacts) {
  const double h = engine.scene().step;
  momentum_ += (h * engine.body_mass()) * engine.scene().gravity_W;
  for (const EngineContact& contact : contacts) {
    const bool a = contact.side_a == ContactSide::body, b = contact.side_b == ContactSide::body;
    if (a != b) momentum_ += (b ? h : -h) * contact.force_W;
  }
  if (std::isnan(unexplained_momentum_)) return;
  unexplained_momentum_ = std::max(unexplained_momentum_, norm(engine.body_momentum() - momentum_));
}

/// Of drives, by their mean torque; of kinematic bodies, whose velocity is constant over the step.
void Account::add_step_work(const DynamicsEngine& engine, std::span<const EngineContact> contacts) {
  step_work_ = 0.0;
  for (std::size_t j = 0; j < joints_.size(); ++j)
    step_work_ += engine.joint_torque(joints_[j]) * (engine.joint_value(joints_[j]) - q_[j]);
  for (const EngineContact& contact : contacts) {
    const Vector3 impulse = engine.scene().step * contact.force_W;  // on B
    if (contact.side_a == ContactSide::kinematic) step_work_ += dot(impulse, contact.kinematic_v_A_W);
    if (contact.side_b == ContactSide::kinematic) step_work_ -= dot(impulse, contact.kinematic_v_B_W);
  }
  work_ += std::abs(step_work_);
}

void Account::compare_conserved(const DynamicsEngine& engine) {
  const physics::SceneConserved& conserved = engine.scene().conserved;
  if (conserved.linear)
    linear_drift_ = std::max(linear_drift_, norm(engine.linear_momentum() - linear_start_));
  if (conserved.energy) energy_drift_ = std::max(energy_drift_, std::abs(engine.energy() - energy_start_));
  const Vector3 turned = engine.angular_momentum() - angular_start_;
  for (int axis = 0; axis < 3; ++axis)
    if (conserved.angular[static_cast<std::size_t>(axis)])
      angular_drift_ = std::max(angular_drift_, std::abs(turned[axis]));
}

/// Of links and latched bodies the engine tells the sum alone.
void Account::scale_momenta(const DynamicsEngine& engine) {
  const physics::DynamicScene& scene = engine.scene();
  double linear = norm(engine.linear_momentum()), angular = norm(engine.angular_momentum());
  for (std::size_t o = 0; o < scene.bodies.size(); ++o) {
    const auto v_W = engine.velocity(o), w_W = engine.angular_velocity(o);
    if (scene.bodies[o].kind != physics::BodyKind::dynamic || !v_W || !w_W) continue;
    // What a body's middle has about the origin at most, and its own.
    const physics::BodyInertia& inertia = scene.bodies[o].inertia;
    const Pose X_WO = engine.object_pose(o);
    const double mv = inertia.mass * norm(*v_W),
                 size = scene.scene.objects[o].tree.nodes()[0].sphere_O.radius;
    linear += mv;
    angular += mv * (norm(transform(X_WO, inertia.centre_B)) + size) +
               norm(inertia.inertia_B * (X_WO.R.transpose() * *w_W));
  }
  linear_scale_ = std::max(linear_scale_, linear);
  angular_scale_ = std::max(angular_scale_, angular);
}

void Account::after_step(const DynamicsEngine& engine, std::span<const EngineContact> contacts) {
  add_impulses(engine, contacts);
  add_step_work(engine, contacts);
  compare_conserved(engine);
  scale_momenta(engine);
  const double energy = engine.energy(), gain = (energy - energy_) - step_work_;
  (gain > 0.0 ? made_ : lost_) += std::abs(gain);
  largest_energy_ = std::max(largest_energy_, std::abs(energy));
}

}  // namespace touchstone::dynamics

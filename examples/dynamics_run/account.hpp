#pragma once

#include <span>
#include <vector>

#include "touchstone/physics/engine/dynamics_engine.hpp"

namespace touchstone::dynamics {

/// Where momentum and energy of a run went, step by step. What latching does to energy, and to the bodies
/// that it makes part of a mechanism or the ground, is taken as explained.
class Account {
 public:
  explicit Account(const physics::DynamicsEngine& engine);

  /// Around DynamicsEngine::begin_step().
  void before_begin(const physics::DynamicsEngine& engine);
  void after_begin(const physics::DynamicsEngine& engine);
  /// After DynamicsEngine::step(), with the contacts that it lists.
  void after_step(const physics::DynamicsEngine& engine, std::span<const physics::EngineContact> contacts);

  /// Largest momentum of the free bodies that gravity and what they touched of other kinds do not explain
  /// [N s]; nan where joints hold some of them to what is not free: engines do not tell with what force.
  double unexplained_momentum() const { return unexplained_momentum_; }
  /// Largest change of what the scene declares conserved; nan where it declares nothing [N s], [N m s], [J].
  double linear_drift() const { return linear_drift_; }
  double angular_drift() const { return angular_drift_; }
  double energy_drift() const { return energy_drift_; }
  /// What drifts of momenta are a share of: the largest sum of what each body has, whatever its direction
  /// [N s], [N m s].
  double linear_scale() const { return linear_scale_; }
  double angular_scale() const { return angular_scale_; }
  /// Sum over the steps of what energy grew by beyond the work of drives and kinematic bodies [J].
  double energy_made() const { return made_; }
  /// Sum of what it fell short of it: impacts, friction [J].
  double energy_lost() const { return lost_; }
  /// Largest |energy| seen and all work done, either way [J].
  double energy_scale() const { return largest_energy_ + work_; }

 private:
  void add_step_work(const physics::DynamicsEngine& engine, std::span<const physics::EngineContact> contacts);
  void add_impulses(const physics::DynamicsEngine& engine, std::span<const physics::EngineContact> contacts);
  void compare_conserved(const physics::DynamicsEngine& engine);
  void scale_momenta(const physics::DynamicsEngine& engine);
  void join(const physics::DynamicsEngine& engine);

  std::vector<physics::JointAddress> joints_;
  std::vector<double> q_;  // of all joints, before the step
  Vector3 linear_start_, angular_start_;
  double energy_start_ = 0.0;
  Vector3 momentum_ = Vector3::Zero();  // of the free bodies, that is explained
  double energy_ = 0.0, step_work_ = 0.0;
  Vector3 momentum_before_ = Vector3::Zero();
  double unexplained_momentum_ = 0.0, linear_drift_, angular_drift_, energy_drift_;
  double linear_scale_ = 0.0, angular_scale_ = 0.0;
  double made_ = 0.0, lost_ = 0.0, largest_energy_ = 0.0, work_ = 0.0;
};

}  // namespace touchstone::dynamics

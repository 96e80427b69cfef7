// What impulses do in no time.

#include <algorithm>

#include "physics/dynamics_world.hpp"

namespace touchstone::physics {

bool DynamicsWorld::needs_impact() const {
  const double least = 10.0 * settings_.solver.tolerance;  // what a solve leaves is no impact
  for (const Point& point : points_)
    if (point.separation <= settings_.contact_gap &&
        dot(point.contact.n_AB_W, relative_velocity(point)) < -least)
      return true;
  for (const Arm& arm : mechanisms_)
    for (const Mechanism::Joint& joint : arm.dynamics->mechanism().joints()) {
      const std::uint32_t i = joint.value;
      if (i == Mechanism::kNone) continue;
      if (arm.q[i] - joint.lower <= settings_.contact_gap && arm.qd[i] < -least) return true;
      if (joint.upper - arm.q[i] <= settings_.contact_gap && arm.qd[i] > least) return true;
    }
  return false;
}

void DynamicsWorld::impact(double h, StepReport& report) {
  gather(Phase::impact, 0.0, false);
  solve(report);
  accumulate();
  for (Body& body : bodies_) {
    if (body.is_kinematic) continue;
    body.state.momentum_W += body.impulse_W;
    body.state.angular_W += body.moment_W - cross(body.state.p_W, body.impulse_W);
  }
  for (Arm& arm : mechanisms_) {
    for (std::size_t i = 0; i < arm.q.size(); ++i) arm.qd[i] += arm.change[i];
    arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
  }
  for (std::size_t i = 0; i < active_.size(); ++i) {
    Point& point = points_[active_[i]];
    const Vector3 impulse =
        (x_[3 * i] * point.contact.n_AB_W + x_[3 * i + 1] * point.t1_W) + x_[3 * i + 2] * point.t2_W;
    point.impulse_W += impulse;
    point.impact_W += impulse;
  }
  for (std::size_t j = 0; j < joint_rows_.size(); ++j)
    if (!joint_rows_[j].is_stop)
      mechanisms_[joint_rows_[j].mechanism].torque[joint_rows_[j].value] += x_[3 * active_.size() + j] / h;
}

}  // namespace touchstone::physics

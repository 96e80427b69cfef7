// What impulses do in no time.

#include <algorithm>

#include "touchstone/physics/compensated_sum.hpp"
#include "touchstone/physics/dynamics_world.hpp"

namespace touchstone::physics {

bool DynamicsWorld::needs_impact() const {
  const double least = 10.0 * settings_.solver.tolerance;  // what a solve leaves is no impact
  // In one piece what does not bounce is stopped with the forces.
  if (is_coarse_)
    return std::any_of(points_.begin(), points_.end(), [&](const Point& point) {
      return point.separation <= settings_.contact_gap && point.approach_v < -settings_.bounce_speed &&
             point.contact->restitution > 0.0;
    });
  for (const Point& point : points_)
    if (point.separation <= settings_.contact_gap && point.approach_v < -least) return true;
  for (const std::uint32_t m : group_.mechanisms) {
    const Arm& arm = mechanisms_[m];
    for (const Mechanism::Joint& joint : arm.dynamics->mechanism().joints()) {
      const std::uint32_t i = joint.value;
      if (i == Mechanism::kNone) continue;
      if (arm.q[i] - joint.lower <= settings_.contact_gap && arm.qd[i] < -least) return true;
      if (joint.upper - arm.q[i] <= settings_.contact_gap && arm.qd[i] > least) return true;
    }
  }
  return false;
}

void DynamicsWorld::impact(double h, StepReport& report) {
  gather(Phase::impact, 0.0, false, true);
  solve(report);
  accumulate();
  for (const std::uint32_t i : group_.bodies) {
    Body& body = bodies_[i];
    add_compensated(body.state.momentum_W, body.state.low_W, body.impulse_W);
    body.state.angular_W += body.moment_W;
  }
  for (const std::uint32_t m : group_.mechanisms) {
    Arm& arm = mechanisms_[m];
    for (std::size_t i = 0; i < arm.q.size(); ++i) arm.qd[i] += arm.change[i];
    arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
  }
  for (std::size_t i = 0; i < active_.size(); ++i) {
    Point& point = points_[active_[i]];
    const Vector3 impulse = impulse_of(i);
    point.impulse_W += impulse;
    point.impact_W += impulse;
  }
  for (std::size_t j = 0; j < joint_rows_.size(); ++j)
    if (!joint_rows_[j].is_stop)
      mechanisms_[joint_rows_[j].mechanism].torque[joint_rows_[j].value] += x_[3 * active_.size() + j] / h;
  update_motions();
  update_speeds();
}

}  // namespace touchstone::physics

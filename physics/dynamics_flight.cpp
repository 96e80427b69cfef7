// Free flight over a piece of a step, and what its impulses change of it.

#include <algorithm>
#include <cmath>

#include "touchstone/physics/compensated_sum.hpp"
#include "touchstone/physics/dynamics_world.hpp"

namespace touchstone::physics {
namespace {

double cut_torque(const JointDrive& drive) {
  return std::min(std::max(drive.torque, -drive.limit), drive.limit);
}

}  // namespace

/// Poses and velocities of what points are on.
void DynamicsWorld::update_motions() {
  const auto update = [&](Body& body) {
    body.X_WB = body.body.pose(body.state);
    body.v_W = body.is_kinematic ? body.told_v_W : body.body.velocity(body.state);
    body.w_W =
        body.is_kinematic ? body.told_w_W : body.body.angular_velocity(body.X_WB.R, body.state.angular_W);
  };
  for (const std::uint32_t i : group_.bodies) update(bodies_[i]);
  for (const std::uint32_t i : kinematics_) update(bodies_[i]);
}

/// Where they were told to be by then: from where the step found them, so that no group's clock shows.
void DynamicsWorld::place_kinematics(double elapsed) {
  for (const std::uint32_t i : kinematics_) {
    Body& body = bodies_[i];
    if (body.told_v_W == Vector3::Zero() && body.told_w_W == Vector3::Zero()) continue;
    body.state.p_W = body.kept.p_W + elapsed * body.told_v_W;
    body.state.q_WB = normalized(quaternion_of_turn(elapsed * body.told_w_W) * body.kept.q_WB);
  }
}

/// What flights of any length from here have in common.
bool DynamicsWorld::begin_flight(StepReport& report) {
  for (const std::uint32_t m : group_.mechanisms) {
    Arm& arm = mechanisms_[m];
    for (std::size_t k = 0; k < arm.q.size(); ++k) {
      const JointDrive& drive = arm.drives[k];
      arm.tau[k] = (drive.mode == JointDrive::Mode::torque ? cut_torque(drive) : 0.0) + arm.push[k];
    }
    if (!arm.dynamics->begin_flight(settings_.gravity_W, arm.tau, arm.qd, arm.placed, arm.scratch))
      return fail(StepFailure::mechanism, m, report);
  }
  return true;
}

/// Says why a body could not fly. Returns false.
bool DynamicsWorld::fail_flight(const Body& body, double t, std::uint32_t index, StepReport& report) {
  const double turn = norm(body.body.angular_velocity(body.state)) * t;
  return fail(turn > RigidBody::kMostTurn ? StepFailure::turn : StepFailure::body, index, report);
}

/// Under gravity and what pushes it.
bool DynamicsWorld::fly_body(const Body& body, RigidBodyState& state, double t) const {
  if (!body.body.fly(state, t, settings_.gravity_W)) return false;
  if (!is_pushed_ || (body.push_W == Vector3::Zero() && body.push_moment_W == Vector3::Zero())) return true;
  const Vector3 impulse = t * body.push_W, twist = t * body.push_moment_W;
  add_compensated(state.p_W, state.p_low_W, (0.5 * t / body.body.inertia().mass) * impulse);
  add_compensated(state.momentum_W, state.low_W, impulse);
  state.angular_W += twist;
  RigidBody::turn_by(state, rotate(body.body.inverse_inertia_W(state), Vector3((0.5 * t) * twist)));
  return is_finite(state);
}

/// They were for one step.
void DynamicsWorld::forget_pushes() {
  if (!is_pushed_) return;
  for (Body& body : bodies_) body.push_W = body.push_moment_W = Vector3::Zero();
  for (Arm& arm : mechanisms_) std::fill(arm.push.begin(), arm.push.end(), 0.0);
  is_pushed_ = false;
}

/// Without contacts, drives of rows and stops: into the flown states.
bool DynamicsWorld::fly(double t, StepReport& report) {
  for (const std::uint32_t i : group_.bodies) {
    Body& body = bodies_[i];
    body.flown = body.state;
    if (!fly_body(body, body.flown, t)) return fail_flight(body, t, i, report);
  }
  for (const std::uint32_t m : group_.mechanisms) {
    Arm& arm = mechanisms_[m];
    arm.flown_q = arm.q;
    arm.flown_qd = arm.qd;
    if (!arm.dynamics->fly(arm.X_WBase, settings_.gravity_W, arm.tau, t, t / h_, arm.flown_q, arm.flown_qd,
                           arm.scratch))
      return fail(StepFailure::mechanism, m, report);
  }
  return true;
}

/// Impulses of the rows on each body and mechanism.
void DynamicsWorld::accumulate() {
  for (const std::uint32_t i : group_.bodies) bodies_[i].impulse_W = bodies_[i].moment_W = Vector3::Zero();
  for (const std::uint32_t m : group_.mechanisms)
    std::fill(mechanisms_[m].change.begin(), mechanisms_[m].change.end(), 0.0);
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const Point& point = points_[active_[i]];
    const Vector3 impulse = impulse_of(i);
    for (const Side& side : point.sides) {
      if (side.unit == kNone) continue;
      if (is_body(side.unit)) {
        bodies_[side.unit].impulse_W += side.sign * impulse;
        bodies_[side.unit].moment_W += cross(side.lever_W, side.sign * impulse);
        continue;
      }
      std::vector<double>& change = arm_of(side.unit).change;
      for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t k = 0; k < change.size(); ++k)
          change[k] += Y_[side.first + r * change.size() + k] * x_[3 * i + r];
    }
  }
  for (std::size_t j = 0; j < joint_rows_.size(); ++j) {
    std::vector<double>& change = mechanisms_[joint_rows_[j].mechanism].change;
    for (std::size_t k = 0; k < change.size(); ++k)
      change[k] += Y_[joint_rows_[j].first + k] * x_[3 * active_.size() + j];
  }
}

void DynamicsWorld::commit(double t, double h) {
  accumulate();
  for (const std::uint32_t i : group_.bodies) {
    Body& body = bodies_[i];
    RigidBodyState& state = body.flown;
    if (body.impulse_W != Vector3::Zero()) {
      // About the mean of where the body was and is: so that the moment of momentum of all stays.
      add_compensated(state.p_W, state.p_low_W, (0.5 * t / body.body.inertia().mass) * body.impulse_W);
      const Vector3 middle = 0.5 * (body.state.p_W + state.p_W);
      const Vector3 twist = body.moment_W - cross(middle - body.middle_W, body.impulse_W);
      const Vector3 turn = rotate(body.row_inverse_W, (0.5 * t) * twist);
      add_compensated(state.momentum_W, state.low_W, body.impulse_W);
      state.angular_W += twist;
      RigidBody::turn_by(state, turn);
      body.body.keep_place(state, body.state);
    }
    body.state = state;
  }
  for (const std::uint32_t m : group_.mechanisms) {
    Arm& arm = mechanisms_[m];
    for (std::size_t i = 0; i < arm.q.size(); ++i) {
      arm.q[i] = arm.flown_q[i] + (0.5 * t) * arm.change[i];
      arm.qd[i] = arm.flown_qd[i] + arm.change[i];
      arm.torque[i] += (arm.tau[i] - arm.push[i]) * (t / h);
    }
    arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
  }
  for (Point& point : points_) point.last_force_W = Vector3::Zero();
  for (std::size_t i = 0; i < active_.size(); ++i) {
    Point& point = points_[active_[i]];
    const Vector3 impulse = impulse_of(i);
    point.impulse_W += impulse;
    point.last_force_W = impulse / t;
  }
  for (std::size_t j = 0; j < joint_rows_.size(); ++j) {
    if (joint_rows_[j].is_stop) continue;
    Arm& arm = mechanisms_[joint_rows_[j].mechanism];
    const double impulse = x_[3 * active_.size() + j];
    arm.torque[joint_rows_[j].value] += impulse / h;
    arm.last_torque[joint_rows_[j].value] = impulse / t;
  }
}

}  // namespace touchstone::physics

// Free flight over a piece of a step, and what its impulses change of it.

#include <algorithm>
#include <cmath>

#include "physics/dynamics_world.hpp"

namespace touchstone::physics {
namespace {

double cut_torque(const JointDrive& drive) {
  return std::min(std::max(drive.torque, -drive.limit), drive.limit);
}

}  // namespace

/// Without contacts, drives of rows and stops: into the flown states.
bool DynamicsWorld::fly(double t, StepReport& report) {
  const auto fail = [&](StepFailure failure, std::size_t index) {
    report.failure = failure;
    report.failed_index = static_cast<std::uint32_t>(index);
    return false;
  };
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Body& body = bodies_[i];
    body.flown = body.state;
    if (body.is_kinematic) {
      body.flown.p_W = body.state.p_W + t * body.v_W;
      body.flown.q_WB = normalized(quaternion_of_turn(t * body.w_W) * body.state.q_WB);
      if (!is_finite(body.flown)) return fail(StepFailure::body, i);
    } else if (!body.body.fly(body.flown, t, settings_.gravity_W)) {
      return fail(StepFailure::body, i);
    }
  }
  for (std::size_t i = 0; i < mechanisms_.size(); ++i) {
    Arm& arm = mechanisms_[i];
    arm.flown_q = arm.q;
    arm.flown_qd = arm.qd;
    for (std::size_t k = 0; k < arm.q.size(); ++k) {
      const JointDrive& drive = arm.drives[k];
      arm.tau[k] = drive.mode == JointDrive::Mode::torque ? cut_torque(drive) : 0.0;
    }
    if (!arm.dynamics->step(arm.X_WBase, settings_.gravity_W, arm.tau, t, arm.flown_q, arm.flown_qd,
                            arm.scratch))
      return fail(StepFailure::mechanism, i);
  }
  return true;
}

/// Impulses of the rows on each body and mechanism.
void DynamicsWorld::accumulate() {
  for (Body& body : bodies_) body.impulse_W = body.moment_W = Vector3::Zero();
  for (Arm& arm : mechanisms_) std::fill(arm.change.begin(), arm.change.end(), 0.0);
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const Point& point = points_[active_[i]];
    const Vector3 impulse =
        (x_[3 * i] * point.contact.n_AB_W + x_[3 * i + 1] * point.t1_W) + x_[3 * i + 2] * point.t2_W;
    const Vector3 moment = cross(point.act_W, impulse);
    const auto act = [&](const Mover& mover, double sign) {
      if (mover.kind != Mover::Kind::body) return;
      bodies_[mover.index].impulse_W += sign * impulse;
      bodies_[mover.index].moment_W += sign * moment;
    };
    act(point.contact.a, -1.0);
    act(point.contact.b, 1.0);
  }
  for (std::size_t r = 0; r < rows_.size(); ++r)
    for (int s = 0; s < rows_[r].count; ++s) {
      const Side& side = rows_[r].sides[s];
      if (side.mover.kind != Mover::Kind::link) continue;
      std::vector<double>& change = mechanisms_[side.mover.index].change;
      for (std::size_t k = 0; k < side.size; ++k) change[k] += Y_[side.first + k] * x_[r];
    }
}

void DynamicsWorld::commit(double t, double h) {
  accumulate();
  for (Body& body : bodies_) {
    RigidBodyState& state = body.flown;
    if (!body.is_kinematic && body.impulse_W != Vector3::Zero()) {
      // About the mean of where the body was and is: so that the moment of momentum of all stays.
      state.p_W += (0.5 * t / body.body.inertia().mass) * body.impulse_W;
      const Vector3 twist = body.moment_W - cross(0.5 * (body.state.p_W + state.p_W), body.impulse_W);
      const Vector3 turn = rotate(body.body.inverse_inertia_W(state), (0.5 * t) * twist);
      state.momentum_W += body.impulse_W;
      state.angular_W += twist;
      state.q_WB = normalized(quaternion_of_turn(turn) * state.q_WB);
    }
    body.state = state;
  }
  for (Arm& arm : mechanisms_) {
    for (std::size_t i = 0; i < arm.q.size(); ++i) {
      arm.q[i] = arm.flown_q[i] + (0.5 * t) * arm.change[i];
      arm.qd[i] = arm.flown_qd[i] + arm.change[i];
      arm.torque[i] += arm.tau[i] * (t / h);
    }
    arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
  }
  for (Point& point : points_) point.last_force_W = Vector3::Zero();
  for (std::size_t i = 0; i < active_.size(); ++i) {
    Point& point = points_[active_[i]];
    const Vector3 impulse =
        (x_[3 * i] * point.contact.n_AB_W + x_[3 * i + 1] * point.t1_W) + x_[3 * i + 2] * point.t2_W;
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

void DynamicsWorld::go_back() {
  for (Body& body : bodies_) body.state = body.start;
  for (Arm& arm : mechanisms_) {
    arm.q = arm.start_q, arm.qd = arm.start_qd, arm.torque = arm.start_torque;
    arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
  }
  for (Point& point : points_) point.impulse_W = point.start_impulse_W;
  refresh();
}

}  // namespace touchstone::physics

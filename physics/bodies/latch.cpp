#include "touchstone/physics/bodies/latch.hpp"

#include <string>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/solver/cholesky.hpp"

namespace touchstone::physics {

LatchedBodies latch(const RigidBody& a, const RigidBodyState& state_a, const RigidBody& b,
                    const RigidBodyState& state_b, std::string_view name) {
  const Pose X_WA = a.pose(state_a);
  const Pose X_AB = compose(inverse(X_WA), b.pose(state_b));
  const RigidBody body(combined(a.inertia(), transform(X_AB, b.inertia())), name);
  RigidBodyState state;
  state.q_WB = state_a.q_WB;
  state.p_W = touchstone::transform(X_WA, body.inertia().centre_B);
  state.momentum_W = state_a.momentum_W + state_b.momentum_W;
  state.angular_W = (state_a.angular_W + cross(state_a.p_W - state.p_W, state_a.momentum_W)) +
                    (state_b.angular_W + cross(state_b.p_W - state.p_W, state_b.momentum_W));
  const RigidBodyState after = release(body, state, b, X_AB);
  return {body, state, after.momentum_W - state_b.momentum_W, after.angular_W - state_b.angular_W};
}

RigidBodyState release(const RigidBody& latched, const RigidBodyState& state, const RigidBody& part,
                       const Pose& X_LP) {
  const Pose X_WP = compose(latched.pose(state), X_LP);
  const Vector3 centre_W = touchstone::transform(X_WP, part.inertia().centre_B);
  const Vector3 w = latched.angular_velocity(state);
  return part.state(X_WP, latched.velocity(state) + cross(w, centre_W - state.p_W), w);
}

BodyInertia latched_link(const BodyInertia& link, const Pose& X_WL, const RigidBody& body,
                         const RigidBodyState& state) {
  return combined(link, transform(compose(inverse(X_WL), body.pose(state)), body.inertia()));
}

CaptureScratch::CaptureScratch(const MechanismDynamics& dynamics)
    : M(std::size_t{dynamics.size()} * dynamics.size()),
      momentum(dynamics.size()),
      J(dynamics.size()),
      placed(dynamics.make_workspace()) {}

void gather_capture(const MechanismDynamics& before, const Pose& X_WBase, std::uint32_t link,
                    const RigidBodyState& state, std::span<const double> q, std::span<const double> qd,
                    CaptureScratch& scratch) {
  const std::size_t n = before.size();
  std::vector<double>&M = scratch.M, &momentum = scratch.momentum, &J = scratch.J;
  before.place(X_WBase, q, qd, scratch.placed);
  before.mass_matrix(M, scratch.placed);
  for (std::size_t r = 0; r < n; ++r) {
    momentum[r] = 0.0;
    for (std::size_t c = 0; c < n; ++c) momentum[r] += M[r * n + c] * qd[c];
  }
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3 e = Vector3::Unit(axis);
    before.point_jacobian(link, state.p_W, e, J, scratch.placed);
    for (std::size_t i = 0; i < n; ++i) momentum[i] += J[i] * state.momentum_W[axis];
    before.turn_jacobian(link, e, J, scratch.placed);
    for (std::size_t i = 0; i < n; ++i) momentum[i] += J[i] * state.angular_W[axis];
  }
}

void finish_capture(const MechanismDynamics& after, const Pose& X_WBase, std::span<const double> q,
                    std::span<double> qd, CaptureScratch& scratch) {
  const std::size_t n = after.size();
  after.place(X_WBase, q, qd, scratch.placed);
  after.mass_matrix(scratch.M, scratch.placed);
  factor_cholesky(scratch.M, n);
  solve_cholesky(scratch.M, scratch.momentum);
  for (std::size_t i = 0; i < n; ++i) qd[i] = scratch.momentum[i];
}

void capture(const MechanismDynamics& before, const MechanismDynamics::Workspace& placed,
             const MechanismDynamics& after, std::uint32_t link, const RigidBodyState& state,
             std::span<const double> q, std::span<double> qd) {
  CaptureScratch scratch(before);
  gather_capture(before, placed.X_WBase, link, state, q, qd, scratch);
  finish_capture(after, placed.X_WBase, q, qd, scratch);
}

}  // namespace touchstone::physics

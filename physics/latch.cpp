#include "physics/latch.hpp"

#include <string>
#include <vector>

#include "physics/cholesky.hpp"
#include "physics/matrix3.hpp"

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

void capture(const MechanismDynamics& before, const MechanismDynamics::Workspace& placed,
             const MechanismDynamics& after, std::uint32_t link, const RigidBodyState& state,
             std::span<const double> q, std::span<double> qd) {
  const std::size_t n = before.size();
  std::vector<double> M(n * n), M_before(n * n), momentum(n, 0.0), J(n);
  MechanismDynamics::Workspace workspace = after.make_workspace();
  after.place(placed.X_WBase, q, qd, workspace);
  after.mass_matrix(M, workspace);
  MechanismDynamics::Workspace own = before.make_workspace();
  before.place(placed.X_WBase, q, qd, own);
  before.mass_matrix(M_before, own);
  for (std::size_t r = 0; r < n; ++r)
    for (std::size_t c = 0; c < n; ++c) momentum[r] += M_before[r * n + c] * qd[c];
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3 e = Vector3::Unit(axis);
    before.point_jacobian(link, state.p_W, e, J, own);
    for (std::size_t i = 0; i < n; ++i) momentum[i] += J[i] * state.momentum_W[axis];
    before.turn_jacobian(link, e, J, own);
    for (std::size_t i = 0; i < n; ++i) momentum[i] += J[i] * state.angular_W[axis];
  }
  factor_cholesky(M, n);
  solve_cholesky(M, momentum);
  for (std::size_t i = 0; i < n; ++i) qd[i] = momentum[i];
}

}  // namespace touchstone::physics

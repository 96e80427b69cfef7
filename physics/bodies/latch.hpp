#pragma once

#include <span>
#include <vector>

#include "touchstone/physics/bodies/mechanism_dynamics.hpp"
#include "touchstone/physics/bodies/rigid_body.hpp"

/// @file
/// Latching in dynamics: an inelastic capture, then one body until release.

namespace touchstone::physics {

/// Two free bodies that move as one, in the first one's frame.
struct LatchedBodies {
  RigidBody body;
  RigidBodyState state;
  Vector3 impulse_W;  ///< of the capture, on the second body [N s]
  Vector3 moment_W;   ///< of the capture, on the second body about its centre of mass [N m s]
};

/// Captures b by a as they stand: linear and angular momentum of both stay, all relative motion ends.
/// @throws InputError where the combined inertia is invalid (see RigidBody).
LatchedBodies latch(const RigidBody& a, const RigidBodyState& state_a, const RigidBody& b,
                    const RigidBodyState& state_b, std::string_view name);

/// The state of a part of a latched body, X_LP its pose in the latched body's frame: without an impulse, each
/// part goes on as it moved.
RigidBodyState release(const RigidBody& latched, const RigidBodyState& state, const RigidBody& part,
                       const Pose& X_LP);

/// A free body captured by a link: the inertia of the link with the body, for a new MechanismDynamics.
BodyInertia latched_link(const BodyInertia& link, const Pose& X_WL, const RigidBody& body,
                         const RigidBodyState& state);

/// Memory for captures by the links of one mechanism.
struct CaptureScratch {
  explicit CaptureScratch(const MechanismDynamics& dynamics);

  std::vector<double> M, momentum, J;
  MechanismDynamics::Workspace placed;
};

/// The joints' momenta with the body's, M qd + J^T of the body's momenta: before the link has it. Does not
/// allocate.
void gather_capture(const MechanismDynamics& before, const Pose& X_WBase, std::uint32_t link,
                    const RigidBodyState& state, std::span<const double> q, std::span<const double> qd,
                    CaptureScratch& scratch);
/// The joint rates after it, M' qd' = those momenta. Limited drives give no impulse at once. Does not
/// allocate. @param after the same mechanism with latched_link().
void finish_capture(const MechanismDynamics& after, const Pose& X_WBase, std::span<const double> q,
                    std::span<double> qd, CaptureScratch& scratch);

/// Both. Allocates. @param before as placed.
void capture(const MechanismDynamics& before, const MechanismDynamics::Workspace& placed,
             const MechanismDynamics& after, std::uint32_t link, const RigidBodyState& state,
             std::span<const double> q, std::span<double> qd);

}  // namespace touchstone::physics

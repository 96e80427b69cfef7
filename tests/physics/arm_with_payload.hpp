#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "touchstone/physics/world/dynamics_world.hpp"
#include "touchstone/tests/physics/arms.hpp"

namespace touchstone::physics {

/// The SSRMS-type arm, brakes of 2332 N m, before a free 100 t payload that comes at it with 0.014 m/s; eight
/// pads around the tip against those of the payload.
struct ArmWithPayload {
  Arm arm = ssrms_arm();
  MechanismDynamics dynamics{arm.mechanism, arm.links};
  RigidBody payload{box_inertia(1e5, {4, 4, 4}), "payload"};
  DynamicsWorld world{{}};
  std::uint32_t mechanism = 0, tip = 0, body = 0;

  ArmWithPayload() : tip(arm.mechanism.find_link("tip")) {
    const std::vector<double> q = {0.1, 0.4, -0.8, 1.2, 0.5, -0.3, 0.2}, zero(7, 0.0);
    mechanism = world.add_mechanism(dynamics, {}, q, zero);
    for (std::uint32_t i = 0; i < 7; ++i)
      world.set_drive(mechanism, i, {.mode = JointDrive::Mode::brake, .limit = 2332.0});
    body = world.add_body(payload, approaching());
    world.reserve(8);
  }
  ArmWithPayload(const ArmWithPayload&) = delete;
  ArmWithPayload& operator=(const ArmWithPayload&) = delete;

  RigidBodyState approaching() const {
    const Pose X_WT = world.link_pose(mechanism, tip);
    return payload.state({X_WT.R, touchstone::transform(X_WT, {2, 0, 0})}, rotate(X_WT.R, {-0.01, 0.01, 0}),
                         {0.001, 0, 0});
  }

  /// @param rolling the payload's points are where its face is now, so that the rim rolls on it.
  std::array<Contact, 8> rim_contacts(bool rolling = false) const {
    const Pose X_WT = world.link_pose(mechanism, tip), X_WB = world.pose(body);
    std::array<Contact, 8> contacts;
    for (unsigned i = 0; i < 8; ++i) {
      const double angle = 0.785398163397448 * i, y = 0.2 * std::cos(angle), z = 0.2 * std::sin(angle);
      const Vector3 n = X_WT.R.col(0), on_tip = touchstone::transform(X_WT, Vector3(0.0, y, z));
      Vector3 on_payload = touchstone::transform(X_WB, Vector3(-2.0, y, z));
      if (rolling) {
        const Vector3 m = X_WB.R.col(0);
        on_payload = on_tip + (dot(m, on_payload - on_tip) / dot(m, n)) * n;
      }
      contacts[i] = {
          Mover::of_link(mechanism, tip), Mover::of_body(body), n, on_tip, on_payload, 0.3, 0.0, i + 1};
    }
    return contacts;
  }
};

}  // namespace touchstone::physics

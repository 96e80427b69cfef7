#include "touchstone/physics/bodies/latch.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/tests/physics/arms.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

Vector3 about_origin(const RigidBodyState& state) {
  return cross(state.p_W, state.momentum_W) + state.angular_W;
}

TEST(Latch, OffCentreCaptureKeepsMomentaAndCombinesInertia) {
  std::mt19937_64 random(51);
  for (int i = 0; i < 50; ++i) {
    const RigidBody a(box_inertia(500.0, random_vector(random, 0.5, 3.0)), "a");
    const RigidBody b(box_inertia(uniform(random, 1.0, 1e5), random_vector(random, 0.5, 3.0)), "b");
    const Pose X_WA = random_pose(random, 3.0), X_WB = random_pose(random, 3.0);
    const Vector3 va = random_vector(random, 1.0), wa = random_vector(random, 1.0),
                  vb = random_vector(random, 1.0), wb = random_vector(random, 1.0);
    const RigidBodyState sa = a.state(X_WA, va, wa), sb = b.state(X_WB, vb, wb);
    const LatchedBodies both = latch(a, sa, b, sb, "both");

    const Vector3 linear = sa.momentum_W + sb.momentum_W, angular = about_origin(sa) + about_origin(sb);
    EXPECT_LT(norm(both.state.momentum_W - linear), 1e-15 * norm(linear));
    EXPECT_LT(norm(about_origin(both.state) - angular), 1e-13 * norm(angular));

    // The combined inertia by the parallel-axis theorem, written out in world axes.
    const double m1 = a.inertia().mass, m2 = b.inertia().mass, reduced = m1 * m2 / (m1 + m2);
    const Vector3 r = X_WB.p - X_WA.p;
    const Matrix3 expected = (turned(X_WA.R, a.inertia().inertia_B) + turned(X_WB.R, b.inertia().inertia_B)) +
                             reduced * (dot(r, r) * Matrix3::Identity() - outer(r, r));
    const Matrix3 got = turned(both.body.pose(both.state).R, both.body.inertia().inertia_B);
    EXPECT_LT((got - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff());
    EXPECT_LE(both.body.kinetic_energy(both.state), a.kinetic_energy(sa) + b.kinetic_energy(sb));

    // Released, the two go on as one moved; the capture's impulse is what b gained.
    const RigidBodyState free_a = release(both.body, both.state, a, {});
    const RigidBodyState free_b = release(both.body, both.state, b, compose(inverse(X_WA), X_WB));
    EXPECT_LT(norm((free_a.momentum_W + free_b.momentum_W) - linear), 1e-13 * norm(linear));
    EXPECT_LT(norm((about_origin(free_a) + about_origin(free_b)) - angular), 1e-12 * norm(angular));
    EXPECT_LT(norm(free_b.momentum_W - (sb.momentum_W + both.impulse_W)), 1e-14 * norm(free_b.momentum_W));
    EXPECT_LT(norm(b.pose(free_b).p - X_WB.p), 1e-13);
  }
}

TEST(Latch, CaptureByALinkIsTheOneJointClosedForm) {
  // A rod of 70 kg and 5 m about z catches, at its tip, a point-like 10 kg at 0.1 m/s: w = m v r / (I + m
  // r^2).
  MechanismDescription description{.name = "rod", .links = {{.name = "base"}, {.name = "rod"}}, .joints = {}};
  JointDescription joint;
  joint.name = "pivot";
  joint.kind = JointKind::revolute;
  joint.parent = "base";
  joint.child = "rod";
  description.joints.push_back(joint);
  const Mechanism mechanism(description);
  const double I = 70.0 * 25.0 / 3.0, spin = 10.0 * 1e-6 / 6.0;  // of a 1 mm cube: not quite a point
  std::vector<BodyInertia> links = {{}, {70.0, {2.5, 0, 0}, Vector3(0, I / 4, I / 4).asDiagonal()}};
  const MechanismDynamics before(mechanism, links);
  auto placed = before.make_workspace();
  std::vector<double> q = {0.0}, qd = {0.0};
  before.place({}, q, qd, placed);
  const RigidBody payload(box_inertia(10.0, {1e-3, 1e-3, 1e-3}), "payload");
  Pose X;
  X.p = {5, 0, 0};
  const RigidBodyState state = payload.state(X, {0, 0.1, 0}, {0, 0, 0.3});
  links[1] = latched_link(links[1], before.link_pose(1, placed), payload, state);
  const MechanismDynamics after(mechanism, links);
  capture(before, placed, after, 1, state, q, qd);
  EXPECT_NEAR(qd[0], (10.0 * 0.1 * 5.0 + spin * 0.3) / (I + 250.0 + spin), 1e-15);
}

}  // namespace

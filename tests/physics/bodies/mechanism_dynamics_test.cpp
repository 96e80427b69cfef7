#include "touchstone/physics/bodies/mechanism_dynamics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/solver/cholesky.hpp"
#include "touchstone/tests/physics/arms.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/refusal.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

const Vector3 kGravity(0.3, -9.8, 1.1);

TEST(MechanismDynamics, ThreeAlgorithmsAgree) {
  std::mt19937_64 random(11);
  for (int i = 0; i < 60; ++i) {
    Arm arm = random_arm(random, i % 2 == 1);
    if (i % 3 == 2) arm.mechanism = arm.mechanism.with_base(std::to_string(i % 7));
    const MechanismDynamics dynamics(arm.mechanism, arm.links);
    auto workspace = dynamics.make_workspace();
    const std::size_t n = dynamics.size();
    const auto q = random_values(random, n, 3.0), qd = random_values(random, n, 1.0),
               qdd = random_values(random, n, 1.0);
    dynamics.place(random_pose(random, 1.0), q, qd, workspace);

    std::vector<double> tau(n), bias(n), M(n * n), got(n);
    dynamics.inverse_dynamics(kGravity, qdd, tau, workspace);
    ASSERT_TRUE(dynamics.forward_dynamics(kGravity, tau, got, workspace));
    EXPECT_LT(relative_error(got, qdd), 1e-11);

    // M qdd + bias = tau, and 1/2 qd M qd is the energy that the bodies have.
    dynamics.inverse_dynamics(kGravity, std::vector<double>(n, 0.0), bias, workspace);
    dynamics.mass_matrix(M, workspace);
    double twice = 0.0;
    for (std::size_t r = 0; r < n; ++r) {
      double sum = bias[r];
      for (std::size_t c = 0; c < n; ++c) sum += M[r * n + c] * qdd[c], twice += qd[r] * M[r * n + c] * qd[c];
      got[r] = sum;
    }
    EXPECT_LT(relative_error(got, tau), 1e-13);
    EXPECT_NEAR(dynamics.kinetic_energy(workspace), 0.5 * twice, 1e-13 * twice);
  }
}

TEST(MechanismDynamics, LinksAreWhereTheMechanismHasThem) {
  std::mt19937_64 random(12);
  for (int i = 0; i < 20; ++i) {
    Arm arm = random_arm(random, true);
    if (i % 2 == 1) arm.mechanism = arm.mechanism.with_base("4");
    const MechanismDynamics dynamics(arm.mechanism, arm.links);
    auto workspace = dynamics.make_workspace();
    const auto q = random_values(random, 7, 3.0), qd = random_values(random, 7, 1.0);
    const Pose X = random_pose(random, 1.0);
    dynamics.place(X, q, qd, workspace);
    std::vector<Pose> X_WL(arm.mechanism.links().size());
    arm.mechanism.link_poses(rigid_frame(X), q, X_WL);
    for (std::uint32_t link = 0; link < X_WL.size(); ++link) {
      const Pose got = dynamics.link_pose(link, workspace);
      EXPECT_LT((got.R - X_WL[link].R).cwiseAbs().maxCoeff(), 2e-14);
      EXPECT_LT(norm(got.p - X_WL[link].p), 1e-13);
    }
  }
}

TEST(MechanismDynamics, JacobianIsTheVelocityOfAPoint) {
  // An arm and a point on its last but one link.
  std::mt19937_64 random(13);
  const Arm arm = random_arm(random, true);
  const MechanismDynamics dynamics(arm.mechanism, arm.links);
  auto workspace = dynamics.make_workspace();
  const auto q = random_values(random, 7, 3.0), qd = random_values(random, 7, 1.0);
  const Vector3 p_L = random_vector(random, 1.0);
  const std::uint32_t link = 6;
  // The point's velocity by differences of its place.
  const auto position_at = [&](double t) {
    std::vector<double> there = q;
    for (std::size_t i = 0; i < 7; ++i) there[i] += t * qd[i];
    dynamics.place({}, there, qd, workspace);
    return touchstone::transform(dynamics.link_pose(link, workspace), p_L);
  };
  const double h = 1e-5;
  const Vector3 expected = (position_at(h) - position_at(-h)) / (2 * h);
  const Vector3 p_W = position_at(0.0);
  EXPECT_LT(norm(dynamics.point_velocity(link, p_W, workspace) - expected), 1e-9);
  // What its acceleration is beyond that of the rates is its bias.
  std::vector<double> qdd(7);
  ASSERT_TRUE(dynamics.forward_dynamics(Vector3::Zero(), random_values(random, 7, 5.0), qdd, workspace));
  const Vector3 acceleration = dynamics.point_acceleration(link, p_W, Vector3::Zero(), workspace);
  const Vector3 bias = dynamics.bias_acceleration(link, p_W, workspace);
  // The Jacobian's rows give the same; the joint beyond the link has no share.
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> J(7);
    dynamics.point_jacobian(link, p_W, Vector3::Unit(axis), J, workspace);
    double along = 0.0;
    for (std::size_t i = 0; i < 7; ++i) along += J[i] * qd[i];
    EXPECT_NEAR(along, expected[axis], 1e-9);
    EXPECT_EQ(J[6], 0.0);  // beyond the link
    double by_rates = 0.0;
    for (std::size_t i = 0; i < 7; ++i) by_rates += J[i] * qdd[i];
    EXPECT_NEAR(bias[axis], acceleration[axis] - by_rates, 1e-11);
  }
}

TEST(MechanismDynamics, TorqueFreeArmKeepsItsEnergyForAMinute) {
  const Arm arm = ssrms_arm();
  const MechanismDynamics dynamics(arm.mechanism, arm.links);
  auto workspace = dynamics.make_workspace();
  // Up to twice the arm's own limit; on the way its light end joints turn at up to 4.2 rad/s.
  std::vector<double> q = {0.1, 0.4, -0.8, 1.2, 0.5, -0.3, 0.2},
                      qd = {0.06, -0.1, 0.08, 0.14, -0.12, 0.1, 0.14};
  const std::vector<double> tau(7, 0.0);
  const Vector3 weightless = Vector3::Zero();
  dynamics.place({}, q, qd, workspace);
  const double energy0 = dynamics.kinetic_energy(workspace);
  double drift = 0.0;
  const std::size_t allocations = allocation_count();
  for (int step = 0; step < 60'000; ++step) {
    ASSERT_TRUE(dynamics.step({}, weightless, tau, 1e-3, q, qd, workspace));
    drift = std::max(drift, std::abs(dynamics.kinetic_energy(workspace) - energy0) / energy0);
  }
  EXPECT_EQ(allocation_count(), allocations);
  std::printf("energy drift %.1e over 60 s, %.0f J, rates at the end %g %g %g\n", drift, energy0, qd[0],
              qd[3], qd[6]);
  EXPECT_LT(drift, 1.2e-12);  // ten times what comes out
}

TEST(MechanismDynamics, ShortFlightsLeaveNoMoreThanTheirWholeStep) {
  // By methods of lower orders: against the same in two steps, with what two steps say of the whole one.
  std::mt19937_64 random(17);
  const double h = 1e-2, ulp = 0x1p-52;
  for (int round = 0; round < 400; ++round) {
    const Arm arm = round % 4 == 0 ? ssrms_arm() : random_arm(random, round % 4 == 1);
    const MechanismDynamics dynamics(arm.mechanism, arm.links);
    auto workspace = dynamics.make_workspace();
    const Vector3 gravity(0, 0, round % 2 == 0 ? 0.0 : -9.81);
    const double extent = std::pow(10.0, uniform(random, -4, 0.5));
    const std::vector<double> q0 = random_values(random, 7, 1.5), qd0 = random_values(random, 7, extent),
                              tau(7, 0.0);
    const auto difference = [&](double t, double share) {
      std::vector<double> q = q0, qd = qd0, other_q = q0, other_qd = qd0;
      dynamics.place({}, q, qd, workspace);
      EXPECT_TRUE(dynamics.begin_flight(gravity, tau, qd, workspace, workspace));
      EXPECT_TRUE(dynamics.fly({}, gravity, tau, t, share, q, qd, workspace));
      for (int half = 0; half < 2; ++half)
        EXPECT_TRUE(dynamics.step({}, gravity, tau, 0.5 * t, other_q, other_qd, workspace));
      return relative_error(qd, other_qd);
    };
    const double whole = difference(h, 1.0);
    for (const double share : {1.0 / 33, 1.0 / 205, 1.0 / 17501})
      EXPECT_LE(difference(share * h, share), std::max(whole, 16.0 * ulp)) << round << ", " << share;
  }
}

TEST(MechanismDynamics, PhysicalPendulumsPeriodIsTheEllipticIntegral) {
  // A rod of length L let go at 90 deg: T = 4 K(1/2) sqrt(2 L / (3 g)), K(m = 1/2) = Gamma(1/4)^2 / (4 sqrt
  // pi).
  const double L = 1.5, g = 9.81;
  MechanismDescription description{
      .name = "pendulum", .links = {{.name = "base"}, {.name = "rod"}}, .joints = {}};
  description.joints.push_back(
      {.name = "pivot", .kind = JointKind::revolute, .parent = "base", .child = "rod"});
  const Mechanism mechanism(description);
  const std::vector<BodyInertia> links = {
      {}, {2.0, {0, -L / 2, 0}, Vector3(2.0 * L * L / 12, 0.0, 2.0 * L * L / 12).asDiagonal()}};
  const MechanismDynamics dynamics(mechanism, links);
  auto workspace = dynamics.make_workspace();
  const double gamma = std::tgamma(0.25);
  const double K = gamma * gamma / (4.0 * std::sqrt(std::numbers::pi));
  const double period = 4.0 * K * std::sqrt(2.0 * L / (3.0 * g));
  const std::vector<double> tau = {0.0};
  const auto error = [&](int steps) {
    std::vector<double> q = {std::numbers::pi / 2}, qd = {0.0};
    for (int step = 0; step < steps; ++step)
      EXPECT_TRUE(dynamics.step({}, {0, -g, 0}, tau, period / steps, q, qd, workspace));
    return std::abs(qd[0]);
  };
  EXPECT_LT(error(2000), 1e-12);
  EXPECT_GT(error(100) / error(200), 50.0);  // of order 6: 64
}

TEST(MechanismDynamics, MassMatrixOfTheTwoJointArmIsTheClosedForm) {
  // Two slender links of 5 m, 70 kg, elbow at 90 deg: M11 = m L^2/3 + m (L^2 + L^2/4) + m L^2/12, M12 = M22 =
  // m L^2/3 (as cos q2 is 0).
  MechanismDescription description{
      .name = "two", .links = {{.name = "base"}, {.name = "upper"}, {.name = "lower"}}, .joints = {}};
  for (int i = 0; i < 2; ++i) {
    JointDescription joint{.name = i == 0 ? "shoulder" : "elbow",
                           .kind = JointKind::revolute,
                           .parent = description.links[i].name,
                           .child = description.links[i + 1].name};
    joint.X_PJ.p = {i == 0 ? 0.0 : 5.0, 0, 0};
    description.joints.push_back(joint);
  }
  const double rod = 70.0 * 25.0 / 12.0;
  const BodyInertia link{70.0, {2.5, 0, 0}, Vector3(0.0, rod, rod).asDiagonal()};
  const Mechanism mechanism(description);
  const MechanismDynamics dynamics(mechanism, std::vector<BodyInertia>{{}, link, link});
  auto workspace = dynamics.make_workspace();
  std::vector<double> M(4);
  dynamics.place({}, std::vector<double>{0.0, std::numbers::pi / 2}, std::vector<double>{0.0, 0.0},
                 workspace);
  dynamics.mass_matrix(M, workspace);
  EXPECT_NEAR(M[0], 2916.0 + 2.0 / 3.0, 1e-12);
  EXPECT_NEAR(M[1], 583.0 + 1.0 / 3.0, 1e-12);
  EXPECT_EQ(M[1], M[2]);
  EXPECT_NEAR(M[3], 583.0 + 1.0 / 3.0, 1e-12);
  EXPECT_EQ(dynamics.moved_masses()[0], 140.0);
  EXPECT_EQ(dynamics.moved_masses()[1], 70.0);
}

TEST(MechanismDynamics, BadInertiasAreRefusedByName) {
  std::mt19937_64 random(14);
  const Arm arm = random_arm(random, false);
  const auto error = [&](std::vector<BodyInertia> links) {
    return refusal_of([&] { const MechanismDynamics dynamics(arm.mechanism, links); });
  };
  std::vector<BodyInertia> links = arm.links;
  EXPECT_EQ(error(links), "accepted");
  links[3].mass = -1.0;
  EXPECT_THAT(error(links), testing::StartsWith("mechanism 'arm', link '3': the mass is -1"));
  links = arm.links;
  links[2].inertia_B = Vector3(1, 1, 3).asDiagonal();
  EXPECT_THAT(error(links), testing::HasSubstr("link '2': principal moments 1, 1, 3"));
  links = arm.links;
  links[7] = BodyInertia{};
  EXPECT_THAT(error(links), testing::HasSubstr("joint 'j6': nothing with inertia moves with it"));
  links.pop_back();
  EXPECT_THAT(error(links), testing::HasSubstr("7 inertias for 8 links"));
  // The arm's published inertias as they are carried: about the links' frames, where they cannot be.
  const Mechanism ssrms(make_ssrms());
  EXPECT_THROW(MechanismDynamics{ssrms}, InputError);
}

TEST(Cholesky, SolvesAndRefuses) {
  std::vector<double> A = {4, 2, 0, 2, 5, 1, 0, 1, 3}, x = {8, 15, 11};
  ASSERT_TRUE(factor_cholesky(A, 3));
  solve_cholesky(A, x);
  EXPECT_NEAR(x[0], 1.0, 1e-15);
  EXPECT_NEAR(x[1], 2.0, 1e-15);
  EXPECT_NEAR(x[2], 3.0, 1e-15);
  std::vector<double> singular = {1, 1, 1, 1};
  EXPECT_FALSE(factor_cholesky(singular, 2));
}

}  // namespace

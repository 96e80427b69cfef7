#include "touchstone/physics/bodies/rigid_body.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/bodies/compensated_sum.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/random_poses.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

/// Angular momentum as anybody else would compute it: from the attitude and the angular velocity.
Vector3 angular_momentum(const RigidBody& body, const RigidBodyState& state) {
  const Matrix3 I_W = turned(body.pose(state).R, body.inertia().inertia_B);
  return rotate(I_W, body.angular_velocity(state));
}

TEST(FreeFlight, PetersAndHsusComplexCase) {
  // The published body and flight.
  const RigidBody body(box_inertia(10.0, {0.1, 0.4, 0.9}), "box");
  const Vector3 gravity(0, 0, -9.8), v0(-2, 2, 8), w0(0.1, 5.0, 0.1);
  RigidBodyState state = body.state({}, v0, w0);
  const auto energy = [&] {
    return body.kinetic_energy(state) - body.inertia().mass * dot(gravity, state.p_W);
  };
  const double energy0 = energy();
  const Vector3 L0 = angular_momentum(body, state);
  double position_error = 0.0, momentum_error = 0.0, energy_error = 0.0;
  const std::size_t allocations = allocation_count();
  // The worst of all steps.
  for (int step = 1; step <= 10'000; ++step) {
    ASSERT_TRUE(body.fly(state, 1e-3, gravity));
    const double t = step * 1e-3;
    const Vector3 p = t * v0 + (0.5 * t * t) * gravity;
    position_error = std::max(position_error, norm(state.p_W - p));
    momentum_error = std::max(momentum_error, norm(angular_momentum(body, state) - L0) / norm(L0));
    energy_error = std::max(energy_error, std::abs(energy() - energy0) / energy0);
  }
  EXPECT_EQ(allocation_count(), allocations);
  std::printf("position %.1e m, angular momentum %.1e, energy %.1e\n", position_error, momentum_error,
              energy_error);
  EXPECT_LT(position_error, 2e-12);  // ten times what comes out, as the others
  EXPECT_LT(momentum_error, 1e-14);
  EXPECT_LT(energy_error, 5e-13);
}

TEST(FreeFlight, SymmetricTopIsTheClosedForm) {
  // Moments a, a, c: the axis precesses about L at |L| / a, the body spins about it at w3 (a - c) / a.
  const double a = 2.0, c = 3.0;
  const RigidBody body({1.0, Vector3::Zero(), Vector3(a, a, c).asDiagonal()}, "top");
  const Vector3 w0(0.3, 0.0, 2.0);
  RigidBodyState state = body.state({}, Vector3::Zero(), w0);
  const Vector3 L = state.angular_W;
  for (int step = 1; step <= 1000; ++step) {
    ASSERT_TRUE(body.fly(state, 0.01, Vector3::Zero()));
    const double t = step * 0.01;
    const Matrix3 R = product(rotation_matrix(quaternion_of_turn((t / a) * L)),
                              rotation_matrix(quaternion_of_turn({0, 0, t * w0.z() * (a - c) / a})));
    ASSERT_LT((body.pose(state).R - R).cwiseAbs().maxCoeff(), 1e-13) << t;
  }
}

TEST(FreeFlight, StepsDoNotShow) {
  // A tumbling body in one step of 0.2 s or in 200 of 1 ms: the series says what it leaves out.
  std::mt19937_64 random(2);
  for (int i = 0; i < 100; ++i) {
    const Vector3 size = random_vector(random, 0.1, 1.0);
    BodyInertia inertia = box_inertia(3.0, size);
    inertia = transform({random_rotation(random), random_vector(random, 1.0)}, inertia);
    const RigidBody body(inertia, "box");
    const Vector3 v = random_vector(random, 3.0), w = random_vector(random, 10.0);
    RigidBodyState once = body.state(random_pose(random, 2.0), v, w), often = once;
    ASSERT_TRUE(body.fly(once, 0.2, Vector3::Zero()));
    for (int step = 0; step < 200; ++step) ASSERT_TRUE(body.fly(often, 1e-3, Vector3::Zero()));
    EXPECT_LT((body.pose(once).R - body.pose(often).R).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT(norm(once.p_W - often.p_W), 1e-14);
  }
}

TEST(FreeFlight, TimeRunsBackwardsToTheStart) {
  const RigidBody body(box_inertia(1.0, {1, 2, 3}), "box");
  const RigidBodyState start = body.state({}, {1, 2, 3}, {0.1, 4.0, 0.1});
  RigidBodyState state = start;
  for (int step = 0; step < 1000; ++step) ASSERT_TRUE(body.fly(state, 1e-3, {0, 0, -9.8}));
  for (int step = 0; step < 1000; ++step) ASSERT_TRUE(body.fly(state, -1e-3, {0, 0, -9.8}));
  EXPECT_LT((body.pose(state).R - body.pose(start).R).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LT(norm(state.p_W - start.p_W), 1e-14);
}

TEST(FreeFlight, StateAndPoseAreEachOthersInverse) {
  std::mt19937_64 random(3);
  const BodyInertia inertia = transform({random_rotation(random), {1, 2, 3}}, box_inertia(2.0, {1, 2, 3}));
  const RigidBody body(inertia, "box");
  for (int i = 0; i < 100; ++i) {
    const Pose X = random_pose(random, 5.0);
    const Vector3 v = random_vector(random, 1.0), w = random_vector(random, 1.0);
    const RigidBodyState state = body.state(X, v, w);
    EXPECT_LT((body.pose(state).R - X.R).cwiseAbs().maxCoeff(), 2e-15);
    EXPECT_LT(norm(body.pose(state).p - X.p), 1e-14);
    EXPECT_LT(norm(body.velocity(state) - v), 1e-15);
    EXPECT_LT(norm(body.angular_velocity(state) - w), 1e-14);
  }
}

TEST(FreeFlight, WhatIsNotFiniteOrTurnsTooFarKeepsTheLastState) {
  const RigidBody body(box_inertia(1.0, {1, 1, 1}), "box");
  RigidBodyState state = body.state({}, {1, 0, 0}, {0, 0, 1000.0});
  const RigidBodyState before = state;
  EXPECT_FALSE(body.fly(state, 0.1, Vector3::Zero()));
  EXPECT_FALSE(body.fly(state, 1e-3, {0, 0, std::nan("")}));
  EXPECT_EQ(state.p_W, before.p_W);
  EXPECT_EQ(state.q_WB.w, before.q_WB.w);
  EXPECT_TRUE(body.fly(state, 1e-3, Vector3::Zero()));
}

TEST(RigidBody, WaysAndTurnsThatAreKeptBackComeTogether) {
  constexpr double kKeptBack = 1e-12, kWay = 3e-14, kTurn = 2e-13;
  const RigidBody body(box_inertia(1.0, {0.2, 0.2, 0.2}), "cube");
  RigidBodyState state = body.state({}, Vector3::Zero(), Vector3::Zero());
  int moves = 0, turns = 0;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i) {
    const RigidBodyState from = state;
    add_compensated(state.p_W, state.p_low_W, {kWay, 0, 0});
    body.keep_place(state, from, kKeptBack);
    RigidBody::turn_by(state, {0, 0, kTurn}, body.least_turn(kKeptBack));
    moves += state.p_W != from.p_W ? 1 : 0;
    turns += state.q_WB.v != from.q_WB.v ? 1 : 0;
    EXPECT_LE(norm(state.p_low_W), kKeptBack);
    EXPECT_LE(norm(state.turn_low_W), body.least_turn(kKeptBack));
  }
  EXPECT_NEAR(state.p_W.x() + state.p_low_W.x(), kSteps * kWay, 1e-20);
  EXPECT_NEAR(2.0 * state.q_WB.v.z() + state.turn_low_W.z(), kSteps * kTurn, 1e-20);
  // One in 34 steps, and in 62: 1e-12 m are 1.2e-11 rad at the radius of gyration.
  EXPECT_NEAR(moves, kSteps * kWay / kKeptBack, 2);
  EXPECT_NEAR(turns, kSteps * kTurn / body.least_turn(kKeptBack), 2);
}

TEST(RigidBody, ImpulsesAtAPointKeepTheMomentumOfBoth) {
  std::mt19937_64 random(4);
  const RigidBody light(box_inertia(1e-3, {0.2, 0.2, 0.2}), "light");
  const RigidBody heavy(box_inertia(1e5, {4, 4, 4}), "heavy");
  RigidBodyState a = light.state(random_pose(random, 2.0), {1, 0, 0}, {0, 1, 0});
  RigidBodyState b = heavy.state(random_pose(random, 2.0), Vector3::Zero(), Vector3::Zero());
  const auto total = [&] {
    return Vector3(cross(a.p_W, a.momentum_W) + cross(b.p_W, b.momentum_W) + (a.angular_W + b.angular_W));
  };
  const Vector3 before = total();
  for (int i = 0; i < 1000; ++i) {
    const Vector3 at = random_vector(random, 2.0), impulse = random_vector(random, 1e-3);
    RigidBody::apply_impulse(a, impulse, at);
    RigidBody::apply_impulse(b, -impulse, at);
  }
  EXPECT_LT(norm(total() - before), 1e-15);
}

}  // namespace

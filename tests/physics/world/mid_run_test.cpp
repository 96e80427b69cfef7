// Changes of a dynamics world between its steps: pushes, snapshots, bodies that come and go.

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/physics/arms.hpp"
#include "touchstone/tests/physics/cubes.hpp"

namespace touchstone::physics {
namespace {

const Vector3 kZero = Vector3::Zero();

TEST(Push, AFreeBodyGoesAsItsForceAndMomentSay) {
  DynamicsWorld world({});
  const RigidBody cube(box_inertia(2.0, {1, 1, 1}), "cube");
  const auto body = world.add_body(cube, cube.state({}, kZero, kZero));
  const double h = 1e-3;
  for (int i = 0; i < 100; ++i) {
    world.push(Mover::of_body(body), {3, 0, 0}, world.pose(body).p + Vector3(0, 0.5, 0));
    world.push(Mover::of_body(body), {1, 0, 0}, world.pose(body).p, {0, 0, 0.5});
    ASSERT_EQ(world.step(h, {}).failure, StepFailure::none);
  }
  const double t = 0.1, inertia = 2.0 / 6.0, moment = 0.5 - 1.5;
  EXPECT_NEAR(world.pose(body).p.x(), 0.5 * (4.0 / 2.0) * t * t, 1e-15);
  EXPECT_NEAR(world.velocity(body).x(), 4.0 / 2.0 * t, 1e-15);
  EXPECT_NEAR(world.angular_velocity(body).z(), moment * t / inertia, 1e-14);
  EXPECT_NEAR(world.pose(body).R(1, 0), std::sin(0.5 * moment / inertia * t * t), 1e-14);
  const Vector3 v = world.velocity(body);
  ASSERT_EQ(world.step(h, {}).failure, StepFailure::none);  // over: each was for one step
  EXPECT_EQ(world.velocity(body), v);
}

TEST(Push, WhatItMakesNotFiniteIsNotSaidToTurnTooFar) {
  // It turns by 40 rad, where 64 are the most; its place overflows.
  DynamicsWorld world({});
  const double mass = 1e-7, h = 1e-3, moment = 40.0 * (mass / 6.0) / (h * h);
  const RigidBody cube(box_inertia(mass, {1, 1, 1}), "cube");
  const auto body = world.add_body(cube, cube.state({}, kZero, kZero));
  world.push(Mover::of_body(body), {1.7e308, 0, 0}, kZero, {0, 0, moment});
  EXPECT_EQ(world.step(h, {}).failure, StepFailure::body);
  world.push(Mover::of_body(body), kZero, kZero, {0, 0, 2.0 * moment});
  EXPECT_EQ(world.step(h, {}).failure, StepFailure::turn);
  EXPECT_EQ(world.pose(body).p, kZero);
}

TEST(Push, ABlockSlidesWhereThePushIsMoreThanFriction) {
  for (const double force : {4.0, 6.0}) {  // friction holds 4.905 N
    Cubes scene;
    scene.add_ground();
    const auto cube = scene.add_cube({0, 0, 0.5 * kCubeSide});
    scene.contacts->build();
    for (int i = 0; i < 200; ++i) {
      scene.world.push(Mover::of_body(cube), {force, 0, 0}, Vector3(scene.world.pose(cube).p.x(), 0, 0));
      ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
    }
    EXPECT_NEAR(scene.world.velocity(cube).x(), std::max(0.0, force - 0.5 * 9.81) * 0.2, 1e-9) << force;
  }
}

TEST(Push, WhatCarriesAPartOfTheWeightLeavesTheGroundTheRest) {
  // A cube, and a stack of more than 21 points, which goes through a step in one piece. Impulses that hold
  // what is pushed give no energy, though they are less than its weight takes.
  for (const int count : {1, 6})
    for (const double share : {0.2, 0.5, 0.9})
      for (const double h : {1e-3, 1.0 / 240.0}) {
        Cubes scene;
        scene.add_ground();
        std::vector<std::uint32_t> cubes;
        for (int i = 0; i < count; ++i) cubes.push_back(scene.add_cube({0, 0, (i + 0.5) * kCubeSide}));
        scene.contacts->build();
        const double top = (count - 0.5) * kCubeSide;
        for (int i = 0; i < 60; ++i) {
          scene.world.push(Mover::of_body(cubes.back()), {0, 0, share * 9.81},
                           scene.world.pose(cubes.back()).p);
          const StepReport report = scene.step(h);
          ASSERT_EQ(report.failure, StepFailure::none);
          EXPECT_EQ(report.unconverged, 0U) << count << ' ' << share << ' ' << h << ' ' << i;
        }
        // Each contact closes by its gap.
        EXPECT_NEAR(scene.world.pose(cubes.back()).p.z(), top, 1e-9 * count)
            << count << ' ' << share << ' ' << h;
      }
}

TEST(Push, WakesWhatSleeps) {
  Cubes scene;
  DynamicsWorld::Settings settings = scene.world.settings();
  settings.sleep_time = 0.05;
  scene.world = DynamicsWorld(settings);
  scene.add_ground();
  const auto cube = scene.add_cube({0, 0, 0.5 * kCubeSide});
  scene.contacts->build();
  for (int i = 0; i < 100; ++i) ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
  ASSERT_TRUE(scene.world.is_asleep(cube));
  scene.world.push(Mover::of_body(cube), {0, 0, 20}, scene.world.pose(cube).p);
  EXPECT_FALSE(scene.world.is_asleep(cube));
  ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
  EXPECT_NEAR(scene.world.velocity(cube).z(), (20.0 - 9.81) * 1e-3, 1e-12);
}

TEST(Push, ALinkIsHeldByTheTorquesThatBalanceIt) {
  const Arm arm = ssrms_arm();
  const MechanismDynamics dynamics(arm.mechanism, arm.links);
  const std::vector<double> q{0.1, 0.4, -0.3, 0.5, 0.2, -0.6, 0.3}, zero(7, 0.0);
  DynamicsWorld world({});
  const auto ssrms = world.add_mechanism(dynamics, {}, q, zero);
  const auto link = static_cast<std::uint32_t>(arm.mechanism.links().size() - 1);
  const Vector3 force(30, -20, 10), moment(-5, 8, 3),
      p = transform(world.link_pose(ssrms, link), Vector3(0.1, 0.2, 0.3));
  auto placed = dynamics.make_workspace();
  dynamics.place({}, q, zero, placed);
  std::vector<double> by_force(7), by_moment(7);
  dynamics.point_jacobian(link, p, force, by_force, placed);
  dynamics.turn_jacobian(link, moment, by_moment, placed);
  for (std::uint32_t i = 0; i < 7; ++i) world.set_drive(ssrms, i, {.torque = -(by_force[i] + by_moment[i])});
  world.push(Mover::of_link(ssrms, link), force, p, moment);
  ASSERT_EQ(world.step(1e-2, {}).failure, StepFailure::none);
  for (std::uint32_t i = 0; i < 7; ++i) {
    EXPECT_NEAR(world.joint_rates(ssrms)[i], 0.0, 1e-13) << i;
    EXPECT_NEAR(world.joint_torques(ssrms)[i], -(by_force[i] + by_moment[i]), 1e-10) << i;
  }
  ASSERT_EQ(world.step(1e-2, {}).failure, StepFailure::none);  // the drives alone
  EXPECT_GT(norm(world.link_angular_velocity(ssrms, link)), 1e-4);
}

TEST(Push, WhatCannotBePushedIsRefusedByName) {
  DynamicsWorld world({});
  const auto commanded = world.add_kinematic({}, kZero, kZero);
  const RigidBody cube(box_inertia(1.0, {1, 1, 1}), "cube");
  const auto body = world.add_body(cube, cube.state({}, kZero, kZero));
  EXPECT_THROW(world.push(Mover::ground(), {1, 0, 0}, kZero), InputError);
  EXPECT_THROW(world.push(Mover::of_body(commanded), {1, 0, 0}, kZero), InputError);
  EXPECT_THROW(world.push(Mover::of_body(7), {1, 0, 0}, kZero), InputError);
  EXPECT_THROW(world.push(Mover::of_link(0, 0), {1, 0, 0}, kZero), InputError);
  EXPECT_THROW(world.push(Mover::of_body(body), {NAN, 0, 0}, kZero), InputError);
  ASSERT_EQ(world.step(1e-3, {}).failure, StepFailure::none);
  EXPECT_EQ(world.velocity(body), kZero);
}

TEST(Snapshot, StepsAfterItHaveTheSameBits) {
  // A leaning stack, of which the top is pushed.
  Cubes scene;
  scene.add_ground();
  std::vector<std::uint32_t> cubes;
  for (int i = 0; i < 9; ++i) cubes.push_back(scene.add_cube({0.03 * (i % 3), 0, 0.101 + 0.21 * i}));
  scene.contacts->build();
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      scene.world.push(Mover::of_body(cubes[8]), {2, 1, 0}, scene.world.pose(cubes[8]).p);
      ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
    }
  };
  // Copied in the middle; from there the run is the same twice.
  run(120);
  const DynamicsWorld kept = scene.world;
  std::vector<RigidBodyState> first;
  for (int again = 0; again < 2; ++again) {
    run(150);
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      const RigidBodyState& state = scene.world.state(cubes[i]);
      if (again == 0) first.push_back(state);
      EXPECT_EQ(state.p_W, first[i].p_W) << i;
      EXPECT_EQ(state.momentum_W, first[i].momentum_W) << i;
      EXPECT_EQ(state.angular_W, first[i].angular_W) << i;
      EXPECT_EQ(state.q_WB.w, first[i].q_WB.w) << i;
      EXPECT_EQ(state.q_WB.v, first[i].q_WB.v) << i;
    }
    scene.world = kept;
  }
}

TEST(MidRun, BodiesComeAndGo) {
  Cubes scene;
  scene.add_ground();
  const auto low = scene.add_cube({0, 0, 0.1}), high = scene.add_cube({0, 0, 0.3});
  scene.contacts->build();
  for (int i = 0; i < 50; ++i) ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
  scene.world.hold_out(low);
  scene.contacts->hold_out(1);  // the part after the ground's
  for (int i = 0; i < 400; ++i) ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
  EXPECT_NEAR(scene.world.pose(high).p.z(), 0.1, 1e-6);
  const auto late = scene.add_cube({0, 0, 0.3});
  scene.contacts->build();
  for (int i = 0; i < 400; ++i) ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
  EXPECT_NEAR(scene.world.pose(late).p.z(), 0.3, 1e-6);
  EXPECT_LT(norm(scene.world.velocity(late)), 1e-9);
}

}  // namespace
}  // namespace touchstone::physics

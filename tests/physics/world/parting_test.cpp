// Overlap is parted slowly and without momentum; bodies at rest go to sleep.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "touchstone/tests/physics/cubes.hpp"

namespace touchstone::physics {
namespace {

TEST(Parting, OverlapAtTheStartLeavesAtACappedSpeedWithoutMomentum) {
  Cubes scene;
  DynamicsWorld::Settings settings;
  scene.world = DynamicsWorld(settings);
  const auto a = scene.add_cube({-0.09, 0, 0}), b = scene.add_cube({0.09, 0, 0});  // 2 cm
  scene.contacts->build();
  double before = 0.18;
  for (int i = 0; i < 1800; ++i) {
    ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
    const Vector3 p_a = scene.world.pose(a).p, p_b = scene.world.pose(b).p;
    EXPECT_LE(p_b.x() - p_a.x() - before, 1.01 * settings.part_speed * 1e-3);
    before = p_b.x() - p_a.x();
    EXPECT_LT(norm(scene.world.velocity(a)) + norm(scene.world.angular_velocity(a)), 1e-12) << i;
    EXPECT_LT(norm(p_a + p_b), 1e-12);
  }
  EXPECT_NEAR(before, 0.2, 1.05e-4);  // less than 0.1 mm is left alone
}

TEST(Parting, OverlapIsPartedInStepsOfOnePiece) {
  // Two cubes on the ground, most of the one in the other: when their points slide, stop and meet within a
  // step means nothing, and is not searched for. Work ended in hundreds of these steps when it was.
  Cubes scene;
  scene.add_ground();
  const auto a = scene.add_cube({0, 0, 0.1}), b = scene.add_cube({0.01, 0, 0.1});
  scene.contacts->build();
  std::uint32_t spent = 0, newton_steps = 0, late = 0;
  for (int i = 0; i < 6000; ++i) {
    const StepReport report = scene.step(1e-3);
    ASSERT_EQ(report.failure, StepFailure::none);
    EXPECT_LE(report.substeps, i < 4000 ? 1U : 16U) << i;
    spent += report.is_work_spent ? 1 : 0;
    newton_steps = std::max(newton_steps, report.newton_steps);
    if (i >= 5000) late += report.newton_steps > 0 ? 1 : 0;
  }
  EXPECT_LT(spent, 100U);        // 24; 718
  EXPECT_LT(newton_steps, 30U);  // 16; 59
  EXPECT_LT(late, 200U);         // 84: at rest forces hold, and are found anew now and then
  EXPECT_NEAR(norm(scene.world.pose(a).p - scene.world.pose(b).p), 0.2, 2e-3);
}

TEST(Parting, CubesSpawnedInTheGroundComeUpAndRest) {
  Cubes scene;
  scene.add_ground();
  std::vector<std::uint32_t> cubes;
  for (int i = 1; i <= 5; ++i) cubes.push_back(scene.add_cube({0.5 * i, 0, 0.1 - 0.01 * i}));
  scene.contacts->build();
  for (int i = 0; i < 2500; ++i) ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
  for (const std::uint32_t cube : cubes) {
    EXPECT_NEAR(scene.world.pose(cube).p.z(), 0.1, 1.05e-4);
    EXPECT_LT(norm(scene.world.velocity(cube)), 1e-6);
  }
}

TEST(Sleep, WhatRestsSleepsUntilItIsTouched) {
  // Three cubes that lie on each other, and one that falls on them.
  Cubes scene;
  DynamicsWorld::Settings settings = scene.world.settings();
  settings.sleep_time = 0.1;
  scene.world = DynamicsWorld(settings);
  scene.add_ground();
  for (int i = 0; i < 3; ++i) scene.add_cube({0, 0, 0.1 + 0.2 * i});
  const auto late = scene.add_cube({0, 0, 1.1});  // 0.4 m above: 0.29 s
  scene.contacts->build();
  // Those that lie sleep before it arrives, without contacts,
  for (int i = 0; i < 200; ++i) ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
  EXPECT_EQ(scene.world.sleepers(), 3U);
  EXPECT_FALSE(scene.world.is_asleep(late));
  EXPECT_TRUE(scene.contacts->find(scene.world).empty());
  // wake as they are hit, and sleep again with it.
  for (int i = 0; i < 100; ++i) ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
  EXPECT_EQ(scene.world.sleepers(), 0U);  // hit
  for (int i = 0; i < 300; ++i) ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
  EXPECT_EQ(scene.world.sleepers(), 4U);
  EXPECT_TRUE(scene.world.is_at_rest());
  EXPECT_NEAR(scene.world.pose(late).p.z(), 0.7, 3e-6);
  // Asleep nothing moves; woken, all that lies together wakes.
  const Vector3 p = scene.world.pose(late).p;
  ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
  EXPECT_EQ(scene.world.pose(late).p, p);
  scene.world.wake(late);
  EXPECT_EQ(scene.world.sleepers(), 0U);  // with all that it lies on
  EXPECT_EQ(scene.contacts->find(scene.world).size(), 16U);
}

}  // namespace
}  // namespace touchstone::physics

// Steps that are bounded: what stacks, pyramids, walls and queues need to come to rest where they stand.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/tests/physics/cubes.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone::physics {
namespace {

TEST(BoundedSteps, StacksOfAnyHeightRest) {
  for (const int height : {17, 50}) {
    Cubes scene;
    scene.add_ground();
    for (int i = 0; i < height; ++i) scene.add_cube({0, 0, kCubeSide * (0.5 + i)});
    scene.contacts->build();
    const double before = scene.world.energy();
    for (int step = 0; step < 300; ++step) {
      const StepReport report = scene.step(1e-3);
      ASSERT_EQ(report.failure, StepFailure::none);
      EXPECT_EQ(report.unconverged, 0U) << step;
    }
    double speed = 0.0, drift = 0.0;
    for (std::uint32_t i = 1; i <= static_cast<std::uint32_t>(height); ++i) {
      speed = std::max(speed, norm(scene.world.velocity(i)));
      drift = std::max(drift, norm(scene.world.pose(i).p - Vector3(0, 0, kCubeSide * (i - 0.5))));
    }
    EXPECT_LT(speed, 1e-5) << height;
    EXPECT_LT(drift, 1e-6) << height;
    EXPECT_LT(scene.world.energy() - before, 1e-6 * before);
  }
}

TEST(BoundedSteps, TowersAllocateNothingAfterTheFirstStep) {
  for (const int height : {10, 40, -40, 60, -100}) {
    Cubes scene;
    scene.add_ground();
    const double shift = height < 0 ? 0.003 : 0.0;
    for (int i = 0; i < std::abs(height); ++i) scene.add_cube({shift * (i % 2), 0, kCubeSide * (0.5 + i)});
    scene.contacts->build();
    const auto room = static_cast<std::size_t>(8 * std::abs(height));
    scene.contacts->reserve(room, room);
    scene.world.reserve(room);
    ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
    for (int i = 0; i < 50; ++i) {
      const std::size_t before = allocation_count();
      const std::span<const Contact> contacts = scene.contacts->find(scene.world, 1e-3);
      EXPECT_EQ(allocation_count(), before) << height << " high, contacts of step " << i;
      const std::size_t found = allocation_count();
      ASSERT_EQ(scene.world.step(1e-3, contacts).failure, StepFailure::none);
      EXPECT_EQ(allocation_count(), found) << height << " high, step " << i;
    }
  }
}

TEST(BoundedSteps, PointsThatComeAndGoLeaveThePairHeldAsItWas) {
  // Edges that lie in each other: two points come up in the middle of them, and two corners get other names.
  Cubes scene;
  const auto cube = scene.add_cube({0, 0, 0.1});
  const auto point = [&](double x, double y, std::uint64_t key) {
    const Vector3 p(x, y, 0);
    return Contact{Mover::ground(), Mover::of_body(cube), {0, 0, 1}, p, p, 0.5, 0.0, key};
  };
  const std::vector<Contact> four{point(-0.1, -0.1, 1), point(-0.1, 0.1, 2), point(0.1, 0.1, 3),
                                  point(0.1, -0.1, 4)};
  const std::vector<Contact> six{point(-0.1, -0.1, 1), point(-0.1, 0.1, 2), point(0.02, 0.1, 5),
                                 point(0.1, 0.1, 6),   point(0.1, -0.1, 7), point(0.02, -0.1, 8)};
  std::vector<ContactForce> forces(6);
  const auto step = [&](const std::vector<Contact>& contacts) {
    ASSERT_EQ(scene.world.step(1e-3, contacts, forces).failure, StepFailure::none);
  };
  for (int i = 0; i < 3; ++i) step(four);
  const std::vector<ContactForce> before = forces;
  step(six);
  const std::size_t corner_of_six[] = {0, 1, 3, 4};
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(forces[corner_of_six[i]].force_W.z(), before[i].force_W.z(), 1e-9) << i;
  for (const std::size_t middle : {2U, 5U}) EXPECT_NEAR(forces[middle].force_W.z(), 0.0, 1e-9);
  step(four);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(forces[i].force_W.z(), before[i].force_W.z(), 1e-9) << i;
}

TEST(BoundedSteps, APyramidRestsWhereItStandsAtDisplayRate) {
  Cubes scene;
  scene.add_ground();
  std::vector<Vector3> places;
  for (int row = 0; row < 6; ++row)
    for (int i = 0; i < 6 - row; ++i) {
      places.emplace_back(0.21 * (i - 0.5 * (5 - row)), 0, kCubeSide * (0.5 + row));
      scene.add_cube(places.back());
    }
  scene.contacts->build();
  const double before = scene.world.energy();
  for (int i = 0; i < 720; ++i) ASSERT_EQ(scene.step(1.0 / 240.0).failure, StepFailure::none);
  for (std::uint32_t i = 0; i < places.size(); ++i) {
    EXPECT_LT(norm(scene.world.velocity(i + 1)), 1e-4) << i;
    EXPECT_LT(norm(scene.world.pose(i + 1).p - places[i]), 5e-5) << i;
  }
  EXPECT_LT(scene.world.energy() - before, 1e-4);
}

TEST(BoundedSteps, WhatTumblesToRestGainsNoEnergy) {
  // Thrown, by an edge and by a corner, over each other in pairs.
  for (const double h : {1e-3, 1.0 / 240.0}) {
    double most = 0.0, sum = 0.0;
    for (int run = 0; run < 6; ++run) {
      Cubes scene;
      scene.add_ground();
      for (int i = 0; i < 2; ++i) {
        const auto cube = scene.add_cube({0.35 * i, 0, 0.2});
        Pose X_WB = at({0.35 * i, 0, 0.2});
        X_WB.R = rotation_about(Vector3(0.6, 0.8 * (run % 2), 0.8 * (1 - run % 2)), 0.3 + 0.2 * run);
        scene.world.set_state(cube,
                              scene.cube.state(X_WB, {1.0 - 2.0 * i, 0.1 * run, 0}, {3.0, 8.0 - run, 1.0}));
      }
      scene.contacts->build();
      for (int i = 0; i < static_cast<int>(1.0 / h); ++i) {
        const double before = scene.world.energy();
        ASSERT_EQ(scene.step(h).failure, StepFailure::none);
        const double gained = scene.world.energy() - before;
        most = std::max(most, gained), sum += std::max(0.0, gained);
      }
    }
    std::printf("tumbling by %.4f s: a step gives %.1e J at most, all %.1e J\n", h, most, sum);
    // 9.4e-4 and 1.3e-3 where the laws hold for velocities of the middle of a step.
    EXPECT_LT(sum, h > 2e-3 ? 6e-4 : 5e-5) << h;
  }
}

/// A wall of rows, each second one shifted by a share of a cube: at rest after 1.5 s, where it was.
void expect_wall_rests(int rows, int columns, double shift, double most_drift) {
  Cubes scene;
  scene.add_ground();
  std::vector<Vector3> places;
  for (int row = 0; row < rows; ++row)
    for (int i = 0; i < columns; ++i) {
      places.emplace_back(kCubeSide * (i + (row % 2 == 1 ? shift : 0.0)), 0, kCubeSide * (0.5 + row));
      scene.add_cube(places.back());
    }
  scene.contacts->build();
  const double before = scene.world.energy();
  constexpr int kSteps = 360;
  std::uint32_t unconverged = 0, late_unconverged = 0;
  for (int i = 0; i < kSteps; ++i) {
    const StepReport report = scene.step(1.0 / 240.0);
    ASSERT_EQ(report.failure, StepFailure::none);
    (i < kSteps / 3 ? unconverged : late_unconverged) += report.unconverged;
  }
  EXPECT_LT(unconverged, 12U) << shift;
  EXPECT_EQ(late_unconverged, 0U) << shift;
  double speed = 0.0, drift = 0.0;
  for (std::uint32_t i = 0; i < places.size(); ++i) {
    speed = std::max(speed, norm(scene.world.velocity(i + 1)));
    drift = std::max(drift, norm(scene.world.pose(i + 1).p - places[i]));
  }
  EXPECT_LT(speed, 1e-7) << shift;
  EXPECT_LT(drift, most_drift) << shift;
  EXPECT_LT(scene.world.energy() - before, 1e-3) << shift;
}

TEST(BoundedSteps, AWallComesToRestWhereItStandsAtDisplayRate) {
  // 748 points, none held at first. With half of the work for them the wall crept by 0.5 mm.
  expect_wall_rests(12, 6, 0.4, 1e-4);
  // In columns that touch, 480 points. With the 392 along edges of cubes of two rows and columns these crept
  // by 0.04 mm, and with half of the work as well fell on each other by 0.4 mm at first and never rested.
  expect_wall_rests(8, 8, 0.0, 1e-6);
}

TEST(BoundedSteps, WhatRestsIsHeldToTheExactToleranceAndKeepsItsPoses) {
  // 21 cubes, 80 points: an island that ContactSolver does not take.
  Cubes scene;
  scene.add_ground();
  for (int row = 0; row < 6; ++row)
    for (int i = 0; i < 6 - row; ++i)
      scene.add_cube({0.21 * (i - 0.5 * (5 - row)), 0, kCubeSide * (0.5 + row)});
  scene.contacts->build();
  for (int i = 0; i < 300; ++i) ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
  std::vector<Vector3> places(22);
  std::uint32_t solved = 0, moved = 0;
  constexpr std::uint32_t kSteps = 200;
  for (std::uint32_t step = 0; step < kSteps; ++step) {
    for (std::uint32_t i = 1; i <= 21; ++i) places[i] = scene.world.pose(i).p;
    const StepReport report = scene.step(1e-3);
    ASSERT_EQ(report.failure, StepFailure::none);
    EXPECT_LT(report.worst_residual, 1e-8);
    solved += report.newton_steps > 0 ? 1 : 0;
    for (std::uint32_t i = 1; i <= 21; ++i) moved += scene.world.pose(i).p != places[i] ? 1 : 0;
  }
  EXPECT_LT(solved, kSteps / 10);
  EXPECT_LT(moved, 21 * kSteps / 10);
}

TEST(BoundedSteps, AQueueAtAStopRestsOnABeltThatRunsOn) {
  // The belt slides beneath it as fast as ever: taken for moving, the queue crept by 11 um. Of friction 0.45
  // and more 26 Newton steps and more find what holds it: left unfinished it crept by 13 um in 5 000 steps,
  // of which the 2 000 here see the beginning.
  for (const double friction : {0.3, 0.45, 0.51, 0.6}) {
    Cubes scene;
    const auto add = [&](std::uint32_t body, const HexahedronTree& tree) {
      scene.contacts->add(Mover::of_body(body), tree, {friction, 0.0});
      return body;
    };
    const double half = 0.5 * kCubeSide;
    add(scene.world.add_kinematic(at(0, 0, -0.5), {1, 0, 0}, Vector3::Zero()), scene.ground_tree);
    add(scene.world.add_kinematic(at(half, 0, half + 0.01), Vector3::Zero(), Vector3::Zero()),
        scene.cube_tree);
    const Vector3 places[2] = {{-half, 0, half}, {-3.0 * half, 0, half}};
    std::uint32_t queue[2];
    for (int i = 0; i < 2; ++i) {
      const RigidBodyState state = scene.cube.state(at(places[i]), Vector3::Zero(), Vector3::Zero());
      queue[i] = add(scene.world.add_body(scene.cube, state), scene.cube_tree);
    }
    scene.contacts->build();
    // It settles by the contact gap of 1 nm, as what is put against anything.
    Vector3 settled[2];
    for (int i = 0; i < 2000; ++i) {
      const StepReport report = scene.step(1e-3);
      ASSERT_EQ(report.failure, StepFailure::none);
      EXPECT_EQ(report.unconverged, 0U) << friction << " at " << i;
      for (int k = 0; i == 100 && k < 2; ++k) settled[k] = scene.world.pose(queue[k]).p;
    }
    for (int i = 0; i < 2; ++i) {
      EXPECT_LT(norm(settled[i] - places[i]), 1e-8) << friction << ", " << i;
      EXPECT_LT(norm(scene.world.pose(queue[i]).p - settled[i]), 1e-9) << friction << ", " << i;
    }
  }
}

}  // namespace
}  // namespace touchstone::physics

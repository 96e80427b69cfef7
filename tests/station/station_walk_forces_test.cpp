#include <gtest/gtest.h>

#include "touchstone/examples/measures/common/allocations.hpp"
#include "touchstone/tests/station/forces_pilot.hpp"
#include "touchstone/tests/station/walking_pilot.hpp"

// The arm that walks, with forces: where its base changes the simulation goes on with the arm held by its
// other end, with what is carried, at the rates that there were.

namespace touchstone::station {
namespace {

void walk(ForcesPilot& pilot) {
  take_hold(pilot);
  let_go(pilot, 1);
  ASSERT_TRUE(move_to(pilot, {-6.0, 0.0, 0.54}));
  swing(pilot, 180.0);
  ASSERT_TRUE(move_to(pilot, {6.0, 0.0, 0.54}));
  ASSERT_TRUE(move_to(pilot, {6.0, 0.0, kHeld}));
  ASSERT_TRUE(pilot.set({Kind::latch, true, Control::kAny}).done);
  pilot.step({});
}

TEST(StationWalkForces, AnArmWalksFromFixtureToFixture) {
  ForcesPilot pilot("walk_off");
  walk(pilot);
  // On, with the middle fixture let go: the arm stands on its first end again.
  let_go(pilot, 0);
  ASSERT_TRUE(move_to(pilot, {0.0, 0.0, 0.54}));
  for (std::size_t task = 0; task < 3; ++task) EXPECT_TRUE(pilot.is_within(task)) << task;
  EXPECT_GT(pilot.figures().torque_share, 0.0);
  EXPECT_EQ(pilot.figures().failed_steps, 0U);
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationWalkForces, AnOruOnTheBoomComesAlong) {
  ForcesPilot pilot("walk_loaded");
  const auto on_boom = [&] {
    return compose(inverse(pilot.pose_of("ssrms.lower_boom")), pilot.pose_of("stowed_oru"));
  };
  const Pose before = on_boom();
  walk(pilot);
  EXPECT_LT(largest_step(std::vector{before}, std::vector{on_boom()}), 1e-9);
  for (std::size_t task = 0; task < 3; ++task)
    EXPECT_TRUE(pilot.is_within(task))
        << task << ": " << pilot.figures().largest_force << " N, " << pilot.figures().contacts
        << " contacts, after " << pilot.figures().done_at[task] << " s";
  EXPECT_EQ(pilot.figures().failed_steps, 0U);
  EXPECT_EQ(pilot.merged, 0);
  EXPECT_EQ(replayed(pilot, pilot.inputs), pilot.session.hash());
  EXPECT_NE(replayed(pilot, without_releases(pilot)), pilot.session.hash());
}

TEST(StationWalkForces, NothingMovesWhenTheBaseChangesNorWhileBothEndsAreHeld) {
  ForcesPilot pilot("walk_loaded");
  take_hold(pilot);
  for (int frame = 0; frame < 50; ++frame)
    pilot.step({});  // the joint that holds takes the arm's last motion
  const std::vector<Pose> held = poses_of(pilot);
  for (int frame = 0; frame < 20; ++frame) pilot.step(ahead(-1.0));
  EXPECT_FALSE(pilot.drive("elbow_pitch", 1.0, 0.5));
  EXPECT_LT(largest_step(held, poses_of(pilot)), 1e-9) << "held by both ends";
  const std::vector<Pose> locked = poses_of(pilot);
  let_go(pilot, 1);
  EXPECT_LT(largest_step(locked, poses_of(pilot)), 1e-12);
  pilot.step({});
  EXPECT_LT(largest_step(locked, poses_of(pilot)), 1e-9);
  // The end that was the base flies now, and the other one stands still to the last bit.
  const Pose stands_on = pilot.pose_of("ssrms.tip_lee");
  ASSERT_TRUE(move_to(pilot, {-6.0, 0.0, 0.54}));
  EXPECT_EQ(norm(pilot.pose_of("ssrms.tip_lee").p - stands_on.p), 0.0);
  EXPECT_GT(norm(pilot.pose_of("ssrms.base_lee").p - locked[pilot.scenes[0]->arm()->first_object].p), 0.4);
}

TEST(StationWalkForces, TheEndThatWasTakenLastMayGoAgain) {
  ForcesPilot pilot("walk_off");
  take_hold(pilot);
  let_go(pilot, 0);
  EXPECT_FALSE(pilot.flight().stance().is_locked());
  EXPECT_TRUE(pilot.fly_to({0.0, 0.0, 0.5}, 0.1)) << "nothing holds it any more";
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationWalkForces, TheMastPressesBackAfterTheBaseHasChanged) {
  ForcesPilot pilot("walk_off");
  take_hold(pilot);
  let_go(pilot, 1);
  ASSERT_TRUE(move_to(pilot, {-6.0, 0.0, 0.54}));
  EXPECT_FALSE(swing(pilot, -180.0));
  EXPECT_GT(pilot.figures().largest_force, 10.0);
  EXPECT_GT(pilot.blocked, 100);
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationWalkForces, WhatIsSwitchedOffAndThePolicyStayThroughAWalk) {
  ForcesPilot pilot("walk_off");
  const std::size_t mast = find_object(pilot.scenes[0]->setting.scene(), "mast");
  ASSERT_TRUE(pilot.set({Kind::select, false, static_cast<std::uint32_t>(mast)}).done);
  take_hold(pilot);
  let_go(pilot, 1);
  ASSERT_TRUE(move_to(pilot, {-6.0, 0.0, 0.54}));
  swing(pilot, -120.0);
  EXPECT_EQ(pilot.figures().largest_force, 0.0) << "through the mast, which is not checked";
}

TEST(StationWalkForces, StepsAfterAWalkAllocateNothing) {
  if (!measures::thread_allocations()) GTEST_SKIP() << "not counted here";
  ForcesPilot pilot("walk_loaded");
  take_hold(pilot);
  const auto fly = [&](int frames) {
    for (int frame = 0; frame < frames; ++frame) pilot.session.step(ahead(frame % 7 < 4 ? -0.5 : 0.3));
  };
  const auto allocated = [&](int frames) {
    const auto before = measures::thread_allocations();
    fly(frames);
    return *measures::thread_allocations() - *before;
  };
  fly(20);
  EXPECT_EQ(allocated(50), 0U) << "held by both ends";
  let_go(pilot, 1);
  fly(20);
  EXPECT_EQ(allocated(100), 0U);
}

}  // namespace
}  // namespace touchstone::station

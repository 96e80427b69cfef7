#include <gtest/gtest.h>

#include <filesystem>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/measures/common/allocations.hpp"
#include "touchstone/tests/station/walking_pilot.hpp"
#include "touchstone/tests/support/program_test.hpp"

// The arm that walks end over end: which end it stands on changes between frames, in the same world.

namespace touchstone::station {
namespace {

TEST(StationWalk, AnArmWalksFromFixtureToFixture) {
  Pilot pilot("walk_off", kOurs | kUnchecked);
  take_hold(pilot);
  let_go(pilot, 1);
  ASSERT_TRUE(move_to(pilot, {-6.0, 0.0, 0.54}));
  EXPECT_TRUE(pilot.is_done(0));
  EXPECT_TRUE(pilot.is_done(1));
  ASSERT_TRUE(swing(pilot, 180.0));
  ASSERT_TRUE(move_to(pilot, {6.0, 0.0, 0.54}));
  ASSERT_TRUE(move_to(pilot, {6.0, 0.0, kHeld}));
  ASSERT_TRUE(pilot.set({Kind::latch, true, Control::kAny}).done);
  // It walks on: the middle fixture is let go, and the arm stands on its first end again.
  const Vector3 base = pilot.tip().p;
  let_go(pilot, 0);
  ASSERT_TRUE(move_to(pilot, {0.0, 0.0, 0.54}));
  for (std::size_t task = 0; task < 3; ++task) {
    EXPECT_TRUE(pilot.is_done(task)) << task;
    EXPECT_TRUE(pilot.is_within(task)) << task;
  }
  EXPECT_LT(norm(transform(pilot.pose_of("ssrms.base_lee"), Vector3::Zero()) - base), 1e-12);
  EXPECT_EQ(pilot.flight().stance().fixture_of(1), find_object(pilot.scenes[0]->setting.scene(), "pdgf_c"));
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationWalk, NothingMovesWhenTheBaseChangesNorWhileBothEndsAreHeld) {
  Pilot pilot("walk_off");
  take_hold(pilot);
  const std::vector<Pose> held = poses_of(pilot);
  for (int frame = 0; frame < 20; ++frame) pilot.step(ahead(-1.0));
  EXPECT_EQ(largest_step(held, poses_of(pilot)), 0.0) << "held by both ends";
  EXPECT_FALSE(pilot.drive("elbow_pitch", 1.0, 0.5));
  EXPECT_EQ(largest_step(held, poses_of(pilot)), 0.0) << "in joint mode";
  let_go(pilot, 1);
  EXPECT_LT(largest_step(held, poses_of(pilot)), 1e-13);
  pilot.step({});
  EXPECT_LT(largest_step(held, poses_of(pilot)), 1e-13);
  // The end that was the base flies now, and the other one stands still to the last bit.
  const Pose stands_on = pilot.pose_of("ssrms.tip_lee");
  ASSERT_TRUE(move_to(pilot, {-6.0, 0.0, 0.54}));
  EXPECT_EQ(norm(pilot.pose_of("ssrms.tip_lee").p - stands_on.p), 0.0);
  EXPECT_GT(norm(pilot.pose_of("ssrms.base_lee").p - held[pilot.scenes[0]->arm()->first_object].p), 0.4);
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationWalk, TheMastStopsASwingOverItsSide) {
  Pilot pilot("walk_off", kOurs | kUnchecked);
  take_hold(pilot);
  let_go(pilot, 1);
  ASSERT_TRUE(move_to(pilot, {-6.0, 0.0, 0.54}));
  ASSERT_TRUE(pilot.set({Kind::policy, true, static_cast<std::uint32_t>(ContactPolicy::advance)}).done);
  EXPECT_FALSE(swing(pilot, -180.0));
  EXPECT_GT(pilot.blocked, 100);
  EXPECT_FALSE(pilot.is_done(2));
  EXPECT_EQ(pilot.merged, 0);
  EXPECT_GT(pilot.unchecked_merged, 100);
}

TEST(StationWalk, AFlightThatWalksReplaysToTheSameBits) {
  Pilot pilot("walk_off", kAllMethods);
  take_hold(pilot);
  let_go(pilot, 1);
  ASSERT_TRUE(move_to(pilot, {-6.0, 0.0, 0.3}));
  EXPECT_EQ(replayed(pilot, pilot.inputs), pilot.session.hash());
  EXPECT_NE(replayed(pilot, without_releases(pilot)), pilot.session.hash());
}

TEST(StationWalk, WhatTheArmCarriesComesAlong) {
  Pilot pilot("walk_loaded", kAllMethods);
  const auto on_boom = [&] {
    return compose(inverse(pilot.pose_of("ssrms.lower_boom")), pilot.pose_of("stowed_oru"));
  };
  const Pose before = on_boom();
  take_hold(pilot);
  const std::vector<Pose> held = poses_of(pilot);
  let_go(pilot, 1);
  pilot.step({});
  EXPECT_LT(largest_step(held, poses_of(pilot)), 1e-13);
  ASSERT_TRUE(move_to(pilot, {-6.0, 0.0, 0.54}));
  ASSERT_TRUE(swing(pilot, 60.0));
  EXPECT_LT(largest_step(std::vector{before}, std::vector{on_boom()}), 1e-12);
  EXPECT_EQ(replayed(pilot, pilot.inputs), pilot.session.hash());
  // It is let go as anything that is carried.
  ASSERT_TRUE(pilot.set({Kind::release}).done);
  const Vector3 left = pilot.pose_of("stowed_oru").p;
  for (int frame = 0; frame < 10; ++frame) pilot.step(ahead(-1.0));
  EXPECT_EQ(pilot.pose_of("stowed_oru").p, left);
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationWalk, StepsAfterAWalkAllocateNothing) {
  if (!measures::thread_allocations()) GTEST_SKIP() << "not counted here";
  Pilot pilot("walk_off");
  take_hold(pilot);
  let_go(pilot, 1);
  const auto fly = [&](int frames) {
    for (int frame = 0; frame < frames; ++frame) pilot.session.step(ahead(frame % 7 < 4 ? -0.5 : 0.3));
  };
  fly(20);
  const auto before = measures::thread_allocations();
  fly(100);
  EXPECT_EQ(*measures::thread_allocations() - *before, 0U);
}

TEST(StationWalk, ResetBringsTheFirstBaseBack) {
  Pilot pilot("walk_off");
  const std::vector<Pose> start = poses_of(pilot);
  take_hold(pilot);
  let_go(pilot, 1);
  ASSERT_TRUE(move_to(pilot, {-6.0, 0.0, 0.3}));
  ASSERT_TRUE(pilot.set({Kind::reset}).done);
  EXPECT_EQ(largest_step(start, poses_of(pilot)), 0.0);
  EXPECT_EQ(pilot.flight().state().tip, 0U);
  EXPECT_FALSE(pilot.flight().stance().is_held(0));
  EXPECT_TRUE(pilot.fly_to({0.0, 0.0, 0.5}));
}

TEST(StationWalk, SaysWhatItDoesNotDo) {
  Pilot pilot("walk_off");
  const auto refused = [&](const Control& control) {
    const ControlAnswer answer = pilot.set(control);
    EXPECT_FALSE(answer.done) << answer.text;
    return answer.text;
  };
  EXPECT_EQ(refused({Kind::latch, true, Control::kAny}), "nothing within reach of the latch");
  EXPECT_EQ(refused({Kind::release}), "nothing is carried");
  EXPECT_EQ(refused({Kind::tip, true, 1}), "the arm stands on base_tip");
  // Upright over the probe but turned by 12 degrees it is not held; the bore is wide enough for that.
  ASSERT_TRUE(pilot.fly_to({0.0, 0.0, 0.5}));
  Vector6 turned = Vector6::Zero();
  turned[3] = 12.0 * kDegree;
  ASSERT_TRUE(pilot.fly_to({0.0, 0.0, 0.09}, 0.1, 30.0, pose_from_position_vector(turned).R * Pilot::down()));
  EXPECT_EQ(refused({Kind::latch, true, Control::kAny}), "nothing within reach of the latch");
  take_hold(pilot);
  ASSERT_TRUE(pilot.set({Kind::tip, true, 0}).done);
  EXPECT_TRUE(pilot.set({Kind::release}).done) << "the end that was taken last may go again";
  EXPECT_FALSE(pilot.flight().stance().is_locked());
  EXPECT_TRUE(pilot.fly_to({0.0, 0.0, 0.5}, 0.1));
  EXPECT_EQ(pilot.merged, 0);
}

using StationWalkScript = FolderTest;

TEST_F(StationWalkScript, ThatHoldsWhatItCannotIsRefused) {
  const std::filesystem::path bundled = STATION_SCENES;
  const std::string script = read(bundled / "walk_off.yaml");
  std::string scene = (bundled / "parts/walk_scene.yaml").string();
  const auto refusal = [&](const std::string& from, const std::string& to) {
    std::string text = script;
    text.replace(text.find("parts/walk_scene.yaml"), 21, scene);
    const std::size_t place = text.find(from);
    EXPECT_NE(place, std::string::npos) << from;
    text.replace(place, from.size(), to);
    try {
      load_station_scene(write("own_walk.yaml", text), kRate);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const std::string of = "script 'Walk-off, end over end': ";
  EXPECT_EQ(refusal("time: 0, hold", "time: 1, hold"),
            of + "an arm that walks is held by one fixture at time 0");
  EXPECT_EQ(refusal("time: 1, hold", "time: 0, hold"),
            of + "an arm that walks is held by one fixture at time 0");
  EXPECT_EQ(refusal("pdgf_a, link: ssrms.base_lee", "pdgf_a, link: ssrms.tip_lee"),
            of + "an arm that walks stands at first on its base");
  EXPECT_EQ(refusal("pdgf_b, link: ssrms.base_lee", "pdgf_b, link: ssrms.upper_boom"),
            of + "pdgf_b holds ssrms.upper_boom: that link is no end of the arm");
  const std::string file = (folder_ / "own_walk.yaml").string() + ":18: actions: hold: ";
  EXPECT_EQ(refusal("fixture: pdgf_b", "fixture: ssrms.tip_lee"), file + "fixture: is a link of an arm");
  EXPECT_EQ(refusal("pdgf_b, link: ssrms.base_lee", "pdgf_b, link: mast"),
            file + "link: is no link of an arm");
  const std::string action = "  - {time: 1, hold: {fixture: pdgf_b, link: ssrms.base_lee}}\n";
  EXPECT_EQ(refusal(action, action + "  - {time: 1, latch: {carrier: mast, carried: pdgf_b}}\n"),
            of + "pdgf_b holds ssrms.base_lee: what may move holds no arm");
  EXPECT_EQ(refusal("ssrms_walking", "ssrms"), of + "pdgf_a holds ssrms.base_lee: the arm has not two ends");
  // The arm 0.11 m aside, and its fixture turned by 12 degrees, then by 8.
  const std::string away =
      of + "an arm that walks is at time 0 within 0.1 m and 10 degrees of the fixture that holds it";
  EXPECT_EQ(refusal("position: [-0.000909,", "position: [0.109091,"), away);
  std::string parts = read(scene);
  const std::string upright = "pose: {position: [-6, 0, 0]}";
  const std::size_t place = parts.find(upright);
  ASSERT_NE(place, std::string::npos);
  parts.replace(place, upright.size(), "pose: {position: [-6, 0, 0], rpy: [12, 0, 0]}");
  scene = write("own_scene.yaml", parts).string();
  EXPECT_EQ(refusal("name:", "name:"), away);
  parts.replace(parts.find("rpy: [12, 0, 0]"), 15, "rpy: [8, 0, 0]");
  write("own_scene.yaml", parts);
  EXPECT_EQ(refusal("name:", "name:"), "accepted");
}

}  // namespace
}  // namespace touchstone::station

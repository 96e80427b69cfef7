#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/station/pilot.hpp"

// The station's tasks with jaws, two arms and rails: a scripted hand does them, merges nothing, and does not
// do them where something is in the way.

namespace touchstone::station {
namespace {

/// Both jaws on the ORU of the scene, and latched.
void take_oru(Pilot& pilot, double x, double y) {
  ASSERT_TRUE(pilot.fly_to({x, y, kOver + 0.2}));
  ASSERT_TRUE(pilot.fly_to({x, y, kOver}, 0.1));
  EXPECT_FALSE(pilot.set({Kind::latch, true, Control::kAny}).done) << "with its jaws open";
  pilot.grip(1.0, 3.0);
  const ControlAnswer answer = pilot.set({Kind::latch, true, Control::kAny});
  ASSERT_TRUE(answer.done) << answer.text;
}

void bring_home(Pilot& pilot, double x, double from_y, double to_y, std::size_t extract, std::size_t insert) {
  const double up = kOver + 0.4, down = kOver;
  ASSERT_TRUE(pilot.fly_to({x, from_y, up}, 0.1));
  EXPECT_TRUE(pilot.is_done(extract));
  ASSERT_TRUE(pilot.fly_to({x, to_y, up}));
  ASSERT_TRUE(pilot.fly_to({x, to_y, down}, 0.1));
  EXPECT_FALSE(pilot.is_done(insert)) << "while it is carried";
  ASSERT_TRUE(pilot.set({Kind::release}).done);
  pilot.grip(-1.0, 3.0);
  ASSERT_TRUE(pilot.fly_to({x, to_y, up}, 0.1));
  EXPECT_TRUE(pilot.is_done(insert));
  EXPECT_TRUE(pilot.is_within(insert));
}

TEST(StationTasks, AnOruIsExchangedByTheOtcm) {
  Pilot pilot("otcm");
  take_oru(pilot, 0.0, 0.0);
  EXPECT_TRUE(pilot.is_done(0));
  bring_home(pilot, 0.0, 0.0, -1.1, 1, 2);
  EXPECT_NEAR(pilot.pose_of("oru").p.z(), 0.001, 1e-4);
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationTasks, JawsStopOneAfterTheOtherAndAloneDoNotLatch) {
  // Scene 2 of the closed forms: 11 mm for each jaw at 5 mm/s; 3 mm aside one has 8 mm, the other 14 mm.
  Pilot pilot("otcm");
  ASSERT_TRUE(pilot.fly_to({0.0, 0.003, kOver + 0.2}));
  ASSERT_TRUE(pilot.fly_to({0.0, 0.003, kOver}, 0.1));
  pilot.grip(1.0, 1.5);
  EXPECT_NEAR(pilot.joint("left_jaw_1"), 0.0075, 1e-9);
  pilot.grip(1.0, 0.6);  // 2.1 s: one is at the stem since 1.6 s, the other on its way
  const double first = std::min(pilot.joint("left_jaw_1"), pilot.joint("right_jaw_1")),
               second = std::max(pilot.joint("left_jaw_1"), pilot.joint("right_jaw_1"));
  EXPECT_NEAR(first, 0.008, 5e-5);
  EXPECT_NEAR(second, 0.0105, 5e-5);
  EXPECT_FALSE(pilot.is_done(0));
  EXPECT_FALSE(pilot.set({Kind::latch, true, Control::kAny}).done);
  pilot.grip(1.0, 1.0);
  EXPECT_NEAR(pilot.joint("left_jaw_1") + pilot.joint("right_jaw_1"), 0.022, 1e-6);
  EXPECT_TRUE(pilot.is_done(0));
  EXPECT_TRUE(pilot.set({Kind::latch, true, Control::kAny}).done);
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationTasks, BesideItsSlotTheOruStopsAtTheRimAndIsNotInserted) {
  Pilot pilot("otcm", kOurs | kUnchecked);
  take_oru(pilot, 0.0, 0.0);
  const double up = kOver + 0.4;
  ASSERT_TRUE(pilot.fly_to({0.0, 0.0, up}, 0.1));
  ASSERT_TRUE(pilot.fly_to({0.0, -1.1 + 0.02, up}));  // 3 mm are free
  EXPECT_FALSE(pilot.fly_to({0.0, -1.1 + 0.02, kOver}, 0.1, 8.0));
  EXPECT_GT(pilot.blocked, 10);
  EXPECT_GT(pilot.pose_of("oru").p.z(), 0.2);
  ASSERT_TRUE(pilot.set({Kind::release}).done);
  pilot.grip(-1.0, 3.0);
  EXPECT_FALSE(pilot.is_done(2));
  EXPECT_EQ(pilot.merged, 0);
  EXPECT_GT(pilot.unchecked_merged, 10) << "the same hand without a check goes through the rim";
}

TEST(StationTasks, OneArmOfTheSpdmSteadiesAndTheOtherExchangesAnOru) {
  Pilot pilot("spdm");
  ASSERT_EQ(pilot.scenes[0]->tips.size(), 2U);
  ASSERT_TRUE(pilot.set({Kind::tip, true, 1}).done);
  EXPECT_FALSE(pilot.set({Kind::tip, true, 2}).done);
  ASSERT_TRUE(pilot.fly_to({-0.9, 0.9, kOver + 0.2}));
  ASSERT_TRUE(pilot.fly_to({-0.9, 0.9, kOver}, 0.1));
  pilot.grip(1.0, 3.0);
  EXPECT_TRUE(pilot.is_done(0));
  EXPECT_FALSE(pilot.set({Kind::latch, true, Control::kAny}).done) << "a stanchion is not carried";
  const Vector3 steady = pilot.tip().p;
  ASSERT_TRUE(pilot.set({Kind::tip, true, 0}).done);
  take_oru(pilot, -0.9, -0.5);
  EXPECT_TRUE(pilot.is_done(1));
  bring_home(pilot, -0.9, -0.5, -1.6, 2, 3);
  // The body's roll joint is not the hand's, so that the other arm has held on.
  ASSERT_TRUE(pilot.set({Kind::tip, true, 1}).done);
  EXPECT_LT(norm(pilot.tip().p - steady), 1e-4);
  EXPECT_EQ(pilot.joint("body_roll"), 0.0);
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationTasks, AnArmOfTheSpdmThatMeetsTheOtherStops) {
  Pilot pilot("spdm");
  EXPECT_FALSE(pilot.fly_to({-0.9, 0.92, kOver + 0.25}, 0.3, 20.0));
  EXPECT_GT(pilot.blocked, 10);
  for (std::size_t task = 0; task < 4; ++task) EXPECT_FALSE(pilot.is_done(task));
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationTasks, AFoldedArmIsMovedAlongTheTrussAndReachesItsFixture) {
  Pilot pilot("mobile_transporter");
  ASSERT_TRUE(pilot.drive("shoulder_pitch", -85.0 * kDegree, 25.0));
  ASSERT_TRUE(pilot.drive("elbow_pitch", 170.0 * kDegree, 25.0));
  ASSERT_TRUE(pilot.drive("rail", 3.0, 130.0));
  EXPECT_TRUE(pilot.is_done(0));
  EXPECT_TRUE(pilot.is_within(0));
  ASSERT_TRUE(pilot.fly_to({-3.4, -1.9, 0.78}));
  EXPECT_TRUE(pilot.is_done(1));
  EXPECT_TRUE(pilot.is_within(1));
  EXPECT_NEAR(pilot.joint("rail"), 3.0, 1e-5);  // the hand holds it
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationTasks, ARaisedArmIsStoppedByThePanelOverTheRails) {
  Pilot pilot("mobile_transporter", kOurs | kUnchecked);
  EXPECT_FALSE(pilot.drive("rail", 3.0, 40.0));
  EXPECT_GT(pilot.blocked, 100);
  EXPECT_GT(pilot.joint("rail"), 0.3);
  EXPECT_LT(pilot.joint("rail"), 1.0);
  EXPECT_FALSE(pilot.is_done(0));
  EXPECT_EQ(pilot.merged, 0);
  EXPECT_GT(pilot.unchecked_merged, 100);
}

TEST(StationTasks, GoalsCountAttitudesAndSayWhatTheyCannotMean) {
  // Tasks are read with the scene's objects and tips.
  const StationScenes scenes = bundled({"otcm"});
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "station_goals.tasks.json";
  const auto read = [&](const std::string& goal) {
    std::ofstream(file) << R"([{"name": "t", "title": "t", )" << goal << "}]";
    return read_tasks(file, scenes[0]->setting, scenes[0]->tips);
  };
  // A goal with an attitude counts within both limits.
  const StationTask task = read(
      R"("kind": "place", "object": "oru", "position": [1, 0, 0], "within": 0.1, "rpy": [0, 0, 90], "turn": 1)")
      [0];
  Pose X;
  X.p = {1.05, 0.0, 0.0};
  EXPECT_FALSE(is_at(task, X));
  const auto turned = [](double degrees) {
    Vector6 position = Vector6::Zero();
    position[5] = degrees * kDegree;
    return pose_from_position_vector(position).R;
  };
  X.R = turned(90.9);
  EXPECT_TRUE(is_at(task, X));
  X.R = turned(91.1);
  EXPECT_FALSE(is_at(task, X));
  X.R = turned(90.0);
  X.p.x() = 1.2;
  EXPECT_FALSE(is_at(task, X));
  // Goals that say nothing are refused by file and reason.
  for (const auto& [goal, why] : std::initializer_list<std::pair<const char*, const char*>>{
           {R"("kind": "fly")", "no kind of task 'fly'"},
           {R"("kind": "carry", "object": "oru", "speed": 1)", "unknown field 'speed'"},
           {R"("kind": "carry", "object": "oro")", "no object 'oro'"},
           {R"("kind": "grip", "object": "oru", "tip": "tip_2")", "no tip 'tip_2'"},
           {R"("kind": "joint", "joint": "rail", "value": 1, "within": 1)", "rail"},
           {R"("kind": "joint", "joint": "tip_frame_1", "value": 1, "within": 1)", "does not move"},
           {R"("kind": "reach", "position": [0, 0, 0], "within": 1, "rpy": [0, 0, 0])", "go together"},
           {R"("kind": "reach", "position": [0, 0], "within": 1)", "task 't'"}}) {
    try {
      read(goal);
      ADD_FAILURE() << goal;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).rfind(file.string() + ": ", 0), 0U) << error.what();
    }
  }
}

}  // namespace
}  // namespace touchstone::station

// Flights of training_run against the closed forms of their scenes. Poses are met to 2 g, times to 2 g /
// closing speed, the rounding of summed steps and 1e-12 s.

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/tests/support/degree.hpp"
#include "touchstone/tests/training/training_run_fixture.hpp"

namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using touchstone::kDegree;
using touchstone::kInfinity;
using namespace touchstone::test;

constexpr double kGap = 1e-9;

json late(const json& script) { return method(script, "figure 1"); }
json first_build(const json& script) { return method(script, "figure 2"); }
json unchecked(const json& script) { return method(script, "no check"); }

bool names(const json& stop, const std::string& object) {
  for (const json& solid : stop["pair"])
    if (solid.get<std::string>().starts_with(object + "/")) return true;
  return false;
}

/// When a pair with the object was first stopped.
double stopped(const json& method, const std::string& object, double after = -1.0) {
  double first = kInfinity;
  for (const json& stop : method["stops"]) {
    const double time = stop["time_s"];
    if (names(stop, object) && time > after) first = std::min(first, time);
  }
  return first;
}

void expect_time(double time, double closed_form, double closing_speed) {
  // Positions within 1 m are summed over no more than 2000 frames, half an ulp each.
  const double rounding = 2000 * 0x1p-54 / closing_speed + 1e-12;
  EXPECT_LE(time, closed_form + rounding);
  EXPECT_GE(time, closed_form - 2 * kGap / closing_speed - rounding);
}

/// Ours: nothing shown merged or between frames, no phantom, no false stop.
void expect_nothing_wrong(const json& world) {
  EXPECT_EQ(world["merged_frames"], 0);
  EXPECT_EQ(world["deepest_between_m"], 0.0);
  EXPECT_EQ(world["passed_through_frames"], 0);
  for (const char* figure : {"missed_frames", "phantom_frames", "false_stop_frames", "iteration_limits"})
    EXPECT_EQ(world[figure], 0) << figure;
}

/// And all stops within the gap rule.
void expect_clean(const json& script) {
  const json world = ours(script);
  expect_nothing_wrong(world);
  // The gap rule leaves room for the rounding of a separation, 32 u times the scale, at most 20 m here.
  const double rounding = 32 * 0x1p-53 * 20;
  for (const json& stop : world["stops"]) {
    EXPECT_GE(stop["clearance_m"].get<double>(), 0.5 * kGap - rounding);
    EXPECT_LE(stop["clearance_m"].get<double>(), kGap + rounding);
  }
}

/// But for the paper's coarse check, which lists what is in range anew in each frame.
void expect_no_allocation(const json& script) {
  for (const json& each : script["methods"])
    if (each["method"] != "figure 2" && !each["allocations"].is_null()) {
      EXPECT_EQ(each["allocations"], 0) << each["method"];
    }
}

double last_z(const json& method, const std::string& object) { return method["last"][object]["p_m"][2]; }

TEST_F(TrainingRun, GrappleMouthMeetsThePlate) {
  const json script = fly("01_grapple_centred");
  expect_time(stopped(ours(script), "lee"), 0.5 / 0.02, 0.02);
  EXPECT_NEAR(last_z(ours(script), "lee"), 0.0, 2 * kGap);
  EXPECT_NEAR(unchecked(script)["deepest_shown_m"].get<double>(), 0.02, 1e-12);
  expect_clean(script);
  expect_no_allocation(script);
}

TEST_F(TrainingRun, GrappleRimMeetsTheTaperOrClearsIt) {
  const json offset = fly("01_grapple_offset");
  const double mouth = 0.25443 + 0.019 * (0.019 - 0.010) / (0.019 - 0.005);
  EXPECT_NEAR(mouth, 0.266644, 5e-7);
  EXPECT_NEAR(last_z(ours(offset), "lee"), mouth, 3 * kGap);
  EXPECT_NEAR(stopped(ours(offset), "lee"), (0.5 - mouth) / 0.02, 1e-6);
  expect_clean(offset);
  const json clear = fly("01_grapple_clears");
  expect_time(stopped(ours(clear), "lee"), 25.0, 0.02);
  expect_clean(clear);
}

TEST_F(TrainingRun, ArmFliesTheApproachUnderResolvedRates) {
  const json script = fly("01_grapple_by_arm");
  // 10 s down, 4.5 s across, 15 s down. Joint values at a frame's end put the mouth where the hand asked, and
  // the contact is at one: met to the gap rule. Within a frame the joints go evenly and the mouth strays from
  // the straight way by (joint rate x frame)^2 x reach / 8, (0.02 / 4 / 50)^2 x 17 / 8 = 2e-8 m here: a
  // contact there would be known to no better than that.
  const std::string lee = "ssrms.tip_lee";
  expect_time(stopped(ours(script), lee), 29.5, 0.02);
  const json joint = ours(script)["last"][lee]["p_m"];  // the mouth is 1.3589 m below
  EXPECT_NEAR(joint[2].get<double>(), 1.3589, 2 * kGap);
  EXPECT_NEAR(joint[0].get<double>(), 0.0, 2 * kGap);
  EXPECT_NEAR(joint[1].get<double>(), 0.0, 2 * kGap);
  const json hand = ours(script)["hands"][0];
  EXPECT_EQ(hand["arm"], true);
  EXPECT_EQ(hand["limited_frames"], 0);
  EXPECT_EQ(hand["damped_frames"], 0);
  EXPECT_LE(hand["largest_residual_m"].get<double>(), 1e-13);
  for (const json& stop : ours(script)["stops"]) {
    EXPECT_TRUE(names(stop, lee));
    EXPECT_TRUE(names(stop, "fixture"));
  }
  // The other links move too, and are shown.
  EXPECT_TRUE(ours(script)["last"].contains("ssrms.upper_boom"));
  EXPECT_FALSE(ours(script)["last"].contains("ssrms.base_lee"));
  const json reported = late(script);
  EXPECT_NEAR(reported["deepest_shown_m"].get<double>(), 0.002, 0.0005);  // 100 ms and up to a frame
  expect_clean(script);
  expect_no_allocation(script);
}

TEST_F(TrainingRun, ArmBringsTheOruIntoItsGuideSliding) {
  const json script = fly("03_oru_by_arm_slide");
  const json world = ours(script);
  // 0.1 m down to the rim at 0.02 m/s; a frame's joints stray by up to 2e-8 m within it.
  EXPECT_NEAR(stopped(world, "oru"), 5.0, 2e-8 / 0.02);
  // At the bottom, but for what is left of a tilt: 0.5 m of lever at 1e-4 rad.
  EXPECT_NEAR(last_z(world, "oru"), -0.525, 5e-5);
  EXPECT_NEAR(world["last"]["oru"]["R_rows"][2][2].get<double>(), 1.0, 1e-8);
  // The end effector went all of the 0.625 m with it, and 0.103 m aside.
  EXPECT_NEAR(last_z(world, "ssrms.tip_lee"), 0.635 + 1.3589 - 0.625, 1e-4);
  EXPECT_NEAR(world["last"]["ssrms.tip_lee"]["p_m"][0].get<double>(), -0.003, 1e-4);
  // Straight aside and down it would be there after 5 + 4.7 + 26.25 s.
  bool is_down = false;
  for (const json& stop : world["stops"]) {
    const bool at_floor = stop["pair"][0] == "slot/wall.-z" || stop["pair"][1] == "slot/wall.-z";
    if (!at_floor) continue;
    is_down = true;
    EXPECT_LT(stop["time_s"].get<double>(), 35.95 + 2.0);
  }
  EXPECT_TRUE(is_down);
  // A method without slides stops on the rim.
  EXPECT_NEAR(last_z(first_build(script), "oru"), 0.0, 1e-9);
  EXPECT_GT(unchecked(script)["deepest_shown_m"].get<double>(), 0.2);
  expect_clean(script);
  expect_no_allocation(script);
}

TEST_F(TrainingRun, ArmComesDownOverTheProbeSliding) {
  const json script = fly("01_grapple_by_arm_slide");
  // On the plate, along the stem that it touches on its way, but for 4 mm: the slide has turned it a little.
  // A method without slides stops 0.16 m above.
  EXPECT_NEAR(last_z(ours(script), "ssrms.tip_lee"), 1.3589, 5e-3);
  EXPECT_GT(last_z(first_build(script), "ssrms.tip_lee"), 1.3589 + 0.15);
  expect_nothing_wrong(ours(script));  // it slides on from its stops within their frames
}

TEST_F(TrainingRun, ArmDrawsItsElbowAlongTheLabSliding) {
  const json script = fly("04_elbow_by_arm_slide");
  const json world = ours(script);
  EXPECT_NEAR(stopped(world, "ssrms.upper_boom"), 8.44, 0.02);
  // Of the 0.9 m that the hand is drawn in, it goes all but 3 % with the elbow on the Lab since. A method
  // without slides stands from there on.
  const auto drawn_in = [](const json& method) {
    return 10.5 - 1.3589 - method["last"]["ssrms.tip_lee"]["p_m"][0].get<double>();
  };
  EXPECT_GT(drawn_in(world), 0.97 * 0.9);
  EXPECT_NEAR(drawn_in(first_build(script)), 0.03 * 8.42, 1e-3);
  expect_nothing_wrong(world);
  expect_no_allocation(script);
}

TEST_F(TrainingRun, ArmAtItsLimitsSlowsDown) {
  // 1 m/s is more than joints of 4 deg/s give: rates are scaled together, and nothing is saved up.
  const fs::path fast =
      write("fast.yaml", std::string("name: x\nscene: {file: ") + TOUCHSTONE_SCENES +
                             "/grapple_approach.yaml, without: [lee]}\nunits: {angle: deg}\n"
                             "duration: 1\nhands:\n  - arm: {model: ssrms, link: tip, "
                             "joints: [10, 25, -70, 110, -35, 20, 15], pose: {position: "
                             "[0, 0, 2], rpy: [0, 90, 0]}}\n"
                             "    rates: [{time: 0, velocity: [0, 0, 1]}, {time: 0.5}]\n");
  const json script = fly(fast.string());
  EXPECT_EQ(ours(script)["hands"][0]["limited_frames"], 25);
  const double height = ours(script)["last"]["ssrms.tip_lee"]["p_m"][2];
  EXPECT_GT(height, 2 + 1.3589 + 0.01);
  EXPECT_LT(height, 2 + 1.3589 + 0.45);
  expect_clean(script);
}

#ifdef TOUCHSTONE_ROBOTS
constexpr const char* kRobot = TOUCHSTONE_ROBOTS "/mesh_arm/urdf/mesh_arm.urdf";

TEST_F(TrainingRun, ARobotWithMeshesFliesToABlockAndStops) {
  const Outcome outcome =
      run("--robot " + std::string(kRobot) + " --over box --out " + (folder_ / "run").string());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              HasSubstr("shoulder/hub: sphere, is one rounded solid, exactly\nupper/boom: mesh"));
  const json script = json::parse(read(folder_ / "run/results.json"))["scripts"][0];
  EXPECT_THAT(first_build(script)["not_flown"].get<std::string>(),
              HasSubstr("'hub' is rounded (radius 0.1 m), which backend 'edge_face' does not take"));
  EXPECT_EQ(ours(script)["merged_frames"], 0);
  EXPECT_GT(unchecked(script)["merged_frames"], 0);
  ASSERT_FALSE(ours(script)["stops"].empty());
  EXPECT_TRUE(names(ours(script)["stops"][0], "block"));
  expect_clean(script);
}

// As a CanadaArm2 of others: straight in the middle of its joints' range.
TEST_F(TrainingRun, ARobotThatIsStraightInTheMiddleOfItsRangeStartsBentAndMeetsTheBlock) {
  // Roll, yaw, three pitches, yaw and roll, each from -180 to 180 degrees.
  std::string text = "<robot name='straight'><link name='link0'/>\n";
  const std::array<std::string, 7> axes = {"1 0 0", "0 0 1", "0 1 0", "0 1 0", "0 1 0", "0 0 1", "1 0 0"};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const std::string half = i == 2 || i == 3 ? "1.5" : "0.3", before = i == 3 || i == 4 ? "3" : "0.6";
    text += "<link name='link" + std::to_string(i + 1) + "'><collision><origin xyz='" + half +
            " 0 0'/><geometry><box size='" + (half == "1.5" ? "2.8" : "0.5") +
            " 0.2 0.2'/></geometry></collision></link>\n<joint name='joint" + std::to_string(i + 1) +
            "' type='revolute'><parent link='link" + std::to_string(i) + "'/><child link='link" +
            std::to_string(i + 1) + "'/><origin xyz='" + (i == 0 ? "0" : before) + " 0 0'/><axis xyz='" +
            axes[i] + "'/><limit lower='-3.14' upper='3.14' velocity='0.5' effort='100'/></joint>\n";
  }
  // A link may have the name of the block that the robot flies to.
  std::ofstream(folder_ / "straight.urdf")
      << std::regex_replace(text, std::regex("'link1'"), "'block'") << "</robot>\n";
  const Outcome outcome =
      run("--robot " + (folder_ / "straight.urdf").string() + " --out " + (folder_ / "run").string());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  // Where it stood straight, its hand was damped in all frames and met nothing.
  const json script = json::parse(read(folder_ / "run/results.json"))["scripts"][0];
  EXPECT_EQ(ours(script)["hands"][0]["damped_frames"], 0);
  ASSERT_FALSE(ours(script)["stops"].empty());
  EXPECT_TRUE(names(ours(script)["stops"][0], "block"));
  EXPECT_GT(unchecked(script)["merged_frames"], 0);
  expect_clean(script);
}

TEST_F(TrainingRun, ARobotsSpheresAreHexahedraWhereThatIsAskedFor) {
  const Outcome outcome = run("--robot " + std::string(kRobot) + " --over box --sphere-facets 8 --out " +
                              (folder_ / "run").string());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("shoulder/hub: sphere, is 9 hexahedra, off by up to 0.0158942 m\n"));
  const json script = json::parse(read(folder_ / "run/results.json"))["scripts"][0];
  EXPECT_FALSE(first_build(script).contains("not_flown"));
}

TEST_F(TrainingRun, ARobotsMeshesAreCoveredWithinTheErrorAskedFor) {
  const auto fly_within = [&](const std::string& over) {
    return run("--robot " + std::string(kRobot) + " --over " + over + " --out " + (folder_ / "run").string());
  };
  const std::string out = fly_within("10%").out;
  EXPECT_THAT(out.substr(out.find("upper/boom: mesh")), HasSubstr("hexahedra, off"));
  EXPECT_THAT(fly_within("8").err, HasSubstr("--over: '8' is no length such as 2mm"));
}

TEST_F(TrainingRun, AScriptFliesARobotsFile) {
  const fs::path script = folder_ / "robot.yaml";
  std::ofstream(script) << "name: Robot\nscene: {file: " TOUCHSTONE_SCENES
                           "/grapple_approach.yaml, without: [lee]}\n"
                        << "duration: 1\nhands:\n  - arm: {model: " << kRobot
                        << ", link: hand, joints: [0, -1, 1, 0.3, 0.2, 0], pose: {position: [0, 0, 3]}}\n"
                        << "    rates: [{time: 0, velocity: [0, 0, 0.05]}]\n";
  const json result = fly(script.string() + " --over box");
  EXPECT_NEAR(ours(result)["last"]["mesh_arm.hand"]["p_m"][2].get<double>(), 3.05, 1e-8);
  EXPECT_THAT(run("--robot " + (folder_ / "none.urdf").string() + " --out " + (folder_ / "run").string()).err,
              HasSubstr("none.urdf: cannot be read"));
}
#endif

TEST_F(TrainingRun, JawsStopEachForItself) {
  const json centred = fly("02_jaws_centred");
  expect_time(stopped(ours(centred), "left jaw"), 2.2, 0.005);
  expect_time(stopped(ours(centred), "right jaw"), 2.2, 0.005);
  expect_clean(centred);
  const json offset = fly("02_jaws_offset");
  expect_time(stopped(ours(offset), "right jaw"), 1.6, 0.005);
  expect_time(stopped(ours(offset), "left jaw"), 2.8, 0.005);
  const json last = ours(offset)["last"];
  EXPECT_NEAR(last["right jaw"]["p_m"][0].get<double>() - last["left jaw"]["p_m"][0].get<double>() - 0.020,
              0.038, 4 * kGap);
  expect_clean(offset);
  expect_no_allocation(offset);
}

TEST_F(TrainingRun, OruIsClearMeetsTheRimOrTouchesTilted) {
  const json clear = fly("03_oru_clear");
  expect_time(stopped(ours(clear), "oru"), 0.525 / 0.02, 0.02);
  expect_clean(clear);
  const json rim = fly("03_oru_rim");
  expect_time(stopped(ours(rim), "oru"), 0.01 / 0.02, 0.02);
  expect_clean(rim);
  const json tilted = fly("03_oru_tilted");
  const double t = kDegree, W = 0.919, c = 0.003, h = (W / 2 * (1 - std::cos(t)) + c) / std::tan(t);
  EXPECT_NEAR(h, 0.175879, 5e-7);
  EXPECT_NEAR(stopped(ours(tilted), "oru"), (0.01 + h) / 0.02, 2 * kGap / std::sin(t) / 0.02);
  EXPECT_NEAR(W / 2 * std::sin(t) - last_z(ours(tilted), "oru"), h, 2 * kGap / std::sin(t));
  expect_clean(tilted);
}

TEST_F(TrainingRun, OruWedgesWithoutTurningAndBottomsWithIt) {
  const double t = kDegree, W = 0.919, c = 0.003;
  const json wedged = fly("03_oru_slide_translation");
  // The corner that touches a wall is the raised one, on the other side.
  const json last = ours(wedged)["last"]["oru"];
  const double depth = ((W + 2 * c) * std::cos(t) - W) / std::sin(t);
  EXPECT_NEAR(depth, 0.3357, 5e-5);
  const double x = last["p_m"][0], z = last["p_m"][2];
  double furthest = 0.0, depth_at_wall = 0.0;
  for (const double side : {-0.5, 0.5}) {
    const double corner_x = x + side * W * std::cos(t), corner_z = z - side * W * std::sin(t);
    if (std::abs(corner_x) > furthest) furthest = std::abs(corner_x), depth_at_wall = -corner_z;
  }
  EXPECT_NEAR(depth_at_wall, depth, 2 * kGap / std::sin(t));
  expect_clean(wedged);
  const json aligned = fly("03_oru_slide");
  EXPECT_NEAR(last_z(ours(aligned), "oru"), -0.525, 2 * kGap);
  EXPECT_NEAR(ours(aligned)["last"]["oru"]["R_rows"][0][2].get<double>(), 0.0, 1e-6);
  expect_clean(aligned);
  expect_no_allocation(aligned);
}

TEST_F(TrainingRun, ElbowIsCuedInTimeByUsAndLateByTheImageGenerator) {
  const json script = fly("04_elbow");
  const double a = std::asin(1.3589 / std::hypot(7.11, 0.175)) - std::atan2(0.175, 7.11);
  const double time = a / (4 * kDegree), closing = 7.11 * std::cos(a) * 4 * kDegree;
  EXPECT_NEAR(time, 2.401282, 5e-7);
  const json cues = ours(script)["cues"];
  ASSERT_EQ(cues.size(), 2u);
  EXPECT_EQ(cues[0]["kind"], "began");
  expect_time(cues[0]["time_s"], time, closing);
  EXPECT_EQ(cues[1]["kind"], "ended");
  EXPECT_NEAR(cues[1]["time_s"].get<double>(), 6 - time, 0.02);  // at the end of its frame
  for (const json& each : script["methods"]) {
    EXPECT_NEAR(each["deepest_shown_m"].get<double>(), 0.290528, 5e-7);
    EXPECT_EQ(each["blocked_frames"], 0);
  }
  EXPECT_EQ(ours(script)["missed_frames"], 0);
  EXPECT_EQ(ours(script)["phantom_frames"], 0);
  // Known 100 ms after the first frame shown in contact, at 2.42 s; so too its end.
  EXPECT_NEAR(late(script)["cues"][0]["time_s"].get<double>(), 2.52, 1e-12);
  EXPECT_EQ(late(script)["missed_frames"], 6);  // 2.42 to 2.52 s: shown before the report was in
  EXPECT_EQ(late(script)["phantom_frames"], 6);
  EXPECT_EQ(unchecked(script)["missed_frames"], unchecked(script)["merged_frames"]);
}

TEST_F(TrainingRun, ThinPlatesAndBarTunnelButNotWithUs) {
  const double r = 16.9628, bar = std::asin(0.005 / r) / (4 * kDegree);
  EXPECT_NEAR(bar, 4.222164e-3, 5e-10);
  for (const auto& [name, object, time, speed] : {std::tuple{"05_plates", "payload", 0.005 / 0.37, 0.37},
                                                  {"05_bar", "arm", bar, 0.999 * r * 4 * kDegree}}) {
    const json script = fly(name, "--backend native exact");
    for (const json& each : script["methods"]) {
      if (each["method"] == "contact world") {
        expect_time(stopped(each, object), time, speed);
        continue;
      }
      EXPECT_EQ(each["merged_frames"], 0) << name;  // the frames look innocent
      EXPECT_EQ(each["passed_through_frames"], 1) << name;
      EXPECT_GT(each["deepest_between_m"].get<double>(), 0.009) << name;
      EXPECT_TRUE(each["stops"].empty()) << name;
    }
    expect_clean(script);
  }
}

TEST_F(TrainingRun, LatchedOruMeetsTheGateAndReleasedDoesSoAsItself) {
  const double L = 1.050, W = 0.919;
  const double a = std::atan2(L, W) - std::acos(1.2 / std::hypot(L, W));
  EXPECT_NEAR(a / kDegree, 18.121, 5e-4);
  // The corner's speed towards the wall, at its radius.
  const double along = (L / 2 * std::cos(a) - W / 2 * std::sin(a)) * 4 * kDegree;
  const json script = fly("06_gate");
  expect_time(stopped(ours(script), "oru"), a / (4 * kDegree), along);
  expect_time(stopped(ours(script), "oru", 6.0), 8.0, along);
  for (const json& stop : ours(script)["stops"]) EXPECT_FALSE(names(stop, "tip"));
  expect_clean(script);
  expect_no_allocation(script);
  const json jump = fly("06_gate_jump", "--backend native exact");
  expect_time(stopped(ours(jump), "oru"), a / (900 * kDegree), along * 225);
  EXPECT_EQ(unchecked(jump)["merged_frames"], 0);
  EXPECT_EQ(unchecked(jump)["passed_through_frames"], 1);
  expect_clean(jump);
}

TEST_F(TrainingRun, ContainedCubeIsContactInASolidBoxOnly) {
  const json solid = fly("07_contained_solid", "--backend native exact");
  for (const json& each : solid["methods"]) {
    EXPECT_NEAR(each["deepest_shown_m"].get<double>(), 0.2725, 1e-12);
    if (each["method"] != "contact world") continue;
    EXPECT_EQ(each["cues"][0]["kind"], "penetrating_at_start");
    EXPECT_EQ(each["blocked_frames"], 0);  // it gets no deeper
    EXPECT_EQ(each["missed_frames"], 0);
    EXPECT_NEAR(each["last"]["cube"]["p_m"][0].get<double>(), 1e-4, 1e-15);
  }
  EXPECT_EQ(unchecked(solid)["missed_frames"], 10);
  EXPECT_EQ(first_build(solid)["missed_frames"], 10);  // it does not see the cube
  EXPECT_EQ(first_build(solid)["blocked_frames"], 0);
  EXPECT_EQ(late(solid)["missed_frames"], 1);
  EXPECT_EQ(late(solid)["false_stop_frames"], 9);
  const json walls = fly("07_contained_walls");
  for (const json& each : walls["methods"]) {
    EXPECT_EQ(each["merged_frames"], 0);
    EXPECT_EQ(each["blocked_frames"], 0);
    EXPECT_TRUE(each["cues"].empty());
  }
}

void expect_ghosting(const json& script, double speed) {
  const double frame = 1.0 / script["frame_rate_hz"].get<double>(), contact = 0.5 / speed;
  const double rounding = 2000 * 0x1p-54;
  const double depth = late(script)["deepest_shown_m"], time = stopped(late(script), "lee");
  EXPECT_GE(depth, 0.1 * speed - rounding) << speed;
  EXPECT_LE(depth, (0.1 + frame) * speed + rounding) << speed;
  EXPECT_NEAR(depth, speed * (time - contact), rounding + 1e-12);
  EXPECT_EQ(late(script)["false_stop_frames"], 0);
  EXPECT_EQ(late(script)["missed_frames"], late(script)["merged_frames"]);
  expect_time(stopped(ours(script), "lee"), contact, speed);
  expect_clean(script);
}

/// The paper's first build stops by what is left of a step before the contact at 0.5 m.
void expect_whole_steps(const json& script, double speed) {
  const json flown = first_build(script);
  const double rate = script["frame_rate_hz"], steps = std::floor(0.5 / (speed / rate));
  for (const char* figure : {"merged_frames", "false_stop_frames", "phantom_frames"})
    EXPECT_EQ(flown[figure], 0) << figure << " at " << rate;
  ASSERT_FALSE(flown["stops"].empty()) << rate;
  EXPECT_NEAR(flown["stops"][0]["clearance_m"].get<double>(), 0.5 - steps * speed / rate, 1e-12) << rate;
  EXPECT_NEAR(stopped(flown, "lee"), steps / rate, 1e-12) << rate;
  if (!flown["allocations"].is_null()) {
    EXPECT_GT(flown["allocations"], flown["frames"]) << rate;  // the coarse check's list
  }
}

TEST_F(TrainingRun, FigureOneGhostsFigureTwoStopsEarlyAndTheWorldDoesNeither) {
  expect_ghosting(fly("10_figure_1_assembly"), 0.02);
  const fs::path unloaded =
      write("unloaded.yaml", std::string("name: x\nscene: {file: ") + TOUCHSTONE_SCENES +
                                 "/grapple_approach.yaml}\nduration: 1.6\nhands:\n"
                                 "  - object: lee\n    rates: [{time: 0, velocity: [0, "
                                 "0, -0.37]}]\n");
  for (const char* rate : {"10", "50", "60", "100", "1000"}) {
    const json script = fly(unloaded.string(), std::string("--rate ") + rate);
    expect_whole_steps(script, 0.37);
    if (std::string(rate) == "60") {
      // 100 ms are no whole number of frames: the report waits for the next one.
      EXPECT_NEAR(stopped(late(script), "lee"), (82 + 6) / 60.0, 1e-12);
      continue;
    }
    expect_ghosting(script, 0.37);
    expect_no_allocation(script);
  }
}

TEST_F(TrainingRun, FigureTwoHoldsAllMoversOfAFrame) {
  // The other jaw is 6.1 mm from the stem when this one's step is refused.
  const json flown = first_build(fly("02_jaws_offset"));
  EXPECT_NEAR(stopped(flown, "right jaw"), 1.58, 1e-12);
  EXPECT_EQ(stopped(flown, "left jaw"), kInfinity);
  EXPECT_EQ(flown["blocked_frames"], 121);
  EXPECT_EQ(flown["false_stop_frames"], 121);
  EXPECT_EQ(flown["merged_frames"], 0);
}

TEST_F(TrainingRun, FigureTwoTellsOfCuedContactAtAFramesEnd) {
  const json flown = first_build(fly("04_elbow"));
  ASSERT_EQ(flown["cues"].size(), 2u);
  EXPECT_EQ(flown["cues"][0]["kind"], "began");
  EXPECT_NEAR(flown["cues"][0]["time_s"].get<double>(), 2.42, 1e-12);
  EXPECT_EQ(flown["cues"][1]["kind"], "ended");
  EXPECT_NEAR(flown["cues"][1]["time_s"].get<double>(), 3.60, 1e-12);
  EXPECT_EQ(flown["missed_frames"], 0);
  EXPECT_EQ(flown["phantom_frames"], 0);
}

TEST_F(TrainingRun, EveryBackendFliesAndSaysWhatItProves) {
  // Of these scripts no sampled backend but libccd_mpr has a blind spot; edge_face has in the contained cube,
  // see below.
  const std::set<std::string> sampled = {"edge_face",  "bullet", "ode",       "libccd_gjk",
                                         "libccd_mpr", "fcl",    "fcl_indep", "mujoco"};
  for (const char* name : {"05_plates", "05_bar", "02_jaws_offset", "06_gate_jump", "10_figure_1_unloaded"}) {
    const json script = fly(name, "--backend all");
    std::size_t flown = 0;
    for (const json& each : script["methods"]) {
      if (each["method"] != "contact world") continue;
      ASSERT_FALSE(each.contains("not_flown")) << each["backend"];
      EXPECT_EQ(each["check"], sampled.contains(each["backend"]) ? "sampled" : "proven") << each["backend"];
      if (std::string(name) == "02_jaws_offset" && each["backend"] == "libccd_mpr") {
        EXPECT_GT(each["merged_frames"], 0) << "MPR sees what it missed: face to face with the jaws";
        continue;
      }
      for (const char* figure : {"merged_frames", "passed_through_frames", "missed_frames", "phantom_frames"})
        EXPECT_EQ(each[figure], 0) << name << " " << each["backend"] << " " << figure;
      ++flown;
    }
    EXPECT_GE(flown, 3u);  // native, edge_face and exact are in every build that has this program
  }
}

TEST_F(TrainingRun, EdgeFaceMergesWhereItIsBlind) {
  // The paper's check sees no contact in a contained cube: edges that cross no face. It is shown so,
  // unreported.
  const json script = fly("07_contained_solid", "--backend edge_face");
  const json world = ours(script);
  EXPECT_EQ(world["check"], "sampled");
  EXPECT_EQ(world["frames"], 10);
  EXPECT_EQ(world["merged_frames"], 10);
  EXPECT_EQ(world["missed_frames"], 10);
  EXPECT_TRUE(world["cues"].empty());
}

}  // namespace

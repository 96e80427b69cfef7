// The bundled dynamic scenes: the results that their files state against the closed forms, evaluated here
// from the scenes' figures, and what runs over native's and exact's contacts come to.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/adapters/scene_files/dynamics_file.hpp"
#include "touchstone/examples/dynamics_run/run.hpp"
#include "touchstone/examples/dynamics_run/simulate.hpp"
#include "touchstone/tests/support/degree.hpp"

namespace touchstone::dynamics {
namespace {

namespace fs = std::filesystem;
using physics::DynamicScene;
using physics::SceneAnswer;

DynamicScene scene(const std::string& name) {
  return load_dynamic_scene(fs::path(TOUCHSTONE_DYNAMIC_SCENES) / (name + ".yaml"));
}

const SceneAnswer& answer(const DynamicScene& scene, SceneAnswer::Figure figure, const std::string& of = "") {
  for (const SceneAnswer& each : scene.answers) {
    if (each.figure != figure) continue;
    std::string name;
    if (each.is_vector()) name = scene.scene.objects[each.object].tree.name();
    if (each.is_of_joint()) name = scene.mechanisms[each.joint.mechanism].joints[each.joint.joint].name;
    if (of.empty() || of == name) return each;
  }
  ADD_FAILURE() << "no answer " << to_string(figure) << " of " << of;
  static const SceneAnswer none;
  return none;
}

BackendRun run(const DynamicScene& scene, const std::string& backend) {
  BackendRegistry registry;
  register_all_backends(registry);
  physics::EngineRegistry engines;
  register_own_engine(engines, registry);
  program::ProgressLine progress;
  return simulate(scene, engines, {"own", backend}, 0, progress);
}

void expect_met(const std::string& name, const std::string& backend = "native") {
  const DynamicScene loaded = scene(name);
  const BackendRun got = run(loaded, backend);
  EXPECT_EQ(got.stopped, "");
  EXPECT_EQ(got.not_run, "");
  EXPECT_EQ(got.steps, loaded.step_count());
  EXPECT_EQ(got.unconverged, 0u);
  EXPECT_EQ(got.failed, 0u);
  ASSERT_FALSE(loaded.answers.empty());
  for (std::size_t i = 0; i < loaded.answers.size(); ++i)
    EXPECT_TRUE(got.answers[i].holds)
        << name << ", " << backend << ": " << loaded.answers[i].where << to_string(loaded.answers[i].figure)
        << " is off by " << got.answers[i].error;
}

constexpr double kOru = 170.1, kTip = 0.02;

TEST(DynamicScenes, PushedInTheCentre) {
  for (const double e : {0.0, 0.5}) {
    const std::string name = e == 0.0 ? "08_pushed_centred" : "08_pushed_centred_bouncing";
    const double v = kTip * (1.0 + e);
    EXPECT_NEAR(answer(scene(name), SceneAnswer::Figure::velocity).value.x(), v, 1e-15);
    EXPECT_NEAR(answer(scene(name), SceneAnswer::Figure::impact).value.x(), kOru * v, 1e-12);
    EXPECT_NEAR(answer(scene(name), SceneAnswer::Figure::position).value.x(), v * 0.5, 1e-15);
    expect_met(name);
  }
}

TEST(DynamicScenes, PushedOffTheCentre) {
  const double I = kOru / 12.0 * (1.050 * 1.050 + 0.919 * 0.919), b = 0.30;
  EXPECT_NEAR(I, 27.60, 0.005);
  const double J = kTip / (1.0 / kOru + b * b / I);
  EXPECT_NEAR(J, 2.188, 5e-4);
  const DynamicScene loaded = scene("08_pushed_offset");
  EXPECT_NEAR(answer(loaded, SceneAnswer::Figure::impact).value.x(), J, 1e-14);
  EXPECT_NEAR(answer(loaded, SceneAnswer::Figure::velocity).value.x(), J / kOru, 1e-16);
  EXPECT_NEAR(answer(loaded, SceneAnswer::Figure::angular_velocity).value.z(), -J * b / I, 1e-16);
  // In the step after the impact the tip gains 0.525 w^2 h on the face, and J grows by that share: what the
  // file's tolerances of the velocities allow, and no more than twice that.
  const double w = J * b / I, share = 0.525 * w * w * 1e-3 / kTip;
  EXPECT_LT(share * J / kOru, answer(loaded, SceneAnswer::Figure::velocity).tolerance);
  EXPECT_GT(2 * share * J / kOru, answer(loaded, SceneAnswer::Figure::velocity).tolerance);
  expect_met("08_pushed_offset");
}

constexpr double kReach = 2 * 7.11 + 1.3589;

double arm_inertia() {
  return 314.88 * 7.11 * 7.11 / 3.0 + 279.2 * (7.11 * 7.11 / 12.0 + 10.665 * 10.665) +
         2.0 * 105.98 * 14.22 * 14.22 + 243.66 * (1.3589 * 1.3589 / 12.0 + 14.89945 * 14.89945);
}

TEST(DynamicScenes, ArmPushes) {
  EXPECT_NEAR(arm_inertia(), 135227.5, 0.05);
  const double effective = arm_inertia() / (kReach * kReach);
  EXPECT_NEAR(effective, 557.2, 0.05);
  for (const double e : {0.0, 0.5}) {
    const std::string name = e == 0.0 ? "08_arm_pushes" : "08_arm_pushes_bouncing";
    const double v = (1.0 + e) * 0.37 * effective / (effective + kOru);
    EXPECT_NEAR(v, e == 0.0 ? 0.2835 : 0.4252, 5e-5);
    EXPECT_NEAR(answer(scene(name), SceneAnswer::Figure::velocity).value.y(), v, 1e-15);
    EXPECT_NEAR(answer(scene(name), SceneAnswer::Figure::rate).value.x() * kReach, v - e * 0.37, 1e-14);
    expect_met(name);
    // Nothing turns the arm but the contact: momentum about the shoulder's axis stays.
    const BackendRun got = run(scene(name), "native");
    EXPECT_LT(got.angular_drift, 1e-15 * arm_inertia() * 0.37 / kReach * 4);
  }
}

TEST(DynamicScenes, TheJointThatLacksTorqueGivesWay) {
  // The force at which each joint lacks torque, by closed form.
  const double L1 = 7.11, L2 = 7.11 + 1.3589, most = 2332.0, growth = 200.0;
  struct Case {
    const char *name, *joint;
    double arm_1, arm_2, force, rounded;  // arms of the push about the joints; when the joint gives way
  };
  const double cosine = std::cos(150 * kDegree);
  for (const Case& c :
       {Case{"09_shoulder_saturates", "shoulder", L1, 0.0, most / L1, 328.0},
        Case{"09_both_saturate", "elbow", -L2, -L2, most / L2, 275.4},
        Case{"09_elbow_saturates", "elbow", L1 + L2 * cosine, L2 * cosine, most / -(L2 * cosine), 318.0}}) {
    // The scene's file has these figures.
    EXPECT_NEAR(c.force, c.rounded, 0.05) << c.name;
    const DynamicScene loaded = scene(c.name);
    const SceneAnswer& moved = answer(loaded, SceneAnswer::Figure::moved);
    EXPECT_EQ(loaded.mechanisms[0].joints[moved.joint.joint].name, c.joint);
    EXPECT_NEAR(moved.value.x(), c.force / growth, 1e-13) << c.name;
    EXPECT_LE(moved.tolerance, 2 * loaded.step);
    // Just before that, torques and force by closed form.
    const SceneAnswer& shoulder = answer(loaded, SceneAnswer::Figure::torque, "shoulder");
    const double force = growth * (shoulder.time - 0.5 * loaded.step);  // in the step's middle
    EXPECT_LT(force, c.force);
    EXPECT_NEAR(shoulder.value.x(), -c.arm_1 * force, 1e-9) << c.name;
    EXPECT_NEAR(answer(loaded, SceneAnswer::Figure::torque, "elbow").value.x(), -c.arm_2 * force, 1e-9)
        << c.name;
    EXPECT_NEAR(norm(answer(loaded, SceneAnswer::Figure::force).value), force, 1e-10);
    expect_met(c.name);
  }
}

TEST(DynamicScenes, Backdriven) {
  struct Case {
    const char* name;
    double mass, speed, degrees, travel, time;
  };
  for (const Case& c : {Case{"09_backdriven_16t", 16.5e3, 0.02, 0.0784, 21.3e-3, 2.205},
                        Case{"09_backdriven_116t", 116e3, 0.012, 0.2042, 55.5e-3, 9.30}}) {
    const double I = arm_inertia() + c.mass * kReach * kReach, w = c.mass * c.speed * kReach / I;
    const double time = I * w / 2332.0, angle = 0.5 * I * w * w / 2332.0;
    EXPECT_NEAR(time, c.time, 5e-3);
    EXPECT_NEAR(angle / kDegree, c.degrees, 5e-5);
    EXPECT_NEAR(angle * kReach, c.travel, 5e-5);
    const DynamicScene loaded = scene(c.name);
    const SceneAnswer& stopped = answer(loaded, SceneAnswer::Figure::stopped);
    EXPECT_NEAR(stopped.value.x(), time, 1e-13);
    EXPECT_LE(stopped.tolerance, 1.001e-6 * time);
    EXPECT_NEAR(answer(loaded, SceneAnswer::Figure::value).value.x(), angle, 1e-15);
    EXPECT_LE(answer(loaded, SceneAnswer::Figure::value).tolerance, 1.001e-6 * angle);
    expect_met(c.name);
  }
}

TEST(DynamicScenes, SlidesToAStopAndRestsAndBumps) {
  const double friction = 0.5, g = 9.81;
  const DynamicScene sliding = scene("sliding_stop");
  EXPECT_NEAR(answer(sliding, SceneAnswer::Figure::stopped).value.x(), 1.0 / (friction * g), 1e-16);
  EXPECT_NEAR(answer(sliding, SceneAnswer::Figure::position).value.x(), 0.5 / (friction * g), 1e-16);
  expect_met("sliding_stop");
  EXPECT_NEAR(answer(scene("box_stack"), SceneAnswer::Figure::force, "floor").value.z(), -5 * 8 * g, 1e-12);
  expect_met("box_stack");
  const double m1 = 10, m2 = 1e5, b = 1.5, I = m2 * 16 / 6, J = 0.1 / (1 / m1 + 1 / m2 + b * b / I);
  const DynamicScene bump = scene("bump_off_centre");
  EXPECT_NEAR(0.1 - J / m1, 1.8434e-5, 5e-10);
  EXPECT_NEAR(-J * b / I, -5.624e-6, 5e-10);
  EXPECT_NEAR(answer(bump, SceneAnswer::Figure::velocity, "light").value.x(), 0.1 - J / m1, 1e-16);
  EXPECT_NEAR(answer(bump, SceneAnswer::Figure::angular_velocity, "heavy").value.z(), -J * b / I, 1e-19);
  expect_met("bump_off_centre");
}

TEST(DynamicScenes, MeetTheClosedFormsOverExactContactsToo) {
  if (!has_backend("exact")) GTEST_SKIP() << "this build has no exact";
  for (const char* name : {"08_pushed_offset", "08_arm_pushes", "09_both_saturate", "bump_off_centre"})
    expect_met(name, "exact");
}

TEST(DynamicScenes, TwoRunsHaveTheSameBits) {
  for (const char* name : {"08_pushed_offset", "09_elbow_saturates", "box_stack"}) {
    const BackendRun first = run(scene(name), "native"), second = run(scene(name), "native");
    ASSERT_EQ(first.last.size(), second.last.size());
    for (std::size_t o = 0; o < first.last.size(); ++o) {
      EXPECT_EQ(first.last[o].p, second.last[o].p) << name;
      EXPECT_EQ(first.last[o].R, second.last[o].R) << name;
    }
    EXPECT_EQ(first.energy_lost, second.energy_lost) << name;
    EXPECT_EQ(first.contact_count, second.contact_count) << name;
  }
}

TEST(DynamicScenes, EveryBundledSceneIsReadAndHasAnswers) {
  std::size_t count = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(TOUCHSTONE_DYNAMIC_SCENES)) {
    const DynamicScene loaded = load_dynamic_scene(entry.path());
    EXPECT_FALSE(loaded.answers.empty()) << entry.path();
    EXPECT_NO_THROW(touchstone::load_scene(entry.path())) << "the same file as a scene of contacts alone";
    ++count;
  }
  EXPECT_GE(count, 13u);
}

TEST(DynamicScenes, AnErrorWidensEveryLimit) {
  const fs::path file = fs::path(TOUCHSTONE_DYNAMIC_SCENES) / "box_stack.yaml";
  Options options;
  const DynamicScene as_it_is = load_scene(file, options);
  options.error = 0.5;
  const DynamicScene wide = load_scene(file, options);
  for (const auto limit :
       {&physics::SceneAccept::depth, &physics::SceneAccept::position, &physics::SceneAccept::angle,
        &physics::SceneAccept::energy_made, &physics::SceneAccept::drift, &physics::SceneAccept::rest})
    EXPECT_EQ(wide.accept.*limit, std::max(as_it_is.accept.*limit, 0.5));
  EXPECT_LT(as_it_is.accept.energy_made, 0.5);
  EXPECT_LT(as_it_is.accept.drift, 0.5);
  for (const SceneAnswer& each : wide.answers) EXPECT_GE(each.tolerance, 0.5);
}

// ---- the accounts and the verdict

TEST(Accounts, FreeFallMakesAndLosesNothingAndABounceLosesWhatItMust) {
  // 1 kg falls 0.1 m on the floor, e 0.5: it loses (1 - e^2) of m g h with the first bounce.
  DynamicScene falling = scene("box_stack");
  falling.scene.objects.erase(falling.scene.objects.begin() + 2, falling.scene.objects.end());
  falling.bodies.resize(2);
  falling.answers.clear();
  falling.scene.duration = 0.2;
  falling.scene.objects[1].X_WO.p.z() = 0.2;
  falling.bodies[1].surface.restitution = 0.5;
  falling.contact_margin = 2e-3;  // more than it falls in a step, 1.4 mm
  const BackendRun got = run(falling, "native");
  const double fall = 8 * 9.81 * 0.1;
  EXPECT_NEAR(got.energy_lost, 0.75 * fall, 1e-9 * fall);
  EXPECT_LT(got.energy_made, 1e-12 * fall);
  EXPECT_LT(got.unexplained_momentum, 1e-13);
  EXPECT_LT(got.deepest, 1e-8);
  // What a joint to the ground gives it no engine tells.
  physics::SceneBodyJoint pin;
  pin.name = "pin";
  pin.child = 1;
  pin.kind = physics::BodyJointKind::ball;
  falling.joints = {pin};
  EXPECT_TRUE(std::isnan(run(falling, "native").unexplained_momentum));
}

TEST(Accounts, WhatDrivesDoIsNotEnergyFromNothing) {
  // The cart of 2 kg, 3 N for a second: 2.25 J of kinetic energy, all of it work.
  DynamicScene cart;
  cart.scene.name = "cart";
  cart.scene.frame_rate = 50;
  cart.scene.contact_gap = 1e-9;
  cart.scene.duration = 1.0;
  cart.scene.objects.push_back(
      {HexahedronTree({{"box", Hexahedron::from_size({1, 1, 1}), {}}}, "cart"), {}, {}, {}});
  cart.bodies.push_back({physics::BodyKind::link,
                         physics::box_inertia(2, {1, 1, 1}),
                         Vector3::Zero(),
                         Vector3::Zero(),
                         {},
                         {}});
  physics::SceneJoint rail;
  rail.name = "rail";
  rail.kind = JointKind::prismatic;
  rail.child = 0;
  rail.axis_W = Vector3::UnitX();
  rail.drive.drive.torque = 3.0;
  cart.mechanisms.push_back({"cart", {rail}, {}});
  const BackendRun got = run(cart, "native");
  EXPECT_NEAR(got.energy_scale, 2 * 2.25, 1e-12);  // seen, and put in
  EXPECT_LT(got.energy_made, 1e-12);
  EXPECT_LT(got.energy_lost, 1e-12);
}

BackendRun made_up(const std::string& backend, double us, double x) {
  BackendRun run;
  run.backend = backend;
  run.steps = 1;
  run.contact_count = 1;
  run.allocations = 0;
  run.last.resize(1);
  run.last[0].p.x() = x;
  run.energy_made = 0.0;
  run.energy_scale = 1.0;
  run.total_us = run.detection_us = {us, us, us};
  return run;
}

SceneResult judged(std::vector<BackendRun> runs, double deadline_us = kNone) {
  SceneResult result;
  result.deadline_us = deadline_us;
  auto made = std::make_shared<DynamicScene>();
  made->accept.position = 1e-3;
  result.scene = made;
  result.reference = "truth";
  result.runs = std::move(runs);
  judge(result);
  return result;
}

TEST(Tables, FitATerminalWithTheLongestNamesAndFigures) {
  BackendRun run = made_up("ode_direct:bullet_gjk", 123456.7, -1.2e-100);
  run.rest_speed = run.linear_drift = run.angular_drift = run.energy_lost = run.unexplained_momentum = 1.2e-9;
  run.allocations = 1479217;
  SceneResult result = judged({run, made_up("truth", 1.0, 0.0)});
  const std::string text = terminal_text(result);
  std::size_t rows = 0;
  for (std::size_t begin = 0, end = 0; end != std::string::npos; begin = end + 1) {
    end = text.find('\n', begin);
    const std::string line = text.substr(begin, end - begin);
    if (line.rfind("  ode_direct:bullet_gjk  ", 0) != 0) continue;
    EXPECT_LE(line.size(), 120U) << line;
    ++rows;
  }
  EXPECT_EQ(rows, 2U);
}

TEST(Verdict, NamesTheFastestWithinTheLimitsAndOfThoseAsFastTheMostAccurate) {
  SceneResult result = judged({made_up("quick", 1.0, 0.5), made_up("coarse", 10.0, 1e-4),
                               made_up("fine", 10.5, 1e-9), made_up("truth", 100.0, 0.0)});
  EXPECT_EQ(result.recommended, "fine");
  EXPECT_EQ(result.runs[0].misses, (std::vector<std::string>{"ends 5e+02 mm off"}));
  EXPECT_NE(result.reason.find("off: quick (ends 5e+02 mm off)"), std::string::npos) << result.reason;
  EXPECT_NE(result.reason.find("slower: truth 100.0 us"), std::string::npos) << result.reason;
  result = judged({made_up("coarse", 10.0, 1e-4), made_up("fine", 11.5, 1e-9), made_up("truth", 100.0, 0.0)});
  EXPECT_EQ(result.recommended, "coarse");
}

// A hundred steps, one of which takes `worst` us.
BackendRun with_tail(BackendRun run, double worst) {
  run.total_us.assign(100, run.total_us[0]);
  run.total_us.back() = worst;
  return run;
}

TEST(Verdict, ATailCountsAsTheMedianDoes) {
  // Exact's figures beside native's where the verdict once was exact: 6.4 ms at 99.9 % against 23 us.
  const SceneResult result =
      judged({with_tail(made_up("steady", 22.0, 0.0), 23.0), with_tail(made_up("truth", 21.0, 0.0), 6400.0)});
  EXPECT_EQ(result.recommended, "steady");
  EXPECT_NE(result.reason.find("slower: truth 21.0 us (6400.0 at 99.9 %)"), std::string::npos)
      << result.reason;
}

TEST(Verdict, WhatAllocatesIsBehindWhatDoesNot) {
  BackendRun truth = made_up("truth", 5.0, 0.0);
  truth.allocations = 579079;
  const SceneResult result = judged({made_up("steady", 22.0, 1e-6), truth});
  EXPECT_EQ(result.recommended, "steady");
  EXPECT_NE(result.reason.find("no allocation; allocates: truth (579 079)"), std::string::npos)
      << result.reason;
  // Where all allocate it is no criterion.
  BackendRun other = made_up("other", 22.0, 1e-6);
  other.allocations = 1;
  EXPECT_EQ(judged({other, truth}).recommended, "truth");
}

TEST(Verdict, TheDeadlineIsForTheTail) {
  const BackendRun quick = with_tail(made_up("quick", 10.0, 1e-6), 2000.0),
                   truth = with_tail(made_up("truth", 900.0, 0.0), 950.0);
  EXPECT_EQ(judged({quick, truth}, 1000.0).recommended, "truth");
  EXPECT_EQ(judged({quick, truth}, 3000.0).recommended, "quick");
  const SceneResult late = judged({quick, truth}, 1000.0);
  EXPECT_TRUE(late.runs[0].late);
  EXPECT_NE(late.reason.find("late: quick 10.0 us (2000.0 at 99.9 %)"), std::string::npos) << late.reason;
  const SceneResult none = judged({quick, truth}, 100.0);
  EXPECT_TRUE(none.reason.starts_with("none keeps the deadline of 100 us at 99.9 %")) << none.reason;
}

TEST(Verdict, WhereNothingTouchesThereIsNothingToChooseBy) {
  BackendRun quick = made_up("quick", 1.0, 0.0), truth = made_up("truth", 5.0, 0.0);
  quick.contact_count = truth.contact_count = 0;
  SceneResult result = judged({quick, truth});
  EXPECT_FALSE(result.touches);
  EXPECT_EQ(result.recommended, "");
  EXPECT_EQ(result.reason, "nothing touches: every backend would do");
  EXPECT_NE(terminal_text(result).find("  no verdict: nothing touches"), std::string::npos);
  // A contact that the reference lacks does not count, and its depth is reported.
  quick = made_up("quick", 1.0, 0.5);
  result = judged({quick, truth});
  EXPECT_EQ(result.recommended, "");
  EXPECT_EQ(result.reason, "nothing touches: every other backend would do; off: quick (ends 5e+02 mm off)");
  EXPECT_EQ(choose_over_all({result}).recommended, "");
}

TEST(Verdict, OverAllScenesIsForWhatHoldsInEachOfThem) {
  // quick is off in the second scene; steady is twice behind in the first, slow 50 times in the second.
  std::vector<SceneResult> results;
  results.push_back(judged({made_up("quick", 1.0, 0.0), made_up("steady", 2.0, 0.0),
                            made_up("slow", 1.0, 0.0), made_up("truth", 500.0, 0.0)}));
  results.push_back(judged({made_up("quick", 1.0, 0.5), made_up("steady", 2.0, 0.0),
                            made_up("slow", 100.0, 0.0), made_up("truth", 500.0, 0.0)}));
  const OverallVerdict verdict = choose_over_all(results);
  EXPECT_EQ(verdict.recommended, "steady");
  EXPECT_EQ(verdict.reason,
            "within every scene's limits; at most 2.00 times behind the fastest, median and 99.9 %, no "
            "allocation; slower: slow (up to 50.00 times), truth (up to 500.00 times); off: quick in 1");
  // A scene without contact decides nothing about times, but a run that fails in it is out.
  BackendRun still = made_up("steady", 1000.0, 0.0), truth = made_up("truth", 1.0, 0.0),
             quick = made_up("quick", 1.0, 0.0), slow = made_up("slow", 1.0, 0.0);
  for (BackendRun* run : {&still, &truth, &quick, &slow}) run->contact_count = 0;
  results.push_back(judged({still, truth, quick, slow}));
  EXPECT_EQ(choose_over_all(results).reason, verdict.reason);
}

TEST(Verdict, OverAllScenesSaysSoWhereNoneIsWithinTheLimits) {
  std::vector<SceneResult> results;
  results.push_back(judged({made_up("quick", 1.0, 0.5), made_up("truth", 5.0, 0.0)}));
  results.push_back(results[0]);
  for (SceneResult& result : results) result.runs[1].misses = {"0.1 mm deep"};
  results[0].runs[0].misses.clear();
  EXPECT_EQ(choose_over_all(results).recommended, "quick");
  EXPECT_EQ(choose_over_all(results).reason,
            "none is within every scene's limits; it is off in 1 of 2; off: truth in 2");
  EXPECT_EQ(choose_over_all({}).recommended, "");
}

TEST(Verdict, SaysSoWhereNoneIsWithinTheLimitsOrNoneWentThrough) {
  BackendRun deep = made_up("deep", 1.0, 0.0), truth = made_up("truth", 5.0, 0.0);
  deep.deepest = 0.2, truth.deepest = 0.1;
  truth.energy_made = 0.5;
  SceneResult result = judged({deep, truth});
  EXPECT_EQ(result.recommended, "deep");
  EXPECT_TRUE(result.reason.starts_with("none is within the scene's limits")) << result.reason;
  truth.stopped = "at 0.1 s", deep.not_run = "no manifolds";
  result = judged({deep, truth});
  EXPECT_EQ(result.recommended, "");
  EXPECT_EQ(result.reason, "none went through");
}

TEST(Verdict, WhatTheSceneSaysStaysMayDriftByTheSharesOfItsLimits) {
  BackendRun stays = made_up("stays", 5.0, 0.0), drifts = made_up("drifts", 1.0, 0.0);
  for (BackendRun* const run : {&stays, &drifts})
    run->linear_drift = run->angular_drift = run->energy_drift = 0.9e-3, run->linear_scale = 1.0,
    run->angular_scale = 1.0;
  drifts.linear_drift = 2e-3, drifts.angular_drift = 3e-3, drifts.energy_drift = 4e-3;
  const SceneResult result = judged({stays, drifts, made_up("truth", 50.0, 0.0)});
  EXPECT_EQ(result.recommended, "stays");
  EXPECT_EQ(result.runs[1].misses,
            (std::vector<std::string>{"momentum off by 0.002 N s", "angular momentum off by 0.003 N m s",
                                      "energy off by 0.004 J"}));
}

TEST(Verdict, SaysWhichAnswersTheNamedOneDoesNotGive) {
  BackendRun silent = made_up("silent", 1.0, 0.0);
  silent.answers.resize(3);
  silent.answers[0].holds = true;
  silent.answers[1].is_given = silent.answers[2].is_given = false;
  const SceneResult result = judged({silent, made_up("truth", 50.0, 0.0)});
  EXPECT_EQ(result.recommended, "silent");
  EXPECT_NE(result.reason.find("no allocation; it does not give 2 of 3 answers; "), std::string::npos)
      << result.reason;
}

TEST(Verdict, WithoutAWholeReferenceNoneIsWithinTheLimits) {
  for (const bool is_run : {false, true}) {
    BackendRun quick = made_up("quick", 1.0, 0.0), truth = made_up("truth", 5.0, 0.0);
    (is_run ? truth.stopped : truth.not_run) = is_run ? "at 0.1 s: body" : "no manifolds";
    const SceneResult result = judged({quick, truth});
    EXPECT_TRUE(std::isnan(result.runs[0].pose_error));  // not another time's
    EXPECT_EQ(result.runs[0].misses, (std::vector<std::string>{"no reference"}));
    EXPECT_EQ(result.reason, "none is within the scene's limits; it is the least off: no reference");
  }
  BackendRun lost = made_up("lost", 1.0, NAN), unknown = made_up("unknown", 1.0, 0.0);
  unknown.energy_made = NAN;
  const SceneResult result = judged({lost, unknown, made_up("truth", 5.0, 0.0)});
  EXPECT_EQ(result.runs[0].misses, (std::vector<std::string>{"no reference"}));
  EXPECT_EQ(result.runs[1].misses, (std::vector<std::string>{"makes nan J"}));
  EXPECT_EQ(result.recommended, "truth");
}

}  // namespace
}  // namespace touchstone::dynamics

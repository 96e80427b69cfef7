// Scene files with a guard, flown as guarded_run flies them.

#include <gtest/gtest.h>

#include <string>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/arms/bundled_arms.hpp"
#include "touchstone/examples/guarded_run/run.hpp"
#include "touchstone/tests/support/written_file.hpp"

namespace touchstone::guarded {
namespace {

const std::filesystem::path kScenes = TOUCHSTONE_GUARDED_SCENES;

GuardedRun flown(const std::string& contacts, double duration, const SlideBudget& slides = {}) {
  BackendRegistry registry;
  register_all_backends(registry);
  GuardedScene scene = load_guarded_scene(kScenes / "oru_pushed_home.yaml");
  scene.scene.scene.duration = duration;
  scene.settings.slides = slides;
  scene.scene.actions.clear();
  // Off as near the end of the guide as it pushes home within the time.
  for (SceneObject& object : scene.scene.scene.objects)
    if (object.tree.name() == "oru") object.X_WO.p.z() -= 0.1;
  for (SceneObject& object : scene.scene.scene.objects)
    if (object.tree.name().starts_with("arm.")) object.X_WO.p.z() -= 0.125;
  for (physics::SceneMechanism& mechanism : scene.scene.mechanisms)
    if (mechanism.name == "arm")
      for (physics::SceneJoint& joint : mechanism.joints) joint.p_W.z() -= 0.125;
  program::ProgressLine progress;
  return run_scene(scene, registry, contacts, progress);
}

TEST(GuardedScenes, AnArmPushesAnOruHomeAndStalls) {
  const GuardedRun run = flown("native", 2.0);
  ASSERT_EQ(run.not_run, "");
  ASSERT_EQ(run.stopped, "");
  EXPECT_EQ(run.merged, 0U);
  EXPECT_GE(run.least_separation, 0.5e-7 * (1.0 - 1e-6));
  EXPECT_LT(run.linear, 1e-9);
  EXPECT_GT(run.stalled, 20U);                        // of 100 frames
  EXPECT_GT(run.samples.back().torque_share, 0.999);  // all that a joint has
  EXPECT_GT(run.samples.back().force, 50.0);
  EXPECT_LT(run.samples.back().asked_W.z(), run.samples.back().hand_W.z() - 0.01);
  EXPECT_EQ(run.allocations.value_or(0), 0U);
  EXPECT_EQ(run.slides_ended, 0U);
  EXPECT_EQ(run.began_merged, 0U);
}

TEST(GuardedScenes, SlidesEndWhereTheGuardsBudgetDoesAndNothingMerges) {
  const GuardedRun run = flown("native", 0.6, {.pairs = 4, .seconds = kInfinity, .mover_work = 1});
  ASSERT_EQ(run.stopped, "");
  EXPECT_GT(run.slides_ended, 0U);
  EXPECT_EQ(run.merged, 0U);
}

/// As the scene is: with the arm's joints far from their stops and more than 64 rows of contacts a warm start
/// was once taken for solved, and the arm stood with no force. It then presses the ORU home askew and tilts
/// it flat; both turn, each on its path, and were once stopped there for good.
TEST(GuardedScenes, AStalledArmPressesIsDrivenBackAndSlidesAlong) {
  BackendRegistry registry;
  register_all_backends(registry);
  GuardedScene scene = load_guarded_scene(kScenes / "oru_pushed_home.yaml");
  scene.scene.scene.duration = 14.0;
  program::ProgressLine progress;
  const GuardedRun run = run_scene(scene, registry, "native", progress);
  ASSERT_EQ(run.stopped, "");
  EXPECT_EQ(run.merged, 0U);
  ASSERT_GE(run.samples.size(), 480U);
  // Home at 6.75 s; the ejector pushes from 9 s to 9.6 s. 50 frames a second.
  const auto& before = run.samples[449];
  const auto& after = run.samples[479];
  EXPECT_GT(run.stalled, 50U);
  EXPECT_GT(before.torque_share, 0.999);
  EXPECT_GT(before.force, 300.0);
  EXPECT_GT(run.driven_back, 10U);
  EXPECT_GT(after.hand_W.z(), before.hand_W.z() + 0.005);
  // Home again at 11.2 s; sideways, still pressing, from 13 s on.
  EXPECT_GT(run.samples[624].torque_share, 0.999);
  EXPECT_GT(run.samples[624].force, 300.0);
  EXPECT_GT(run.samples[699].hand_W.x(), run.samples[649].hand_W.x() + 0.004);
}

/// Links of arms are exempt and carry from the start, in files and of whatever model the program knows.
TEST(GuardedScenes, ArmsOfTheProgramsModelsCarryFromTheStart) {
  const std::filesystem::path path = written_file(
      "name: x\nunits: {length: m, angle: deg}\nframe_rate: 50\ncontact_gap: 1.0e-9\npolicy: cue\n"
      "duration: 0.1\nobjects:\n  - {name: oru, hexahedra: [{name: b, box: {size: [1, 1, 1]}}]}\n"
      "dynamics:\n  step: 0.001\n  bodies:\n    - {object: oru, kind: dynamic, mass: 100}\n"
      "  arms:\n    - {name: arm, model: mine, link: tip, joints: [10, 25, -70, 110, -35, 20, 15],\n"
      "       pose: {position: [0, 0, 0.7], rpy: [0, 90, 0]}}\n"
      "  exempt: [[arm.tip_lee, arm.base_lee]]\n"
      "  latches:\n    - {carrier: arm.tip_lee, carried: oru, allowed: [[arm.tip_lee, oru]]}\n"
      "  guard:\n    hands: [{link: arm.tip_lee, rates: [{time: 0, velocity: [0, 0, 0.02]}]}]\n",
      ".yaml");
  const auto models = [](const std::string& model, const std::filesystem::path&) {
    EXPECT_EQ(model, "mine");
    return make_bundled_arm("ssrms");
  };
  EXPECT_THROW(load_guarded_scene(path), InputError);
  const GuardedScene scene = load_guarded_scene(path, {}, models);
  EXPECT_EQ(scene.scene.scene.exempt_pairs.back().first, "arm.tip_lee");
  BackendRegistry registry;
  register_all_backends(registry);
  program::ProgressLine progress;
  const GuardedRun run = run_scene(scene, registry, "native", progress);
  EXPECT_EQ(run.not_run + run.stopped, "");
  EXPECT_EQ(run.merged, 0U);
  EXPECT_EQ(run.samples.size(), 5U);
}

TEST(GuardedScenes, WhatIsWrongIsNamed) {
  const auto refused = [](const std::string& guard, const std::string& why) {
    const std::string error = error_in_file(
        "name: x\nunits: {length: m, angle: deg}\nframe_rate: 50\ncontact_gap: 1.0e-9\npolicy: "
        "cue\nduration: 1\n"
        "objects:\n  - name: a\n    hexahedra: [{name: b, box: {size: [1, 1, 1]}}]\n"
        "dynamics:\n  step: 0.01\n" +
            guard,
        ".yaml", [](const std::filesystem::path& path) { load_guarded_scene(path); });
    EXPECT_NE(error.find(why), std::string::npos) << error;
  };
  refused("", "there is no guard");
  refused("  guard: {policy: shove}\n", "unknown policy 'shove'");
  refused("  latches: [{carrier: a, carried: z}]\n  guard: {}\n", "z");
  refused("  guard: {slide_pairs: 0}\n", "must be at least 1");
  refused("  guard: {slide_work: many}\n", "slide_work");
  refused("  guard: {hands: [{link: z, rates: []}]}\n", "no object 'z'");
  refused("  guard: {rules: [{between: [a], policy: hold}]}\n", "expected two objects or groups");
  refused("  guard: {}\n  arms: [{name: arm, model: ssrms, link: tip, joints: [1], pose: {}}]\n",
          "1 joint values for 7");
}

}  // namespace
}  // namespace touchstone::guarded

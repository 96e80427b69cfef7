#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "touchstone/adapters/scene_files/dynamics_file.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/world/scene_world.hpp"
#include "touchstone/physics/scene/scene_simulation.hpp"
#include "touchstone/tests/support/written_file.hpp"

// One scene file, flown through a contact world and run by dynamics: latches, what they allow and exemptions
// mean the same in both.

namespace touchstone {
namespace {

/// A jaw comes along -x at 0.1 m/s from x = 0.6: its pad's face meets the payload's, at x = 0.5, after 0.5 s,
/// and that of the bone behind it after 1.5 s. The payload hangs on a wrist until it is let go, after 0.3 s.
std::string file_text(const std::string& latches, const std::string& actions) {
  return "name: gripper\nframe_rate: 10\ncontact_gap: 1e-9\npolicy: advance\nduration: 2\nobjects:\n"
         "  - {name: wrist, pose: {position: [-3, 0, 0]}, hexahedra: [{name: box, box: {size: [1, 1, 1]}}]}\n"
         "  - {name: payload, hexahedra: [{name: box, box: {size: [1, 1, 1]}}]}\n"
         "  - name: jaw\n    pose: {position: [0.6, 0, 0]}\n    groups: [jaws]\n    hexahedra:\n"
         "      - {name: pad, box: {size: [0.1, 1, 1]}}\n"
         "      - {name: bone, pose: {position: [0.1, 0, 0]}, box: {size: [0.1, 1, 1]}}\n"
         "    motion: {segments: [{velocity: [-0.1, 0, 0]}]}\n" +
         latches +
         "dynamics:\n  step: 0.01\n  bodies:\n"
         "    - {object: wrist, kind: dynamic, mass: 10}\n    - {object: payload, kind: dynamic, mass: "
         "10}\n" +
         actions;
}

constexpr int kNever = -1, kReleaseFrame = 3;
constexpr const char* kRelease = "  actions: [{time: 0.3, release: payload}]\n";
constexpr const char* kLatch = "latches: [{carrier: wrist, carried: payload}]\n";

std::string latch_that_allows(const std::string& first, const std::string& second) {
  return "latches: [{carrier: wrist, carried: payload, allowed: [[" + first + ", " + second + "]]}]\n";
}

/// Where the jaw stands in the world at the end. kNever: the payload is not let go.
double jaw_in_world(const std::string& text, int release_frame) {
  const Scene scene = load_scene(written_file(text, ".yaml"));
  BackendRegistry registry;
  register_core(registry);
  SceneWorld run(scene, registry.make_narrowphase("native"), registry.make_broadphase("native"));
  for (int frame = 0; frame < 20; ++frame) {
    if (frame == release_frame) run.world().unlatch(run.object("payload"));
    run.step();
  }
  return run.world().actual_pose(run.object("jaw")).p.x();
}

/// How far dynamics have pushed the payload at the end.
double payload_in_dynamics(const std::string& text) {
  const physics::DynamicScene scene = load_dynamic_scene(written_file(text, ".yaml"));
  BackendRegistry registry;
  register_core(registry);
  physics::SceneSimulation run(scene, [&] {
    return std::make_unique<physics::NarrowphaseContacts>(
        registry.make_broadphase("native"), registry.make_narrowphase("native"), scene.contact_margin);
  });
  while (!run.is_over()) {
    run.begin_step();
    run.find_contacts();
    if (run.advance().failure == physics::StepFailure::none) continue;
    ADD_FAILURE() << "at " << run.time() << " s";
    break;
  }
  return run.object_pose(1).p.x();
}

/// The pad stops the jaw, and pushes the payload for 1.5 s.
void expect_pad_is_checked(const std::string& text, int release_frame) {
  EXPECT_NEAR(jaw_in_world(text, release_frame), 0.55, 1e-8);
  EXPECT_NEAR(payload_in_dynamics(text), -0.15, 1e-6);
}

/// The pad goes through; the bone stops the jaw, and pushes the payload for 0.5 s.
void expect_pad_is_exempt(const std::string& text, int release_frame) {
  EXPECT_NEAR(jaw_in_world(text, release_frame), 0.45, 1e-8);
  EXPECT_NEAR(payload_in_dynamics(text), -0.05, 1e-6);
}

TEST(LatchedScene, WhatNoLatchAllowsIsChecked) {
  expect_pad_is_checked(file_text(kLatch, ""), kNever);
  expect_pad_is_checked(file_text(kLatch, kRelease), kReleaseFrame);
}

TEST(LatchedScene, LatchAllowsItsPairsWhileItHoldsInTheWorldAndInDynamics) {
  expect_pad_is_exempt(file_text(latch_that_allows("jaw/pad", "payload"), ""), kNever);
  expect_pad_is_exempt(file_text(latch_that_allows("payload/box", "jaw/pad"), ""), kNever);
}

TEST(LatchedScene, WhatALatchAllowedIsCheckedAfterTheReleaseInTheWorldAndInDynamics) {
  expect_pad_is_checked(file_text(latch_that_allows("jaw/pad", "payload"), kRelease), kReleaseFrame);
}

// Let go after 0.7 s, the pad is 20 mm inside: the world stops it there, dynamics push the payload on with
// it.
TEST(LatchedScene, OverlapAtTheReleaseGrowsNoDeeperInTheWorldAndInDynamics) {
  const std::string text =
      file_text(latch_that_allows("jaw/pad", "payload"), "  actions: [{time: 0.7, release: payload}]\n");
  EXPECT_NEAR(jaw_in_world(text, 7), 0.53, 1e-12);
  EXPECT_NEAR(payload_in_dynamics(text), -0.13, 1e-6);
}

TEST(LatchedScene, GroupsAreAllowedInTheWorldAndInDynamics) {
  const std::string text = file_text(latch_that_allows("jaws", "payload"), "");
  EXPECT_NEAR(jaw_in_world(text, kNever), 0.4, 1e-12);
  EXPECT_EQ(payload_in_dynamics(text), 0.0);
  expect_pad_is_checked(file_text(latch_that_allows("jaws", "payload"), kRelease), kReleaseFrame);
}

TEST(LatchedScene, ExemptHexahedraStayExemptWhateverIsReleasedInTheWorldAndInDynamics) {
  const std::string exempt = "exempt: [[jaw/pad, payload/box]]\n";
  expect_pad_is_exempt(file_text(kLatch + exempt, ""), kNever);
  expect_pad_is_exempt(file_text(kLatch + exempt, kRelease), kReleaseFrame);
}

TEST(LatchedScene, LatchOfAnActionAllowsItsOwnPairs) {
  const std::string latch =
      "  actions:\n    - {time: 0, latch: {carrier: wrist, carried: payload, allowed: [[jaw/pad, "
      "payload]]}}\n";
  EXPECT_NEAR(payload_in_dynamics(file_text("", latch)), -0.05, 1e-6);
  EXPECT_NEAR(payload_in_dynamics(file_text("", latch + "    - {time: 0.3, release: payload}\n")), -0.15,
              1e-6);
  // A second latch brings nothing of the first one's.
  const std::string again = "    - {time: 0.4, latch: {carrier: wrist, carried: payload}}\n";
  const std::string released = "  actions:\n    - {time: 0.3, release: payload}\n";
  EXPECT_NEAR(payload_in_dynamics(file_text(latch_that_allows("jaw", "payload"), released + again)), -0.15,
              1e-6);
}

TEST(LatchedScene, NamesThatAnActionsLatchAllowsAreLookedUp) {
  const std::string text = file_text(
      "",
      "  actions: [{time: 0, latch: {carrier: wrist, carried: payload, allowed: [[jaw/lid, payload]]}}]\n");
  EXPECT_THROW(load_dynamic_scene(written_file(text, ".yaml")), InputError);
}

}  // namespace
}  // namespace touchstone

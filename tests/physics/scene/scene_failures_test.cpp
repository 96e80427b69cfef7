#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/physics/scene/scene_simulation.hpp"
#include "touchstone/tests/physics/hand_made_scene.hpp"
#include "touchstone/tests/proof/checks/lying_narrowphase.hpp"
#include "touchstone/tests/support/refusal.hpp"

// Steps that fail, and scenes that are refused, by name.

using namespace touchstone;
using namespace touchstone::physics;

namespace {

TEST(SceneSimulation, WhatTurnsTooFarStopsAndIsNamed) {
  // 1e5 rad/s is more than a body may turn in a step: nothing moves then, the other body neither.
  DynamicScene scene = empty_scene(1.0);
  const Vector3 size(0.2, 0.2, 0.2);
  add(scene, box("calm", size, at({1, 0, 0})), free_body(1, size, {1, 0, 0}));
  add(scene, box("top", size, at({0, 0, 0})), free_body(1, size, kZero, {0, 0, 1e5}));
  SceneSimulation simulation(scene, native_contacts);
  const StepReport report = step(simulation);
  EXPECT_EQ(report.failure, StepFailure::turn);
  EXPECT_EQ(simulation.failed_name(report), "object 'top'");
  EXPECT_EQ(reason_of(report.failure), "it would turn by more than 64 rad in a step");
  EXPECT_EQ(simulation.steps(), 0u);
  EXPECT_EQ(simulation.object_pose(0).p, Vector3(1, 0, 0));
}

TEST(SceneSimulation, WhatIsNotFiniteStopsAndIsNamed) {
  // A weight of 1e312 N; a force of 1.7e308 N on half a kilogram.
  for (const bool is_body : {true, false}) {
    DynamicScene scene = empty_scene(1.0);
    const Vector3 size(0.2, 0.2, 0.2);
    add(scene, box("calm", size, at({1e4, 0, 0})), free_body(1, size, {1, 0, 0}));
    if (is_body) {
      scene.gravity_W = {0, 0, -1e8};
      SceneBody heavy = free_body(1, size);
      heavy.inertia.mass = 1e304;
      add(scene, box("heavy", size, {}), heavy);
    } else {
      add(scene, box("cart", size, {}), {.kind = BodyKind::link, .inertia = box_inertia(0.5, size)});
      SceneJoint joint = pivot(1, kZero);
      joint.kind = JointKind::prismatic;
      joint.drive.drive.torque = 1.7e308;
      scene.mechanisms.push_back({"rail", {joint}, {}});
    }
    SceneSimulation simulation(scene, native_contacts);
    const StepReport report = step(simulation);
    EXPECT_EQ(to_string(report.failure), is_body ? "body" : "mechanism");
    EXPECT_EQ(simulation.failed_name(report), is_body ? "object 'heavy'" : "mechanism 'rail'");
    EXPECT_EQ(simulation.object_pose(0).p, Vector3(1e4, 0, 0));
    EXPECT_EQ(simulation.object_pose(1).p, kZero);
    EXPECT_EQ(simulation.steps(), 0u);
  }
}

TEST(SceneSimulation, ABadContactNamesItsPair) {
  DynamicScene scene = empty_scene(1.0);
  const Vector3 size(0.2, 0.2, 0.2);
  add(scene, box("floor", {4, 4, 1}, at({0, 0, -0.5})), {});
  add(scene, box("first", size, at({0, 0, 0.1})), free_body(1, size));
  add(scene, box("second", size, at({1, 0, 0.1})), free_body(1, size));
  const auto spoil = [](const NarrowphaseInput& input, const NarrowphaseOutput& output) {
    for (std::size_t i = 1; i < input.pairs.size(); ++i) output.geometry[i].n_AB_W.z() = NAN;
  };
  SceneSimulation simulation(scene, [&] {
    return std::make_unique<NarrowphaseContacts>(make_native_broadphase(),
                                                 std::make_unique<proof::LyingNarrowphase>(spoil), 1e-3);
  });
  const StepReport report = step(simulation);
  EXPECT_EQ(report.failure, StepFailure::bad_contact);
  EXPECT_EQ(simulation.failed_name(report), "'floor/box' and 'second/box'");
  EXPECT_THAT(std::string(reason_of(report.failure)), testing::HasSubstr("a normal that is not unit"));
}

TEST(SceneSimulation, ALatchThatNoInertiaFitsFailsTheStepAndIsNamed) {
  // 1e7 m apart: the moment about the line between them is less than a rounding of the others.
  DynamicScene scene = empty_scene(0.2);
  const Vector3 size(0.5, 0.4, 0.3);
  add(scene, box("a", size, {}), free_body(5, size, {0.1, 0, 0}));
  add(scene, box("b", size, at({1e7, 0, 0})), free_body(3, size));
  SceneAction latch{SceneAction::Kind::latch, 0.05};
  latch.carrier = 0, latch.carried = 1;
  scene.actions = {latch};
  SceneSimulation simulation(scene, native_contacts);
  const StepReport report = run_until_failure(simulation);
  EXPECT_EQ(report.failure, StepFailure::latch);
  EXPECT_EQ(simulation.failed_name(report), "object 'b'");
  EXPECT_EQ(simulation.steps(), 50u);
  EXPECT_NEAR(simulation.object_pose(0).p.x(), 0.005, 1e-15);
  EXPECT_EQ(simulation.root_of(1), 1u);
  EXPECT_EQ(step(simulation).failure, StepFailure::latch);  // it does not go on without
}

TEST(SceneSimulation, AReleaseThatNoInertiaFitsFailsTheStepAndChangesNothing) {
  // b, 1e6 m aside, makes the three a body; without it a and c are two points 2e7 m apart.
  DynamicScene scene = empty_scene(0.2);
  const Vector3 size(0.5, 0.4, 0.3);
  add(scene, box("a", size, {}), free_body(5, size));
  add(scene, box("b", size, at({0, 1e6, 0})), free_body(3, size));
  add(scene, box("c", size, at({2e7, 0, 0})), free_body(5, size));
  SceneAction first{SceneAction::Kind::latch, 0.0}, second = first, release{SceneAction::Kind::release, 0.05};
  first.carrier = 0, first.carried = release.carried = 1;
  second.carrier = 0, second.carried = 2;
  scene.actions = {first, second, release};
  SceneSimulation simulation(scene, native_contacts);
  const StepReport report = run_until_failure(simulation);
  EXPECT_EQ(report.failure, StepFailure::latch);
  EXPECT_EQ(simulation.failed_name(report), "object 'b'");
  EXPECT_EQ(simulation.steps(), 50u);
  for (const std::size_t object : {1u, 2u}) EXPECT_EQ(simulation.root_of(object), 0u);
}

/// A crane of two links beside a ball; an action and an answer, each from a line of a file.
DynamicScene scene_of_a_crane() {
  DynamicScene good = empty_scene(1.0);
  const Vector3 size(0.2, 0.2, 0.2);
  add(good, box("arm", size, {}), {.kind = BodyKind::link, .inertia = box_inertia(1, size)});
  add(good, box("hand", size, at({1, 0, 0})), {.kind = BodyKind::link, .inertia = box_inertia(1, size)});
  add(good, box("ball", size, at({5, 0, 0})), free_body(1, size));
  SceneJoint weld = pivot(1, kZero);
  weld.name = "weld", weld.kind = JointKind::fixed, weld.parent = 0, weld.where = "file:3: ";
  good.mechanisms.push_back({"crane", {pivot(0, kZero), weld}, {}});
  SceneAction action{SceneAction::Kind::drive, 0.5};
  action.where = "file:7: ";
  good.actions = {action};
  SceneAnswer answer;
  answer.object = 2, answer.time = 1.0, answer.tolerance = 1e-3, answer.where = "file:9: ";
  good.answers = {answer};
  return good;
}

/// Why the scene is refused once spoilt.
std::string error(const std::function<void(DynamicScene&)>& spoil) {
  DynamicScene scene = scene_of_a_crane();
  spoil(scene);
  return refusal_of([&] { validate(scene); });
}

TEST(DynamicScene, AddressesOfActionsAreChecked) {
  EXPECT_EQ(error([](DynamicScene&) {}), "accepted");
  EXPECT_EQ(error([](DynamicScene& s) { s.actions[0].joint.mechanism = 1; }),
            "file:7: drive: no mechanism 1");
  EXPECT_EQ(error([](DynamicScene& s) { s.actions[0].joint.joint = 2; }),
            "file:7: drive: mechanism 'crane' has no joint 2");
  EXPECT_EQ(error([](DynamicScene& s) { s.actions[0].joint.joint = 1; }),
            "file:7: drive: mechanism 'crane': joint 'weld' is fixed");
  EXPECT_EQ(error([](DynamicScene& s) { s.mechanisms[0].joints[1].drive.drive.torque = 1.0; }),
            "file:3: mechanism 'crane': joint 'weld': a fixed joint has no drive");
}

TEST(DynamicScene, AddressesAndFiguresOfAnswersAreChecked) {
  using Figure = SceneAnswer::Figure;
  EXPECT_EQ(error([](DynamicScene& s) { s.answers[0].object = 3; }),
            "file:9: answer 'position': no such object");
  EXPECT_EQ(error([](DynamicScene& s) { s.answers[0].object = 0, s.answers[0].figure = Figure::velocity; }),
            "file:9: answer 'velocity': object 'arm' is not dynamic: it has no such figure");
  EXPECT_EQ(error([](DynamicScene& s) {
              s.answers[0].figure = Figure::rate;
              s.answers[0].joint = {0, 5};
            }),
            "file:9: answer 'rate': mechanism 'crane' has no joint 5");
  EXPECT_EQ(error([](DynamicScene& s) {
              s.answers[0].figure = Figure::moved;
              s.answers[0].joint = {0, 1};
            }),
            "file:9: answer 'moved': mechanism 'crane': joint 'weld' is fixed");
  for (const double time : {0.0, -1.0, 1.1, static_cast<double>(NAN)})
    EXPECT_EQ(error([&](DynamicScene& s) { s.answers[0].time = time; }),
              "file:9: answer 'position': the time is not that of a step's end");
  for (const double tolerance : {0.0, -1.0, static_cast<double>(NAN), static_cast<double>(INFINITY)})
    EXPECT_EQ(error([&](DynamicScene& s) { s.answers[0].tolerance = tolerance; }),
              "file:9: answer 'position': the tolerance is not above 0");
  EXPECT_EQ(error([](DynamicScene& s) { s.answers[0].value.z() = NAN; }),
            "file:9: answer 'position': the value is not finite");
}

TEST(DynamicScene, LimitsAndSpeedsAreChecked) {
  EXPECT_EQ(error([](DynamicScene& s) { s.accept.angle = NAN; }), "scene 'scene': accept: a limit below 0");
  for (double DynamicScene::*const figure : {&DynamicScene::bounce_speed, &DynamicScene::push_out,
                                             &DynamicScene::part_speed, &DynamicScene::sleep_speed})
    for (const double value : {-1.0, static_cast<double>(NAN), static_cast<double>(INFINITY)})
      EXPECT_EQ(error([&](DynamicScene& s) { s.*figure = value; }),
                "scene 'scene': bounce speed, push-out, part speed and sleep speed must be >= 0 and finite");
  for (const double value : {-1.0, static_cast<double>(NAN)})
    EXPECT_EQ(error([&](DynamicScene& s) { s.sleep_time = value; }),
              "scene 'scene': the sleep time must be >= 0");
}

TEST(SceneSimulation, SetUpRefusesAJointThatMovesNoInertia) {
  DynamicScene scene = empty_scene(1.0);
  add(scene, box("frame", {1, 1, 1}, {}), {.kind = BodyKind::link});
  scene.mechanisms.push_back({"arm", {pivot(0, kZero)}, "file:7: "});
  EXPECT_EQ(refusal_of([&] { SceneSimulation(scene, native_contacts); }),
            "file:7: mechanism 'arm', joint 'pivot': nothing with inertia moves with it");
}

}  // namespace

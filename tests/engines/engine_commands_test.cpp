// A program's requests to a running engine, in every one with each of its checks: wrenches, joints put at
// values, and what touches.

#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/engine/engine_touches.hpp"
#include "touchstone/tests/engines/engine_suite.hpp"

namespace touchstone {
namespace {

using namespace engine_tests;
using physics::BodyKind;
using physics::DynamicScene;
using physics::EngineFeature;
using physics::TouchEvent;

class EngineCommands : public EngineSuite {};

/// One step, with commands between begin_step() and step().
template <class Tell>
void take_step(physics::DynamicsEngine& engine, const Tell& tell) {
  engine.begin_step();
  tell();
  const physics::EngineStep step = engine.step();
  ASSERT_TRUE(step.failure.empty()) << step.failure;
}

TEST_P(EngineCommands, AWrenchMovesABodyForAStep) {
  DynamicScene scene = empty_scene(1.0);
  scene.gravity_W.setZero();
  const std::size_t box = add_box(scene, "box", {0.2, 0.2, 0.2}, {1, 2, 3}, 3.0);
  const auto engine = engines().make(GetParam(), scene);
  const double inertia = 3.0 * 0.2 * 0.2 / 6.0;
  // One at a corner, and a moment: J = F h, and about the centre (r x F + M) h.
  const Vector3 force(3, 0, 0), r(0.1, 0.1, 0.1), moment(0, 0, 0.4);
  engine->push(box, 0.5 * force, Vector3(1, 2, 3) + r);  // before the commands of the step: counts as well
  take_step(*engine, [&] { engine->push(box, 0.5 * force, Vector3(1, 2, 3) + r, moment); });
  const Vector3 v = kStep / 3.0 * force, w = kStep / inertia * (cross(r, force) + moment);
  expect_error("pushed to [m/s]", norm(*engine->velocity(box) - v), 1e-14, 1e-12);
  expect_error("turned to [rad/s]", norm(*engine->angular_velocity(box) - w), 1e-12, 1e-9);
  while (!engine->is_over()) take_step(*engine, [] {});
  expect_error("and no more [m/s]", norm(*engine->velocity(box) - v), 1e-14, 1e-12);
  expect_error(
      "nor turned [N m s]",
      norm(engine->angular_momentum() - (kStep * moment + cross(Vector3(1, 2, 3) + r, kStep * force))), 1e-12,
      1e-8);
}

TEST_P(EngineCommands, AWrenchTurnsALinkThroughItsJoint) {
  DynamicScene scene = empty_scene(1.0);
  scene.gravity_W.setZero();
  const std::size_t rod = add_box(scene, "rod", {2, 0.02, 0.02}, {1, 0, 0}, 3.0);
  scene.bodies[rod].kind = BodyKind::link;
  scene.bodies[rod].inertia.inertia_B = Vector3(0, 1, 1).asDiagonal();
  physics::SceneJoint joint;
  joint.name = "hinge";
  joint.child = rod;
  scene.mechanisms.push_back({"arm", {joint}, {}});
  if (!can(EngineFeature::arms)) {
    EXPECT_THROW(engines().make(GetParam(), scene), InputError);
    return;
  }
  const auto engine = engines().make(GetParam(), scene);
  // Across the rod, at its tip, and a moment about the hinge; along it the hinge bears what is pushed.
  const double torque = 2.0 * 0.25 + 0.3, inertia = 4.0;
  while (!engine->is_over())
    take_step(*engine, [&] {
      const Pose X = engine->object_pose(rod);
      const Vector3 tip = X.p + X.R.col(0), across = X.R.col(1), along = X.R.col(0);
      engine->push(rod, 0.25 * across + 5.0 * along, tip, {0, 0, 0.3});
    });
  const double rate = torque / inertia;
  expect_error("link turns at [rad/s]", std::abs(engine->joint_rate({0, 0}) - rate), 1e-9, 1e-6);
  expect_error("link turned by [rad]", std::abs(engine->joint_value({0, 0}) - 0.5 * rate), 1e-9,
               1.1 * kStep * rate);
}

TEST_P(EngineCommands, RefusesAPushThatNothingFollows) {
  DynamicScene scene = empty_scene(0.1);
  const std::size_t ground = add_ground(scene);
  const std::size_t box = add_box(scene, "box", {0.2, 0.2, 0.2}, {0, 0, 3}, 3.0);
  const auto engine = engines().make(GetParam(), scene);
  const Vector3 force(1, 0, 0), none(kNaN, 0, 0);
  EXPECT_THROW(engine->push(ground, force, {0, 0, 0}), InputError);
  EXPECT_THROW(engine->push(box + 1, force, {0, 0, 0}), InputError);
  EXPECT_THROW(engine->push(box, none, {0, 0, 0}), InputError);
  EXPECT_THROW(engine->push(box, force, none), InputError);
  EXPECT_THROW(engine->push(box, force, {0, 0, 0}, none), InputError);
  take_step(*engine, [] {});
  EXPECT_EQ(engine->velocity(box)->x(), 0.0);
}

TEST_P(EngineCommands, TellsWhatBeginsToTouchAndParts) {
  DynamicScene scene = empty_scene(1.5);
  const std::size_t ground = add_ground(scene);
  const std::size_t box = add_box(scene, "box", {0.2, 0.2, 0.2}, {0, 0, 0.15}, 3.0);
  const auto engine = engines().make(GetParam(), scene);
  physics::TouchEvents events(scene.scene.contact_gap);
  std::vector<physics::EngineContact> contacts;
  std::size_t began = 0, ended = 0;
  double began_at = 0.0, ended_at = 0.0;
  while (!engine->is_over()) {
    // At rest on the ground from 0.1 s on; lifted at once by three weights.
    take_step(*engine, [&] {
      if (engine->time() > 1.0 - 0.5 * kStep)
        engine->push(box, {0, 0, 3 * 3.0 * kGravity}, engine->object_pose(box).p);
    });
    engine->list_contacts(contacts);
    physics::take_touches(*engine, contacts, events);
    for (const TouchEvent& event : events.events()) {
      EXPECT_GE(event.impulse_W.z(), -1e-9);  // on the box
      EXPECT_EQ(event.solids, (SolidPair{SolidIndex(ground), SolidIndex(box)}));
      if (event.kind == TouchEvent::Kind::began && began++ == 0) began_at = engine->time();
      if (event.kind == TouchEvent::Kind::ended) ended_at = engine->time(), ++ended;
    }
  }
  EXPECT_GE(began, 1u);
  EXPECT_EQ(began, ended);
  // It falls by 5 cm. An engine's contacts give way for some steps, and are listed by its own margin.
  EXPECT_NEAR(began_at, std::sqrt(2 * 0.05 / kGravity), 2e-2);
  EXPECT_NEAR(ended_at, 1.0, 5e-2);
}

TEST_P(EngineCommands, AJointPutAtAValueGoesOnFromThere) {
  DynamicScene scene = empty_scene(1.0);
  scene.gravity_W.setZero();
  const std::size_t rod = add_box(scene, "rod", {2, 0.02, 0.02}, {1, 0, 0}, 3.0);
  const std::size_t tip = add_box(scene, "tip", {0.1, 0.02, 0.02}, {2.1, 0, 0}, 0.5);
  for (const std::size_t link : {rod, tip}) scene.bodies[link].kind = BodyKind::link;
  physics::SceneJoint hinge;
  hinge.name = "hinge";
  hinge.child = rod;
  hinge.value = 0.2;  // where the scene has it
  physics::SceneJoint slider;
  slider.name = "slider";
  slider.kind = JointKind::prismatic;
  slider.parent = rod, slider.child = tip;
  slider.axis_W = {1, 0, 0};
  scene.mechanisms.push_back({"arm", {hinge, slider}, {}});
  for (const auto& [joint, value] : {std::pair(0, 0.9), std::pair(1, 0.3)}) {
    physics::SceneAction set;
    set.kind = physics::SceneAction::Kind::set_joint;
    set.time = 0.5;
    set.joint = {0, static_cast<std::size_t>(joint)};
    set.value = value;
    scene.actions.push_back(set);
  }
  if (!can(EngineFeature::set_joints) || !can(EngineFeature::arms)) {
    EXPECT_THROW(engines().make(GetParam(), scene), InputError);
    return;
  }
  const auto engine = run(GetParam(), scene);
  const double turn = 0.9 - 0.2;
  const Vector3 along(std::cos(turn), std::sin(turn), 0);
  expect_error("put at [rad]", std::abs(engine->joint_value({0, 0}) - 0.9), 1e-12, 1e-9);
  expect_error("put at [m]", std::abs(engine->joint_value({0, 1}) - 0.3), 1e-12, 1e-9);
  expect_error("rod is at [m]", norm(engine->object_pose(rod).p - along), 1e-12, 1e-9);
  expect_error("tip is at [m]", norm(engine->object_pose(tip).p - 2.4 * along), 1e-12, 1e-9);

  // Turning on, the tip fast on the rod.
  scene.mechanisms[0].joints[1].kind = JointKind::fixed;
  scene.actions.resize(1);
  scene.actions[0].rate = -0.2;
  const auto turning = run(GetParam(), scene);
  expect_error("turned on to [rad]", std::abs(turning->joint_value({0, 0}) - (0.9 - 0.5 * 0.2)), 1e-12, 1e-9);
  expect_error("turned on at [rad/s]", std::abs(turning->joint_rate({0, 0}) + 0.2), 1e-12, 1e-9);
}

/// A rod on a hinge, a box on the ground and one above it, which a latch or a joint may hold.
DynamicScene told_scene() {
  DynamicScene scene = empty_scene(0.4);
  add_ground(scene);
  const std::size_t rod = add_box(scene, "rod", {1, 0.02, 0.02}, {3, 0, 1}, 3.0);
  scene.bodies[rod].kind = BodyKind::link;
  physics::SceneJoint hinge;
  hinge.name = "hinge";
  hinge.child = rod;
  hinge.p_W = {2.5, 0, 1};
  hinge.effort = 100.0;
  scene.mechanisms.push_back({"arm", {hinge}, {}});
  add_box(scene, "box", {0.2, 0.2, 0.2}, {0, 0, 0.1}, 3.0);
  add_box(scene, "load", {0.2, 0.2, 0.2}, {0, 0, 0.301}, 1.0);
  scene.gravity_W = {0, 0, -kGravity};
  return scene;
}

/// What a scene has its engine do at `time`, and what a program tells it then, come to the same bits.
TEST_P(EngineCommands, WhatAProgramTellsIsWhatAnActionOfTheSceneDoes) {
  using Kind = physics::SceneAction::Kind;
  constexpr std::size_t kBox = 2, kLoad = 3;
  std::vector<physics::SceneAction> actions(11);
  for (std::size_t i = 0; i < actions.size(); ++i) actions[i].time = 0.1, actions[i].joint = {0, 0};
  actions[0].drive.drive.torque = 2.0, actions[0].drive.ramp = 3.0;
  actions[1].drive.drive.mode = physics::JointDrive::Mode::rate, actions[1].drive.drive.rate = 0.3;
  actions[2].drive.drive.mode = physics::JointDrive::Mode::brake;
  actions[3].drive.drive.mode = physics::JointDrive::Mode::position, actions[3].drive.drive.stiffness = 30.0;
  actions[4].kind = Kind::set_joint, actions[4].value = 0.2, actions[4].rate = -0.1;
  actions[5].kind = Kind::remove, actions[5].carried = kLoad;
  actions[6].kind = Kind::latch, actions[6].carrier = kBox, actions[6].carried = kLoad;
  actions[7].kind = Kind::add, actions[7].carried = kLoad;
  actions[8].kind = Kind::release, actions[8].carried = kLoad;
  actions[9].kind = Kind::join, actions[10].kind = Kind::part;
  actions[9].joint = actions[10].joint = {physics::JointAddress::kBodyJoint, 0};
  for (const physics::SceneAction& action : actions) {
    SCOPED_TRACE(static_cast<int>(&action - actions.data()));
    DynamicScene told = told_scene();
    if (!can(EngineFeature::arms)) told.mechanisms.clear(), told.bodies[1].kind = BodyKind::fixed;
    if (action.kind == Kind::latch && can(EngineFeature::latches))
      told.latch_options.push_back({kBox, kLoad});
    if (action.kind == Kind::release) {
      if (!can(EngineFeature::latches)) continue;
      told.actions = {actions[6]};
      told.actions[0].time = 0.02;
    }
    if (action.kind == Kind::join || action.kind == Kind::part) {
      if (!can(EngineFeature::body_joints)) continue;
      physics::SceneBodyJoint joint;
      joint.name = "joint";
      joint.kind = physics::BodyJointKind::hinge;
      joint.parent = kBox, joint.child = kLoad;
      joint.p_W = {0.1, 0, 0.2};
      joint.axis_W = {0, 1, 0};
      joint.is_on = action.kind == Kind::part;
      told.joints.push_back(joint);
    }
    DynamicScene acting = told;
    acting.actions.push_back(action);
    const bool is_of_arm = action.kind == Kind::drive || action.kind == Kind::set_joint;
    if (is_of_arm && !can(EngineFeature::arms)) continue;
    const auto engine = engines().make(GetParam(), told);
    if (action.kind == Kind::add) engine->remove(kLoad);
    while (engine->steps() < 100) take_step(*engine, [] {});
    // What the scene would be refused for is refused by the same words, and changes nothing.
    std::unique_ptr<physics::DynamicsEngine> other;
    std::string why;
    try {
      other = engines().make(GetParam(), acting);
    } catch (const InputError& error) {
      why = error.what();
    }
    if (!other) {
      try {
        engine->act(action);
        ADD_FAILURE() << "taken";
      } catch (const InputError& error) {
        const std::string_view said = error.what();
        EXPECT_NE(said.find("unsupported"), std::string_view::npos) << said;
      }
      continue;
    }
    engine->act(action);
    while (!other->is_over()) take_step(*other, [] {});
    while (!engine->is_over()) take_step(*engine, [] {});
    for (std::size_t i = 1; i < told.bodies.size(); ++i) {
      EXPECT_EQ(engine->object_pose(i).p, other->object_pose(i).p) << i;
      EXPECT_EQ(engine->object_pose(i).R, other->object_pose(i).R) << i;
    }
  }
}

/// Steps until one fails. @return its reason, or nothing at the run's end
std::string failure_of(physics::DynamicsEngine& engine) {
  while (!engine.is_over()) {
    engine.begin_step();
    if (const physics::EngineStep step = engine.step(); !step.failure.empty()) return step.failure;
  }
  return {};
}

/// What a program does before an action of the scene that then has no place; and what makes place for it.
TEST_P(EngineCommands, AnActionThatAProgramLeftNoPlaceForFailsAndIsNamed) {
  using Kind = physics::SceneAction::Kind;
  constexpr std::size_t kBox = 2, kLoad = 3;
  if (!can(EngineFeature::latches) || !can(EngineFeature::come_and_go)) return;
  const auto action = [](Kind kind, double time, std::size_t carrier, std::size_t carried) {
    physics::SceneAction out;
    out.kind = kind, out.time = time, out.carrier = carrier, out.carried = carried;
    return out;
  };
  const physics::SceneAction latch = action(Kind::latch, 0.1, kBox, kLoad),
                             release = action(Kind::release, 0.1, 0, kLoad);
  struct Case {
    std::vector<physics::SceneAction> scene;
    physics::SceneAction told, mend;
    bool has_option = true;  // for the latch; else the scene's own action is what engines are set up for
  };
  const Case cases[] = {
      {{latch}, latch, release},
      {{action(Kind::latch, 0.1, kLoad, kBox)}, latch, release},
      {{action(Kind::latch, 0.02, kBox, kLoad), release}, release, latch},
      {{action(Kind::remove, 0.1, 0, kLoad)}, latch, release},
      {{action(Kind::remove, 0.02, 0, kLoad), action(Kind::add, 0.1, 0, kLoad)}, latch, release},
      {{latch}, action(Kind::remove, 0.0, 0, kLoad), action(Kind::add, 0.0, 0, kLoad)},
      {{action(Kind::latch, 0.02, kBox, kLoad), release}, release, latch, false},
  };
  for (const Case& each : cases) {
    SCOPED_TRACE(&each - cases);
    DynamicScene scene = told_scene();
    if (!can(EngineFeature::arms)) scene.mechanisms.clear(), scene.bodies[1].kind = BodyKind::fixed;
    if (each.has_option) scene.latch_options = {{kBox, kLoad}};
    scene.actions = each.scene;
    const auto engine = engines().make(GetParam(), scene);
    while (engine->steps() < 50) take_step(*engine, [] {});
    if (!engine->has(kLoad)) engine->add(kLoad, scene.scene.objects[kLoad].X_WO, {0, 0, 0}, {0, 0, 0});
    engine->act(each.told);
    for (int twice = 0; twice < 2; ++twice) {
      const std::string why = failure_of(*engine);
      EXPECT_NE(why.find(each.scene.back().carried == kBox ? "'box'" : "'load'"), std::string::npos) << why;
      EXPECT_EQ(engine->steps(), 100u);
    }
    engine->act(each.mend);
    EXPECT_EQ(failure_of(*engine), "");
    EXPECT_LT(std::abs(engine->object_pose(kLoad).p.z() - 0.3), 0.05);
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, EngineCommands, ::testing::ValuesIn(choices()), name_of);

}  // namespace
}  // namespace touchstone

// Every engine between its steps: bodies that come and go, snapshots, and back to the start.

#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/engines/engine_suite.hpp"

namespace touchstone {
namespace {

using namespace engine_tests;
using physics::DynamicScene;
using physics::DynamicsEngine;
using physics::EngineFeature;
using physics::EngineReturn;
using physics::SceneAction;

class EngineState : public EngineSuite {
 protected:
  std::unique_ptr<DynamicsEngine> make(const DynamicScene& scene) const {
    return engines().make(GetParam(), scene);
  }
};

void take(DynamicsEngine& engine, int steps) {
  for (int i = 0; i < steps; ++i) {
    engine.begin_step();
    const physics::EngineStep step = engine.step();
    ASSERT_TRUE(step.failure.empty()) << step.failure;
  }
}

std::vector<Pose> poses(const DynamicsEngine& engine) {
  std::vector<Pose> out;
  for (std::size_t i = 0; i < engine.scene().bodies.size(); ++i) out.push_back(engine.object_pose(i));
  return out;
}

double largest_difference(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max({most, (a[i].p - b[i].p).cwiseAbs().maxCoeff(), (a[i].R - b[i].R).cwiseAbs().maxCoeff()});
  return most;
}

SceneAction action(SceneAction::Kind kind, double time, std::size_t object) {
  SceneAction out;
  out.kind = kind;
  out.time = time;
  out.carried = object;
  return out;
}

/// A tower of three on the ground, none flush (ODE's direct method breaks down on its own check's ties),
/// struck at 0.05 s by a fourth.
DynamicScene struck_tower() {
  DynamicScene scene = empty_scene(0.6);
  add_ground(scene);
  for (int i = 0; i < 3; ++i)
    scene.scene
        .objects[add_box(scene, "box " + std::to_string(i), {0.2, 0.2, 0.2}, {0.01 * i, 0, 0.105 + 0.211 * i},
                         2.0)]
        .X_WO.R = rotation_about(Vector3(0.6, 0.8, 0), 0.03 + 0.02 * i);
  const std::size_t ball = add_box(scene, "striker", {0.1, 0.1, 0.1}, {-0.3, 0.02, 0.45}, 1.0);
  scene.bodies[ball].v_W = {3, 0, 0.5};
  scene.bodies[ball].w_W = {1, 2, 0};
  return scene;
}

TEST_P(EngineState, ARestoredRunTakesTheSteps) {
  // A run that goes on.
  const DynamicScene scene = struck_tower();
  const auto engine = make(scene);
  take(*engine, 120);
  const auto kept = engine->snapshot();
  const std::vector<Pose> then = poses(*engine);
  const double momentum = norm(engine->linear_momentum());
  take(*engine, 200);
  const std::vector<Pose> went_on = poses(*engine);
  // Restored: state and time as they were.
  engine->restore(*kept);
  EXPECT_EQ(engine->steps(), 120u);
  EXPECT_EQ(largest_difference(poses(*engine), then), 0.0);
  EXPECT_EQ(norm(engine->linear_momentum()), momentum);
  // The steps after two restores are the same.
  take(*engine, 200);
  const std::vector<Pose> first = poses(*engine);
  take(*engine, 70);
  engine->restore(*kept);
  take(*engine, 200);
  ASSERT_NE(engine->after_restore(), EngineReturn::none);
  EXPECT_EQ(largest_difference(poses(*engine), first), 0.0);
  // Some engines take the steps of the run that went on, too.
  const double off = largest_difference(first, went_on);
  std::printf("  %-16s from the run that went on %.2e\n", GetParam().text().c_str(), off);
  if (engine->after_restore() == EngineReturn::same_bits) {
    EXPECT_EQ(off, 0.0);
  }
  EXPECT_GT(largest_difference(first, then), 0.01);
}

TEST_P(EngineState, ResetIsANewEngine) {
  const DynamicScene scene = struck_tower();
  const auto engine = make(scene);
  take(*engine, 250);
  const std::vector<Pose> first = poses(*engine);
  engine->reset();
  EXPECT_EQ(engine->steps(), 0u);
  take(*engine, 250);
  EXPECT_EQ(largest_difference(poses(*engine), first), 0.0);
  const auto anew = make(scene);
  take(*anew, 250);
  EXPECT_EQ(largest_difference(poses(*anew), first), 0.0);
}

TEST_P(EngineState, ASnapshotIsOfItsEngine) {
  const DynamicScene scene = struck_tower();
  const auto engine = make(scene), other = make(scene);
  EXPECT_THROW(other->restore(*engine->snapshot()), InputError);
}

/// Actions, latches and drives go back too.
TEST_P(EngineState, AnArmGoesBackWithItsDrivesAndLatches) {
  DynamicScene scene = empty_scene(0.4);
  scene.gravity_W.setZero();
  const std::size_t link = add_box(scene, "link", {1.0, 0.1, 0.1}, {0.5, 0, 0}, 2.0);
  scene.bodies[link].kind = physics::BodyKind::link;
  const std::size_t load = add_box(scene, "load", {0.2, 0.2, 0.2}, {1.3, 0, 0}, 1.0);
  physics::SceneJoint joint;
  joint.name = "joint";
  joint.child = link;
  joint.drive.drive = {physics::JointDrive::Mode::torque, 2.0, 0.0, 5.0};
  scene.mechanisms.push_back({"arm", {joint}, {}});
  const bool can_latch = can(EngineFeature::latches);
  SceneAction drive;
  drive.time = 0.1;
  drive.drive.drive = {physics::JointDrive::Mode::brake, 0.0, 0.0, 3.0};
  scene.actions.push_back(drive);
  if (can_latch) {
    SceneAction latch = action(SceneAction::Kind::latch, 0.15, load);
    latch.carrier = link;
    scene.actions.push_back(latch);
    scene.actions.push_back(action(SceneAction::Kind::release, 0.25, load));
  }
  if (!can(EngineFeature::arms)) {
    EXPECT_THROW(make(scene), InputError);
    return;
  }
  const auto engine = make(scene);
  take(*engine, 60);
  const auto driven = engine->snapshot();
  take(*engine, 140);
  const auto held = engine->snapshot();
  take(*engine, 150);
  const std::vector<Pose> went_on = poses(*engine);
  const double rate = engine->joint_rate({0, 0});
  const bool is_same = engine->after_restore() == EngineReturn::same_bits;
  for (const auto* const kept : {held.get(), driven.get()}) {
    engine->restore(*kept);
    take(*engine, kept == held.get() ? 150 : 290);
    const double off =
        std::max(largest_difference(poses(*engine), went_on), std::abs(engine->joint_rate({0, 0}) - rate));
    // A latch that ODE makes again stands elsewhere among its joints.
    EXPECT_LE(off, is_same && GetParam().engine != "ode_direct" ? 0.0 : 1e-9) << off;
  }
}

TEST_P(EngineState, WhatIsRemovedHoldsNothing) {
  DynamicScene scene = empty_scene(0.6);
  add_ground(scene);
  const std::size_t low = add_box(scene, "low", {0.2, 0.2, 0.2}, {0, 0, 0.1}, 2.0);
  const std::size_t high = add_box(scene, "high", {0.2, 0.2, 0.2}, {0, 0, 0.3}, 2.0);
  const auto engine = make(scene);
  take(*engine, 100);
  const double height = engine->object_pose(high).p.z();
  engine->remove(low);
  EXPECT_FALSE(engine->has(low));
  EXPECT_FALSE(engine->velocity(low).has_value());
  EXPECT_THROW(engine->push(low, {1, 0, 0}, {0, 0, 0}), InputError);
  EXPECT_NEAR(engine->body_mass(), 2.0, 1e-15);
  const Pose where = engine->object_pose(low);
  take(*engine, 100);
  EXPECT_EQ(largest_difference({engine->object_pose(low)}, {where}), 0.0);
  // Soft contacts of the last step still push.
  expect_error("falls [m]", std::abs(engine->object_pose(high).p.z() - (height - 0.5 * kGravity * 0.1 * 0.1)),
               1e-9, 2e-3);
  engine->add(low, {Matrix3::Identity(), {1, 0, 0.3}}, {0, 1, 0}, {0, 0, 2});
  EXPECT_TRUE(engine->has(low));
  take(*engine, 100);
  expect_error("comes back [m]",
               norm(engine->object_pose(low).p - Vector3(1, 0.1, 0.3 - 0.5 * kGravity * 0.01)), 1e-9,
               0.5 * kGravity * kStep * 0.1 + 1e-9);
  expect_error("turns [rad/s]", norm(*engine->angular_velocity(low) - Vector3(0, 0, 2)), 1e-9, 1e-6);
  take(*engine, 250);
  EXPECT_NEAR(engine->object_pose(high).p.z(), 0.1, 5e-3);
}

TEST_P(EngineState, ActionsBringInAndTakeOut) {
  // One box goes as another comes in its place, sliding.
  DynamicScene scene = empty_scene(0.5);
  add_ground(scene);
  const std::size_t low = add_box(scene, "low", {0.2, 0.2, 0.2}, {0, 0, 0.1}, 2.0);
  const std::size_t late = add_box(scene, "late", {0.2, 0.2, 0.2}, {0, 0, 0.1}, 2.0);
  scene.bodies[late].v_W = {0, 0.5, 0};
  scene.actions.push_back(action(SceneAction::Kind::remove, 0.2, low));
  scene.actions.push_back(action(SceneAction::Kind::add, 0.2, late));
  // Before that the second is not there.
  const auto engine = make(scene);
  EXPECT_FALSE(engine->has(late));
  EXPECT_NEAR(engine->body_mass(), 2.0, 1e-15);
  take(*engine, 200);
  EXPECT_NEAR(norm(engine->object_pose(low).p - Vector3(0, 0, 0.1)), 0.0, 2e-3);  // nothing was in it
  EXPECT_EQ(largest_difference({engine->object_pose(late)}, {scene.scene.objects[late].X_WO}), 0.0);
  // Afterwards it slides, by closed form.
  const auto kept = engine->snapshot();
  take(*engine, 50);
  EXPECT_FALSE(engine->has(low));
  EXPECT_TRUE(engine->has(late));
  const double t = 0.05;
  expect_error("slides [m]", std::abs(engine->object_pose(late).p.y() - (0.5 * t - 0.25 * kGravity * t * t)),
               1e-6, 2e-3);
  // Restored: as before, and with the same steps.
  const std::vector<Pose> went_on = poses(*engine);
  engine->restore(*kept);
  EXPECT_TRUE(engine->has(low));
  EXPECT_FALSE(engine->has(late));
  take(*engine, 50);
  const double off = largest_difference(poses(*engine), went_on);
  if (engine->after_restore() == EngineReturn::same_bits) {
    EXPECT_EQ(off, 0.0);
  }
  EXPECT_LT(off, 1e-4);
}

/// Actions are checked against each other alone: a caller may have been there before.
TEST_P(EngineState, ActionsMeetWhatWasDoneByHand) {
  DynamicScene scene = empty_scene(0.5);
  scene.gravity_W.setZero();
  const std::size_t guest = add_box(scene, "guest", {0.2, 0.2, 0.2}, {5, 0, 0}, 2.0);
  add_box(scene, "other", {0.2, 0.2, 0.2}, {0, 0, 0}, 2.0);
  scene.bodies[guest].v_W = {0, 1, 0};
  scene.actions.push_back(action(SceneAction::Kind::add, 0.1, guest));
  scene.actions.push_back(action(SceneAction::Kind::remove, 0.2, guest));
  const auto engine = make(scene);
  engine->add(guest, {Matrix3::Identity(), {7, 0, 0}}, {0, 0, 0}, {0, 0, 0});
  take(*engine, 150);
  EXPECT_TRUE(engine->has(guest));
  expect_error("comes in once [m]", norm(engine->object_pose(guest).p - Vector3(5, 0.05, 0)), 1e-9, 1e-6);
  engine->remove(guest);
  take(*engine, 100);
  EXPECT_FALSE(engine->has(guest));
}

TEST_P(EngineState, ALatchOnWhatIsOutFailsTheStepUntilItIsBack) {
  if (!can(EngineFeature::latches)) return;
  DynamicScene scene = empty_scene(0.5);
  scene.gravity_W.setZero();
  const std::size_t carrier = add_box(scene, "carrier", {0.2, 0.2, 0.2}, {0, 0, 0}, 2.0);
  const std::size_t load = add_box(scene, "load", {0.2, 0.2, 0.2}, {0.3, 0, 0}, 1.0);
  SceneAction latch = action(SceneAction::Kind::latch, 0.05, load);
  latch.carrier = carrier;
  scene.actions.push_back(latch);
  const auto engine = make(scene);
  engine->remove(load);
  take(*engine, 50);
  engine->begin_step();
  EXPECT_NE(engine->step().failure, "");
  EXPECT_EQ(engine->steps(), 50u);
  engine->add(load, {Matrix3::Identity(), {0.3, 0, 0}}, {0, 0, 0}, {0, 0, 0});
  take(*engine, 50);
  EXPECT_EQ(engine->steps(), 100u);
}

TEST_P(EngineState, WhatMayNotComeOrGoIsNamed) {
  // Two boxes, latched where the engine can.
  DynamicScene scene = empty_scene(0.1);
  const std::size_t ground = add_ground(scene);
  const std::size_t a = add_box(scene, "a", {0.2, 0.2, 0.2}, {0, 0, 1}, 2.0);
  const std::size_t b = add_box(scene, "b", {0.2, 0.2, 0.2}, {1, 0, 1}, 2.0);
  if (can(EngineFeature::latches)) scene.scene.latches.push_back({"a", "b", {}});
  const auto engine = make(scene);
  const auto message = [&](const auto& call) -> std::string {
    try {
      call();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  // Objects that cannot be taken out or are there already.
  EXPECT_EQ(message([&] { engine->remove(ground); }), "remove: object 'ground': is not dynamic");
  EXPECT_EQ(message([&] { engine->remove(7); }), "remove: no such object");
  EXPECT_EQ(message([&] { engine->add(a, {}, {0, 0, 0}, {0, 0, 0}); }), "add: object 'a': is there already");
  if (can(EngineFeature::latches)) {
    EXPECT_NE(message([&] { engine->remove(a); }), "");
    EXPECT_NE(message([&] { engine->remove(b); }), "");
    return;
  }
  // Objects that are gone, and poses and velocities that are none.
  engine->remove(b);
  EXPECT_EQ(message([&] { engine->remove(b); }), "remove: object 'b': is not there");
  EXPECT_EQ(message([&] {
              engine->add(b, {2 * Matrix3::Identity(), {0, 0, 0}}, {0, 0, 0}, {0, 0, 0});
            }),
            "add: object 'b': a bad pose");
  EXPECT_EQ(message([&] {
              engine->add(b, {}, {NAN, 0, 0}, {0, 0, 0});
            }),
            "add: object 'b': velocities that are not finite");
}

TEST_P(EngineState, JoinedAndPartedGoBack) {
  // Two boxes, joined by a hinge at 0.1 s and parted at 0.3 s.
  if (!can(EngineFeature::body_joints)) GTEST_SKIP() << "no joints between bodies";
  DynamicScene scene = empty_scene(0.6);
  scene.gravity_W.setZero();
  const std::size_t a = add_box(scene, "a", {0.2, 0.2, 0.2}, {-0.2, 0, 0}, 1.0);
  const std::size_t b = add_box(scene, "b", {0.2, 0.2, 0.2}, {0.2, 0, 0}, 3.0);
  scene.bodies[b].v_W = {0, 0.2, 0};
  scene.bodies[b].w_W = {0, 0, 1};
  physics::SceneBodyJoint joint;
  joint.name = "joint";
  joint.kind = physics::BodyJointKind::hinge;
  joint.parent = a, joint.child = b;
  joint.is_on = false;
  scene.joints.push_back(joint);
  for (const auto& [kind, time] :
       {std::pair(SceneAction::Kind::join, 0.1), std::pair(SceneAction::Kind::part, 0.3)}) {
    SceneAction each = action(kind, time, 0);
    each.joint = {physics::JointAddress::kBodyJoint, 0};
    scene.actions.push_back(each);
  }
  // Kept before the hinge joins and while it holds.
  const auto engine = make(scene);
  take(*engine, 50);
  const auto apart = engine->snapshot();
  take(*engine, 150);
  const auto joined = engine->snapshot();
  const double value = engine->joint_value({physics::JointAddress::kBodyJoint, 0});
  take(*engine, 200);
  const std::vector<Pose> went_on = poses(*engine);
  // Restored from either, the run ends where it did.
  for (const auto* const kept : {joined.get(), apart.get(), joined.get()}) {
    engine->restore(*kept);
    if (kept == joined.get()) {
      EXPECT_NEAR(engine->joint_value({physics::JointAddress::kBodyJoint, 0}), value, 1e-15);
    }
    take(*engine, kept == joined.get() ? 200 : 350);
    const double off = largest_difference(poses(*engine), went_on);
    EXPECT_LE(off, is_own() ? 0.0 : 1e-9) << off;
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, EngineState, ::testing::ValuesIn(choices()), name_of);

}  // namespace
}  // namespace touchstone

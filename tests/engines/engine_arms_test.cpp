// Arms in every dynamics engine: torques and their limits, brakes, rates, stops and latches against closed
// forms, within what each method may be off. An engine without the feature must refuse it by name.

#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/engines/engine_suite.hpp"

namespace touchstone {
namespace {

using namespace engine_tests;
using physics::BodyKind;
using physics::DynamicScene;
using physics::EngineFeature;
using physics::JointDrive;
using physics::SceneJoint;

constexpr double kMass = 3.0, kLength = 2.0;
/// Of the rod about its end.
constexpr double kInertia = kMass * kLength * kLength / 3.0;

class EngineArms : public EngineSuite {
 protected:
  /// True where the engine lacks the feature; checks that it refuses it by name.
  bool is_refused(EngineFeature feature, const DynamicScene& scene) {
    if (can(EngineFeature::arms) && can(feature)) return false;
    EXPECT_THROW(engines().make(GetParam(), scene), InputError);
    return true;
  }
};

/// No gravity; a slender rod along x from the origin, its hinge about z there.
DynamicScene rod_scene(double duration, const JointDrive& drive, double rate = 0.0) {
  DynamicScene scene = empty_scene(duration);
  scene.gravity_W.setZero();
  const std::size_t rod = add_box(scene, "rod", {kLength, 0.02, 0.02}, {0.5 * kLength, 0, 0}, kMass);
  scene.bodies[rod].kind = BodyKind::link;
  const double moment = kMass * kLength * kLength / 12.0;
  scene.bodies[rod].inertia.inertia_B = Vector3(0, moment, moment).asDiagonal();
  SceneJoint joint;
  joint.name = "hinge";
  joint.child = rod;
  joint.rate = rate;
  joint.effort = 2.0;
  joint.drive.drive = drive;
  scene.mechanisms.push_back({"arm", {joint}, {}});
  return scene;
}

constexpr physics::JointAddress kHinge{0, 0};
const Vector3 kNone = Vector3::Zero();

TEST_P(EngineArms, TorqueIsCutToItsLimit) {
  const DynamicScene scene = rod_scene(1.0, {JointDrive::Mode::torque, 50.0, 0.0, kInfinity});
  if (is_refused(EngineFeature::torque_drives, scene)) return;
  const auto engine = run(GetParam(), scene);
  const double turn = 0.5 * 2.0 / kInertia;
  // The sum of h^2 i is h t / 2 more than t^2 / 2.
  expect_error("turned [rad]", std::abs(engine->joint_value(kHinge) - turn), 1e-9, 1.1 * kStep * turn);
  expect_error("its torque [N m]", std::abs(engine->joint_torque(kHinge) - 2.0), 1e-9, 1e-9);
}

TEST_P(EngineArms, ABrakeStopsAndHolds) {
  const DynamicScene scene = rod_scene(3.0, {JointDrive::Mode::brake, 0.0, 0.0, kInfinity}, 0.5);
  if (is_refused(EngineFeature::brakes, scene)) return;
  const auto engine = run(GetParam(), scene);
  const double turn = kInertia * 0.5 * 0.5 / (2 * 2.0);  // after 1 s
  expect_error("braked over [rad]", std::abs(engine->joint_value(kHinge) - turn), 1e-9, 0.6 * kStep * 0.5);
  expect_error("held at [rad/s]", std::abs(engine->joint_rate(kHinge)), 1e-12, 1e-8);
}

/// Four fifths of its limit, all the time.
TEST_P(EngineArms, ABrakeHoldsASteadyLoad) {
  const DynamicScene scene = rod_scene(0.5, {JointDrive::Mode::brake, 0.0, 0.0, kInfinity});
  if (is_refused(EngineFeature::brakes, scene)) return;
  const auto engine = engines().make(GetParam(), scene);
  while (!engine->is_over()) {
    engine->begin_step();
    engine->push(0, kNone, kNone, {0, 0, 1.6});
    ASSERT_EQ(engine->step().failure, "");
  }
  expect_error("load moved it by [rad]", std::abs(engine->joint_value(kHinge)), 1e-12, 1e-6);
  expect_error("brake bears [N m]", std::abs(engine->joint_torque(kHinge) + 1.6), 1e-9, 1e-4);
}

TEST_P(EngineArms, ARateIsReachedAtTheLimit) {
  const DynamicScene scene = rod_scene(2.0, {JointDrive::Mode::rate, 0.0, 0.3, kInfinity});
  if (is_refused(EngineFeature::rate_drives, scene)) return;
  const auto engine = run(GetParam(), scene);
  const double ramp = kInertia * 0.3 / 2.0, turn = 0.3 * (2.0 - 0.5 * ramp);
  expect_error("driven over [rad]", std::abs(engine->joint_value(kHinge) - turn), 1e-9, 0.6 * kStep * 0.3);
  expect_error("driven at [rad/s]", std::abs(engine->joint_rate(kHinge) - 0.3), 1e-12, 1e-8);
}

TEST_P(EngineArms, AStopHolds) {
  DynamicScene scene = rod_scene(2.0, {JointDrive::Mode::torque, 2.0, 0.0, kInfinity});
  scene.mechanisms[0].joints[0].upper = 0.1;
  if (is_refused(EngineFeature::joint_stops, scene)) return;
  const auto engine = run(GetParam(), scene);
  // Met a step late, at sqrt(2 T q / I); soft stops give way under the torque.
  const double rate = std::sqrt(2 * 2.0 * 0.1 / kInertia);
  expect_error("stopped at [rad]", std::abs(engine->joint_value(kHinge) - 0.1), 1e-9,
               is_soft() ? 1e-2 : 1.1 * rate * kStep);
  expect_error("and rests [rad/s]", std::abs(engine->joint_rate(kHinge)), 1e-12, 1e-3);
}

TEST_P(EngineArms, APendulumSwings) {
  DynamicScene scene = rod_scene(0.6, {JointDrive::Mode::torque, 0.0, 0.0, kInfinity});
  scene.gravity_W = {0, -kGravity, 0};
  if (is_refused(EngineFeature::arms, scene)) return;
  const auto engine = run(GetParam(), scene);
  // From the horizontal: w^2 = 3 g sin(-q) / l.
  const double q = engine->joint_value(kHinge), w = engine->joint_rate(kHinge);
  const double expected = std::sqrt(3 * kGravity * std::sin(-q) / kLength);
  expect_error("swings at [rad/s]", std::abs(-w - expected), 1e-6, 1.5 * kGravity / kLength * kStep);
}

TEST_P(EngineArms, ASliderTakesAForce) {
  DynamicScene scene = rod_scene(1.0, {JointDrive::Mode::torque, 1.5, 0.0, kInfinity});
  scene.mechanisms[0].joints[0].kind = JointKind::prismatic;
  scene.mechanisms[0].joints[0].axis_W = {0, 0.6, 0.8};
  if (is_refused(EngineFeature::torque_drives, scene)) return;
  const auto engine = run(GetParam(), scene);
  const double way = 0.5 * 1.5 / kMass;
  expect_error("slid [m]", std::abs(engine->joint_value(kHinge) - way), 1e-9, 1.1 * kStep * way);
  const Vector3 moved = engine->object_pose(0).p - scene.scene.objects[0].X_WO.p;
  expect_error("along [m]", norm(moved - engine->joint_value(kHinge) * Vector3(0, 0.6, 0.8)), 1e-9, 1e-6);
}

/// The force on a solid's object of all contacts, the last step's [N].
Vector3 force_on(const physics::DynamicsEngine& engine, SolidIndex solid) {
  std::vector<physics::EngineContact> contacts;
  engine.list_contacts(contacts);
  Vector3 sum = Vector3::Zero();
  for (const physics::EngineContact& contact : contacts) {
    if (contact.solids.a == solid) sum -= contact.force_W;
    if (contact.solids.b == solid) sum += contact.force_W;
  }
  return sum;
}

/// The rod's torque presses it against a box, at the box's nearer and farther edge.
TEST_P(EngineArms, PressesOnWhatIsFixed) {
  DynamicScene scene = rod_scene(0.5, {JointDrive::Mode::torque, 2.0, 0.0, kInfinity});
  const std::size_t block = add_box(scene, "block", {0.2, 0.2, 0.2}, {1.5, 0.11, 0}, 0.0, 0.0);
  scene.bodies[0].surface.friction = 0.0;
  if (is_refused(EngineFeature::torque_drives, scene)) return;
  const auto engine = run(GetParam(), scene);
  const Vector3 force = force_on(*engine, static_cast<SolidIndex>(block));
  // Between T / 1.6 and T / 1.4, wherever on the face the method puts it.
  expect_error("pressed by [N]", std::abs(force.y() - 2.0 / 1.5), 0.1, is_soft() ? 0.15 : 0.1);
  expect_error("turned [rad]", std::abs(engine->joint_value(kHinge)), 1e-9, is_soft() ? 5e-3 : 1e-4);
}

/// One arm's slider presses a second arm's rod against its brake: F = T / l until that gives way.
TEST_P(EngineArms, AnArmPressesOnAnother) {
  DynamicScene scene = rod_scene(0.5, {JointDrive::Mode::brake, 0.0, 0.0, kInfinity});
  scene.bodies[0].surface.friction = 0.0;
  const std::size_t head = add_box(scene, "head", {0.02, 0.02, 0.02}, {1.6, -0.02, 0}, 1.0, 0.0);
  scene.bodies[head].kind = BodyKind::link;
  SceneJoint rail;
  rail.name = "rail";
  rail.child = head;
  rail.kind = JointKind::prismatic;
  rail.axis_W = {0, 1, 0};
  rail.drive.drive = {JointDrive::Mode::torque, 1.0, 0.0, kInfinity};
  scene.mechanisms.push_back({"pusher", {rail}, {}});
  if (is_refused(EngineFeature::brakes, scene)) return;
  const auto engine = run(GetParam(), scene);
  expect_error("pressed by [N]", std::abs(force_on(*engine, 0).y() - 1.0), 1e-6, is_soft() ? 1e-5 : 1e-3);
  // On the head's two edges, 20 mm apart: 1.59 to 1.61 N m.
  expect_error("held with [N m]", std::abs(engine->joint_torque(kHinge) + 1.6), 0.011,
               is_soft() ? 1e-5 : 0.012);
}

/// A payload of a hundred rods flies by the rod's end and is caught there.
DynamicScene catch_scene(double duration, double brake) {
  DynamicScene scene = rod_scene(duration, {JointDrive::Mode::brake, 0.0, 0.0, brake});
  const std::size_t payload =
      add_box(scene, "payload", {0.2, 0.2, 0.2}, {kLength + 0.2, 0, 0}, 100.0 * kMass);
  scene.bodies[payload].v_W = {0, 0.05, 0};
  scene.scene.exempt_pairs.push_back({"rod", "payload"});
  physics::SceneAction latch;
  latch.kind = physics::SceneAction::Kind::latch;
  latch.time = 0.1;
  latch.carrier = 0, latch.carried = payload;
  scene.actions.push_back(latch);
  return scene;
}

TEST_P(EngineArms, ALatchCatchesAPayload) {
  DynamicScene scene = catch_scene(1.0, 0.0);
  if (is_refused(EngineFeature::latches, scene)) return;
  const auto engine = run(GetParam(), scene);
  const double m = 100.0 * kMass, x = kLength + 0.2, y = 0.05 * 0.1;
  const double own = m * 0.2 * 0.2 / 6.0;  // a cube's about its centre
  const double rate = m * x * 0.05 / (kInertia + own + m * (x * x + y * y));
  expect_error("caught at [rad/s]", std::abs(engine->joint_rate(kHinge) - rate), 1e-9, 1e-6);
  expect_error("turned with it [rad]", std::abs(engine->joint_value(kHinge) - 0.9 * rate), 1e-9,
               2.0 * kStep * rate);
}

TEST_P(EngineArms, ABrakeIsDrivenBackByAPayload) {
  DynamicScene scene = catch_scene(4.0, 10.0);
  scene.mechanisms[0].joints[0].effort = 10.0;
  if (is_refused(EngineFeature::latches, scene)) return;
  const auto engine = run(GetParam(), scene);
  const double m = 100.0 * kMass, x = kLength + 0.2, y = 0.05 * 0.1;
  const double inertia = kInertia + m * 0.2 * 0.2 / 6.0 + m * (x * x + y * y);
  const double rate = m * x * 0.05 / inertia, turn = inertia * rate * rate / (2 * 10.0);  // over 3.3 s
  expect_error("driven back [rad]", std::abs(engine->joint_value(kHinge) - turn), 1e-6, 2.0 * kStep * rate);
  expect_error("and held [rad/s]", std::abs(engine->joint_rate(kHinge)), 1e-9, 1e-6);
}

TEST_P(EngineArms, WhatIsReleasedFliesOn) {
  DynamicScene scene = catch_scene(1.0, 0.0);
  physics::SceneAction release = scene.actions[0];
  release.kind = physics::SceneAction::Kind::release;
  release.time = 0.2;
  scene.actions.push_back(release);
  if (is_refused(EngineFeature::latches, scene)) return;
  const auto engine = run(GetParam(), scene);
  const double m = 100.0 * kMass, x = kLength + 0.2, y = 0.05 * 0.1;
  const double rate = m * x * 0.05 / (kInertia + m * 0.2 * 0.2 / 6.0 + m * (x * x + y * y));
  const double turn = 0.1 * rate;
  const Vector3 v =
      rate * Vector3(-std::sin(turn) * x - std::cos(turn) * y, std::cos(turn) * x - std::sin(turn) * y, 0);
  expect_error("let go at [m/s]", norm(*engine->velocity(1) - v), 1e-9, 2e-6 + kStep * rate * rate * x);
  expect_error("turning [rad/s]", norm(*engine->angular_velocity(1) - Vector3(0, 0, rate)), 1e-9, 1e-6);
}

TEST_P(EngineArms, FreeBodiesLatchedMoveAsOne) {
  DynamicScene scene = empty_scene(0.5);
  scene.gravity_W.setZero();
  for (int i = 0; i < 3; ++i)
    add_box(scene, "box " + std::to_string(i), {0.2, 0.2, 0.2}, {0.3 * i, 0, 0}, 1.0 + 9.0 * i);
  scene.bodies[2].v_W = {0, 0.1, 0};
  scene.scene.latches.push_back({"box 0", "box 1", {}});
  physics::SceneAction latch;
  latch.kind = physics::SceneAction::Kind::latch;
  latch.time = 0.1;
  latch.carrier = 1, latch.carried = 2;
  scene.actions.push_back(latch);
  if (is_refused(EngineFeature::latches, scene)) return;
  const auto engine = run(GetParam(), scene);
  const double mass = 1 + 10 + 19;
  // A tree's rates are those of its first body: m w^2 r of the others turns by a step's first order.
  const double turn = norm(*engine->angular_velocity(0));
  const double off = (mass - 1.0) * turn * turn * 0.6 * kStep;
  expect_error("momentum [N s]", norm(engine->linear_momentum() - Vector3(0, 1.9, 0)), 1e-9, off);
  expect_error("angular [N m s]", norm(engine->angular_momentum() - Vector3(0, 0, 1.9 * 0.6)), 1e-9, 1e-3);
  expect_error("one velocity [m/s]", norm(*engine->velocity(0) - Vector3(0, 1.9 / mass, 0)), 1e-9,
               off / mass);
  expect_error("one turn [rad/s]", norm(*engine->angular_velocity(0) - *engine->angular_velocity(2)), 1e-9,
               1e-6);
}

/// Two links and a payload a thousand times theirs, caught while both brakes slip: as the own engine has it.
TEST_P(EngineArms, TwoBrakesSlipTogether) {
  DynamicScene scene = catch_scene(2.0, kInfinity);
  const std::size_t far = add_box(scene, "fore", {1, 0.02, 0.02}, {kLength + 0.5, 0, 0}, 1.0);
  scene.bodies[far].kind = BodyKind::link;
  SceneJoint joint;
  joint.name = "elbow";
  joint.parent = 0, joint.child = far;
  joint.p_W = {kLength, 0, 0};
  joint.drive.drive = {JointDrive::Mode::brake, 0.0, 0.0, 4.0};
  scene.mechanisms[0].joints[0].effort = 8.0;
  scene.mechanisms[0].joints[0].drive.drive.limit = 8.0;
  scene.mechanisms[0].joints.push_back(joint);
  scene.scene.exempt_pairs.push_back({"fore", "payload"});
  scene.actions[0].carrier = far;
  if (is_refused(EngineFeature::latches, scene)) return;
  const auto expected = run({"own", "native"}, scene);
  const auto engine = run(GetParam(), scene);
  for (std::size_t j = 0; j < 2; ++j)
    expect_error(j == 0 ? "shoulder [rad]" : "elbow [rad]",
                 std::abs(engine->joint_value({0, j}) - expected->joint_value({0, j})), 0.0, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Engines, EngineArms, ::testing::ValuesIn(choices()), name_of);

}  // namespace
}  // namespace touchstone

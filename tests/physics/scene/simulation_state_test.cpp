// Snapshots of a scene's run, its reset, and joints put at values.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/engine/engine_features.hpp"
#include "touchstone/tests/physics/hand_made_scene.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone::physics {
namespace {

/// A driven arm that catches a body, lets it go and leans on a stack; a tool that comes by.
DynamicScene busy_scene() {
  // Bodies: a rod with a payload, a stack of two, and a tool that pushes it.
  DynamicScene scene = empty_scene(0.6);
  scene.gravity_W = {0, 0, -9.81};
  const Vector3 size(0.2, 0.2, 0.2);
  add(scene, box("floor", {6, 6, 1}, at({0, 0, -0.5})), {});
  add(scene, box("rod", {1, 0.1, 0.1}, at({0.5, 0, 1})),
      {.kind = BodyKind::link, .inertia = box_inertia(5, {1, 0.1, 0.1})});
  add(scene, box("payload", size, at({1.15, 0.05, 1})), free_body(1, size));
  add(scene, box("low", size, at({-1, 0, 0.1})), free_body(1, size));
  add(scene, box("high", size, at({-1.05, 0, 0.3})), free_body(1, size, {0.2, 0, 0}));
  SceneObject tool = box("tool", {0.1, 0.1, 0.1}, at({-1.4, 0, 0.1}));
  tool.motion.segments.push_back({0.1, 0.4, {1.0, 0, 0}, Vector3::UnitZ(), 0.0, kZero});
  add(scene, tool, {.kind = BodyKind::kinematic});
  for (SceneBody& body : scene.bodies) body.surface = {0.4, 0.2};
  // The rod's joint has a drive.
  SceneJoint joint = pivot(1, {0, 0, 1});
  joint.lower = -2, joint.upper = 2;
  joint.drive.drive.torque = 30;
  joint.drive.ramp = -10;
  scene.mechanisms.push_back({"arm", {joint}, {}});
  scene.mechanisms[0].joints[0].axis_W = {0, -1, 0};
  // The payload is latched and released, and the drive changes.
  SceneAction latch{SceneAction::Kind::latch, 0.05}, release{SceneAction::Kind::release, 0.3},
      drive{SceneAction::Kind::drive, 0.35};
  latch.carrier = 1, latch.carried = release.carried = 2;
  drive.drive.drive = {JointDrive::Mode::rate, 0, 0.5, 20};
  scene.actions = {latch, release, drive};
  return scene;
}

/// All poses, rates and touches of the rest of the run, to the bit.
std::vector<double> rest_of(SceneSimulation& simulation) {
  std::vector<double> out;
  while (!simulation.is_over()) {
    EXPECT_EQ(step(simulation).failure, StepFailure::none);
    for (std::size_t i = 0; i < simulation.scene().bodies.size(); ++i) {
      const Pose X = simulation.object_pose(i);
      out.insert(out.end(), X.R.data(), X.R.data() + 9);
      out.insert(out.end(), X.p.data(), X.p.data() + 3);
    }
    out.push_back(simulation.joint_rate({0, 0}));
    for (const ContactForce& force : simulation.forces()) out.push_back(force.force_W.z());
    for (const TouchEvent& event : simulation.touches().events())
      out.push_back(static_cast<double>(event.kind) + event.impulse_W.z());
  }
  return out;
}

TEST(SimulationState, ASnapshotTakesTheSameStepsToTheBitFromAnyTime) {
  const DynamicScene scene = busy_scene();
  SceneSimulation simulation(scene, native_contacts);
  const auto go_to = [&](std::uint64_t steps) {
    while (simulation.steps() < steps) ASSERT_EQ(step(simulation).failure, StepFailure::none);
  };
  for (const std::uint64_t at : {0U, 20U, 100U, 250U, 310U, 400U}) {  // before, in and after the latch
    simulation.reset();
    go_to(at);
    simulation.watch_touches(true);
    const SceneSimulation::Snapshot snapshot = simulation.snapshot();
    simulation.restore(snapshot);
    const std::vector<double> first = rest_of(simulation);
    simulation.restore(snapshot);
    EXPECT_EQ(simulation.steps(), at);
    EXPECT_EQ(rest_of(simulation), first) << at;
  }
}

TEST(SimulationState, ResetIsTheStartToTheBitAndAllocatesNothing) {
  const DynamicScene scene = busy_scene();
  SceneSimulation fresh(scene, native_contacts), simulation(scene, native_contacts);
  fresh.watch_touches(true);
  simulation.watch_touches(true);
  const std::vector<double> first = rest_of(fresh);
  for (const int steps : {1, 120, 600}) {
    for (int i = 0; i < steps && !simulation.is_over(); ++i)
      ASSERT_EQ(step(simulation).failure, StepFailure::none);
    simulation.reset();  // warm from here on
    const std::uint64_t before = allocation_count();
    simulation.reset();
    EXPECT_EQ(allocation_count() - before, 0u) << steps;
    EXPECT_EQ(simulation.time(), 0.0);
  }
  EXPECT_EQ(rest_of(simulation), first);
}

TEST(SimulationState, SnapshotsAreOfTheirSimulationAlone) {
  const DynamicScene scene = busy_scene();
  SceneSimulation a(scene, native_contacts), b(scene, native_contacts);
  EXPECT_THROW(b.restore(a.snapshot()), InputError);
}

TEST(SimulationState, AJointPutAtAValueSwingsFromThere) {
  // A rod on a pivot that is put aside at 0.5 s.
  DynamicScene scene = empty_scene(2.0);
  scene.gravity_W = {0, 0, -9.81};
  const Vector3 size(0.1, 0.1, 1.0);
  add(scene, box("rod", size, at({0, 0, -0.5})), {.kind = BodyKind::link, .inertia = box_inertia(2, size)});
  SceneJoint joint = pivot(0, kZero);
  joint.axis_W = {0, 1, 0};
  joint.lower = -1, joint.upper = 1;
  scene.mechanisms.push_back({"arm", {joint}, {}});
  SceneAction set{SceneAction::Kind::set_joint, 0.5};
  set.value = 0.3, set.rate = -0.1;
  scene.actions = {set};
  SceneSimulation simulation(scene, native_contacts);
  // It hangs still until then, and swings from the value on, with the rate.
  while (simulation.steps() < 500) ASSERT_EQ(step(simulation).failure, StepFailure::none);
  EXPECT_EQ(simulation.joint_value({0, 0}), 0.0);
  ASSERT_EQ(step(simulation).failure, StepFailure::none);
  const double energy = simulation.world().energy();
  EXPECT_NEAR(simulation.joint_value({0, 0}), 0.3, 2e-4);
  EXPECT_LT(simulation.joint_rate({0, 0}), -0.1);
  run(simulation);
  EXPECT_NEAR(simulation.world().energy(), energy, 1e-12);
  // Values at a limit are taken; beyond it, not numbers or of no joint they are refused.
  simulation.set_joint({0, 0}, -1.0, 0.0);
  EXPECT_EQ(simulation.joint_value({0, 0}), -1.0);
  EXPECT_NEAR(simulation.object_pose(0).p.x(), 0.5 * std::sin(1.0), 1e-15);
  EXPECT_THROW(simulation.set_joint({0, 0}, 1.01, 0.0), InputError);
  EXPECT_THROW(simulation.set_joint({0, 0}, 0.0, std::nan("")), InputError);
  EXPECT_THROW(simulation.set_joint({0, 1}, 0.0, 0.0), InputError);
  EXPECT_THROW(simulation.set_joint({1, 0}, 0.0, 0.0), InputError);
}

/// A free hub with an arm of a hinge and a gripped payload: joints between bodies, described in a scene.
TEST(SimulationState, JointsBetweenBodiesHoldLetGoAndGoBackInTime) {
  DynamicScene scene = empty_scene(0.6);
  const Vector3 hub(1, 1, 1), rod(1, 0.1, 0.1), size(0.2, 0.2, 0.2);
  add(scene, box("hub", hub, at({0, 0, 0})), free_body(20, hub));
  add(scene, box("rod", rod, at({1, 0, 0})), free_body(2, rod));
  add(scene, box("payload", size, at({1.62, 0, 0})), free_body(3, size, {0.1, 0, 0}));
  SceneBodyJoint hinge;
  hinge.name = "hinge", hinge.kind = BodyJointKind::hinge, hinge.parent = 0, hinge.child = 1;
  hinge.p_W = {0.5, 0, 0};
  hinge.drive.drive = {JointDrive::Mode::rate, 0.0, 0.5, 5.0};
  SceneBodyJoint grip;
  grip.name = "grip", grip.parent = 1, grip.child = 2, grip.p_W = {1.5, 0, 0}, grip.is_on = false;
  scene.joints = {hinge, grip};
  SceneAction join{SceneAction::Kind::join, 0.1}, part{SceneAction::Kind::part, 0.4};
  join.joint = part.joint = {JointAddress::kBodyJoint, 1};
  scene.actions = {join, part};
  SceneSimulation simulation(scene, native_contacts);
  const Vector3 P = simulation.world().linear_momentum(), L = simulation.world().angular_momentum();
  std::vector<double> first;
  for (const int life : {0, 1}) {
    std::vector<double> poses;
    Pose X_RP;
    while (!simulation.is_over()) {
      ASSERT_EQ(step(simulation).failure, StepFailure::none);
      EXPECT_LT(norm(simulation.world().linear_momentum() - P), 1e-13);
      EXPECT_LT(norm(simulation.world().angular_momentum() - L), 1e-12);
      const Pose now = compose(inverse(simulation.object_pose(1)), simulation.object_pose(2));
      if (simulation.steps() == 100) X_RP = now;
      if (simulation.steps() > 100 && simulation.steps() <= 400) {
        EXPECT_LT(norm(now.p - X_RP.p), 1e-12);
      }
      for (int i = 0; i < 3; ++i) poses.push_back(simulation.object_pose(2).p[i]);
      poses.push_back(simulation.joint_rate({JointAddress::kBodyJoint, 0}));
    }
    EXPECT_NEAR(poses.back(), 0.5, 1e-9);
    EXPECT_FALSE(simulation.world().world_joint(1).is_on);
    if (life == 0) first = poses;
    EXPECT_EQ(poses, first);
    simulation.reset();
    EXPECT_FALSE(simulation.world().world_joint(1).is_on);
  }
  // Engines without them refuse.
  const std::vector<std::string> lacking = unsupported(EngineFeatures::usual(), scene);
  ASSERT_EQ(lacking.size(), 1u);
  EXPECT_EQ(lacking[0], "joints between bodies (joint 'hinge')");
  scene.joints[1].child = 1;
  EXPECT_THROW(validate(scene), InputError);
}

/// A stack whose lowest cube goes and comes back beside it, one that comes later, and a scene of which
/// another is never in.
DynamicScene coming_and_going() {
  DynamicScene scene = empty_scene(0.6);
  scene.gravity_W = {0, 0, -9.81};
  const Vector3 size(0.2, 0.2, 0.2);
  add(scene, box("floor", {6, 6, 1}, at({0, 0, -0.5})), {});
  add(scene, box("low", size, at({0, 0, 0.1})), free_body(1, size));
  add(scene, box("high", size, at({0.03, 0, 0.3})), free_body(1, size));
  add(scene, box("late", size, at({0, 0.02, 0.8})), free_body(1, size, {0, 0, -1}));
  for (SceneBody& body : scene.bodies) body.surface = {0.4, 0.0};
  SceneAction remove{SceneAction::Kind::remove, 0.2}, come{SceneAction::Kind::add, 0.25},
      back{SceneAction::Kind::add, 0.35};
  remove.carried = back.carried = 1, come.carried = 3;
  scene.actions = {remove, come, back};
  return scene;
}

TEST(SimulationState, WhatComesAndGoesGoesBackInTimeAndAllocatesNothing) {
  const DynamicScene scene = coming_and_going();
  SceneSimulation simulation(scene, native_contacts);
  // Runs on to the end, without allocating; all places on the way.
  const auto run_on = [&] {
    std::vector<double> out;
    std::size_t allocated = 0;
    while (!simulation.is_over()) {
      const std::size_t before = allocation_count();
      EXPECT_EQ(step(simulation).failure, StepFailure::none);
      allocated += allocation_count() - before;
      for (std::size_t i = 1; i < 4; ++i)
        for (int k = 0; k < 3; ++k) out.push_back(simulation.object_pose(i).p[k]);
    }
    EXPECT_EQ(allocated, 0U);
    return out;
  };
  // From the start, and again.
  EXPECT_FALSE(simulation.has(3));
  const std::vector<double> first = run_on();
  EXPECT_TRUE(simulation.has(1) && simulation.has(3));
  simulation.reset();
  EXPECT_FALSE(simulation.has(3));
  EXPECT_EQ(run_on(), first);
  // From the middle, and again.
  simulation.reset();
  for (int i = 0; i < 220; ++i) ASSERT_EQ(step(simulation).failure, StepFailure::none);
  EXPECT_FALSE(simulation.has(1));
  const SceneSimulation::Snapshot between = simulation.snapshot();
  const std::vector<double> rest = run_on();
  EXPECT_EQ(rest, std::vector<double>(first.end() - static_cast<std::ptrdiff_t>(rest.size()), first.end()));
  simulation.restore(between);
  EXPECT_FALSE(simulation.has(1));
  EXPECT_EQ(run_on(), rest);
}

TEST(SimulationState, WhatIsRemovedLeavesTheRestAsIfItHadNeverBeen) {
  // Far off: the bits of all others are those of a scene without it.
  DynamicScene with = coming_and_going();
  with.actions.clear();
  with.scene.objects[3].X_WO.p = {3, 0, 0.4};
  DynamicScene without = with;
  without.scene.objects.pop_back();
  without.bodies.pop_back();
  SceneSimulation one(with, native_contacts), other(without, native_contacts);
  one.remove(3);
  EXPECT_FALSE(one.velocity(3).has_value());
  while (!one.is_over()) {
    ASSERT_EQ(step(one).failure, StepFailure::none);
    ASSERT_EQ(step(other).failure, StepFailure::none);
    for (std::size_t i = 1; i < 3; ++i) ASSERT_EQ(one.object_pose(i).p, other.object_pose(i).p);
    ASSERT_EQ(one.world().energy(), other.world().energy());
  }
  EXPECT_EQ(one.object_pose(3).p, Vector3(3, 0, 0.4));
}

TEST(SimulationState, WhatSleptOnARemovedBodyWakesAndFalls) {
  DynamicScene scene = coming_and_going();
  scene.actions.clear();
  scene.sleep_time = 0.05;
  SceneSimulation simulation(scene, native_contacts);
  simulation.remove(3);
  for (int i = 0; i < 300; ++i) ASSERT_EQ(step(simulation).failure, StepFailure::none);
  ASSERT_GE(simulation.world().sleepers(), 2U);
  const double height = simulation.object_pose(2).p.z();
  simulation.remove(1);
  for (int i = 0; i < 100; ++i) ASSERT_EQ(step(simulation).failure, StepFailure::none);
  EXPECT_NEAR(simulation.object_pose(2).p.z(), height - 0.5 * 9.81 * 0.01, 1e-9);
  EXPECT_THROW(simulation.remove(1), InputError);
  EXPECT_THROW(simulation.remove(0), InputError);
  EXPECT_THROW(simulation.add(2, {}, kZero, kZero), InputError);
}

}  // namespace
}  // namespace touchstone::physics

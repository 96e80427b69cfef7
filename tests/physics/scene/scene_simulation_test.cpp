#include "touchstone/physics/scene/scene_simulation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/scene/motion.hpp"
#include "touchstone/tests/physics/hand_made_scene.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

TEST(SceneSimulation, KinematicBodiesAreWhereTheyAreTold) {
  DynamicScene scene = empty_scene(1.0);
  SceneObject object = box("tool", {0.1, 0.2, 0.3}, at({1, 2, 3}));
  object.motion.segments.push_back({0.1, 0.6, {0.3, 0, -0.2}, Vector3(0, 0.6, 0.8), 2.0, {0, 1, 0}});
  add(scene, object, {.kind = BodyKind::kinematic});
  SceneSimulation simulation(scene, native_contacts);
  while (!simulation.is_over()) {
    ASSERT_EQ(step(simulation).failure, StepFailure::none);
    const Pose expected = pose_at(object.motion, object.X_WO, simulation.time());
    const Pose got = simulation.object_pose(0);
    ASSERT_LT(norm(got.p - expected.p), 4e-15) << simulation.time();
    ASSERT_LT((got.R - expected.R).cwiseAbs().maxCoeff(), 4e-15) << simulation.time();
  }
}

TEST(SceneSimulation, WhatRestsSleepsUntilAToolTouchesIt) {
  DynamicScene scene = empty_scene(1.0);
  scene.gravity_W = {0, 0, -9.81};
  scene.sleep_time = 0.1;
  add(scene, box("floor", {4, 4, 1}, at({0, 0, -0.5})), {.surface = {0.5, 0.0}});
  add(scene, box("block", {0.2, 0.2, 0.2}, at({0, 0, 0.1})), free_body(1.0, {0.2, 0.2, 0.2}));
  SceneObject tool = box("tool", {0.2, 0.2, 0.2}, at({-0.25, 0, 0.11}));  // 5 cm away
  tool.motion.segments.push_back({0.5, 0.5, {0.2, 0, 0}, Vector3::UnitZ(), 0.0, kZero});
  add(scene, tool, {.kind = BodyKind::kinematic});
  SceneSimulation simulation(scene, native_contacts);
  const auto run_to = [&](double time) {
    while (simulation.time() < time) ASSERT_EQ(step(simulation).failure, StepFailure::none);
  };
  run_to(0.45);
  const std::uint32_t block = *simulation.dynamic_body(1);
  EXPECT_TRUE(simulation.world().is_asleep(block));
  EXPECT_TRUE(simulation.world().is_at_rest());
  run_to(0.95);  // touched at 0.75 s
  EXPECT_FALSE(simulation.world().is_asleep(block));
  EXPECT_GT(simulation.object_pose(1).p.x(), 0.01);
}

TEST(SceneSimulation, JointsToldInTheWorldLeaveTheObjectsWhereTheyStand) {
  // Two links in poses of no pattern, at joint values other than 0, on a fixed stand.
  DynamicScene scene = empty_scene(1.0);
  const Pose X_A{rotation_about(Vector3(0.6, 0, 0.8), 0.7), {1, 2, 3}},
      X_B{rotation_about(Vector3(0, 0.8, 0.6), -1.1), {2, 2.5, 3}};
  add(scene, box("stand", {1, 1, 1}, at({1, 1.9, 3})), {});
  add(scene, box("a", {1, 1, 1}, X_A), {.kind = BodyKind::link, .inertia = box_inertia(3, {1, 1, 1})});
  add(scene, box("b", {1, 1, 1}, X_B), {.kind = BodyKind::link, .inertia = box_inertia(2, {1, 1, 1})});
  SceneMechanism arm{"arm", {pivot(1, {1.25, 2, 2.5}), pivot(2, {1.5, 2.25, 3})}, {}};
  arm.joints[0].parent = 0;
  arm.joints[0].axis_W = {0, 0.6, 0.8};
  arm.joints[0].value = 0.4;
  arm.joints[1].name = "slide";
  arm.joints[1].kind = JointKind::prismatic;
  arm.joints[1].parent = 1;
  arm.joints[1].axis_W = {0.8, 0, -0.6};
  arm.joints[1].value = -0.3;
  arm.joints[1].rate = 0.25;
  scene.mechanisms.push_back(arm);
  scene.scene.exempt_pairs.push_back({"stand", "b"});
  SceneSimulation simulation(scene, native_contacts);
  EXPECT_EQ(simulation.joint_value({0, 0}), 0.4);
  for (const std::size_t o : {std::size_t{1}, std::size_t{2}}) {
    const Pose X = simulation.object_pose(o);
    EXPECT_LT(norm(X.p - scene.scene.objects[o].X_WO.p), 4e-15);
    EXPECT_LT((X.R - scene.scene.objects[o].X_WO.R).cwiseAbs().maxCoeff(), 4e-15);
  }
  // The slide moves its child along the axis as it stands.
  ASSERT_EQ(step(simulation).failure, StepFailure::none);
  EXPECT_TRUE(simulation.contacts().empty());  // all three overlap: joined, or exempt
  const Vector3 moved = simulation.object_pose(2).p - X_B.p;
  EXPECT_NEAR(dot(moved, Vector3(0.8, 0, -0.6)), 0.25e-3, 1e-6);
  EXPECT_LT(norm(cross(moved, Vector3(0.8, 0, -0.6))), 1e-6);
}

TEST(SceneSimulation, LatchedBodiesKeepMomentumMoveAsOneAndPartAgain) {
  DynamicScene scene = empty_scene(0.3);
  const Vector3 size(0.5, 0.4, 0.3);
  add(scene, box("a", size, at({0, 0, 0})), free_body(5, size, {0.1, 0, 0}, {0, 0, 0.5}));
  add(scene, box("b", size, at({1, 0.2, 0})), free_body(3, size, {-0.2, 0.1, 0.1}, {0.3, 0, 0}));
  add(scene, box("c", size, at({-1, 0, 0.2})), free_body(2, size, {0, 0, 0.4}, {0, 0.2, 0}));
  SceneAction latch_b{SceneAction::Kind::latch, 0.05}, latch_c{SceneAction::Kind::latch, 0.1},
      release_b{SceneAction::Kind::release, 0.2};
  latch_b.carrier = 2, latch_b.carried = 1;
  latch_c.carrier = 0, latch_c.carried = 2;  // with b, which it carries
  release_b.carried = 1;
  scene.actions = {latch_b, latch_c, release_b};
  SceneSimulation simulation(scene, native_contacts);
  const Vector3 P = simulation.world().linear_momentum(), L = simulation.world().angular_momentum();
  Pose X_AB, X_AC;
  while (!simulation.is_over()) {
    ASSERT_EQ(step(simulation).failure, StepFailure::none);
    EXPECT_LT(norm(simulation.world().linear_momentum() - P), 1e-14 * norm(P));
    EXPECT_LT(norm(simulation.world().angular_momentum() - L), 1e-13 * norm(L));
    const Pose X_WA = simulation.object_pose(0);
    const Pose b = compose(inverse(X_WA), simulation.object_pose(1)),
               c = compose(inverse(X_WA), simulation.object_pose(2));
    if (simulation.steps() == 101) X_AB = b, X_AC = c;
    if (simulation.steps() <= 101) continue;
    EXPECT_LT(norm(c.p - X_AC.p), 1e-14);
    if (simulation.steps() <= 200) {
      EXPECT_LT(norm(b.p - X_AB.p), 1e-14);
    }
  }
  EXPECT_EQ(simulation.worlds(), 4u);
  EXPECT_EQ(simulation.root_of(2), 0u);
  EXPECT_EQ(simulation.root_of(1), 1u);
  // Let go, each keeps to its tangent: apart by about w^2 r t^2 / 2.
  EXPECT_GT(norm(compose(inverse(simulation.object_pose(0)), simulation.object_pose(1)).p - X_AB.p), 1e-5);
}

TEST(SceneSimulation, ALinkCatchesAndReleasesWithTheAnglesMomentum) {
  // A free rod about z catches a body off its axis and lets it go half a second later.
  DynamicScene scene = empty_scene(1.0);
  const Vector3 size(0.2, 0.2, 0.2);
  const double I = 70.0 * 25.0 / 3.0, m = 10.0, own = m * 0.08 / 12.0;
  add(scene, box("rod", {5, 0.1, 0.1}, at({2.5, 0, 0})),
      {.kind = BodyKind::link, .inertia = {70, kZero, Vector3(0, I / 4, I / 4).asDiagonal()}});
  add(scene, box("payload", size, at({5.2, 0, 0})), free_body(m, size, {0.3, 0.1, 0}));
  scene.mechanisms.push_back({"arm", {pivot(0, kZero)}, {}});
  SceneAction latch{SceneAction::Kind::latch, 0.0}, release{SceneAction::Kind::release, 0.5};
  latch.carrier = 0, latch.carried = release.carried = 1;
  scene.actions = {latch, release};
  SceneSimulation simulation(scene, native_contacts);
  ASSERT_EQ(step(simulation).failure, StepFailure::none);
  const double w = m * 0.1 * 5.2 / (I + m * 5.2 * 5.2 + own);
  EXPECT_NEAR(simulation.joint_rate({0, 0}), w, 1e-15);
  EXPECT_FALSE(simulation.velocity(1).has_value());
  run(simulation);
  EXPECT_NEAR(simulation.joint_rate({0, 0}), w, 1e-14);  // let go, both go on
  ASSERT_TRUE(simulation.velocity(1).has_value());
  EXPECT_NEAR(norm(*simulation.velocity(1)), 5.2 * w, 1e-13);
  EXPECT_NEAR(simulation.angular_velocity(1)->z(), w, 1e-14);
}

TEST(SceneSimulation, ReleasedByATurningCarrierItGoesOffAlongTheTangent) {
  DynamicScene scene = empty_scene(0.5);
  SceneObject wheel = box("wheel", {1, 1, 0.1}, {});
  wheel.motion.segments.push_back({0.0, 0.5, kZero, Vector3::UnitZ(), 2.0, kZero});
  add(scene, wheel, {.kind = BodyKind::kinematic});
  add(scene, box("stone", {0.1, 0.1, 0.1}, at({0, 1, 0})), free_body(1, {0.1, 0.1, 0.1}));
  scene.scene.latches.push_back({"wheel", "stone", {}});
  SceneAction release{SceneAction::Kind::release, 0.25};
  release.carried = 1;
  scene.actions = {release};
  SceneSimulation simulation(scene, native_contacts);
  run(simulation);
  // It left at 0.5 rad, from (-sin, cos), at 2 m/s.
  const Vector3 v(-2 * std::cos(0.5), -2 * std::sin(0.5), 0), left(-std::sin(0.5), std::cos(0.5), 0);
  EXPECT_LT(norm(*simulation.velocity(1) - v), 1e-12);
  EXPECT_LT(norm(simulation.object_pose(1).p - (left + 0.25 * v)), 1e-12);
  EXPECT_NEAR(simulation.angular_velocity(1)->z(), 2.0, 1e-12);
}

TEST(SceneSimulation, ExemptObjectsPassThroughEachOtherAndNobodyElse) {
  // Two fixed plates in the way of a box; one is exempt. Both are ground.
  for (const bool second_is_exempt : {true, false}) {
    DynamicScene scene = empty_scene(1.0);
    const Vector3 size(0.2, 0.2, 0.2);
    add(scene, box("first", {0.1, 1, 1}, at({0.5, 0, 0})), {});
    add(scene, box("second", {0.1, 1, 1}, at({1.0, 0, 0})), {});
    add(scene, box("ball", size, {}), free_body(1, size, {2, 0, 0}));
    scene.scene.exempt_pairs.push_back({"first", "ball"});
    if (second_is_exempt) scene.scene.exempt_pairs.push_back({"ball", "second"});
    SceneSimulation simulation(scene, native_contacts);
    run(simulation);
    EXPECT_NEAR(simulation.object_pose(2).p.x(), second_is_exempt ? 2.0 : 0.85, 1e-8);
  }
}

TEST(SceneSimulation, ARampGrowsEvenly) {
  // m x'' = k t, so x = k t^3 / (6 m). The torque of a step is that of its middle: velocities at the ends are
  // right, each step goes k h^3 / (12 m) too far.
  DynamicScene scene = empty_scene(1.0);
  add(scene, box("cart", {0.1, 0.1, 0.1}, {}),
      {.kind = BodyKind::link, .inertia = box_inertia(2, {0.1, 0.1, 0.1})});
  SceneJoint rail = pivot(0, kZero);
  rail.kind = JointKind::prismatic;
  rail.axis_W = Vector3::UnitX();
  rail.drive.ramp = 6.0;
  scene.mechanisms.push_back({"cart", {rail}, {}});
  SceneSimulation simulation(scene, native_contacts);
  run(simulation);
  EXPECT_NEAR(simulation.joint_value({0, 0}), 0.5 + 6.0 * 1e-6 / 24.0, 1e-12);
  EXPECT_NEAR(simulation.joint_rate({0, 0}), 1.5, 1e-12);
  EXPECT_NEAR(simulation.joint_torque({0, 0}), 6.0 * (1.0 - 0.5e-3), 1e-12);
}

TEST(SceneSimulation, AServoFollowsItsCommandsAsFarAsItsTorqueGoes) {
  // 2 kg m2 on a servo of 4 N m: commanded 1 rad/s, then -1 rad/s, it gets there at 2 rad/s2, within the
  // step.
  DynamicScene scene = empty_scene(2.0);
  const BodyInertia wheel{1.0, kZero, Vector3(1, 1, 2).asDiagonal()};
  add(scene, box("wheel", {1, 1, 0.1}, {}), {.kind = BodyKind::link, .inertia = wheel});
  SceneJoint joint = pivot(0, kZero);
  joint.effort = 4.0;
  joint.most_rate = 1.0;
  scene.mechanisms.push_back({"servo", {joint}, {}});
  SceneAction forwards{SceneAction::Kind::drive, 0.0}, backwards{SceneAction::Kind::drive, 0.75};
  forwards.drive.drive = {.mode = JointDrive::Mode::rate, .rate = 5.0};  // cut to the joint's own
  backwards.drive.drive = {.mode = JointDrive::Mode::rate, .rate = -1.0, .limit = 100.0};
  scene.actions = {forwards, backwards};
  SceneSimulation simulation(scene, native_contacts);
  while (!simulation.is_over()) {
    ASSERT_EQ(step(simulation).failure, StepFailure::none);
    const double t = simulation.time();
    const double rate = t <= 0.75 ? std::min(1.0, 2.0 * t) : std::max(-1.0, 1.0 - 2.0 * (t - 0.75));
    ASSERT_NEAR(simulation.joint_rate({0, 0}), rate, 1e-10) << t;  // the solver's tolerance
    ASSERT_LE(std::abs(simulation.joint_torque({0, 0})), 4.0 * (1 + 1e-12)) << t;
  }
}

TEST(SceneSimulation, StepsAllocateNothing) {
  DynamicScene scene = empty_scene(0.5);
  scene.gravity_W = {0, 0, -9.81};
  const Vector3 size(0.2, 0.2, 0.2);
  add(scene, box("floor", {4, 4, 1}, at({0, 0, -0.5})), {});
  for (int i = 0; i < 3; ++i)
    add(scene, box("box" + std::to_string(i), size, at({0, 0, 0.1 + 0.2 * i})), free_body(8, size));
  SceneObject pusher = box("pusher", size, at({-0.3, 0, 0.3}));
  pusher.motion.segments.push_back({0.0, 0.5, {0.3, 0, 0}});
  add(scene, pusher, {.kind = BodyKind::kinematic});
  SceneSimulation simulation(scene, native_contacts);
  std::size_t allocations = 0;
  while (!simulation.is_over()) {
    ASSERT_EQ(step(simulation).failure, StepFailure::none);
    if (simulation.steps() == 400) allocations = allocation_count();  // all have met
  }
  EXPECT_EQ(allocation_count(), allocations);
  EXPECT_GT(simulation.object_pose(2).p.x(), 0.01);  // it was pushed
}

TEST(SceneSimulation, LatchesReleasesAndRampsAllocateNothing) {
  // A rod with a ramp on its drive catches a free body and lets it go; two free bodies latch, one of them is
  // let go again; a box falls onto the floor meanwhile. Not one allocation after set-up.
  DynamicScene scene = empty_scene(0.5);
  scene.gravity_W = {0, 0, -9.81};
  const Vector3 size(0.2, 0.2, 0.2);
  const double I = 70.0 * 25.0 / 3.0;
  add(scene, box("rod of the arm", {5, 0.1, 0.1}, at({2.5, 0, 3})),
      {.kind = BodyKind::link, .inertia = {70, kZero, Vector3(0, I / 4, I / 4).asDiagonal()}});
  add(scene, box("payload of the arm", size, at({5.2, 0, 3})), free_body(10, size, {0.3, 0.1, 0}));
  add(scene, box("first of two bodies", size, at({0, 5, 3})), free_body(5, size, {0.1, 0, 0}, {0, 0, 0.5}));
  add(scene, box("second of two bodies", size, at({0.5, 5, 3})), free_body(3, size, {0, 0.2, 0.1}));
  add(scene, box("floor", {4, 4, 1}, at({0, -4, -0.5})), {});
  add(scene, box("falling box", size, at({0, -4, 0.15})), free_body(8, size));
  SceneJoint joint = pivot(0, {0, 0, 3});
  joint.drive.ramp = 6.0;
  scene.mechanisms.push_back({"arm", {joint}, {}});
  SceneAction by_link{SceneAction::Kind::latch, 0.1}, by_body{SceneAction::Kind::latch, 0.2},
      from_link{SceneAction::Kind::release, 0.3}, from_body{SceneAction::Kind::release, 0.4};
  by_link.carrier = 0, by_link.carried = from_link.carried = 1;
  by_body.carrier = 2, by_body.carried = from_body.carried = 3;
  scene.actions = {by_link, by_body, from_link, from_body};
  SceneSimulation simulation(scene, native_contacts);
  const std::size_t allocations = allocation_count();
  while (!simulation.is_over()) {
    ASSERT_EQ(step(simulation).failure, StepFailure::none);
    ASSERT_EQ(allocation_count(), allocations) << simulation.time();
  }
  EXPECT_EQ(simulation.worlds(), 5u);
  EXPECT_EQ(simulation.contacts().size(), 4u);
  EXPECT_NEAR(simulation.object_pose(5).p.z(), 0.1, 1e-8);
}

TEST(SceneSimulation, ManyContactsAllocateNothingWhereTheyAreReservedFor) {
  // 64 cubes in 16 stacks fall by 1 mm: 256 contacts, of which there are none at first.
  DynamicScene scene = empty_scene(0.05);
  scene.gravity_W = {0, 0, -9.81};
  add(scene, box("floor", {20, 20, 1}, at({0, 0, -0.5})), {});
  const Vector3 size(0.2, 0.2, 0.2);
  for (int i = 0; i < 64; ++i)
    add(scene,
        box("cube " + std::to_string(i), size,
            at({0.5 * (i % 4), 0.5 * (i / 4 % 4), 0.102 + 0.202 * (i / 16)})),
        free_body(1, size));
  SceneSimulation simulation(scene, native_contacts);
  // More than there is changes nothing.
  EXPECT_ANY_THROW(simulation.reserve(SIZE_MAX));
  EXPECT_NO_THROW(simulation.watch_touches(true));
  simulation.watch_touches(false);
  simulation.reserve(256);
  const std::size_t allocations = allocation_count();
  while (!simulation.is_over()) {
    ASSERT_EQ(step(simulation).failure, StepFailure::none);
    ASSERT_EQ(allocation_count(), allocations) << simulation.time();
  }
  EXPECT_EQ(simulation.contacts().size(), 256u);
}

TEST(SceneSimulation, NothingPassesThroughAPlateHoweverFast) {
  // In one step of 1 ms it goes 0.4 m at most, through a plate of 5 cm and beyond; the margin is 1 mm.
  for (const double speed : {0.5, 2.0, 50.0, 400.0}) {
    for (const bool plate_moves : {false, true}) {
      DynamicScene scene = empty_scene(std::ceil(1500.0 / speed) * 1e-3);
      const Vector3 size(0.2, 0.2, 0.2);
      add(scene, box("ball", size, at({-1.0, 0.1, 0})),
          free_body(1, size, {plate_moves ? 0.0 : speed, 0, 0}));
      SceneObject plate = box("plate", {0.05, 1, 1}, {});
      if (plate_moves) plate.motion.segments.push_back({0.0, scene.scene.duration, {-speed, 0, 0}});
      add(scene, plate, {.kind = plate_moves ? BodyKind::kinematic : BodyKind::fixed});
      SceneSimulation simulation(scene, native_contacts);
      while (!simulation.is_over()) {
        ASSERT_EQ(step(simulation).failure, StepFailure::none);
        const double gap = simulation.object_pose(1).p.x() - simulation.object_pose(0).p.x() - 0.125;
        ASSERT_GE(gap, -1e-8) << speed << " m/s at " << simulation.time();
      }
      const Vector3 ball = simulation.object_pose(0).p;
      EXPECT_NEAR(ball.x() + 0.125, simulation.object_pose(1).p.x(), 1e-8) << speed;
      EXPECT_NEAR(ball.y(), 0.1, 1e-12);
    }
  }
}

TEST(SceneSimulation, FastBodiesPassByWhatTheyDoNotMeet) {
  // Past the plate's edge by 2 mm, and away from it: no contact, no force.
  DynamicScene scene = empty_scene(0.02);
  const Vector3 size(0.2, 0.2, 0.2);
  add(scene, box("past", size, at({-1.0, 0.602, 0})), free_body(1, size, {100, 0, 0}));
  add(scene, box("away", size, at({-0.2, 0, 0})), free_body(1, size, {-100, 0, 0}));
  add(scene, box("plate", {0.05, 1, 1}, {}), {});
  SceneSimulation simulation(scene, native_contacts);
  run(simulation);
  EXPECT_NEAR(simulation.object_pose(0).p.x(), 1.0, 1e-12);
  EXPECT_NEAR(simulation.object_pose(1).p.x(), -2.2, 1e-12);
}

/// Knows poses only.
class PosesOnly final : public Broadphase {
 public:
  std::string_view name() const noexcept override { return "poses_only"; }
  void build(const BroadphaseInput& input) override { of_->build(input); }
  void update(std::span<const Pose> poses, std::span<const std::uint32_t> moved) noexcept override {
    of_->update(poses, moved);
  }
  std::size_t find_pairs(PairCursor& cursor, std::span<SolidPair> block) noexcept override {
    return of_->find_pairs(cursor, block);
  }

 private:
  std::unique_ptr<Broadphase> of_ = make_native_broadphase();
};

TEST(NarrowphaseContacts, SayWhatTheBroadphaseCannotFollow) {
  DynamicsWorld world({});
  const Vector3 size(0.2, 0.2, 0.2);
  const RigidBody ball(box_inertia(1, size), "ball");
  const HexahedronTree tree({{"box", Hexahedron::from_size(size), {}}}, "ball");
  const std::uint32_t slow = world.add_body(ball, ball.state(at({0, 3, 0}), {0.4, 0, 0}, kZero));
  const std::uint32_t fast = world.add_body(ball, ball.state({}, {0.6, 0, 0}, kZero));
  for (const bool knows_paths : {true, false}) {
    std::unique_ptr<Broadphase> broadphase = make_native_broadphase();
    if (!knows_paths) broadphase = std::make_unique<PosesOnly>();
    NarrowphaseContacts contacts(std::move(broadphase), make_native(), 1e-3);
    for (const std::uint32_t body : {slow, fast}) contacts.add(Mover::of_body(body), tree, {});
    contacts.build();
    contacts.find(world, 1e-3);
    EXPECT_EQ(contacts.unfollowed(), knows_paths ? 0u : 1u);
    contacts.find(world, 0.5e-3);
    EXPECT_EQ(contacts.unfollowed(), 0u);
  }
}

}  // namespace

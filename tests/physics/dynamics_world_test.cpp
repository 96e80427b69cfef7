#include "physics/dynamics_world.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

#include "contact_core/input_error.hpp"
#include "tests/physics/arm_with_payload.hpp"
#include "tests/support/counting_allocator.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

const Vector3 kZero = Vector3::Zero();

std::string error_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const InputError& refusal) {
    return refusal.what();
  }
  return "";
}

Pose at(const Vector3& p) {
  Pose X;
  X.p = p;
  return X;
}

TEST(DynamicsWorld, BadSetUpIsRefusedByName) {
  const Arm arm = ssrms_arm();
  const MechanismDynamics dynamics(arm.mechanism, arm.links);
  const std::vector<double> zero(7, 0.0);
  DynamicsWorld world({});
  const auto mechanism = world.add_mechanism(dynamics, {}, zero, zero);
  EXPECT_THAT(error_of([&] { world.set_drive(mechanism, 2, {.limit = -1.0}); }),
              testing::StrEq("mechanism 'ssrms', value 2: a torque limit below 0"));
  EXPECT_THAT(error_of([&] { world.set_drive(7, 0, {}); }), testing::StrEq("no mechanism 7"));
  EXPECT_THAT(error_of([&] { world.set_drive(mechanism, 9, {}); }), testing::HasSubstr("no such joint"));
  EXPECT_THAT(error_of([&] { world.set_drive(mechanism, 0, {.torque = NAN}); }),
              testing::HasSubstr("not finite"));
  std::vector<double> beyond = zero;
  beyond[3] = 5.0;
  EXPECT_THAT(error_of([&] { world.add_mechanism(dynamics, {}, beyond, zero); }),
              testing::HasSubstr("out of limits"));
  EXPECT_THAT(error_of([&] { world.add_mechanism(dynamics, {}, std::array{0.0}, zero); }),
              testing::HasSubstr("1 values and 7 rates for 7 joints"));
  EXPECT_THAT(error_of([&] { world.set_velocity(0, kZero, kZero); }),
              testing::HasSubstr("body 0 is not kinematic"));
  DynamicsWorld::Settings settings;
  settings.contact_gap = 0.0;
  EXPECT_THROW(DynamicsWorld{settings}, InputError);
}

TEST(DynamicsWorld, WhatIsNotFiniteKeepsTheLastGoodStateAndNamesTheCause) {
  DynamicsWorld world({.gravity_W = {0, 0, -9.81}});
  const RigidBody body(box_inertia(1.0, {1, 1, 1}), "body");
  world.add_body(body, body.state({}, kZero, kZero));
  const auto spinning = world.add_body(body, body.state(at({5, 0, 0}), {1, 0, 0}, {0, 0, 1e6}));
  const RigidBodyState before = world.state(0);
  StepReport report = world.step(1e-3, {});
  EXPECT_EQ(report.failure, StepFailure::body);
  EXPECT_EQ(report.failed_index, spinning);
  EXPECT_EQ(world.state(0).p_W, before.p_W);
  EXPECT_EQ(world.state(0).momentum_W, before.momentum_W);

  Contact contact{Mover::ground(), Mover::of_body(7), Vector3::UnitZ(), kZero, kZero, 0.5, 0.0, 0};
  report = world.step(1e-3, {&contact, 1});
  EXPECT_EQ(report.failure, StepFailure::bad_contact);
  contact.b = Mover::of_body(0);
  contact.n_AB_W = {0, 0, 2};
  EXPECT_EQ(world.step(1e-3, {&contact, 1}).failure, StepFailure::bad_contact);
  EXPECT_EQ(to_string(report.failure), "bad_contact");
}

TEST(DynamicsWorld, JointsFollowCommandedRatesWithinTheirTorque) {
  const Arm arm = ssrms_arm();
  const MechanismDynamics dynamics(arm.mechanism, arm.links);
  DynamicsWorld world({});
  const std::vector<double> q = {0.1, 0.4, -0.8, 1.2, 0.5, -0.3, 0.2}, zero(7, 0.0);
  const auto mechanism = world.add_mechanism(dynamics, {}, q, zero);
  const std::vector<double> rates = {0.01, -0.02, 0.03, 0.01, -0.02, 0.03, 0.02};
  for (std::uint32_t i = 0; i < 7; ++i)
    world.set_drive(mechanism, i, {.mode = JointDrive::Mode::rate, .rate = rates[i], .limit = 2332.0});
  bool was_limited = false;
  for (int step = 0; step < 4000; ++step) {
    ASSERT_EQ(world.step(1e-3, {}).failure, StepFailure::none);
    for (const double torque : world.joint_torques(mechanism)) {
      EXPECT_LE(std::abs(torque), 2332.0 * (1.0 + 1e-12));
      was_limited = was_limited || std::abs(torque) > 2331.9;
    }
  }
  EXPECT_TRUE(was_limited);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(world.joint_rates(mechanism)[i], rates[i], 1e-9);
}

TEST(DynamicsWorld, ForcesOnARestingBodyAreItsWeight) {
  const double g = 9.81;
  DynamicsWorld world({.gravity_W = {0, 0, -g}});
  const RigidBody cube(box_inertia(3.0, {0.2, 0.2, 0.2}), "cube");
  const auto body = world.add_body(cube, cube.state(at({1, 0, 0.1}), kZero, kZero));
  std::array<Contact, 2> contacts;
  std::array<ContactForce, 2> forces;
  for (unsigned i = 0; i < 2; ++i) {
    const Vector3 p(1.0, i == 0 ? -0.1 : 0.1, 0.0);
    contacts[i] = {Mover::ground(), Mover::of_body(body), Vector3::UnitZ(), p, p, 0.5, 0.0, i + 1};
  }
  ASSERT_EQ(world.step(1e-3, contacts, forces).failure, StepFailure::none);
  const Wrench on_cube = wrench_on(Mover::of_body(body), contacts, forces);
  EXPECT_LT(norm(on_cube.force_W - Vector3(0, 0, 3.0 * g)), 1e-6);
  EXPECT_LT(norm(on_cube.moment_W - Vector3(0, -3.0 * g, 0)), 1e-6);
  const Wrench on_ground = wrench_on(Mover::ground(), contacts, forces);
  EXPECT_EQ(on_ground.force_W, -on_cube.force_W);
}

TEST(DynamicsWorld, RestingPointsThatGetAnotherNameKeepTheirForces) {
  const RigidBody box(box_inertia(3.0, {1, 1, 1}), "box");
  DynamicsWorld::Settings settings;
  settings.gravity_W = {0, 0, -9.81};
  DynamicsWorld world(settings);
  world.add_body(box, box.state(at({0, 0, 0.5}), kZero, kZero));
  std::vector<Contact> contacts;
  for (const Vector3& corner : {Vector3(0.5, 0.5, 0), Vector3(-0.4, 0.5, 0), Vector3(0, -0.5, 0)}) {
    const auto key = static_cast<std::uint64_t>(contacts.size() + 1);
    contacts.push_back({Mover::ground(), Mover::of_body(0), {0, 0, 1}, corner, corner, 0.5, 0.0, key});
  }
  EXPECT_GT(world.step(1e-3, contacts).sweeps, 0U);
  EXPECT_EQ(world.step(1e-3, contacts).sweeps, 0U);
  contacts[0].key = 77;
  contacts[2].key = 78;
  std::swap(contacts[0], contacts[1]);
  const StepReport renamed = world.step(1e-3, contacts);
  EXPECT_EQ(renamed.sweeps, 0U);
  EXPECT_EQ(renamed.newton_steps, 0U);
  EXPECT_LE(renamed.worst_residual, 1e-10);
}

TEST(DynamicsWorld, CommandedRatesAreCutToTheJointsOwn) {
  const Arm arm = ssrms_arm();
  const MechanismDynamics dynamics(arm.mechanism, arm.links);
  DynamicsWorld world({});
  const std::vector<double> zero(7, 0.0);
  const auto mechanism = world.add_mechanism(dynamics, {}, zero, zero);
  for (std::uint32_t i = 0; i < 7; ++i)
    world.set_drive(mechanism, i, {.mode = JointDrive::Mode::rate, .rate = i == 6 ? 1.0 : 0.0});
  ASSERT_EQ(world.step(1e-3, {}).failure, StepFailure::none);
  EXPECT_NEAR(world.joint_rates(mechanism)[6], arm.mechanism.joints()[6].rate, 1e-9);
}

TEST(DynamicsWorld, JointsStopAtTheirLimits) {
  MechanismDescription description{
      .name = "slider", .links = {{.name = "base"}, {.name = "block"}}, .joints = {}};
  JointDescription joint;
  joint.name = "rail";
  joint.kind = JointKind::prismatic;
  joint.parent = "base";
  joint.child = "block";
  joint.axis_J = Vector3::UnitX();
  joint.lower = -1.0, joint.upper = 0.25;
  description.joints.push_back(joint);
  const Mechanism mechanism(description);
  const MechanismDynamics dynamics(mechanism, std::vector<BodyInertia>{{}, box_inertia(2.0, {1, 1, 1})});
  DynamicsWorld world({});
  const auto slider = world.add_mechanism(dynamics, {}, std::array{0.0}, std::array{0.4});
  for (int step = 0; step < 1000; ++step) ASSERT_EQ(world.step(1e-3, {}).failure, StepFailure::none);
  EXPECT_NEAR(world.joint_values(slider)[0], 0.25, 2e-9);
  EXPECT_NEAR(world.joint_rates(slider)[0], 0.0, 1e-12);
}

TEST(DynamicsWorld, KinematicBodiesPushAndDoNotYield) {
  // The driven tip of scene 8: 0.02 m/s against a free 170.1 kg box, centred: v = 0.02 (1 + e).
  for (const double e : {0.0, 0.5}) {
    DynamicsWorld world({});
    const RigidBody oru(box_inertia(170.1, {1.050, 0.919, 0.525}), "ORU");
    const auto box = world.add_body(oru, oru.state({}, kZero, kZero));
    const auto tip = world.add_kinematic(at({-0.525, 0, 0}), {0.02, 0, 0}, kZero);
    const Contact contact{Mover::of_body(tip),
                          Mover::of_body(box),
                          Vector3::UnitX(),
                          {-0.525, 0, 0},
                          {-0.525, 0, 0},
                          0.0,
                          e,
                          1};
    ASSERT_EQ(world.step(1e-3, {&contact, 1}).failure, StepFailure::none);
    EXPECT_NEAR(world.velocity(box).x(), 0.02 * (1.0 + e), 1e-12);
    EXPECT_NEAR(world.pose(tip).p.x(), -0.525 + 0.02 * 1e-3, 1e-16);
    EXPECT_EQ(world.velocity(tip).x(), 0.02);
  }
}

TEST(DynamicsWorld, StepsDoNotAllocate) {
  ArmWithPayload scene;
  std::array<ContactForce, 8> forces;
  for (int step = 0; step < 50; ++step) {
    const std::array<Contact, 8> contacts = scene.rim_contacts();
    const std::size_t allocations = allocation_count();
    const StepReport report = scene.world.step(1e-3, contacts, forces);
    EXPECT_EQ(allocation_count(), allocations);
    ASSERT_EQ(report.failure, StepFailure::none);
  }
}

TEST(DynamicsWorld, AStopInOneGroupCutsNoOthersStep) {
  // A block slides on; beside it, or not, another stops and a third lands within the step.
  const RigidBody block(box_inertia(3.0, {1, 1, 1}), "block");
  const auto run = [&](bool with_others) {
    DynamicsWorld world({.gravity_W = {0, 0, -9.81}});
    world.add_body(block, block.state(at({0, 0, 0.5}), {1, 0.3, 0}, kZero));
    world.add_body(block, block.state(at({5, 0, 0.5}), {2e-3, 0, 0}, kZero));
    world.add_body(block, block.state(at({9, 0, 0.5 + 2e-5}), {0, 0, -0.05}, kZero));
    std::vector<Contact> contacts;
    for (std::uint32_t body = 0; body < (with_others ? 3U : 1U); ++body)
      for (const Vector3& corner :
           {Vector3(0.5, 0.5, -0.5), Vector3(-0.5, 0.5, -0.5), Vector3(0, -0.5, -0.5)}) {
        const Vector3 p = touchstone::transform(world.pose(body), corner);
        contacts.push_back({Mover::ground(),
                            Mover::of_body(body),
                            {0, 0, 1},
                            {p.x(), p.y(), 0},
                            p,
                            0.5,
                            0.0,
                            contacts.size() + 1});
      }
    const StepReport report = world.step(1e-3, contacts);
    EXPECT_EQ(report.failure, StepFailure::none);
    EXPECT_EQ(report.substeps > 1, with_others);
    EXPECT_EQ(std::isnan(report.last_stop), !with_others);
    return world.state(0);
  };
  const RigidBodyState alone = run(false), beside = run(true);
  EXPECT_EQ(alone.p_W, beside.p_W);
  EXPECT_EQ(alone.momentum_W, beside.momentum_W);
  EXPECT_EQ(alone.angular_W, beside.angular_W);
  EXPECT_EQ(alone.q_WB.v, beside.q_WB.v);
}

}  // namespace

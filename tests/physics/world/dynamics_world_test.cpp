#include "touchstone/physics/world/dynamics_world.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/physics/arm_with_payload.hpp"
#include "touchstone/tests/support/at.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/refusal.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

const Vector3 kZero = Vector3::Zero();

const std::vector<BodyInertia> kSliderLinks = {{}, box_inertia(2.0, {1, 1, 1})};

TEST(DynamicsWorld, BadSetUpIsRefusedByName) {
  const Arm arm = ssrms_arm();
  const MechanismDynamics dynamics(arm.mechanism, arm.links);
  const std::vector<double> zero(7, 0.0);
  DynamicsWorld world({});
  const auto mechanism = world.add_mechanism(dynamics, {}, zero, zero);
  EXPECT_THAT(refusal_of([&] { world.set_drive(mechanism, 2, {.limit = -1.0}); }),
              testing::StrEq("mechanism 'ssrms', value 2: a torque limit below 0"));
  EXPECT_THAT(refusal_of([&] { world.set_drive(7, 0, {}); }), testing::StrEq("no mechanism 7"));
  EXPECT_THAT(refusal_of([&] { world.set_drive(mechanism, 9, {}); }), testing::HasSubstr("no such joint"));
  EXPECT_THAT(refusal_of([&] { world.set_drive(mechanism, 0, {.torque = NAN}); }),
              testing::HasSubstr("not finite"));
  std::vector<double> beyond = zero;
  beyond[3] = 5.0;
  EXPECT_THAT(refusal_of([&] { world.add_mechanism(dynamics, {}, beyond, zero); }),
              testing::HasSubstr("out of limits"));
  EXPECT_THAT(refusal_of([&] { world.add_mechanism(dynamics, {}, std::array{0.0}, zero); }),
              testing::HasSubstr("1 values and 7 rates for 7 joints"));
  EXPECT_THAT(refusal_of([&] { world.set_velocity(0, kZero, kZero); }),
              testing::HasSubstr("body 0 is not kinematic"));
  DynamicsWorld::Settings settings;
  settings.contact_gap = 0.0;
  EXPECT_THROW(DynamicsWorld{settings}, InputError);
}

TEST(DynamicsWorld, BadFiguresOfBodiesAndSettingsAreRefused) {
  // Velocities and states that are no numbers are refused, and change nothing.
  DynamicsWorld world({});
  const RigidBody body(box_inertia(1.0, {1, 1, 1}), "body");
  world.add_body(body, {});
  const Vector3 bad(0, NAN, 0);
  EXPECT_THAT(refusal_of([&] { world.add_kinematic({}, bad, kZero); }),
              testing::StrEq("kinematic body 1: velocities are not finite"));
  EXPECT_THAT(refusal_of([&] { world.add_kinematic({}, kZero, bad); }), testing::HasSubstr("not finite"));
  EXPECT_EQ(world.body_count(), 1u);
  RigidBodyState state;
  state.momentum_W = bad;
  EXPECT_THAT(refusal_of([&] { world.set_state(0, state); }),
              testing::StrEq("body 0: its state is not finite"));
  EXPECT_THAT(refusal_of([&] { world.set_state(1, {}); }), testing::StrEq("no body 1"));
  EXPECT_EQ(world.state(0).momentum_W, kZero);

  // Each figure out of its range is refused by its name.
  using Settings = DynamicsWorld::Settings;
  const auto error_with = [](const auto& spoil) {
    Settings settings;
    spoil(settings);
    return refusal_of([&] { DynamicsWorld{settings}; });
  };
  EXPECT_EQ(error_with([](Settings&) {}), "accepted");
  for (const double value : {-1.0, static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    const auto gap =
        "dynamics: the contact gap must be > 0, bounce speed, push-out and part speed >= 0, all finite";
    EXPECT_EQ(error_with([&](Settings& settings) { settings.contact_gap = value; }), gap);
    EXPECT_EQ(error_with([&](Settings& settings) { settings.bounce_speed = value; }), gap);
    EXPECT_EQ(error_with([&](Settings& settings) { settings.push_out = value; }), gap);
    EXPECT_THAT(error_with([&](Settings& settings) { settings.solver.tolerance = value; }),
                testing::HasSubstr("the solver's tolerance"));
  }
  EXPECT_THAT(error_with([](Settings& settings) { settings.solver.rounds = 0; }),
              testing::HasSubstr("at least one round"));
  EXPECT_THAT(error_with([](Settings& settings) { settings.solver.sweeps = -1; }),
              testing::HasSubstr("sweeps"));
  EXPECT_THAT(error_with([](Settings& settings) { settings.solver.newton_steps = -1; }),
              testing::HasSubstr("Newton steps"));
  EXPECT_THAT(error_with([](Settings& settings) { settings.work = -1.0; }),
              testing::HasSubstr("work and time"));
}

/// A calm body and another far off, in gravity.
struct TwoBodies {
  static constexpr std::uint32_t kCalm = 0, kOther = 1;
  RigidBody body{box_inertia(1.0, {1, 1, 1}), "body"};
  DynamicsWorld world{{.gravity_W = {0, 0, -9.81}}};

  explicit TwoBodies(const Vector3& v_W, const Vector3& w_W = kZero) {
    world.add_body(body, body.state({}, kZero, kZero));
    world.add_body(body, body.state(at({5, 0, 0}), v_W, w_W));
  }
  void expect_failure(StepFailure failure, std::uint32_t index, std::span<const Contact> contacts,
                      double h = 1e-3) {
    const RigidBodyState before = world.state(kCalm);
    const StepReport report = world.step(h, contacts);
    EXPECT_EQ(to_string(report.failure), to_string(failure));
    EXPECT_EQ(report.failed_index, index);
    EXPECT_EQ(world.state(kCalm).p_W, before.p_W);
    EXPECT_EQ(world.state(kCalm).momentum_W, before.momentum_W);
  }
};

TEST(DynamicsWorld, WhatIsNotFiniteKeepsTheLastGoodStateAndNamesTheCause) {
  TwoBodies fast({0, 0, 1e308});  // 1e305 m on it still is somewhere; 1e5 s on it is nowhere
  fast.expect_failure(StepFailure::body, TwoBodies::kOther, {}, 1e5);
  // The moment of any force so far out is infinite: loose from all else, and in a pair that is fine.
  TwoBodies far(kZero);
  std::array<Contact, 2> contacts;
  const Vector3 near(0, 0, -0.5), out(1e200, 0, -0.5);
  contacts[0] = {Mover::ground(), Mover::of_body(0), Vector3::UnitZ(), near, near, 0.5, 0.0, 1};
  contacts[1] = {Mover::ground(), Mover::of_body(1), Vector3::UnitZ(), out, out, 0.5, 0.0, 2};
  far.expect_failure(StepFailure::body, TwoBodies::kOther, contacts);
  EXPECT_EQ(reason_of(StepFailure::body), "its state would not be finite");
}

TEST(DynamicsWorld, ABodyThatWouldTurnTooFarIsNamedForThat) {
  TwoBodies scene({1, 0, 0}, {0, 0, 1e6});
  scene.expect_failure(StepFailure::turn, TwoBodies::kOther, {});
  Contact near{Mover::ground(), Mover::of_body(1), Vector3::UnitZ(), kZero, kZero, 0.5, 0.0, 1};
  scene.expect_failure(StepFailure::turn, TwoBodies::kOther, {&near, 1});
  // So is one that a moment would turn so far in its own step.
  for (const std::span<const Contact> contacts : {std::span<const Contact>(), {&near, 1}}) {
    TwoBodies pushed(kZero);
    pushed.world.push(Mover::of_body(TwoBodies::kOther), kZero, kZero, {0, 0, 1e12});
    pushed.expect_failure(StepFailure::turn, TwoBodies::kOther, contacts);
  }
}

TEST(DynamicsWorld, AMechanismThatWouldNotBeFiniteIsNamed) {
  const Mechanism mechanism = rail(Vector3::UnitX());
  const MechanismDynamics dynamics(mechanism, kSliderLinks);
  TwoBodies scene(kZero);
  DynamicsWorld& world = scene.world;
  world.add_mechanism(dynamics, {}, std::array{0.0}, std::array{0.0});
  const auto driven = world.add_mechanism(dynamics, at({0, 9, 0}), std::array{0.5}, std::array{0.25});
  ASSERT_EQ(world.step(1e-3, {}).failure, StepFailure::none);
  const double q = world.joint_values(driven)[0];
  world.set_drive(driven, 0, {.mode = JointDrive::Mode::torque, .torque = 1e308});
  scene.expect_failure(StepFailure::mechanism, driven, {}, 1e3);  // 5e310 m/s
  EXPECT_EQ(world.joint_values(driven)[0], q);
  EXPECT_EQ(world.joint_rates(driven)[0], 0.25);
  EXPECT_EQ(world.link_pose(driven, 1).p.x(), q);
}

TEST(DynamicsWorld, BadContactsAndStepsAreRefusedByName) {
  TwoBodies scene(kZero);
  const Contact good{Mover::ground(), Mover::of_body(0), Vector3::UnitZ(), kZero, kZero, 0.5, 0.0, 0};
  std::array<Contact, 2> contacts = {good, good};
  const auto expect_bad = [&](const auto& spoil) {
    contacts[1] = good;
    spoil(contacts[1]);
    scene.expect_failure(StepFailure::bad_contact, 1, contacts);
  };
  expect_bad([](Contact& contact) { contact.b = Mover::of_body(7); });
  expect_bad([](Contact& contact) { contact.a = Mover::of_link(0, 0); });
  expect_bad([](Contact& contact) { contact.n_AB_W = {0, 0, 2}; });
  expect_bad([](Contact& contact) { contact.n_AB_W.x() = NAN; });
  expect_bad([](Contact& contact) { contact.p_A_W.y() = NAN; });
  expect_bad([](Contact& contact) { contact.p_B_W.y() = INFINITY; });
  expect_bad([](Contact& contact) { contact.radius_A = -0.1; });
  expect_bad([](Contact& contact) { contact.radius_B = INFINITY; });
  expect_bad([](Contact& contact) { contact.friction = NAN; });
  expect_bad([](Contact& contact) { contact.friction = -0.1; });
  expect_bad([](Contact& contact) { contact.restitution = 1.5; });
  contacts[1] = good;
  for (const double h : {0.0, -1e-3, static_cast<double>(NAN), static_cast<double>(INFINITY)})
    scene.expect_failure(StepFailure::bad_step, 0, contacts, h);
  EXPECT_EQ(scene.world.step(1e-3, contacts).failure, StepFailure::none);
}

/// A resting box, a sliding one, an arm that brakes and one in a joint stop's way; and a body that spins too
/// fast whenever asked to.
struct Undone {
  Mechanism mechanism = rail(Vector3::UnitZ());
  MechanismDynamics dynamics{mechanism, kSliderLinks};
  RigidBody body{box_inertia(3.0, {1, 1, 1}), "body"};
  DynamicsWorld world{{.gravity_W = {0, 0, -9.81}}};
  std::array<ContactForce, 6> forces;

  Undone() {
    world.add_body(body, body.state(at({0, 0, 0.5}), kZero, kZero));
    world.add_body(body, body.state(at({5, 0, 0.5}), {0.05, 0.01, 0}, kZero));
    world.add_body(body, body.state(at({9, 0, 0}), kZero, kZero));
    world.add_mechanism(dynamics, {}, std::array{0.0}, std::array{0.02});
    world.set_drive(0, 0, {.mode = JointDrive::Mode::brake, .limit = 50.0});
  }
  std::vector<Contact> contacts() const {
    std::vector<Contact> out;
    for (std::uint32_t i = 0; i < 2; ++i)
      for (const Vector3& corner :
           {Vector3(0.5, 0.5, -0.5), Vector3(-0.5, 0.5, -0.5), Vector3(0, -0.5, -0.5)}) {
        const Vector3 p = touchstone::transform(world.pose(i), corner);
        out.push_back(
            {Mover::ground(), Mover::of_body(i), {0, 0, 1}, {p.x(), p.y(), 0}, p, 0.5, 0.0, out.size() + 1});
      }
    return out;
  }
  StepReport step() { return world.step(1e-3, contacts(), forces); }
  /// A step that fails when all else is through: the loose body goes last.
  void fail() {
    const RigidBodyState calm = world.state(2);
    RigidBodyState spinning = calm;
    spinning.angular_W = {0, 0, 1e9};
    world.set_state(2, spinning);
    ASSERT_EQ(step().failure, StepFailure::turn);
    world.set_state(2, calm);
  }
};

TEST(DynamicsWorld, AFailedStepLeavesNoTrace) {
  Undone once, again;
  for (int i = 0; i < 60; ++i) {
    // A step that fails: torques and forces stay as they were.
    const double torque = again.world.joint_torques(0)[0];
    const std::array<ContactForce, 6> forces = again.forces;
    again.fail();
    EXPECT_EQ(again.world.joint_torques(0)[0], torque);
    for (std::size_t c = 0; i > 0 && c < forces.size(); ++c)
      EXPECT_EQ(again.forces[c].force_W, forces[c].force_W);
    // The next step is that of a world in which none failed.
    const StepReport a = once.step(), b = again.step();
    ASSERT_EQ(a.failure, StepFailure::none);
    ASSERT_EQ(b.failure, StepFailure::none);
    EXPECT_EQ(a.sweeps, b.sweeps) << i;
    EXPECT_EQ(a.newton_steps, b.newton_steps) << i;
    EXPECT_EQ(a.worst_residual, b.worst_residual) << i;
    for (std::uint32_t body = 0; body < 2; ++body) {
      EXPECT_EQ(once.world.state(body).p_W, again.world.state(body).p_W);
      EXPECT_EQ(once.world.state(body).momentum_W, again.world.state(body).momentum_W);
      EXPECT_EQ(once.world.state(body).angular_W, again.world.state(body).angular_W);
    }
    EXPECT_EQ(once.world.joint_values(0)[0], again.world.joint_values(0)[0]);
    EXPECT_EQ(once.world.joint_torques(0)[0], again.world.joint_torques(0)[0]);
    for (std::size_t c = 0; c < forces.size(); ++c)
      EXPECT_EQ(once.forces[c].force_W, again.forces[c].force_W);
  }
}

TEST(DynamicsWorld, ABrakedJointThatSomethingElseBringsToRestAtTheEndStopsInTime) {
  // Upwards at g h: gravity alone would stop it at the step's end, and what the brake gives and holds against
  // is 0 in all. With a brake of 100 N it stops after v / (g + 100 / m), and is held there.
  const double g = 9.81, h = 1e-3, v = 0.00981, brake = 100.0;
  const Mechanism mechanism = rail(Vector3::UnitZ());
  const MechanismDynamics dynamics(mechanism, kSliderLinks);
  DynamicsWorld world({.gravity_W = {0, 0, -g}});
  const auto cart = world.add_mechanism(dynamics, {}, std::array{0.0}, std::array{v});
  world.set_drive(cart, 0, {.mode = JointDrive::Mode::brake, .limit = brake});
  const RigidBody body(box_inertia(1.0, {1, 1, 1}), "elsewhere");
  world.add_body(body, body.state(at({50, 0, 0}), kZero, kZero));
  const double stop = v / (g + brake / 2.0);
  StepReport report = world.step(h, {});
  ASSERT_EQ(report.failure, StepFailure::none);
  EXPECT_NEAR(report.last_stop, stop, 1e-12);
  EXPECT_NEAR(world.joint_values(cart)[0], 0.5 * v * stop, 1e-15);
  for (int step = 1; step < 5; ++step) {
    report = world.step(h, {});
    ASSERT_EQ(report.failure, StepFailure::none) << step;
    EXPECT_LE(report.worst_residual, 1e-10);
    EXPECT_NEAR(world.joint_rates(cart)[0], 0.0, 1e-10);
    EXPECT_NEAR(world.joint_torques(cart)[0], 2.0 * g, 1e-6);
  }
  EXPECT_NEAR(world.joint_values(cart)[0], 0.5 * v * stop, 1e-12);
}

TEST(DynamicsWorld, ASlidingPointThatSomethingElseBringsToRestAtTheEndKeepsAGoodState) {
  // All figures are powers of two: without friction it comes to rest exactly at the step's end.
  const double h = 0x1p-10;
  DynamicsWorld world({.gravity_W = {-1, 0, -8}});
  const RigidBody box(box_inertia(1.0, {1, 1, 1}), "box");
  world.add_body(box, box.state({}, {h, 0, 0}, kZero));
  for (int step = 0; step < 3; ++step) {
    const Vector3 p = world.state(0).p_W;  // so that nothing turns it
    const Contact contact{Mover::ground(), Mover::of_body(0), Vector3::UnitZ(), p, p, 0.5, 0.0, 1};
    const StepReport report = world.step(h, {&contact, 1});
    ASSERT_EQ(report.failure, StepFailure::none) << step;
    EXPECT_LE(report.worst_residual, 1e-10);
    EXPECT_LT(norm(world.velocity(0)), 1e-10);
  }
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
  const Mechanism mechanism = rail(Vector3::UnitX(), -1.0, 0.25);
  const MechanismDynamics dynamics(mechanism, kSliderLinks);
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

// Joints between movers of a world: with drives, contacts, arms, and mid-run.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/resolved_rate.hpp"
#include "touchstone/physics/bodies/latch.hpp"
#include "touchstone/tests/physics/arms.hpp"
#include "touchstone/tests/physics/cubes.hpp"
#include "touchstone/tests/support/at.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone::physics {
namespace {

constexpr double kPi = 3.141592653589793;
const Vector3 kZero = Vector3::Zero();

/// z of the frame along y of the world.
Matrix3 about_y() { return rotation_about(Vector3(Vector3::UnitX()), -0.5 * kPi); }

DynamicsWorld world_in(const Vector3& gravity) {
  DynamicsWorld::Settings settings;
  settings.gravity_W = gravity;
  return DynamicsWorld(settings);
}

std::uint32_t add_box(DynamicsWorld& world, double mass, const Vector3& size, const Pose& X,
                      const Vector3& v = kZero, const Vector3& w = kZero) {
  const RigidBody body(box_inertia(mass, size), "box");
  return world.add_body(body, body.state(X, v, w));
}

Pose pose_of(const DynamicsWorld& world, const Mover& mover) {
  if (mover.kind == Mover::Kind::ground) return {};
  return mover.kind == Mover::Kind::body ? world.pose(mover.index) : world.link_pose(mover.index, mover.link);
}

/// As all stands, at a frame of the world.
WorldJoint joint_at(const DynamicsWorld& world, BodyJointKind kind, const Mover& a, const Mover& b,
                    const Pose& X_WJ) {
  WorldJoint out;
  out.a = a, out.b = b;
  out.joint = {kind, compose(inverse(pose_of(world, a)), X_WJ), compose(inverse(pose_of(world, b)), X_WJ)};
  return out;
}

StepReport run(DynamicsWorld& world, int steps, double h = 1e-3) {
  StepReport last;
  for (int i = 0; i < steps; ++i) {
    last = world.step(h, {});
    EXPECT_EQ(last.failure, StepFailure::none) << i;
    EXPECT_EQ(last.unconverged, 0u) << i;
    if (last.failure != StepFailure::none || last.unconverged > 0) break;
  }
  return last;
}

TEST(WorldJoints, ADoublePendulumOfBodiesSwingsBesideTheArmOfTheSameLinks) {
  // Two bodies on hinges.
  DynamicsWorld world = world_in({0, 0, -9.81});
  const auto a = add_box(world, 2, {1, 0.1, 0.1}, at({0.5, 0, 0}));
  const auto b = add_box(world, 1, {0.8, 0.1, 0.1}, at({1.4, 0, 0}));
  world.add_joint(joint_at(world, BodyJointKind::hinge, {}, Mover::of_body(a), at(kZero, about_y())));
  const auto elbow = world.add_joint(
      joint_at(world, BodyJointKind::hinge, Mover::of_body(a), Mover::of_body(b), at({1, 0, 0}, about_y())));
  // The same as a mechanism of two links.
  MechanismDescription description = planar_arm(std::vector<double>{1.0, 0.8});
  for (JointDescription& joint : description.joints) joint.axis_J = Vector3::UnitY();
  const Mechanism arm(description);
  std::vector<BodyInertia> links(3);
  links[1] = transform(at({0.5, 0, 0}), box_inertia(2, {1, 0.1, 0.1}));
  links[2] = transform(at({0.4, 0, 0}), box_inertia(1, {0.8, 0.1, 0.1}));
  const MechanismDynamics dynamics(arm, links);
  const auto mechanism =
      world.add_mechanism(dynamics, {}, std::vector<double>{0, 0}, std::vector<double>{0, 0});
  // Tips stay together, and so do values and rates.
  double worst = 0.0;
  for (int i = 0; i < 1000; ++i) {
    run(world, 1);
    const Vector3 tip = transform(world.link_pose(mechanism, 2), Vector3(0.4, 0, 0));
    worst = std::max(worst, norm(tip - world.state(b).p_W));
  }
  const WorldJointState state = world.joint_state(elbow);
  std::printf("way between the two %.2g m, joint error %.2g\n", worst, state.error);
  EXPECT_LT(worst, 1e-9);
  EXPECT_NEAR(state.value, world.joint_values(mechanism)[1], 1e-9);
  EXPECT_NEAR(state.rate, world.joint_rates(mechanism)[1], 1e-9);
}

TEST(WorldJoints, AHingeHasDrivesLossesAndEndsAsAMechanismsJoint) {
  // A wheel on a hinge beside one on an axle, through one life.
  MechanismDescription description{
      .name = "wheel", .links = {{.name = "base"}, {.name = "rim", .solids = {}}}, .joints = {}};
  JointDescription axle;
  axle.name = "axle", axle.kind = JointKind::revolute, axle.parent = "base", axle.child = "rim";
  axle.lower = -1.0, axle.upper = 20.0;
  description.joints.push_back(axle);
  const Mechanism mechanism(description);
  const BodyInertia inertia{2.0, kZero, Vector3(0.3, 0.3, 0.5).asDiagonal()};
  const MechanismDynamics dynamics(mechanism, std::vector<BodyInertia>{{}, inertia});
  DynamicsWorld world = world_in(kZero);
  world.add_mechanism(dynamics, {}, std::vector<double>{0}, std::vector<double>{1.5});
  const RigidBody rim(inertia, "rim");
  const auto body = world.add_body(rim, rim.state(at({3, 0, 0}), kZero, {0, 0, 1.5}));
  WorldJoint joint = joint_at(world, BodyJointKind::hinge, {}, Mover::of_body(body), at({3, 0, 0}));
  joint.lower = -1.0, joint.upper = 20.0;
  joint.losses = {0.2, 0.1};
  const auto hinge = world.add_joint(joint);
  world.set_losses(0, 0, {0.2, 0.1});
  using Mode = JointDrive::Mode;
  const std::vector<JointDrive> life{
      {},
      {Mode::torque, 3.0},
      {Mode::rate, 0.0, 9.0, 4.0},
      {Mode::brake, 0.0, 0.0, 1.0},
      {Mode::rate, 0.0, 40.0, 10.0},                        // into the upper end
      {Mode::position, 0.0, 0.0, 500.0, -2.0, 50.0, 3.0}};  // and the lower one
  for (const JointDrive& drive : life) {
    world.set_drive(0, 0, drive);
    world.set_joint_drive(hinge, drive);
    for (int i = 0; i < 1000; ++i) {
      run(world, 1);
      const WorldJointState state = world.joint_state(hinge);
      ASSERT_NEAR(state.value, world.joint_values(0)[0], 2e-8) << i;
      ASSERT_NEAR(state.rate, world.joint_rates(0)[0], 2e-8) << i;
      ASSERT_NEAR(state.torque, world.joint_torques(0)[0], 1e-4) << i;
    }
  }
  EXPECT_NEAR(world.joint_state(hinge).value, -1.0, 1e-8);
}

TEST(WorldJoints, ASliderMovesALoadByItsForceAgainstItsLosses) {
  DynamicsWorld world = world_in({0, 0, -10});
  const auto load = add_box(world, 4, {0.2, 0.2, 0.2}, at({0, 0, 1}));
  WorldJoint joint = joint_at(world, BodyJointKind::slider, {}, Mover::of_body(load), at({0, 0, 1}));
  joint.drive.torque = 50.0;
  joint.losses.friction = 2.0;
  const auto slider = world.add_joint(joint);
  run(world, 1000);
  const WorldJointState state = world.joint_state(slider);
  EXPECT_NEAR(state.rate, (50.0 - 40.0 - 2.0) / 4.0, 1e-10);
  EXPECT_NEAR(state.value, 1.0, 1e-9);
  EXPECT_NEAR(world.pose(load).p.z(), 2.0, 1e-9);
  EXPECT_NEAR(state.torque, 50.0, 1e-12);
}

TEST(WorldJoints, AFourBarLinkageStaysClosedAndKeepsItsEnergy) {
  // Crank, coupler and rocker, on hinges.
  DynamicsWorld world = world_in({0, 0, -9.81});
  const auto crank = add_box(world, 1, {0.05, 0.05, 0.3}, at({0, 0, 0.15}));
  const auto coupler = add_box(world, 2, {0.8, 0.05, 0.05}, at({0.4, 0, 0.3}));
  const Matrix3 R = rotation_about(Vector3(Vector3::UnitY()), -std::atan2(0.2, 0.3));
  const auto rocker = add_box(world, 1.5, {0.05, 0.05, std::hypot(0.2, 0.3)}, at({0.9, 0, 0.15}, R));
  const Mover one = Mover::of_body(crank), two = Mover::of_body(coupler), three = Mover::of_body(rocker);
  world.add_joint(joint_at(world, BodyJointKind::hinge, {}, one, at(kZero, about_y())));
  world.add_joint(joint_at(world, BodyJointKind::hinge, one, two, at({0, 0, 0.3}, about_y())));
  world.add_joint(joint_at(world, BodyJointKind::hinge, two, three, at({0.8, 0, 0.3}, about_y())));
  const auto last =
      world.add_joint(joint_at(world, BodyJointKind::hinge, {}, three, at({1.0, 0, 0}, about_y())));
  // Swings without allocating.
  world.reserve(4);
  const double energy = world.energy();
  run(world, 2);
  const std::uint64_t before = allocation_count();
  double worst = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const StepReport report = run(world, 1);
    worst = std::max({worst, report.worst_joint_error, world.joint_state(last).error});
  }
  EXPECT_EQ(allocation_count() - before, 0u);
  std::printf("closure %.2g m, energy %.2g J\n", worst, world.energy() - energy);
  EXPECT_LT(worst, 1e-12);
  EXPECT_NEAR(world.energy(), energy, 1e-8);
}

/// An arm in space: a hub and three links on hinges of different axes, driven.
struct FreeArm {
  DynamicsWorld world = world_in(kZero);
  std::vector<std::uint32_t> bodies, joints;

  FreeArm() {
    bodies.push_back(add_box(world, 50, {1, 1, 1}, at(kZero)));
    const Matrix3 frames[] = {Matrix3::Identity(), about_y(), about_y()};
    for (int i = 0; i < 3; ++i) {
      bodies.push_back(add_box(world, 5, {1, 0.1, 0.1}, at({1.0 + i, 0, 0})));
      WorldJoint joint =
          joint_at(world, BodyJointKind::hinge, Mover::of_body(bodies[static_cast<std::size_t>(i)]),
                   Mover::of_body(bodies.back()), at({0.5 + i, 0, 0}, frames[i]));
      joint.drive = {JointDrive::Mode::rate, 0.0, 0.2 * (i + 1), 10.0};
      joints.push_back(world.add_joint(joint));
    }
  }
};

TEST(WorldJoints, AnArmWithAFreeBaseKeepsItsMomentaWhileDrivesMoveIt) {
  FreeArm arm;
  double worst = 0.0;
  for (int i = 0; i < 3000; ++i) {
    run(arm.world, 1);
    worst = std::max({worst, norm(arm.world.linear_momentum()), norm(arm.world.angular_momentum())});
  }
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(arm.world.joint_state(arm.joints[k]).rate, 0.2 * static_cast<double>(k + 1), 1e-9);
    EXPECT_LT(arm.world.joint_state(arm.joints[k]).error, 1e-12);
  }
  std::printf("momenta %.2g\n", worst);
  EXPECT_LT(worst, 1e-11);
  EXPECT_GT(norm(arm.world.pose(arm.bodies[0]).p), 1e-2);  // the hub gives way
}

TEST(WorldJoints, AnArmWalksOffByChangingEndsWithoutAJump) {
  FreeArm arm;
  DynamicsWorld& world = arm.world;
  const auto base =
      world.add_joint(joint_at(world, BodyJointKind::fixed, {}, Mover::of_body(arm.bodies[0]), at(kZero)));
  WorldJoint held_tip =
      joint_at(world, BodyJointKind::fixed, {}, Mover::of_body(arm.bodies[3]), at({3.5, 0, 0}));
  held_tip.is_on = false;
  const auto tip = world.add_joint(held_tip);
  run(world, 500);
  for (const auto joint : arm.joints) world.set_joint_drive(joint, {JointDrive::Mode::brake, 0, 0, 50});
  run(world, 1000);
  const auto speed = [&] {
    double sum = 0.0;
    for (const auto body : arm.bodies) sum += norm(world.velocity(body)) + norm(world.angular_velocity(body));
    return sum;
  };
  EXPECT_LT(speed(), 1e-9);
  std::vector<Pose> before;
  for (const auto body : arm.bodies) before.push_back(world.pose(body));
  const auto farthest = [&] {
    double worst = 0.0;
    for (std::size_t i = 0; i < before.size(); ++i)
      worst = std::max(worst, norm(world.pose(arm.bodies[i]).p - before[i].p));
    return worst;
  };
  world.join_as_they_stand(tip);
  run(world, 100);  // both ends held: brakes and joints repeat six equations
  EXPECT_LT(farthest(), 1e-9);
  world.switch_joint(base, false);
  run(world, 100);
  EXPECT_LT(farthest(), 1e-9);
  EXPECT_LT(speed(), 1e-8);
  // On it goes about its other end.
  for (const auto joint : arm.joints) world.set_joint_drive(joint, {JointDrive::Mode::rate, 0, 0.1, 50});
  run(world, 500);
  EXPECT_GT(norm(world.pose(arm.bodies[0]).p - before[0].p), 0.05);
  EXPECT_LT(norm(world.pose(arm.bodies[3]).p - before[3].p), 1e-9);
  EXPECT_LT(world.joint_state(tip).error, 1e-12);
}

TEST(WorldJoints, TwoArmsCarryOnePayloadAndTheirForcesSumToItsWeight) {
  // Planar arms with brakes, their tips at +-1 m, a payload between them.
  const Arm arms[] = {{Mechanism(planar_arm(std::vector<double>{1.0, 1.0}, "left")), {}},
                      {Mechanism(planar_arm(std::vector<double>{1.0, 1.0}, "right")), {}}};
  const std::vector<BodyInertia> links{{},
                                       transform(at({0.5, 0, 0}), box_inertia(5, {1, 0.1, 0.1})),
                                       transform(at({0.5, 0, 0}), box_inertia(5, {1, 0.1, 0.1}))};
  const MechanismDynamics left(arms[0].mechanism, links), right(arms[1].mechanism, links);
  DynamicsWorld world = world_in({0, -9.81, 0});  // across the hinges' axes
  const std::vector<double> zero{0, 0};
  // Elbows up: each tip 1 m inwards of its base.
  const double q = std::acos(0.5);
  const auto l = world.add_mechanism(left, at({-2, 0, 0}), std::vector<double>{q, -2 * q}, zero);
  const auto r = world.add_mechanism(right, at({2, 0, 0}), std::vector<double>{kPi - q, 2 * q}, zero);
  for (const auto m : {l, r})
    for (const std::uint32_t i : {0U, 1U}) world.set_drive(m, i, {JointDrive::Mode::brake, 0, 0, 1e4});
  const auto payload = add_box(world, 40, {2, 0.2, 0.2}, at(kZero));
  const auto held_l = world.add_joint(
      joint_at(world, BodyJointKind::fixed, Mover::of_link(l, 2), Mover::of_body(payload), at({-1, 0, 0})));
  const auto held_r = world.add_joint(
      joint_at(world, BodyJointKind::fixed, Mover::of_link(r, 2), Mover::of_body(payload), at({1, 0, 0})));
  run(world, 500);
  const Vector3 f_l = world.joint_state(held_l).force_W, f_r = world.joint_state(held_r).force_W;
  std::printf("left %.6f, right %.6f N, squeeze %.3g N\n", f_l.y(), f_r.y(), f_l.x());
  EXPECT_NEAR(f_l.y() + f_r.y(), 40 * 9.81, 1e-6);
  EXPECT_NEAR(f_l.x() + f_r.x(), 0.0, 1e-6);
  EXPECT_NEAR(f_l.y(), f_r.y(), 1e-3);  // of all answers, one that shares evenly
  EXPECT_LT(norm(world.pose(payload).p), 1e-8);
  // The brakes let go on one side, whose arm then hangs on the payload.
  for (const std::uint32_t i : {0U, 1U}) world.set_drive(r, i, {});
  run(world, 300);
  EXPECT_LT(norm(world.pose(payload).p), 1e-8);
  EXPECT_NEAR(world.joint_state(held_l).force_W.y() + world.joint_state(held_r).force_W.y(), 40 * 9.81, 1e-6);
}

/// Two arms of seven joints that hold one payload and follow rates which no motion of the loop has: torques
/// fight up to their limits. Rates that a solve left off by 1e-7 m/s were sought anew as stops, and what
/// joints missed by as little as impacts: two to five pieces and up to eleven solves in every step.
TEST(WorldJoints, DrivesThatFightOnAClosedLoopAreSolvedOnceAStep) {
  const Arm arm = ssrms_arm();
  const MechanismDynamics left(arm.mechanism, arm.links), right(arm.mechanism, arm.links);
  DynamicsWorld world = world_in(kZero);
  const std::vector<double> q{0.2, 0.4, -1.2, 1.9, -0.6, 0.3, 0.3}, zero(7, 0.0);
  const std::uint32_t tip = arm.mechanism.find_link("tip_lee");
  const auto l = world.add_mechanism(left, {}, q, zero);
  // The other stands turned by half a turn about an axis at the first's tip.
  Pose X_turn;
  X_turn.R = rotation_about(Vector3(Vector3::UnitZ()), kPi);
  const Vector3 tip_W = world.link_pose(l, tip).p;
  X_turn.p = 2.0 * Vector3(tip_W.x() + 1.0, tip_W.y(), 0.0);
  const auto r = world.add_mechanism(right, X_turn, q, zero);
  const auto payload = add_box(world, 400, {2, 0.5, 0.5}, at(tip_W + Vector3(1, 0, 0)));
  for (const auto m : {l, r})
    world.add_joint(joint_at(world, BodyJointKind::fixed, Mover::of_link(m, tip), Mover::of_body(payload),
                             world.link_pose(m, tip)));
  // Both hands ask for one motion of the payload.
  ResolvedRate control(arm.mechanism, tip);
  std::vector<Pose> X_WL(arm.mechanism.links().size());
  std::vector<double> rates(7);
  const auto follow = [&](std::uint32_t m, const Pose& X_WBase) {
    arm.mechanism.link_poses(X_WBase, world.joint_values(m), X_WL);
    control.solve(X_WL, X_WL[tip].p, {{0, 0, -0.02}, kZero}, rates);
    for (std::uint32_t i = 0; i < 7; ++i) world.set_drive(m, i, {JointDrive::Mode::rate, 0, rates[i], 2332});
  };
  std::uint32_t solves = 0, pieces = 0;
  for (int i = 0; i < 600; ++i) {
    follow(l, {}), follow(r, X_turn);
    const StepReport step = run(world, 1);
    if (i >= 400) solves += step.solves, pieces += step.substeps;
  }
  std::printf("%u solves, %u pieces\n", solves, pieces);
  EXPECT_LE(solves, 250u);  // of 200 steps
  EXPECT_LE(pieces, 250u);
}

TEST(WorldJoints, AJointThatCatchesIsAnInelasticCapture) {
  const Vector3 size(0.5, 0.4, 0.3);
  DynamicsWorld world = world_in(kZero);
  const RigidBody a(box_inertia(5, size), "a"), b(box_inertia(3, size), "b");
  const RigidBodyState sa = a.state(at(kZero), {0.1, 0, 0}, {0, 0, 0.5}),
                       sb = b.state(at({1, 0.2, 0}), {-0.2, 0.1, 0.1}, {0.3, 0, 0});
  world.add_body(a, sa);
  world.add_body(b, sb);
  const LatchedBodies both = latch(a, sa, b, sb, "both");
  WorldJoint joint;
  joint.a = Mover::of_body(0), joint.b = Mover::of_body(1);
  const auto weld = world.add_joint(joint);
  world.join_as_they_stand(weld);
  const Vector3 P = world.linear_momentum(), L = world.angular_momentum();
  run(world, 1);
  EXPECT_NEAR(norm(world.angular_velocity(0) - both.body.angular_velocity(both.state)), 0.0, 1e-3);
  EXPECT_NEAR(world.energy(), both.body.kinetic_energy(both.state), 1e-9);
  run(world, 1000);
  EXPECT_LT(norm(world.linear_momentum() - P), 1e-13);
  EXPECT_LT(norm(world.angular_momentum() - L), 1e-12);
  EXPECT_LT(norm(world.angular_velocity(0) - world.angular_velocity(1)), 1e-9);
  EXPECT_LT(world.joint_state(weld).error, 1e-12);
}

TEST(WorldJoints, MassRatiosOf1e4HangAndSwing) {
  for (const auto& [link, load] : {std::pair(0.01, 100.0), std::pair(100.0, 0.01)}) {
    DynamicsWorld world = world_in({0, 0, -9.81});
    const auto rod = add_box(world, link, {0.05, 0.05, 1}, at({0, 0, -0.5}));
    const auto ball = add_box(world, load, {0.3, 0.3, 0.3}, at({0, 0, -1.0}), {0.5, 0, 0}, {0, -0.5, 0});
    world.set_state(rod, world.body(rod).state(at({0, 0, -0.5}), {0.25, 0, 0}, {0, -0.5, 0}));
    const auto top =
        world.add_joint(joint_at(world, BodyJointKind::ball, {}, Mover::of_body(rod), at(kZero)));
    const auto low = world.add_joint(
        joint_at(world, BodyJointKind::fixed, Mover::of_body(rod), Mover::of_body(ball), at({0, 0, -1})));
    const double energy = world.energy();
    double worst = 0.0;
    for (int i = 0; i < 2000; ++i) worst = std::max(worst, run(world, 1).worst_joint_error);
    std::printf("link %g kg, load %g kg: error %.2g m, energy %.2g of %.3g J\n", link, load, worst,
                world.energy() - energy, energy);
    EXPECT_LT(worst, 1e-11);
    EXPECT_LE(world.energy(), energy + 1e-6 * std::abs(energy));
    EXPECT_NEAR(world.joint_state(top).force_W.z(), (link + load) * 9.81, 0.1 * (link + load) * 9.81);
    EXPECT_LT(world.joint_state(low).error, 1e-11);
  }
}

TEST(WorldJoints, JointsThatContradictEachOtherShareTheErrorAndSayIt) {
  DynamicsWorld world = world_in({0, 0, -9.81});
  const auto door = add_box(world, 10, {1, 0.05, 2}, at({0.5, 0, 0}));
  WorldJoint hinge = joint_at(world, BodyJointKind::hinge, {}, Mover::of_body(door), at({0, 0, 0.5}));
  world.add_joint(hinge);
  hinge = joint_at(world, BodyJointKind::hinge, {}, Mover::of_body(door), at({0, 0, -0.5}));
  hinge.joint.X_AJ.p += Vector3(0, 0, -0.02);  // 2 cm off
  world.add_joint(hinge);
  StepReport report;
  for (int i = 0; i < 500; ++i) report = run(world, 1);
  EXPECT_NEAR(report.worst_joint_error, 0.01, 1e-6);
  EXPECT_NEAR(world.pose(door).p.z(), -0.01, 1e-6);
  EXPECT_LT(norm(world.velocity(door)), 1e-6);
  const double z = world.joint_state(0).force_W.z() + world.joint_state(1).force_W.z();
  EXPECT_NEAR(z, 98.1, 1e-3);
}

TEST(WorldJoints, FramesThatStandApartComeTogetherWithoutMomentum) {
  DynamicsWorld world = world_in(kZero);
  const auto a = add_box(world, 1, {0.2, 0.2, 0.2}, at(kZero)),
             b = add_box(world, 3, {0.2, 0.2, 0.2}, at({1, 0, 0}));
  WorldJoint joint;
  joint.a = Mover::of_body(a), joint.b = Mover::of_body(b);
  joint.joint.X_AJ = at({0.9, 0.02, 0});  // B is 10.2 cm from there
  world.add_joint(joint);
  StepReport report = run(world, 1000);
  EXPECT_GT(report.worst_joint_error, 0.049);  // 5 cm/s of 10 cm
  report = run(world, 3000);
  EXPECT_LT(report.worst_joint_error, 1e-12);
  EXPECT_LT(norm(world.linear_momentum()), 1e-14);
  EXPECT_NEAR(world.energy(), 0.0, 1e-14);
  EXPECT_NEAR(0.25 * (world.pose(a).p.x() + 3 * world.pose(b).p.x()), 0.75, 1e-12);
}

/// Cubes that hinges join to a chain, dropped on the ground.
struct Chain : Cubes {
  std::vector<std::uint32_t> cubes, joints;

  explicit Chain(std::size_t count, double height = 0.3) {
    add_ground();
    for (std::size_t i = 0; i < count; ++i)
      cubes.push_back(add_cube({0.21 * static_cast<double>(i), 0, height}));
    for (std::size_t i = 1; i < count; ++i) {
      const Mover a = Mover::of_body(cubes[i - 1]), b = Mover::of_body(cubes[i]);
      joints.push_back(world.add_joint(joint_at(world, BodyJointKind::hinge, a, b,
                                                at({0.21 * static_cast<double>(i) - 0.105, 0, height}))));
      contacts->exempt(a, b);
    }
    contacts->build();
    world.reserve(64);
  }
};

TEST(WorldJoints, AChainFallsLiesAndSleepsAndGainsNoEnergy) {
  Chain chain(6);
  double energy = chain.world.energy(), worst = 0.0, gained = 0.0;
  std::uint32_t unconverged = 0;
  for (int i = 0; i < 2000; ++i) {
    const StepReport report = chain.step(1e-3);
    ASSERT_EQ(report.failure, StepFailure::none) << i;
    unconverged += report.unconverged;
    worst = std::max(worst, report.worst_joint_error);
    gained = std::max(gained, chain.world.energy() - energy);
    energy = chain.world.energy();
  }
  double fastest = 0.0;
  for (const auto cube : chain.cubes) fastest = std::max(fastest, norm(chain.world.velocity(cube)));
  std::printf("joint error %.2g m, energy gained in a step %.2g J, at rest %.2g m/s, unconverged %u\n", worst,
              gained, fastest, unconverged);
  EXPECT_LT(worst, 1e-9);
  EXPECT_LT(gained, 1e-6);
  EXPECT_LT(fastest, 1e-6);
  for (const auto cube : chain.cubes)
    EXPECT_NEAR(chain.world.pose(cube).p.z(), 0.1, 1e-4);  // less overlap is left
}

TEST(WorldJoints, WhatIsJoinedSleepsAndWakesTogether) {
  Cubes scene;
  DynamicsWorld::Settings settings = scene.world.settings();
  settings.sleep_time = 0.05;
  scene.world = DynamicsWorld(settings);
  scene.add_ground();
  const auto a = scene.add_cube({0, 0, 0.1}), b = scene.add_cube({0.3, 0, 0.1});
  scene.contacts->build();
  const auto hinge = scene.world.add_joint(
      joint_at(scene.world, BodyJointKind::hinge, Mover::of_body(a), Mover::of_body(b), at({0.15, 0, 0.1})));
  for (int i = 0; i < 200; ++i) ASSERT_EQ(scene.step(1e-3).failure, StepFailure::none);
  EXPECT_TRUE(scene.world.is_asleep(a) && scene.world.is_asleep(b));
  scene.world.set_joint_drive(hinge, {JointDrive::Mode::rate, 0.0, 0.5, 50.0});
  EXPECT_FALSE(scene.world.is_asleep(a) || scene.world.is_asleep(b));
  for (int i = 0; i < 100; ++i) {
    const StepReport report = scene.step(1e-3);
    ASSERT_EQ(report.failure, StepFailure::none);
  }
  // Two cubes that turn about each other on the ground: friction's law ends some steps' work before they are
  // solved, which is reported.
  EXPECT_NEAR(scene.world.joint_state(hinge).rate, 0.5, 0.05);
}

TEST(WorldJoints, ACopyTakesTheSameStepsToTheBit) {
  FreeArm arm;
  run(arm.world, 200);
  DynamicsWorld copy = arm.world;
  run(arm.world, 300);
  run(copy, 300);
  for (const auto body : arm.bodies) {
    EXPECT_EQ(arm.world.pose(body).p, copy.pose(body).p);
    EXPECT_EQ(arm.world.state(body).angular_W, copy.state(body).angular_W);
  }
}

TEST(WorldJoints, AToldBodyLeadsWhatHangsOnIt) {
  DynamicsWorld world = world_in({0, 0, -9.81});
  const auto hand = world.add_kinematic(at(kZero), {0.2, 0, 0}, {0, 0, 1.0});
  const auto load = add_box(world, 2, {0.1, 0.1, 0.1}, at({0.5, 0, 0}), {0.2, 0.5, 0}, {0, 0, 1.0});
  const auto grip = world.add_joint(
      joint_at(world, BodyJointKind::fixed, Mover::of_body(hand), Mover::of_body(load), at({0.5, 0, 0})));
  double worst = 0.0;
  for (int i = 0; i < 1000; ++i) worst = std::max(worst, run(world, 1).worst_joint_error);
  EXPECT_LT(worst, 1e-12);
  const Vector3 expected(0.2 + 0.5 * std::cos(1.0), 0.5 * std::sin(1.0), 0);
  EXPECT_LT(norm(world.pose(load).p - expected), 1e-11);
  EXPECT_NEAR(world.joint_state(grip).force_W.z(), 2 * 9.81, 1e-8);
}

TEST(WorldJoints, WhatIsNoJointIsRefused) {
  DynamicsWorld world = world_in(kZero);
  const auto a = add_box(world, 1, {1, 1, 1}, at(kZero)), b = add_box(world, 1, {1, 1, 1}, at({1, 0, 0}));
  const auto commanded = world.add_kinematic({}, kZero, kZero);
  // The error of a joint that was changed so.
  const auto refused = [&](auto change) {
    WorldJoint joint = joint_at(world, BodyJointKind::hinge, Mover::of_body(a), Mover::of_body(b), at(kZero));
    change(joint);
    try {
      world.add_joint(joint);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  // Movers, limits, losses and frames.
  const std::string start = "joint 0: ";
  EXPECT_EQ(refused([](WorldJoint& j) { j.b = Mover::of_body(9); }), start + "no such body or link");
  EXPECT_EQ(refused([](WorldJoint& j) { j.b = j.a; }), start + "it joins a mover with itself");
  EXPECT_EQ(refused([&](WorldJoint& j) { j.a = {}, j.b = Mover::of_body(commanded); }),
            start + "neither side moves freely");
  EXPECT_EQ(refused([](WorldJoint& j) { j.lower = 1, j.upper = -1; }),
            start + "the limits are crossed or not numbers");
  EXPECT_EQ(refused([](WorldJoint& j) { j.joint.kind = BodyJointKind::ball, j.losses.friction = 1; }),
            start + "limits, drives and losses are of hinges and sliders alone");
  EXPECT_EQ(refused([](WorldJoint& j) { j.losses.damping = -1; }),
            start + "friction and damping must be >= 0 and finite");
  EXPECT_NE(refused([](WorldJoint& j) { j.joint.X_AJ.R *= 2.0; }), "taken");
  // Nothing was added; a sound one is taken.
  EXPECT_EQ(world.joint_count(), 0u);
  EXPECT_EQ(refused([](WorldJoint&) {}), "taken");
  EXPECT_THROW(world.switch_joint(1, true), InputError);
}

}  // namespace
}  // namespace touchstone::physics

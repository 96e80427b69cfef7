// Scenes with narrowphase contacts: the pushed ORU, backdrive and torque saturation.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/registry.hpp"
#ifdef TOUCHSTONE_HAS_BULLET
#include "touchstone/adapters/bullet/bullet.hpp"
#endif
#ifdef TOUCHSTONE_HAS_ODE
#include "touchstone/adapters/ode/ode.hpp"
#endif
#include "touchstone/physics/contacts/narrowphase_contacts.hpp"
#include "touchstone/tests/physics/arms.hpp"
#include "touchstone/tests/support/at.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/degree.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

const Vector3 kZero = Vector3::Zero();
HexahedronTree box_tree(const std::string& name, const Vector3& size,
                        const Vector3& centre = Vector3::Zero()) {
  return HexahedronTree({{"box", Hexahedron::from_size(size), at(centre)}}, name);
}

struct Finder {
  BackendRegistry registry;
  std::unique_ptr<NarrowphaseContacts> contacts;

  explicit Finder(double margin) {
    register_core(registry);
    contacts = std::make_unique<NarrowphaseContacts>(registry.make_broadphase("native"),
                                                     registry.make_narrowphase("native"), margin);
  }
};

// Scene 8: a free ORU, 170.1 kg, 1.050 x 0.919 x 0.525 m: 27.60 kg m2 about the vertical.
const Vector3 kOruSize(1.050, 0.919, 0.525);
constexpr double kOruMass = 170.1;

struct PushedOru {
  RigidBody oru{box_inertia(kOruMass, kOruSize), "ORU"};
  HexahedronTree oru_tree = box_tree("oru", kOruSize);
  // A tapered tip: a box would touch with its face.
  HexahedronTree tip_tree = box_tree("tip", {0.02, 0.002, 0.002});
  DynamicsWorld world{{}};
  Finder finder{1e-3};
  std::uint32_t box, tip;

  PushedOru(double offset, double restitution) {
    box = world.add_body(oru, oru.state({}, kZero, kZero));
    tip = world.add_kinematic(at({-0.525 - 0.01 - 1e-5, offset, 0}), {0.02, 0, 0}, kZero);
    finder.contacts->add(Mover::of_body(box), oru_tree, {0.0, restitution});
    finder.contacts->add(Mover::of_body(tip), tip_tree, {0.0, restitution});
    finder.contacts->build();
  }
  /// Until the tip has met the box.
  void run() {
    for (int i = 0; i < 10 && norm(world.velocity(box)) == 0.0; ++i)
      ASSERT_EQ(world.step(1e-3, finder.contacts->find(world)).failure, StepFailure::none);
  }
};

TEST(Scene8, PushedInTheCentre) {
  for (const double e : {0.0, 0.5}) {
    PushedOru scene(0.0, e);
    scene.run();
    EXPECT_NEAR(scene.world.velocity(scene.box).x(), 0.02 * (1.0 + e), 1e-9);
    EXPECT_LT(norm(scene.world.angular_velocity(scene.box)), 1e-9);
  }
}

TEST(Scene8, PushedOffTheCentre) {
  // J = v / (1/m + b^2 / I); the tip is 2 mm wide, and touches with the edge that yields least: b = 0.299 m.
  PushedOru scene(0.30, 0.0);
  const double I = kOruMass / 12.0 * (kOruSize.x() * kOruSize.x() + kOruSize.y() * kOruSize.y());
  EXPECT_NEAR(I, 27.60, 0.005);
  const double written = 0.02 / (1.0 / kOruMass + 0.09 / I);
  EXPECT_NEAR(written, 2.188, 5e-4);
  EXPECT_NEAR(written / kOruMass, 0.01286, 5e-6);
  EXPECT_NEAR(written * 0.3 / I, 0.02379, 5e-6);
  scene.run();
  const double v = scene.world.velocity(scene.box).x(), w = scene.world.angular_velocity(scene.box).z();
  const double b = -w * I / (kOruMass * v);  // where the impulse acted
  EXPECT_NEAR(b, 0.299, 1e-6);
  EXPECT_NEAR(kOruMass * v, 0.02 / (1.0 / kOruMass + b * b / I), 1e-9);
}

/// The arm of scenes 8 and 9, straight along x, about z: slender links of the SSRMS's masses and lengths.
constexpr double kL1 = 7.11, kL2 = 7.11, kL3 = 1.3589;

BodyInertia slender(double mass, double length, double start) {
  const double moment = mass * length * length / 12.0;
  return {mass, {start + length / 2.0, 0, 0}, Vector3(0.0, moment, moment).asDiagonal()};
}

/// All of the arm as one link about the shoulder: upper and lower boom, two clusters as points at the wrist,
/// the end effector.
BodyInertia straight_arm() {
  BodyInertia arm = slender(314.88, kL1, 0.0);
  arm = combined(arm, slender(279.2, kL2, kL1));
  arm = combined(arm, {2.0 * 105.98, {kL1 + kL2, 0, 0}, Matrix3::Zero()});
  return combined(arm, slender(243.66, kL3, kL1 + kL2));
}

Mechanism planar(std::span<const double> lengths) {
  MechanismDescription arm = planar_arm(lengths);
  for (JointDescription& joint : arm.joints) joint.effort = 2332.0;
  return Mechanism(arm);
}

constexpr double kReach = kL1 + kL2 + kL3;

TEST(Scene8, FreeArmPushesWithItsEffectiveMass) {
  // The arm's inertia about its pivot, from its links.
  const double I = 314.88 * kL1 * kL1 / 3.0 + 279.2 * (kL1 * kL1 / 12.0 + 10.665 * 10.665) +
                   2.0 * 105.98 * 14.22 * 14.22 + 243.66 * (kL3 * kL3 / 12.0 + 14.89945 * 14.89945);
  EXPECT_NEAR(I, 135227.5, 0.05);
  const double effective = I / (kReach * kReach);
  EXPECT_NEAR(effective, 557.2, 0.05);
  const Mechanism mechanism = planar(std::array{kReach});
  const MechanismDynamics dynamics(mechanism, std::vector<BodyInertia>{{}, straight_arm()});
  const RigidBody oru(box_inertia(kOruMass, {0.525, 0.525, 0.525}), "ORU");
  // Speeds after it hits a box with its tip, without and with a bounce.
  for (const double e : {0.0, 0.5}) {
    DynamicsWorld world({});
    const auto arm = world.add_mechanism(dynamics, {}, std::array{0.0}, std::array{0.37 / kReach});
    const auto box = world.add_body(oru, oru.state(at({kReach, 0.2625, 0}), kZero, kZero));
    const Contact contact{Mover::of_link(arm, 1),
                          Mover::of_body(box),
                          Vector3::UnitY(),
                          {kReach, 0, 0},
                          {kReach, 0, 0},
                          0.0,
                          e,
                          1};
    ASSERT_EQ(world.step(1e-9, {&contact, 1}).failure, StepFailure::none);
    const double v = (1.0 + e) * 0.37 * effective / (effective + kOruMass);
    EXPECT_NEAR(v, e == 0.0 ? 0.2835 : 0.4252, 5e-5);
    EXPECT_NEAR(world.velocity(box).y(), v, 1e-9);
    EXPECT_NEAR(world.joint_rates(arm)[0] * kReach, v - e * 0.37, 1e-9);
  }
}

/// Scene 9: L1 = 7.11, L2 = 7.11 + 1.3589 m, both joints held by brakes of 2332 N m, the tip pushed by a
/// plate on a rail.
struct Held {
  std::array<double, 2> torques;
  std::array<bool, 2> moves;
};
Held push(double elbow, const Vector3& direction, double force) {
  const double L1 = 7.11, L2 = 7.11 + 1.3589, mass = 1.0;
  const Mechanism mechanism = planar(std::array{L1, L2});
  const MechanismDynamics dynamics(mechanism,
                                   std::vector<BodyInertia>{{}, slender(500, L1, 0), slender(500, L2, 0)});
  DynamicsWorld world({});
  const auto arm = world.add_mechanism(dynamics, {}, std::array{0.0, elbow}, std::array{0.0, 0.0});
  for (std::uint32_t i = 0; i < 2; ++i)
    world.set_drive(arm, i, {.mode = JointDrive::Mode::brake, .limit = 2332.0});
  const Vector3 tip = touchstone::transform(world.link_pose(arm, 2), Vector3(L2, 0, 0));
  const Mechanism pusher = rail(direction);
  const MechanismDynamics pushing(pusher, std::vector<BodyInertia>{{}, box_inertia(mass, {0.1, 0.1, 0.1})});
  const auto plate = world.add_mechanism(pushing, at(tip), std::array{0.0}, std::array{0.0});
  world.set_drive(plate, 0, {.mode = JointDrive::Mode::torque, .torque = force});
  const Contact contact{Mover::of_link(plate, 1), Mover::of_link(arm, 2), direction, tip, tip, 0.0, 0.0, 1};
  EXPECT_EQ(world.step(1e-3, {&contact, 1}).failure, StepFailure::none);
  const auto rates = world.joint_rates(arm), torques = world.joint_torques(arm);
  return {{torques[0], torques[1]}, {std::abs(rates[0]) > 1e-9, std::abs(rates[1]) > 1e-9}};
}

TEST(Scene9, TheJointThatLacksTorqueGivesWay) {
  const double L1 = 7.11, L2 = 7.11 + 1.3589, most = 2332.0;
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY();
  // Elbow at 90 deg, pushed along y: the shoulder holds F L1, the elbow nothing.
  EXPECT_NEAR(most / L1, 328.0, 0.05);
  Held held = push(90 * kDegree, y, 0.999 * most / L1);
  EXPECT_EQ(held.moves, (std::array{false, false}));
  EXPECT_NEAR(held.torques[0], -0.999 * most, 1e-6);
  EXPECT_NEAR(held.torques[1], 0.0, 1e-6);
  EXPECT_TRUE(push(90 * kDegree, y, 1.001 * most / L1).moves[0]);
  // Along x: both hold F L2.
  EXPECT_NEAR(most / L2, 275.4, 0.05);
  held = push(90 * kDegree, x, 0.999 * most / L2);
  EXPECT_EQ(held.moves, (std::array{false, false}));
  EXPECT_NEAR(held.torques[0], 0.999 * most, 1e-6);
  EXPECT_NEAR(held.torques[1], 0.999 * most, 1e-6);
  held = push(90 * kDegree, x, 1.001 * most / L2);
  EXPECT_TRUE(held.moves[0] || held.moves[1]);
  // Elbow at 150 deg, along y: the elbow.
  const double arm = -L2 * std::cos(150 * kDegree);
  EXPECT_NEAR(most / arm, 318.0, 0.05);
  held = push(150 * kDegree, y, 0.999 * most / arm);
  EXPECT_EQ(held.moves, (std::array{false, false}));
  EXPECT_NEAR(held.torques[1], 0.999 * most, 1e-6);
  held = push(150 * kDegree, y, 1.001 * most / arm);
  EXPECT_TRUE(held.moves[1]);
}

TEST(Scene9, BackdrivenByAPayload) {
  // w0 = m v r / (I + m r^2), then the brake's torque takes (I + m r^2) w0 / tau; all closed forms.
  const double I = 135227.5;
  struct Case {
    double mass, speed, angle, travel, time;
  };
  for (const Case& c :
       {Case{16.5e3, 0.02, 0.0784, 21.3e-3, 2.205}, Case{116e3, 0.012, 0.2042, 55.5e-3, 9.30}}) {
    const Mechanism mechanism = planar(std::array{kReach});
    BodyInertia loaded = combined(straight_arm(), {c.mass, {kReach, 0, 0}, Matrix3::Zero()});
    const MechanismDynamics dynamics(mechanism, std::vector<BodyInertia>{{}, loaded});
    const double inertia = I + c.mass * kReach * kReach, w0 = c.mass * c.speed * kReach / inertia;
    DynamicsWorld world({});
    const auto arm = world.add_mechanism(dynamics, {}, std::array{0.0}, std::array{w0});
    world.set_drive(arm, 0, {.mode = JointDrive::Mode::brake, .limit = 2332.0});
    double time = 0.0, stop = 0.0;
    while (time < 10.0) {
      const StepReport report = world.step(1e-3, {});
      ASSERT_EQ(report.failure, StepFailure::none);
      if (!std::isnan(report.last_stop)) stop = time + report.last_stop;
      time += 1e-3;
    }
    const double angle = world.joint_values(arm)[0];
    EXPECT_NEAR(stop, inertia * w0 / 2332.0, 1e-6 * stop);
    EXPECT_NEAR(angle, 0.5 * inertia * w0 * w0 / 2332.0, 1e-6 * angle);
    EXPECT_NEAR(stop, c.time, 5e-3);
    EXPECT_NEAR(angle / kDegree, c.angle, 5e-5);
    EXPECT_NEAR(angle * kReach, c.travel, 5e-5);
  }
}

/// Cubes of 0.2 m and 1000 kg/m3 on the ground, which is z = 0.
struct CubesOnTheGround {
  Finder finder{1e-3};
  DynamicsWorld world{{.gravity_W = {0, 0, -9.81}}};
  HexahedronTree ground = box_tree("ground", {10, 10, 1}, {0, 0, -0.5}),
                 cube = box_tree("cube", {0.2, 0.2, 0.2});
  RigidBody body{inertia_of_density(cube.solids(), 1000.0, "cube"), "cube"};

  CubesOnTheGround() { finder.contacts->add(Mover::ground(), ground, {}); }
  void add(const Vector3& p_W, const Vector3& velocity_W) {
    const auto added = world.add_body(body, body.state(at(p_W), velocity_W, kZero));
    finder.contacts->add(Mover::of_body(added), cube, {});
  }
};

TEST(NarrowphaseContacts, AStackOfBoxesRestsAndAllocatesNothing) {
  CubesOnTheGround scene;
  for (int i = 0; i < 5; ++i) scene.add({0, 0, 0.1 + 0.2 * i}, kZero);
  Finder& finder = scene.finder;
  DynamicsWorld& world = scene.world;
  finder.contacts->build();
  world.reserve(64);
  std::size_t allocations = 0;
  for (int step = 0; step < 200; ++step) {
    if (step == 1) allocations = allocation_count();
    const auto contacts = finder.contacts->find(world);
    ASSERT_GE(contacts.size(), 20U);
    const StepReport report = world.step(1e-3, contacts);
    ASSERT_EQ(report.failure, StepFailure::none);
    EXPECT_LE(report.worst_residual, 1e-9);
  }
  EXPECT_EQ(allocation_count(), allocations);
  for (std::uint32_t i = 0; i < 5; ++i) EXPECT_NEAR(world.state(i).p_W.z(), 0.1 + 0.2 * i, 1e-7);
}

TEST(NarrowphaseContacts, PairsThatKeepTheirPosesKeepWhatAFreshLookFinds) {
  // Two cubes rest, one slides: what is kept from step to step has the bits of what is found anew.
  CubesOnTheGround scene;
  for (const double x : {1.0, 2.0, 3.0}) scene.add({x, 0, 0.1}, {x > 2.5 ? 0.5 : 0.0, 0, 0});
  Finder& finder = scene.finder;
  DynamicsWorld& world = scene.world;
  finder.contacts->build();
  int same = 0;
  for (int step = 0; step < 50; ++step) {
    const Pose before = world.pose(0);
    const auto found = finder.contacts->find(world);
    const std::vector<Contact> kept(found.begin(), found.end());
    ASSERT_EQ(world.step(1e-3, kept).failure, StepFailure::none);
    same += before.R == world.pose(0).R && before.p == world.pose(0).p ? 1 : 0;
    const auto next = finder.contacts->find(world);
    const std::vector<Contact> incremental(next.begin(), next.end());
    finder.contacts->build();  // forgets
    const auto fresh = finder.contacts->find(world);
    ASSERT_EQ(incremental.size(), fresh.size());
    for (std::size_t i = 0; i < fresh.size(); ++i) {
      EXPECT_EQ(incremental[i].p_A_W, fresh[i].p_A_W);
      EXPECT_EQ(incremental[i].p_B_W, fresh[i].p_B_W);
      EXPECT_EQ(incremental[i].n_AB_W, fresh[i].n_AB_W);
      EXPECT_EQ(incremental[i].key, fresh[i].key);
    }
  }
  EXPECT_GT(same, 40);  // or nothing was kept
}

TEST(NarrowphaseContacts, ABoxRestsOnWhateverBackend) {
  // The same scene, another word: within 1e-4 m, which is Bullet's and ODE's own slack, not native's.
  BackendRegistry registry;
  register_core(registry);
  std::vector<std::pair<std::string, double>> backends = {{"native", 1e-9}};
#ifdef TOUCHSTONE_HAS_BULLET
  register_bullet(registry);
  backends.emplace_back("bullet", 1e-4);
#endif
#ifdef TOUCHSTONE_HAS_ODE
  register_ode(registry);
  backends.emplace_back("ode", 1e-4);
#endif
  const HexahedronTree ground = box_tree("ground", {4, 4, 1}, {0, 0, -0.5}),
                       cube = box_tree("cube", {0.2, 0.2, 0.2});
  const RigidBody body(inertia_of_density(cube.solids(), 1000.0, "cube"), "cube");
  for (const auto& [name, tolerance] : backends) {
    DynamicsWorld world({.gravity_W = {0, 0, -9.81}});
    const auto box = world.add_body(body, body.state(at({0, 0, 0.1}), kZero, kZero));
    NarrowphaseContacts contacts(registry.make_broadphase("native"), registry.make_narrowphase(name), 1e-3);
    contacts.add(Mover::ground(), ground, {});
    contacts.add(Mover::of_body(box), cube, {});
    contacts.build();
    for (int step = 0; step < 300; ++step)
      ASSERT_EQ(world.step(1e-3, contacts.find(world)).failure, StepFailure::none) << name;
    EXPECT_NEAR(world.state(box).p_W.z(), 0.1, tolerance) << name;
    EXPECT_LT(norm(world.velocity(box)), 1e-3) << name;
  }
}

TEST(NarrowphaseContacts, StacksApartAreProblemsApart) {
  // A leaning stack's motion has the same bits beside others as alone.
  const HexahedronTree ground = box_tree("ground", {50, 50, 1}, {0, 0, -0.5}),
                       cube = box_tree("cube", {0.2, 0.2, 0.2});
  const RigidBody body(inertia_of_density(cube.solids(), 1000.0, "cube"), "cube");
  const auto run = [&](int stacks) {
    Finder finder(1e-3);
    DynamicsWorld world({.gravity_W = {0, 0, -9.81}});
    finder.contacts->add(Mover::ground(), ground, {});
    for (int k = 0; k < stacks; ++k)
      for (int i = 0; i < 3; ++i)
        finder.contacts->add(Mover::of_body(world.add_body(
                                 body, body.state(at({1.0 * k, 0.01 * i, 0.1 + 0.2 * i}), kZero, kZero))),
                             cube, {});
    finder.contacts->build();
    std::uint32_t solves = 0;
    for (int step = 0; step < 30; ++step) solves = world.step(1e-3, finder.contacts->find(world)).solves;
    EXPECT_GE(solves, static_cast<std::uint32_t>(stacks));
    return world.state(2).p_W;
  };
  const Vector3 alone = run(1), beside = run(4);
  EXPECT_EQ(alone, beside);
}

TEST(NarrowphaseContacts, SeamsBetweenHexahedraCostNoSpeed) {
  // A cube slides without friction over a floor of abutting tiles.
  Finder finder(1e-3);
  DynamicsWorld world({.gravity_W = {0, 0, -9.81}});
  std::vector<PlacedHexahedron> tiles;
  for (int i = 0; i < 12; ++i)
    tiles.push_back(
        {"tile" + std::to_string(i), Hexahedron::from_size({0.25, 1, 0.5}), at({0.25 * i, 0, -0.25})});
  const HexahedronTree floor(tiles, "floor"), cube = box_tree("cube", {0.2, 0.2, 0.2});
  const RigidBody body(inertia_of_density(cube.solids(), 1000.0, "cube"), "cube");
  const auto slider = world.add_body(body, body.state(at({0.05, 0, 0.1}), {1, 0, 0}, kZero));
  finder.contacts->add(Mover::ground(), floor, {0.0, 0.0});
  finder.contacts->add(Mover::of_body(slider), cube, {0.0, 0.0});
  finder.contacts->build();
  for (int step = 0; step < 2000; ++step)
    ASSERT_EQ(world.step(1e-3, finder.contacts->find(world)).failure, StepFailure::none);
  // The gap of 1e-9 m lets the cube of 0.2 m lean by 5e-9: in 2 s that is 1e-7 m/s.
  EXPECT_NEAR(world.state(slider).p_W.x(), 2.05, 1e-8);
  EXPECT_NEAR(world.velocity(slider).x(), 1.0, 1e-8);
  EXPECT_NEAR(world.state(slider).p_W.z(), 0.1, 1e-7);
}

/// Two cubes of 0.2 m, turned together about the vertical, B off A as given in their axes.
struct CubePair {
  HexahedronTree cube_tree = box_tree("cube", {0.2, 0.2, 0.2});
  RigidBody cube{box_inertia(1.0, {0.2, 0.2, 0.2}), "cube"};
  Matrix3 R_WC;
  DynamicsWorld world;
  Finder finder{1e-3};
  std::uint32_t a, b;

  CubePair(double yaw, const Vector3& gravity_W, const Vector3& off_C, const Vector3& v_C)
      : R_WC(rotation_about({0, 0, 1}, yaw)), world({.gravity_W = gravity_W}) {
    const auto add = [&](const Vector3& p_C, const Vector3& v) {
      return world.add_body(
          cube, cube.state(at(rotate(R_WC, p_C) + Vector3(0, 0, 0.1), R_WC), rotate(R_WC, v), kZero));
    };
    a = add(kZero, kZero), b = add(off_C, v_C);
    for (const std::uint32_t body : {a, b}) finder.contacts->add(Mover::of_body(body), cube_tree, {0.5, 0.0});
  }
  void step(double h) {
    ASSERT_EQ(world.step(h, finder.contacts->find(world, h)).failure, StepFailure::none);
  }
  /// Of B's middle from A's, in their axes at the start.
  Vector3 off_C() const { return rotate_back(R_WC, world.state(b).p_W - world.state(a).p_W); }
};

TEST(NarrowphaseContacts, WhatFallsFlushAlongAnotherDoesNotCatchOnItsEdge) {
  // It caught, and lay on its side at the end. On its way it is slow and fast, and stands on the edge at
  // first.
  const HexahedronTree ground = box_tree("ground", {20, 20, 1}, {0, 0, -0.5});
  for (const double yaw : {0.0, 0.3, 0.7})
    for (const double drop : {0.0, 0.1, 1.0}) {
      CubePair pair(yaw, {0, 0, -9.81}, {0.2, 0, 0.2 + drop}, kZero);
      pair.finder.contacts->add(Mover::ground(), ground, {0.5, 0.0});
      pair.finder.contacts->build();
      for (int i = 0; i < 240; ++i) pair.step(1.0 / 240.0);
      // What falls beside it may push it by rounding and what solves leave.
      EXPECT_LT(norm(pair.off_C() - Vector3(0.2, 0, 0)), 1e-6) << yaw << " " << drop;
      EXPECT_LT(norm(pair.world.velocity(pair.b)), 1e-9) << yaw << " " << drop;
    }
}

TEST(NarrowphaseContacts, EdgesThatMeetEdgesOnTheirWayBothWaysStopEachOther) {
  // Edge to edge along the diagonal: passed by as if it were free across, B would be in A by up to a step's
  // way.
  for (const double yaw : {0.0, 0.3})
    for (const double speed : {0.1, 30.0}) {
      CubePair pair(yaw, kZero, {0.2 + 1e-4 * speed, 0, 0.2 + 1e-4 * speed}, {-speed, 0, -speed});
      pair.finder.contacts->build();
      double deepest = 0.0;
      for (int i = 0; i < 30; ++i) {
        pair.step(1e-3);
        const Vector3 off_C = pair.off_C();
        deepest = std::max(deepest, 0.2 - std::max(off_C.x(), off_C.z()));
      }
      EXPECT_LT(deepest, 1e-6) << yaw << " " << speed;
    }
}

TEST(NarrowphaseContacts, EdgesAreLookedAtAnewWhenTheyBeginToCloseAndWhenTheyStop) {
  // No pose changes, and none of the speeds is fast.
  CubePair pair(0.0, kZero, {0.2, 0, 0.2}, kZero);
  pair.finder.contacts->build();
  for (const double speed : {0.0, 0.1, 0.0, 0.1}) {
    pair.world.set_state(pair.b, pair.cube.state(at({0.2, 0, 0.3}), {-speed, 0, -speed}, kZero));
    for (int again = 0; again < 2; ++again)
      EXPECT_EQ(pair.finder.contacts->find(pair.world, 1e-3).empty(), speed == 0.0) << speed;
  }
  // Where they are judged they are there at any rate.
  pair.finder.contacts->keep_edges();
  pair.world.set_state(pair.b, pair.cube.state(at({0.2, 0, 0.3}), kZero, kZero));
  EXPECT_FALSE(pair.finder.contacts->find(pair.world, 1e-3).empty());
}

TEST(NarrowphaseContacts, AnEdgeThatClosesAtOneEndAloneIsStoppedThere) {
  // B comes down on A's edge and turns about the vertical: beside A at one end of the edge, over it at the
  // other.
  for (const double turning : {-5.0, 5.0, -50.0, 50.0}) {
    CubePair pair(0.0, kZero, {0.2, 0, 0.2 + 1e-4}, kZero);
    pair.world.set_state(pair.b,
                         pair.cube.state(at({0.2, 0, 0.3 + 1e-4}), {0, 0, -1}, Vector3(0, 0, turning)));
    pair.finder.contacts->build();
    EXPECT_FALSE(pair.finder.contacts->find(pair.world, 1e-3).empty()) << turning;
  }
}

/// Ten cubes off each other's middle on a free slab that comes up to them: too large for the dense solver,
/// and it slides at every level.
struct LeaningStack {
  static constexpr int kCubes = 10;
  HexahedronTree slab_tree = box_tree("slab", {4, 4, 0.2}), cube_tree = box_tree("cube", {0.2, 0.2, 0.2});
  RigidBody slab{box_inertia(1000.0, {4, 4, 0.2}), "slab"}, cube{box_inertia(1.0, {0.2, 0.2, 0.2}), "cube"};
  DynamicsWorld world{{}};
  Finder finder{1e-3};

  LeaningStack() {
    const auto add = [&](const RigidBody& body, const HexahedronTree& tree, const Vector3& p,
                         const Vector3& v) {
      finder.contacts->add(Mover::of_body(world.add_body(body, body.state(at(p), v, kZero))), tree,
                           {0.5, 0.0});
    };
    add(slab, slab_tree, {0, 0, -0.1}, {0, 0, 0.1});
    for (int i = 0; i < kCubes; ++i)
      add(cube, cube_tree, {i % 2 == 1 ? 0.03 : 0.0, 0, 0.1 + 0.2 * i}, {0.2, 0.05 * i, -0.05 * i});
    finder.contacts->build();
    world.reserve(8 * kCubes);
  }
};

TEST(LargeIslands, SayWhatIsLeftAndKeepMomentum) {
  LeaningStack scene, again;
  const Vector3 p = scene.world.linear_momentum(), l = scene.world.angular_momentum();
  std::uint32_t left = 0;
  double worst = 0.0, depth = 0.0;
  // Steps with residuals reported, and without allocations.
  for (int step = 0; step < 60; ++step) {
    const auto contacts = scene.finder.contacts->find(scene.world);
    for (const Contact& contact : contacts)
      depth = std::max(depth, -dot(contact.n_AB_W, contact.p_B_W - contact.p_A_W));
    const std::size_t allocations = allocation_count();
    const StepReport report = scene.world.step(1e-3, contacts);
    EXPECT_TRUE(step == 0 || allocation_count() == allocations);
    ASSERT_EQ(report.failure, StepFailure::none);
    left += report.unconverged;
    worst = std::max(worst, report.worst_residual);
    if (report.unconverged > 0)
      EXPECT_GT(report.worst_residual, 1e-9);  // reported, and for a reason
    else
      EXPECT_LT(report.worst_residual, 1e-5);  // of speeds of 0.5 m/s
    again.world.step(1e-3, again.finder.contacts->find(again.world));
  }
  std::printf("%u solves unconverged, worst residual %.1e m/s, deepest %.1e m\n", left, worst, depth);
  EXPECT_LT(left, 30U);    // of 60: those whose work ended
  EXPECT_LT(worst, 0.2);   // of speeds of 0.5 m/s
  EXPECT_LT(depth, 1e-3);  // what these make of two steps
  // Momentum is kept, and the same run gives the same bits.
  EXPECT_LT(norm(scene.world.linear_momentum() - p), 1e-13 * 100.0);
  EXPECT_LT(norm(scene.world.angular_momentum() - l), 1e-13 * 100.0);
  for (std::uint32_t i = 0; i <= LeaningStack::kCubes; ++i)
    EXPECT_EQ(scene.world.state(i).p_W, again.world.state(i).p_W);
}

}  // namespace

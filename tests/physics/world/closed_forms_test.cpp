// Contact dynamics against closed forms; every input stands in its test.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "touchstone/physics/world/dynamics_world.hpp"
#include "touchstone/tests/physics/arms.hpp"
#include "touchstone/tests/support/at.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

const Vector3 kZero = Vector3::Zero();

/// Where a contact is and how; both points at p.
Contact touch(const Mover& a, const Mover& b, const Vector3& n, const Vector3& p, double friction = 0.0,
              double restitution = 0.0) {
  return {a, b, n, p, p, friction, restitution, 1};
}

/// A slender rod from its joint along +x.
BodyInertia rod(double mass, double length) {
  const double moment = mass * length * length / 12.0;
  return {mass, {length / 2.0, 0, 0}, Vector3(0.0, moment, moment).asDiagonal()};
}

/// Of slender links.
struct PlanarArm {
  Mechanism mechanism;
  MechanismDynamics dynamics;

  static std::vector<BodyInertia> rods(std::span<const double> masses, std::span<const double> lengths) {
    std::vector<BodyInertia> out = {{}};
    for (std::size_t i = 0; i < masses.size(); ++i) out.push_back(rod(masses[i], lengths[i]));
    return out;
  }
  PlanarArm(std::span<const double> masses, std::span<const double> lengths)
      : mechanism(planar_arm(lengths)), dynamics(mechanism, rods(masses, lengths)) {}
  PlanarArm(const PlanarArm&) = delete;
};

TEST(ClosedForm, TenKilogramsOntoAHundredTonnes) {
  const double m1 = 10.0, m2 = 1e5, v = 0.1;
  for (const double e : {0.0, 0.5}) {
    DynamicsWorld world({});
    const RigidBody small(box_inertia(m1, {0.5, 0.5, 0.5}), "small"),
        large(box_inertia(m2, {4, 4, 4}), "large");
    const auto a = world.add_body(small, small.state(at({-2.25, 0, 0}), {v, 0, 0}, kZero));
    const auto b = world.add_body(large, large.state(at({0, 0, 0}), kZero, kZero));
    const Contact contact = touch(Mover::of_body(a), Mover::of_body(b), Vector3::UnitX(), {-2, 0, 0}, 0.0, e);
    const Vector3 before = world.linear_momentum();
    ContactForce force;
    const StepReport report = world.step(1e-3, {&contact, 1}, {&force, 1});
    ASSERT_EQ(report.failure, StepFailure::none);
    const double impulse = (1.0 + e) * v / (1.0 / m1 + 1.0 / m2);
    EXPECT_NEAR(force.impact_W.x(), impulse, 1e-10 * impulse);
    EXPECT_NEAR(world.velocity(a).x(), v - impulse / m1, 1e-10 * v);
    EXPECT_NEAR(world.velocity(b).x(), impulse / m2, 1e-10 * impulse / m2);
    EXPECT_LT(norm(world.linear_momentum() - before), 1e-14 * norm(before));
    EXPECT_LT(report.worst_residual, 1e-10);
  }
  EXPECT_NEAR(0.1 / (1.0 / 10.0 + 1.0 / 1e5), 0.99990001, 1e-8);
}

TEST(ClosedForm, ACradleOfTouchingBodiesBouncesAsOne) {
  // Newton's law at every contact at once, elastic: of n the first contact's impulse p has
  // p (1 + 1 / (n - 1)) = 2, and those behind it, which do not part, share it. (A real cradle of hard balls
  // passes all of it on to the last, one contact after the other.)
  for (const std::size_t n : {2U, 3U, 5U}) {
    DynamicsWorld world({});
    const RigidBody body(box_inertia(2.0, {0.1, 0.1, 0.1}), "body");
    for (std::size_t i = 0; i < n; ++i) {
      const Vector3 p(0.1 * static_cast<double>(i), 0, 0), v(i == 0 ? 1.0 : 0.0, 0, 0);
      world.add_body(body, body.state(at(p), v, kZero));
    }
    std::vector<Contact> contacts;
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      contacts.push_back(touch(Mover::of_body(i), Mover::of_body(i + 1), Vector3::UnitX(),
                               {0.1 * i + 0.05, 0, 0}, 0.0, 1.0));
      contacts.back().key = i + 1;
    }
    const double energy = world.energy();
    ASSERT_EQ(world.step(1e-3, contacts).failure, StepFailure::none);
    const double impulse = 2.0 * static_cast<double>(n - 1) / static_cast<double>(n);
    EXPECT_NEAR(world.velocity(0).x(), 1.0 - impulse, 1e-12) << n;
    for (std::uint32_t i = 1; i < n; ++i)
      EXPECT_NEAR(world.velocity(i).x(), impulse / static_cast<double>(n - 1), 1e-12) << n << ", " << i;
    EXPECT_NEAR(world.energy(), energy, 1e-12);
    if (n == 5) {
      EXPECT_NEAR(world.velocity(0).x(), -0.6, 1e-12);
      EXPECT_NEAR(world.velocity(4).x(), 0.4, 1e-12);
    }
  }
}

TEST(ClosedForm, OffTheCentreOfACube) {
  // 1.5 m off the centre of a 100 t, 4 m cube (inertia 266 666.67), e = 0: the effective mass has b^2 / I
  // too.
  const double m1 = 10.0, m2 = 1e5, I = m2 * 16.0 / 6.0, b = 1.5, v = 0.1;
  DynamicsWorld world({});
  const RigidBody small(box_inertia(m1, {0.5, 0.5, 0.5}), "small"),
      large(box_inertia(m2, {4, 4, 4}), "large");
  const auto one = world.add_body(small, small.state(at({-2.25, b, 0}), {v, 0, 0}, kZero));
  const auto two = world.add_body(large, large.state(at({0, 0, 0}), kZero, kZero));
  const Contact contact = touch(Mover::of_body(one), Mover::of_body(two), Vector3::UnitX(), {-2, b, 0});
  const Vector3 linear = world.linear_momentum(), angular = world.angular_momentum();
  ASSERT_EQ(world.step(1e-6, {&contact, 1}).failure, StepFailure::none);
  const double impulse = v / (1.0 / m1 + 1.0 / m2 + b * b / I);
  const double v1 = v - impulse / m1, w2 = -b * impulse / I;
  EXPECT_NEAR(v1, 1.8434e-5, 1e-9);
  EXPECT_NEAR(w2, -5.624e-6, 1e-9);
  EXPECT_NEAR(world.velocity(one).x(), v1, 1e-9 * v);
  EXPECT_NEAR(world.angular_velocity(two).z(), w2, 1e-9 * std::abs(w2));
  EXPECT_LT(norm(world.linear_momentum() - linear), 1e-14 * norm(linear));
  EXPECT_LT(norm(world.angular_momentum() - angular), 1e-14 * norm(angular));
}

TEST(ClosedForm, MomentumOfAFrictionalCollisionStays) {
  // Two tumbling boxes that touch in a point, with friction and bounce, over steps long enough to show.
  DynamicsWorld world({});
  const RigidBody body(box_inertia(3.0, {0.4, 0.6, 1.0}), "box");
  const auto a = world.add_body(body, body.state(at({-0.5, 0.1, 0}), {1, 0.2, 0}, {0.3, -2, 1}));
  const auto b = world.add_body(body, body.state(at({0.5, 0, 0.2}), {-1, 0, 0.5}, {1, 1, -1}));
  const Vector3 linear = world.linear_momentum(), angular = world.angular_momentum();
  for (int i = 0; i < 50; ++i) {
    // Held together by a contact that is renewed each step at the point between them.
    const Vector3 p = 0.5 * (world.state(a).p_W + world.state(b).p_W);
    const Contact contact = touch(Mover::of_body(a), Mover::of_body(b), Vector3::UnitX(), p, 0.5, 0.2);
    ASSERT_EQ(world.step(1e-2, {&contact, 1}).failure, StepFailure::none);
  }
  EXPECT_LT(norm(world.linear_momentum() - linear), 1e-13 * norm(linear));
  EXPECT_LT(norm(world.angular_momentum() - angular), 1e-13 * norm(angular));
}

/// 10 kg at 0.1 m/s square onto the tip of a 70 kg, 5 m rod on a joint at its end.
struct Backdrive {
  PlanarArm arm{std::array{70.0}, std::array{5.0}};
  RigidBody payload{box_inertia(10.0, {0.2, 0.2, 0.2}), "payload"};
  DynamicsWorld world{{}};
  std::uint32_t mechanism, body;
  Mover tip;

  explicit Backdrive(double brake) {
    mechanism = world.add_mechanism(arm.dynamics, {}, std::array{0.0}, std::array{0.0});
    world.set_drive(mechanism, 0, {.mode = JointDrive::Mode::brake, .limit = brake});
    body = world.add_body(payload, payload.state(at({5, -0.1, 0}), {0, 0.1, 0}, kZero));
    tip = Mover::of_link(mechanism, 1);
  }
  Contact contact() const { return touch(Mover::of_body(body), tip, Vector3::UnitY(), {5, 0, 0}); }
};

TEST(ClosedForm, BackdriveWithABrake) {
  // J = m v / (1 + m r^2 / I), I = m_rod r^2 / 3; then the brake takes I w / tau seconds.
  Backdrive scene(1.0);
  const double I = 70.0 * 25.0 / 3.0, impulse = 0.1 / (1.0 / 10.0 + 25.0 / I), w = 5.0 * impulse / I;
  EXPECT_NEAR(impulse, 0.7, 1e-15);
  EXPECT_NEAR(w, 0.006, 1e-15);
  const Contact contact = scene.contact();
  ContactForce force;
  ASSERT_EQ(scene.world.step(1e-9, {&contact, 1}, {&force, 1}).failure, StepFailure::none);
  EXPECT_NEAR(force.impact_W.y(), impulse, 1e-9 * impulse);
  EXPECT_NEAR(scene.world.velocity(scene.body).y(), 0.03, 1e-9);
  EXPECT_NEAR(scene.world.joint_rates(scene.mechanism)[0], w, 1e-9 * w);
  // The payload is taken away: no contact from here on.
  double time = 1e-9, stop = 0.0;
  while (time < 3.6) {
    const StepReport report = scene.world.step(1e-3, {});
    ASSERT_EQ(report.failure, StepFailure::none);
    if (!std::isnan(report.last_stop)) stop = time + report.last_stop;
    time += 1e-3;
  }
  EXPECT_NEAR(stop, I * w / 1.0, 1e-6 * 3.5);
  EXPECT_NEAR(scene.world.joint_values(scene.mechanism)[0], 0.5 * I * w * w / 1.0, 1e-6 * 0.0105);
  EXPECT_NEAR(scene.world.joint_rates(scene.mechanism)[0], 0.0, 1e-12);
}

TEST(ClosedForm, BackdriveLeftInContactPushesOn) {
  Backdrive scene(1.0);
  double time = 0.0, stop = 0.0;
  for (int i = 0; i < 5500; ++i) {
    // The tip's edge on the payload's flat face, wherever both are now: square at the start.
    const Vector3 tip = touchstone::transform(scene.world.link_pose(scene.mechanism, 1), Vector3(5, 0, 0));
    Contact contact = scene.contact();
    const double face = scene.world.state(scene.body).p_W.y() + 0.1;
    contact.p_B_W = tip;
    contact.p_A_W = {tip.x(), face, 0};
    const StepReport report = scene.world.step(1e-3, {&contact, 1});
    ASSERT_EQ(report.failure, StepFailure::none);
    if (!std::isnan(report.last_stop)) stop = time + report.last_stop;
    time += 1e-3;
  }
  EXPECT_NEAR(stop, 5.0, 5e-3);
  EXPECT_NEAR(scene.world.joint_values(scene.mechanism)[0], 0.015, 1e-3 * 0.015);
}

TEST(ClosedForm, UncommandedMotionOfTwoJoints) {
  // Links of 5 m and 70 kg, elbow at 90 deg: M = (2916.667, 583.333; 583.333, 583.333), the tip's row along
  // -x (5, 5). 50 N m on joint 1, joint 2 holds with at most 5, a free 10 kg at the tip: M a = (50, -5 s) -
  // (5, 5)^T f, 10 (5 a1 + 5 a2) = f.
  PlanarArm arm(std::array{70.0, 70.0}, std::array{5.0, 5.0});
  const RigidBody payload(box_inertia(10.0, {0.2, 0.2, 0.2}), "payload");
  const auto run = [&](double holding) {
    DynamicsWorld world({});
    const auto mechanism =
        world.add_mechanism(arm.dynamics, {}, std::array{0.0, std::numbers::pi / 2}, std::array{0.0, 0.0});
    world.set_drive(mechanism, 0, {.mode = JointDrive::Mode::torque, .torque = 50.0});
    world.set_drive(mechanism, 1, {.mode = JointDrive::Mode::brake, .limit = holding});
    const auto body = world.add_body(payload, payload.state(at({4.9, 5, 0}), kZero, kZero));
    const Contact contact =
        touch(Mover::of_link(mechanism, 2), Mover::of_body(body), -Vector3::UnitX(), {5, 5, 0});
    ContactForce force;
    const double h = 1e-6;
    EXPECT_EQ(world.step(h, {&contact, 1}, {&force, 1}).failure, StepFailure::none);
    return std::array{world.joint_rates(mechanism)[0] / h, world.joint_rates(mechanism)[1] / h,
                      -force.force_W.x(), world.joint_torques(mechanism)[1]};
  };
  const auto limited = run(5.0);
  EXPECT_NEAR(limited[0], 0.0192857, 1e-7);
  EXPECT_NEAR(limited[1], -0.0132857, 1e-7);
  EXPECT_NEAR(limited[2], 0.3, 1e-6);
  EXPECT_NEAR(limited[3], 5.0, 1e-12);
  const auto strong = run(100.0);  // joint 2 then needs 13.158 and holds
  EXPECT_NEAR(strong[1], 0.0, 1e-9);
  EXPECT_NEAR(strong[3], 13.158, 1e-3);
}

TEST(ClosedForm, AnArmWhoseTipSlidesStaysOnTheGround) {
  // A rod of 1 m and one of 0.6 m, their knee up, under gravity: the knee sinks at a steady rate, and the tip
  // slides outwards on smooth ground, from which it bends away. Where the laws held for the tip as it is at a
  // step's start, it parted by half of h^2 times that, fell back and was met anew in each step.
  const double start = 0.5, rate = -0.1, inner = 1.0, outer = 0.6, h = 1e-3;
  PlanarArm arm(std::array{1.0, 1.0}, std::array{inner, outer});
  DynamicsWorld world({.gravity_W = {0, -9.81, 0}});
  const double slope = std::asin(inner * std::sin(start) / outer);
  const double outer_rate = -rate * inner * std::cos(start) / (outer * std::cos(slope));
  const auto mechanism = world.add_mechanism(arm.dynamics, {}, std::array{start, -start - slope},
                                             std::array{rate, outer_rate - rate});
  world.set_drive(mechanism, 0, {.mode = JointDrive::Mode::rate, .rate = rate, .limit = 100.0});
  double lifted = 0.0;
  unsigned pieces = 0, steps = 0;
  for (; world.joint_values(mechanism)[0] > 0.4; ++steps) {
    const Vector3 tip = touchstone::transform(world.link_pose(mechanism, 2), Vector3(outer, 0, 0));
    lifted = std::max(lifted, tip.y());
    Contact contact = touch(Mover::ground(), Mover::of_link(mechanism, 2), Vector3::UnitY(), tip);
    contact.p_A_W.y() = 0.0;
    const StepReport report = world.step(h, {&contact, 1});
    ASSERT_EQ(report.failure, StepFailure::none);
    pieces += report.substeps;
  }
  std::printf("tip slides: lifted by %.1e m, %u pieces in %u steps\n", lifted, pieces, steps);
  EXPECT_LT(lifted, 1e-9);
  EXPECT_LT(pieces, steps + 5);
}

/// A cube on a plane, four contact points at its corners, in the plane's axes.
struct OnAPlane {
  DynamicsWorld world;
  std::uint32_t body;
  double half, friction;

  OnAPlane(double mass, double side, double mu, const Vector3& gravity, const Vector3& velocity)
      : world({.gravity_W = gravity}), half(side / 2.0), friction(mu) {
    const RigidBody cube(box_inertia(mass, {side, side, side}), "cube");
    body = world.add_body(cube, cube.state(at({0, 0, half}), velocity, kZero));
  }
  std::array<Contact, 4> contacts() const {
    std::array<Contact, 4> out;
    for (unsigned i = 0; i < 4; ++i) {
      const Vector3 corner((i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half, -half);
      const Vector3 p = touchstone::transform(world.pose(body), corner);
      out[i] = touch(Mover::ground(), Mover::of_body(body), Vector3::UnitZ(), p, friction);
      out[i].p_A_W.z() = 0.0;
      out[i].key = i + 1;
    }
    return out;
  }
};

TEST(ClosedForm, SlidingStopsWithinTheStep) {
  const double v = 1.0, mu = 0.5, g = 9.81;
  OnAPlane scene(2.0, 0.2, mu, {0, 0, -g}, {v * 0.6, v * 0.8, 0});
  double time = 0.0, stop = 0.0;
  std::size_t allocations = 0;
  scene.world.reserve(4);
  for (int i = 0; i < 300; ++i) {
    const auto contacts = scene.contacts();
    if (i == 1) allocations = allocation_count();
    const StepReport report = scene.world.step(1e-3, contacts);
    ASSERT_EQ(report.failure, StepFailure::none);
    EXPECT_EQ(report.unconverged, 0U) << i;
    if (!std::isnan(report.last_stop)) stop = time + report.last_stop;
    time += 1e-3;
  }
  EXPECT_EQ(allocation_count(), allocations);
  const Vector3 p = scene.world.state(scene.body).p_W;
  std::printf("stop off by %.1e s, %.1e m\n", stop - v / (mu * g),
              std::hypot(p.x(), p.y()) - v * v / (2 * mu * g));
  // Some ten times what comes out: what the solver leaves (1e-10 m/s) over the deceleration.
  EXPECT_NEAR(stop, v / (mu * g), 2e-10);
  EXPECT_NEAR(std::hypot(p.x(), p.y()), v * v / (2.0 * mu * g), 5e-13);
  EXPECT_NEAR(p.z(), 0.1, 1e-9);
}

TEST(ClosedForm, SlidingDownAWedgeAndSticking) {
  const double g = 9.81, angle = std::numbers::pi / 6.0;
  const Vector3 gravity(g * std::sin(angle), 0, -g * std::cos(angle));
  OnAPlane sliding(2.0, 0.2, 0.2, gravity, kZero);
  for (int i = 0; i < 500; ++i)
    ASSERT_EQ(sliding.world.step(1e-3, sliding.contacts()).failure, StepFailure::none);
  const double a = g * (std::sin(angle) - 0.2 * std::cos(angle));
  EXPECT_NEAR(a, 3.205858158, 1e-9);
  EXPECT_NEAR(sliding.world.velocity(sliding.body).x() / 0.5, a, 1e-6 * a);
  EXPECT_NEAR(sliding.world.state(sliding.body).p_W.x() / 0.125, a, 1e-6 * a);
  for (const double off : {-1e-6, 1e-6}) {  // friction of tan(30 deg) = 0.577350 is what it takes to stick
    OnAPlane scene(2.0, 0.2, std::tan(angle) + off, gravity, kZero);
    for (int i = 0; i < 500; ++i)
      ASSERT_EQ(scene.world.step(1e-3, scene.contacts()).failure, StepFailure::none);
    const double v = scene.world.velocity(scene.body).x();
    if (off > 0.0) {
      EXPECT_LT(std::abs(v), 1e-9);
    } else {
      EXPECT_NEAR(v, 0.5 * g * 1e-6 * std::cos(angle), 1e-9);
    }
  }
}

TEST(ClosedForm, ACubeThatFallsBouncesInTimeAndHeight) {
  // From 0.1 m with e = 0.5: arrives after sqrt(2 h / g), bounces to e^2 h.
  const double g = 9.81, drop = 0.1;
  const RigidBody cube(box_inertia(2.0, {0.2, 0.2, 0.2}), "cube");
  DynamicsWorld world({.gravity_W = {0, 0, -g}});
  const auto body = world.add_body(cube, cube.state(at({0, 0, 0.1 + drop}), kZero, kZero));
  double highest = 0.0;
  bool has_bounced = false;
  for (int i = 0; i < 280; ++i) {
    std::array<Contact, 4> contacts;
    for (unsigned k = 0; k < 4; ++k) {
      const Vector3 corner((k & 1) != 0 ? 0.1 : -0.1, (k & 2) != 0 ? 0.1 : -0.1, -0.1);
      contacts[k] = touch(Mover::ground(), Mover::of_body(body), Vector3::UnitZ(),
                          touchstone::transform(world.pose(body), corner), 0.5, 0.5);
      contacts[k].p_A_W.z() = 0.0;
    }
    ASSERT_EQ(world.step(1e-3, contacts).failure, StepFailure::none);
    has_bounced = has_bounced || world.velocity(body).z() > 0.0;
    if (has_bounced) highest = std::max(highest, world.state(body).p_W.z() - 0.1);
  }
  EXPECT_NEAR(highest, 0.25 * drop, 0.5 * g * 0.5e-3 * 0.5e-3 + 1e-9);  // seen at whole steps
}

TEST(ClosedForm, ACubeThatTipsOverItsEdgeKeepsItsEnergy) {
  // Its edge stays where it is, so that the ground does no work. Where the laws held for velocities at the
  // middle of a step, each lifted the cube by about m w^4 R^2 h^2 / 2.
  const double side = 0.1, radius = side / std::numbers::sqrt2, start = 0.1, rate = 5.0;
  const RigidBody cube(box_inertia(1.0, {side, side, side}), "cube");
  for (const double h : {1e-3, 1.0 / 240.0}) {
    DynamicsWorld world({.gravity_W = {0, 0, -9.81}});
    Pose X_WB = at({-radius * std::sin(start), 0, radius * std::cos(start)});
    X_WB.R = rotation_about({0, 1, 0}, 0.25 * std::numbers::pi - start);
    const Vector3 w_W(0, rate, 0);
    const auto body = world.add_body(cube, cube.state(X_WB, cross(w_W, X_WB.p), w_W));
    const double energy = world.energy();
    double most = 0.0;
    for (int i = 0; i < static_cast<int>(2.0 * start / rate / h); ++i) {
      std::array<Contact, 2> contacts;
      for (int k = 0; k < 2; ++k) {
        const Vector3 p_B_W =
            touchstone::transform(world.pose(body), Vector3(0.5 * side, (k - 0.5) * side, -0.5 * side));
        contacts[k] = touch(Mover::ground(), Mover::of_body(body), Vector3::UnitZ(), p_B_W, 1.0);
        contacts[k].p_A_W.z() = 0.0;
      }
      ASSERT_EQ(world.step(h, contacts).failure, StepFailure::none);
      most = std::max(most, std::abs(world.energy() - energy));
    }
    const Vector3 p = world.pose(body).p;
    std::printf("tips by %.4f s: energy off by %.1e J, radius by %.1e m\n", h, most,
                std::hypot(p.x(), p.z()) - radius);
    EXPECT_LT(most, 0.1 * h * h) << h;
    EXPECT_NEAR(std::hypot(p.x(), p.z()), radius, 1e-6) << h;
  }
}

TEST(ClosedForm, LightCubeUnderAHeavyOne) {
  const double g = 9.81;
  // A gram under a tonne.
  const RigidBody light(box_inertia(1e-3, {0.2, 0.2, 0.2}), "light"),
      heavy(box_inertia(1e3, {0.2, 0.2, 0.2}), "heavy");
  DynamicsWorld world({.gravity_W = {0, 0, -g}});
  const auto a = world.add_body(light, light.state(at({0, 0, 0.1}), kZero, kZero));
  const auto b = world.add_body(heavy, heavy.state(at({0, 0, 0.3}), kZero, kZero));
  double worst = 0.0, residual = 0.0;
  std::array<ContactForce, 8> forces;
  for (int i = 0; i < 1000; ++i) {
    // Contacts at the corners: on the ground, and of the two.
    std::array<Contact, 8> contacts;
    for (unsigned k = 0; k < 4; ++k) {
      const Vector3 below((k & 1) != 0 ? 0.1 : -0.1, (k & 2) != 0 ? 0.1 : -0.1, -0.1),
          above(below.x(), below.y(), 0.1);
      contacts[k] = touch(Mover::ground(), Mover::of_body(a), Vector3::UnitZ(),
                          touchstone::transform(world.pose(a), below), 0.5);
      contacts[k].p_A_W.z() = 0.0;
      contacts[4 + k] = touch(Mover::of_body(a), Mover::of_body(b), Vector3::UnitZ(),
                              touchstone::transform(world.pose(b), below), 0.5);
      contacts[4 + k].p_A_W = touchstone::transform(world.pose(a), above);
      contacts[k].key = k + 1, contacts[4 + k].key = k + 5;
    }
    // Nothing moves.
    const StepReport report = world.step(1e-3, contacts, forces);
    ASSERT_EQ(report.failure, StepFailure::none);
    residual = std::max(residual, report.worst_residual);
    worst = std::max(worst, std::abs(world.state(a).p_W.z() - 0.1));
  }
  // The ground carries both.
  double load = 0.0;
  for (std::size_t k = 0; k < 4; ++k) load += forces[k].force_W.z();
  std::printf("light cube: %.1e m off, residual %.1e m/s\n", worst, residual);
  EXPECT_LT(worst, 3e-11);                              // ten times the most that it has come to
  EXPECT_NEAR(load, 1000.001 * g, 1e3 * 1e-10 / 1e-3);  // mass times the solver's tolerance over the step
}

}  // namespace

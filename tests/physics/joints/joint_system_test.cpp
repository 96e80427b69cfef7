// Bodies held together by joints, without contacts: against arms in joint values and closed forms.

#include "touchstone/physics/joints/joint_system.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/at.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone::physics {
namespace {

const Vector3 kZero = Vector3::Zero();
const Vector3 kGravity(0, 0, -9.81);

/// z of the frame is y of the world.
Matrix3 about_y() { return rotation_about(Vector3(Vector3::UnitX()), -0.5 * 3.141592653589793); }

/// Bodies and joints with lives of their own.
struct Linkage {
  std::vector<std::unique_ptr<RigidBody>> owned;
  std::vector<std::unique_ptr<BodyJoint>> held;
  JointSystem system;

  std::uint32_t add(double mass, const Vector3& size, const Pose& X, const Vector3& v = kZero,
                    const Vector3& w = kZero) {
    owned.push_back(std::make_unique<RigidBody>(box_inertia(mass, size), "body"));
    system.bodies.push_back({owned.back().get(), owned.back()->state(X, v, w)});
    return static_cast<std::uint32_t>(system.bodies.size() - 1);
  }
  Pose pose(std::uint32_t body) const { return owned[body]->pose(system.bodies[body].state); }
  Pose pose(const JointSystem::Side& side) const {
    return side.kind == JointSystem::Side::Kind::body ? pose(side.index) : Pose{};
  }
  static JointSystem::Side body(std::uint32_t index) { return {JointSystem::Side::Kind::body, index, 0}; }
  /// At a frame of the world, as all stand.
  void join(BodyJointKind kind, const JointSystem::Side& a, const JointSystem::Side& b, const Pose& X_WJ) {
    held.push_back(std::make_unique<BodyJoint>(
        BodyJoint{kind, compose(inverse(pose(a)), X_WJ), compose(inverse(pose(b)), X_WJ)}));
    system.joints.push_back({held.back().get(), a, b});
  }
  double energy(const Vector3& gravity) const {
    double sum = 0.0;
    for (const JointSystem::Body& each : system.bodies)
      sum += each.body->kinetic_energy(each.state) - each.body->inertia().mass * dot(gravity, each.state.p_W);
    return sum;
  }
  Vector3 momentum() const {
    Vector3 sum = kZero;
    for (const JointSystem::Body& each : system.bodies) sum += each.state.momentum_W;
    return sum;
  }
  Vector3 angular() const {
    Vector3 sum = kZero;
    for (const JointSystem::Body& each : system.bodies)
      sum += each.state.angular_W + cross(each.state.p_W, each.state.momentum_W);
    return sum;
  }
};

/// Two rods in a row from the origin along x, hinged about y.
Linkage double_pendulum(double first_mass = 2.0, double second_mass = 1.0) {
  Linkage out;
  const auto a = out.add(first_mass, {1, 0.1, 0.1}, at({0.5, 0, 0}));
  const auto b = out.add(second_mass, {0.8, 0.1, 0.1}, at({1.4, 0, 0}));
  out.join(BodyJointKind::hinge, {}, Linkage::body(a), at(kZero, about_y()));
  out.join(BodyJointKind::hinge, Linkage::body(a), Linkage::body(b), at({1, 0, 0}, about_y()));
  return out;
}

Mechanism double_arm() {
  MechanismDescription description{.name = "arm", .links = {{.name = "base"}}, .joints = {}};
  for (const char* name : {"a", "b"}) description.links.push_back({.name = name, .solids = {}});
  for (int i = 0; i < 2; ++i) {
    JointDescription joint;
    joint.name = i == 0 ? "first" : "second";
    joint.kind = JointKind::revolute;
    joint.parent = i == 0 ? "base" : "a";
    joint.child = i == 0 ? "a" : "b";
    joint.X_PJ.p = i == 0 ? kZero : Vector3(1, 0, 0);
    joint.axis_J = Vector3::UnitY();
    description.joints.push_back(joint);
  }
  return Mechanism(description);
}

/// The arm's links are the pendulum's rods.
std::vector<BodyInertia> double_arm_links() {
  std::vector<BodyInertia> links(3);
  links[1] = transform(at({0.5, 0, 0}), box_inertia(2, {1, 0.1, 0.1}));
  links[2] = transform(at({0.4, 0, 0}), box_inertia(1, {0.8, 0.1, 0.1}));
  return links;
}

TEST(JointSystem, ADoublePendulumOfBodiesSwingsAsTheArmOfTheSameLinks) {
  Linkage linkage = double_pendulum();
  const Mechanism arm = double_arm();
  const MechanismDynamics dynamics(arm, double_arm_links());
  auto workspace = dynamics.make_workspace();
  std::vector<double> q{0, 0}, qd{0, 0}, tau{0, 0};
  const double energy = linkage.energy(kGravity);
  double worst = 0.0, worst_error = 0.0;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(linkage.system.fly(1e-3, kGravity));
    worst_error = std::max(worst_error, linkage.system.worst_error());
    linkage.system.pull_together(1.0);
    ASSERT_TRUE(dynamics.step({}, kGravity, tau, 1e-3, q, qd, workspace));
    const Vector3 centre = transform(dynamics.link_pose(2, workspace), Vector3(0.4, 0, 0));
    worst = std::max(worst, norm(centre - linkage.system.bodies[1].state.p_W));
  }
  RecordProperty("way_between", std::to_string(worst));
  std::printf("between the two %.2g m, errors before they are pulled together %.2g m, energy %.2g\n", worst,
              worst_error, linkage.energy(kGravity) - energy);
  EXPECT_LT(worst, 1e-9);
  EXPECT_LT(worst_error, 1e-12);
  EXPECT_NEAR(linkage.energy(kGravity), energy, 1e-9);
}

TEST(JointSystem, APhysicalPendulumKeepsItsPeriodAndPivotForce) {
  // A rod of length l about its end: small swings of 2 pi sqrt(2 l / (3 g)), to 1 + a^2 / 16 of the
  // amplitude.
  Linkage linkage;
  const double l = 1.2, a = 1e-3, mass = 3.0;
  const Matrix3 R = rotation_about(Vector3(Vector3::UnitY()), a);
  const Vector3 size(0.02, 0.02, l);
  const auto rod = linkage.add(mass, size, at(-0.5 * l * Vector3(R.col(2)), R));
  linkage.join(BodyJointKind::hinge, {}, Linkage::body(rod), at(kZero, about_y()));
  const double inertia = mass * (l * l + 0.02 * 0.02) / 12 + 0.25 * mass * l * l;
  const double period =
      2 * 3.141592653589793 * std::sqrt(inertia / (mass * 9.81 * 0.5 * l)) * (1 + a * a / 16);
  // Ten swings, the last crossing of the middle by a straight line.
  const double h = 1e-3;
  double last_x = 0.0, time = 0.0, crossed = 0.0;
  int crossings = 0;
  while (crossings < 21) {
    last_x = linkage.system.bodies[rod].state.p_W.x();
    ASSERT_TRUE(linkage.system.fly(h, kGravity));
    linkage.system.pull_together(1.0);
    time += h;
    const double x = linkage.system.bodies[rod].state.p_W.x();
    if ((x < 0) == (last_x < 0)) continue;
    ++crossings;
    crossed = time - h * x / (x - last_x);
  }
  EXPECT_NEAR(crossed, 10.25 * period, 1e-8);
  EXPECT_NEAR(linkage.system.reactions()[0].impulse_W.z() / h, mass * 9.81, 1e-4);
}

TEST(JointSystem, AFreeChainKeepsItsMomentaAndEnergy) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> draw(-1, 1);
  Linkage linkage;
  for (int i = 0; i < 6; ++i)
    linkage.add(1.0 + i, {0.5, 0.1, 0.2}, at({0.6 * i, 0, 0}), kZero,
                Vector3(draw(random), draw(random), draw(random)));
  const BodyJointKind kinds[] = {BodyJointKind::ball, BodyJointKind::hinge, BodyJointKind::slider,
                                 BodyJointKind::fixed, BodyJointKind::hinge};
  for (std::uint32_t i = 0; i < 5; ++i)
    linkage.join(kinds[i], Linkage::body(i), Linkage::body(i + 1),
                 at({0.6 * i + 0.3, 0, 0}, rotation_about(Vector3(0.6, 0, 0.8), draw(random))));
  for (JointSystem::Body& body : linkage.system.bodies) body.state.angular_W = kZero;
  // Set moving by forces, which leave rates that the joints allow.
  for (JointSystem::Body& body : linkage.system.bodies) {
    body.push_W = 20 * Vector3(draw(random), draw(random), draw(random));
    body.push_moment_W = 2 * Vector3(draw(random), draw(random), draw(random));
  }
  for (int i = 0; i < 300; ++i) {
    ASSERT_TRUE(linkage.system.fly(1e-3, kZero));
    linkage.system.pull_together(1.0);
  }
  for (JointSystem::Body& body : linkage.system.bodies) body.push_W = body.push_moment_W = kZero;
  const Vector3 p0 = linkage.momentum(), L0 = linkage.angular();
  const double energy = linkage.energy(kZero);
  double worst = 0.0;
  for (int i = 0; i < 2000; ++i) {
    ASSERT_TRUE(linkage.system.fly(1e-3, kZero));
    worst = std::max(worst, linkage.system.pull_together(1.0));
  }
  std::printf("momentum %.2g, moment %.2g, energy %.2g of %.2g, error left %.2g\n",
              norm(linkage.momentum() - p0), norm(linkage.angular() - L0), linkage.energy(kZero) - energy,
              energy, worst);
  EXPECT_LT(norm(linkage.momentum() - p0), 1e-14);
  EXPECT_LT(norm(linkage.angular() - L0), 1e-12);
  EXPECT_NEAR(linkage.energy(kZero), energy, 1e-11 * energy);
  EXPECT_LT(worst, 1e-13);
}

TEST(JointSystem, AFourBarLinkageStaysClosed) {
  // Hinges about y give three equations too many: a loop in a plane.
  Linkage linkage;
  const auto crank = linkage.add(1, {0.05, 0.05, 0.3}, at({0, 0, 0.15}));
  const auto coupler = linkage.add(2, {0.8, 0.05, 0.05}, at({0.4, 0, 0.3}));
  const double angle = std::atan2(0.2, 0.3);
  const auto rocker = linkage.add(1.5, {0.05, 0.05, std::hypot(0.2, 0.3)},
                                  at({0.9, 0, 0.15}, rotation_about(Vector3(Vector3::UnitY()), -angle)));
  linkage.join(BodyJointKind::hinge, {}, Linkage::body(crank), at(kZero, about_y()));
  linkage.join(BodyJointKind::hinge, Linkage::body(crank), Linkage::body(coupler),
               at({0, 0, 0.3}, about_y()));
  linkage.join(BodyJointKind::hinge, Linkage::body(coupler), Linkage::body(rocker),
               at({0.8, 0, 0.3}, about_y()));
  linkage.join(BodyJointKind::hinge, {}, Linkage::body(rocker), at({1.0, 0, 0}, about_y()));
  const double energy = linkage.energy(kGravity);
  double worst = 0.0, before = 0.0, travelled = 0.0;
  for (int i = 0; i < 5000; ++i) {
    ASSERT_TRUE(linkage.system.fly(1e-3, kGravity));
    before = std::max(before, linkage.system.worst_error());
    worst = std::max(worst, linkage.system.pull_together(1.0));
    travelled +=
        1e-3 * norm(linkage.system.bodies[crank].body->angular_velocity(linkage.system.bodies[crank].state));
  }
  std::printf("closure %.2g m (before %.2g), energy %.2g, the crank turned %.3g rad\n", worst, before,
              linkage.energy(kGravity) - energy, travelled);
  EXPECT_GT(travelled, 3.0);
  EXPECT_LT(worst, 1e-13);
  EXPECT_NEAR(linkage.energy(kGravity), energy, 1e-8);
}

TEST(JointSystem, ABodyHeldTwiceIsHeldByEqualShares) {
  Linkage linkage;
  const auto beam = linkage.add(10, {2, 0.1, 0.1}, at(kZero));
  linkage.join(BodyJointKind::fixed, {}, Linkage::body(beam), at({-1, 0, 0}));
  linkage.join(BodyJointKind::fixed, {}, Linkage::body(beam), at({1, 0, 0}));
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(linkage.system.fly(1e-3, kGravity));
  double sum = 0.0;
  for (const JointSystem::Reaction& reaction : linkage.system.reactions()) {
    EXPECT_NEAR(reaction.impulse_W.z() / 1e-3, 0.5 * 98.1, 1e-6);
    sum += reaction.impulse_W.z() / 1e-3;
  }
  EXPECT_NEAR(sum, 98.1, 1e-9);
  EXPECT_LT(norm(linkage.pose(beam).p), 1e-15);
}

TEST(JointSystem, MassRatiosOf1e4AreHeldAsTheArmsAre) {
  for (const auto& [light, heavy] : {std::pair(1e-2, 1e2), std::pair(1e2, 1e-2)}) {
    Linkage linkage = double_pendulum(light, heavy);
    const double energy = linkage.energy(kGravity);
    double worst = 0.0, drift = 0.0;
    for (int i = 0; i < 1000; ++i) {
      ASSERT_TRUE(linkage.system.fly(1e-3, kGravity));
      worst = std::max(worst, linkage.system.pull_together(1.0));
      drift = std::max(drift, std::abs(linkage.energy(kGravity) - energy));
    }
    std::printf("masses %g and %g: error %.2g m, energy %.2g J\n", light, heavy, worst, drift);
    EXPECT_LT(worst, 1e-12);
    EXPECT_LT(drift, 1e-5);
  }
}

TEST(JointSystem, HingesThatAreNotAlignedAreMetHalfWayAndSaid) {
  // A door on two hinges a metre apart, one of them 2 cm off where the frame has it.
  Linkage linkage;
  const auto door = linkage.add(10, {1, 0.05, 2}, at({0.5, 0, 0}));
  linkage.join(BodyJointKind::ball, {}, Linkage::body(door), at({0, 0, 0.5}));
  linkage.join(BodyJointKind::ball, {}, Linkage::body(door), at({0, 0, -0.5}));
  linkage.held[1]->X_AJ.p.z() -= 0.02;
  double left = 0.0;
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(linkage.system.fly(1e-3, kZero));
    left = linkage.system.pull_together(1e-3);
  }
  EXPECT_NEAR(left, 0.01, 1e-9);  // half at each
  EXPECT_NEAR(linkage.pose(door).p.z(), -0.01, 1e-9);
  EXPECT_LT(norm(linkage.momentum()), 1e-15);
}

TEST(JointSystem, ALoopThroughAnArmAndABodyHoldsAndAllocatesNothing) {
  // The arm's tip carries a bar that hangs on the ground as well.
  const Mechanism arm = double_arm();
  const MechanismDynamics dynamics(arm, double_arm_links());
  auto workspace = dynamics.make_workspace();
  std::vector<double> q{0, 0.4}, qd{0, 0}, tau{0, 0};
  dynamics.place({}, q, qd, workspace);
  const Vector3 tip = transform(dynamics.link_pose(2, workspace), Vector3(0.8, 0, 0));
  Linkage linkage;
  const auto bar = linkage.add(1.5, {0.1, 0.1, 1}, at(tip + Vector3(0, 0, 0.5)));
  linkage.system.arms.push_back({&dynamics, {}, tau, q, qd, &workspace});
  const JointSystem::Side link{JointSystem::Side::Kind::arm, 0, 2};
  linkage.held.push_back(std::make_unique<BodyJoint>(
      BodyJoint{BodyJointKind::ball, at({0.8, 0, 0}), compose(inverse(linkage.pose(bar)), at(tip))}));
  linkage.system.joints.push_back({linkage.held.back().get(), link, Linkage::body(bar)});
  linkage.join(BodyJointKind::hinge, {}, Linkage::body(bar), at(tip + Vector3(0, 0, 1), about_y()));
  const auto energy = [&] {
    dynamics.place({}, q, qd, workspace);
    return linkage.energy(kGravity) + dynamics.kinetic_energy(workspace) +
           dynamics.potential_energy(kGravity, workspace);
  };
  const double start = energy();
  double worst = 0.0;
  std::uint64_t before = 0;
  for (int i = 0; i < 1000; ++i) {
    if (i == 2) before = allocation_count();
    ASSERT_TRUE(linkage.system.fly(1e-3, kGravity));
    worst = std::max(worst, linkage.system.pull_together(1.0));
  }
  EXPECT_EQ(allocation_count() - before, 0u);
  std::printf("loop %.2g m, energy %.2g J\n", worst, energy() - start);
  EXPECT_LT(worst, 1e-13);
  EXPECT_NEAR(energy(), start, 1e-9);
}

}  // namespace
}  // namespace touchstone::physics

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <array>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/world/arms/arm_fixture.hpp"

// How stiffly a hand holds an arm by its tool, and what it feels. Closed forms: the springs' least energy.

namespace touchstone {
namespace {

/// Slides along x, y and z one on the other, the last with a box of 0.2 m that turns by `X_box`.
MechanismHandle add_gantry(ContactWorld& world, const Pose& X_box) {
  MechanismDescription gantry;
  gantry.name = "gantry";
  gantry.links = {{"base", {}, {}}, {"x", {}, {}}, {"y", {}, {}}};
  gantry.links.push_back({"z", {{"box", Hexahedron::from_size({0.2, 0.2, 0.2}), X_box}}, {}});
  for (int k = 0; k < 3; ++k) {
    JointDescription joint;
    joint.name = joint.child = gantry.links[k + 1].name;
    joint.kind = JointKind::prismatic;
    joint.parent = gantry.links[k].name;
    joint.axis_J = Vector3::Unit(k);
    joint.lower = -5, joint.upper = 5;
    gantry.joints.push_back(joint);
  }
  gantry.base = "base";
  return world.add_mechanism({std::make_shared<const Mechanism>(gantry), {}, {}});
}

// On a slope of 30 deg: d = g - K^-1 n (n . g) / (n . K^-1 n), K of the tool and of the joints in a row.
TEST(ArmHand, AStifferAxisGivesLessAndTheSlopeIsFelt) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  const Pose X_box = add_slope(*world);
  const Vector3 n = X_box.R.col(2);
  const MechanismHandle arm = add_gantry(*world, X_box);
  ArmHandStiffness hand;
  hand.link = "z";
  hand.X_LT = at(0.3, 0.2, 0.4);
  hand.translation = {400, 400, 100};
  hand.joints = {20, 30, 50};
  world->set_hand(arm, hand);
  const Vector3 g(0.0, 0.0, -0.01), K(420, 430, 150);
  FrameReport report;
  for (int frame = 0; frame < 5; ++frame) report = move_joints(*world, arm, {g.x(), g.y(), g.z()});
  const Vector3 K_n = n.cwiseQuotient(K);
  const double force = -dot(n, g) / dot(n, K_n);
  const Vector3 expected = g + force * K_n;
  const std::vector<double> q = joints_of(*world, arm);
  EXPECT_LT(norm(Vector3(q[0], q[1], q[2]) - expected), 5e-6);
  const Vector3 even = g - dot(n, g) * n;
  EXPECT_GT(norm(Vector3(q[0], q[1], q[2]) - even), 1e-3);
  ASSERT_EQ(report.felt.size(), 1u);
  const HandFeel& felt = report.felt[0];
  EXPECT_EQ(felt.object, world->link(arm, "z"));
  EXPECT_LT(norm(felt.force_W - force * n), 1e-3 * force);
  EXPECT_LT(norm(felt.lag_W - (g - Vector3(q[0], q[1], q[2]))), 1e-12);
  EXPECT_LT(norm(felt.turn_lag_W), 1e-12);
  // About the tool: no more than the box's half diagonal off where its centre is pressed.
  const Vector3 at_centre = cross(X_box.p - hand.X_LT.p, force * n);
  EXPECT_LT(norm(felt.moment_W - at_centre), 0.15 * force);
}

/// Two bars along x, the second's end from 3.4 to 3.6 m beside a block in y, commanded to turn into it.
struct TwoBarsAtABlock {
  static constexpr double kBy = 1e-5, kFar = 3.6;
  std::unique_ptr<ContactWorld> world = make_world();
  MechanismHandle arm;

  TwoBarsAtABlock() {
    world->set_default_rule(rule(ContactPolicy::slide));
    world->add({box_tree("block", {0.2, 1, 1}), at(3.5, 0.1 + 0.5 + 0.75 * kGap, 0), true});
    arm = world->add_mechanism({make_arm("arm", 2), {}, {}});
  }
  FrameReport turn() {
    FrameReport report;
    for (int frame = 0; frame < 5; ++frame) report = move_joints(*world, arm, {kBy, 0.0});
    return report;
  }
  double tip() const {
    const std::vector<double> q = joints_of(*world, arm);
    return 4 * q[0] + 2 * q[1];
  }
};

// dq = goal - M^-1 g f, f = g . goal / (g . M^-1 g): g of the block's far corner, M of the joints and the
// tip.
TEST(ArmHand, TheToolIsHeldByAllJoints) {
  const Eigen::Vector2d g(TwoBarsAtABlock::kFar, TwoBarsAtABlock::kFar - 2.0);
  const Eigen::Vector2d goal(TwoBarsAtABlock::kBy, 0.0), across(4.0, 2.0), turn(1.0, 1.0);
  // Stiffness of the tool and of the joints.
  for (const auto& [k, c, w] :
       {std::array{500.0, 500.0, 5.0}, {2000.0, 0.5, 1.0}, {2.0, 4000.0, 1.0}, {300.0, 100.0, 400.0}}) {
    TwoBarsAtABlock scene;
    ArmHandStiffness hand;
    hand.link = "tip";
    hand.translation = {k, k, k}, hand.turning = {c, c, c}, hand.joints = {w, w};
    scene.world->set_hand(scene.arm, hand);
    const FrameReport report = scene.turn();
    // The commanded joints less what the force at the contact moves, by the stiffness in joint space.
    const Eigen::Matrix2d M =
        w * Eigen::Matrix2d::Identity() + k * across * across.transpose() + c * turn * turn.transpose();
    const Eigen::Vector2d M_g = M.inverse() * g;
    const double force = g.dot(goal) / g.dot(M_g);
    const Eigen::Vector2d expected = goal - force * M_g;
    // Joints, force, moment and lag.
    const std::vector<double> q = joints_of(*scene.world, scene.arm);
    const double tolerance = 1e-3 * TwoBarsAtABlock::kBy;
    EXPECT_NEAR(q[0], expected[0], tolerance) << k << " " << c;
    EXPECT_NEAR(q[1], expected[1], tolerance) << k << " " << c;
    ASSERT_EQ(report.felt.size(), 1u);
    const HandFeel& felt = report.felt[0];
    EXPECT_NEAR(felt.force_W.y(), -force, 1e-3 * force);
    EXPECT_NEAR(felt.moment_W.z(), 0.4 * force, 2e-3 * force);  // at 3.6 m, 0.4 before the tip
    EXPECT_NEAR(felt.lag_W.y(), 4 * TwoBarsAtABlock::kBy - scene.tip(), 1e-9);
    EXPECT_NEAR(felt.turn_lag_W.z(), TwoBarsAtABlock::kBy - q[0] - q[1], 1e-12);
  }
}

// A tool that is stiff against translation leaves its place less than one that is stiff against turning.
TEST(ArmHand, TranslationCountsAgainstTurning) {
  const auto tip_lag = [](double k, double c) {
    TwoBarsAtABlock scene;
    ArmHandStiffness hand;
    hand.link = "tip";
    hand.translation = {k, k, k}, hand.turning = {c, c, c}, hand.joints = {1, 1};
    scene.world->set_hand(scene.arm, hand);
    scene.turn();
    return std::abs(4 * TwoBarsAtABlock::kBy - scene.tip());
  };
  EXPECT_LT(tip_lag(1000, 1), 0.2 * tip_lag(1, 1000));
}

// Without one, and once it is taken back, nothing is felt and the bits are the weights'.
TEST(ArmHand, IsTakenBackToTheLastBit) {
  TwoBarsAtABlock plain, other;
  ArmHandStiffness hand;
  hand.link = "tip";
  other.world->set_hand(other.arm, hand);
  other.world->set_hand(other.arm, std::nullopt);
  EXPECT_TRUE(plain.turn().felt.empty());
  EXPECT_TRUE(other.turn().felt.empty());
  EXPECT_EQ(joints_of(*plain.world, plain.arm), joints_of(*other.world, other.arm));
}

TEST(ArmHand, CostsNoAllocation) {
  TwoBarsAtABlock scene;
  ArmHandStiffness hand;
  hand.link = "tip";
  scene.world->set_hand(scene.arm, hand);
  scene.turn();
  const std::vector<double> back{0.0, 0.0}, into{TwoBarsAtABlock::kBy, -1e-5};
  const JointCommand there{scene.arm, into}, home{scene.arm, back};
  const std::size_t before = allocation_count();
  std::size_t felt = 0;
  for (int frame = 0; frame < 20; ++frame)
    felt += scene.world->frame({}, {frame % 2 == 0 ? &there : &home, 1}).felt.size();
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(felt, 5u);
}

TEST(ArmHand, NoJointIsPushedBeyondItsLimits) {
  for (const bool has_hand : {false, true}) {
    for (const double step : {0.5, 0.05, 0.005}) {
      const auto world = make_world();
      world->set_default_rule(rule(ContactPolicy::slide));
      world->add({box_tree("block", {0.2, 1, 1}), at(2.9, 0.61, 0), true});
      MechanismDescription bars = planar_arm("arm", 2);
      bars.joints[1].lower = -0.1, bars.joints[1].upper = 0.1;
      const MechanismHandle arm = world->add_mechanism({std::make_shared<const Mechanism>(bars), {}, {}});
      if (has_hand) world->set_hand(arm, ArmHandStiffness{"tip"});
      double largest = 0.0;
      for (double turn = step; turn <= 0.8; turn += step) {
        move_joints(*world, arm, {turn, 0.0});
        largest = std::max(largest, std::abs(joints_of(*world, arm)[1]));
      }
      EXPECT_LE(largest, 0.1) << has_hand << " " << step;
      EXPECT_GT(largest, 0.09) << has_hand << " " << step;  // it goes as far as that
    }
  }
}

TEST(ArmHand, RefusesWhatIsNoHand) {
  TwoBarsAtABlock scene;
  ArmHandStiffness hand;
  const auto refuses = [&] { EXPECT_THROW(scene.world->set_hand(scene.arm, hand), InputError); };
  refuses();  // no link
  hand.link = "base";
  refuses();  // which no joint moves
  hand.link = "tip", hand.translation.x() = 0.0;
  refuses();
  hand = {"tip"}, hand.turning.y() = 1e9;
  refuses();
  hand = {"tip"}, hand.joints = {1.0};
  refuses();
  hand.joints = {1.0, 1e-9};
  refuses();
  hand = {"tip"}, hand.X_LT.p.x() = std::nan("");
  refuses();
  hand = {"tip"}, hand.X_LT.p.x() = 1e20;  // frames merged
  refuses();
  EXPECT_THROW(scene.world->set_hand(MechanismHandle{}, ArmHandStiffness{"tip"}), InputError);
  EXPECT_TRUE(scene.turn().felt.empty());
}

}  // namespace
}  // namespace touchstone

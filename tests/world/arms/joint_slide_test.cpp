#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "touchstone/contact_core/mechanism/joint_space.hpp"
#include "touchstone/tests/world/arms/arm_fixture.hpp"

// Mechanisms that slide in joint space.

namespace touchstone {
namespace {

double least_separation(const FrameReport& report) {
  double least = 1.0;
  for (const ContactEvent& event : report.events) least = std::min(least, event.geometry.separation);
  return least;
}

double distance(const ContactWorld& world, MechanismHandle arm) {
  double sum = 0.0;
  for (std::size_t k = 0; k < world.joint_values(arm).size(); ++k) {
    const double left = world.commanded_joints(arm)[k] - world.joint_values(arm)[k];
    sum += left * left;
  }
  return std::sqrt(sum);
}

// Two bars under a wall at y = 0.5: both joints are commanded to turn on. The one constraint is that the
// end's corner stays below the wall: 2 sin a + 2 sin(a + b) + 0.1 cos(a + b) <= 0.5, and that bar 1's does.
// The arm ends at the point of that boundary that is closest to the command.
TEST(JointSlide, EndsClosestToTheCommand) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  world->add({box_tree("wall", {40, 1, 4}), at(0, 1.0, 0), true});
  const MechanismHandle arm = world->add_mechanism({make_arm("arm", 2), {}, {0, -0.3}});
  FrameReport report;
  for (int frame = 0; frame < 40; ++frame) report = move_joints(*world, arm, {0.15, 0.3});
  const double a = world->joint_values(arm)[0], b = world->joint_values(arm)[1];
  const auto height = [](double x, double y) {
    return 2 * std::sin(x) + 2 * std::sin(x + y) + 0.1 * std::cos(x + y);
  };
  EXPECT_LE(height(a, b), 0.5);
  EXPECT_NEAR(height(a, b), 0.5, 2 * kGap);
  // Lagrange: the way that is left is along the constraint's gradient.
  const double db = 2 * std::cos(a + b) - 0.1 * std::sin(a + b), da = 2 * std::cos(a) + db;
  const double left_a = 0.15 - a, left_b = 0.3 - b;
  std::printf("ends at %.9f %.9f, %.9f left\n", a, b, distance(*world, arm));
  EXPECT_NEAR(left_a * db - left_b * da, 0, 1e-3 * std::hypot(left_a, left_b) * std::hypot(da, db));
  EXPECT_GE(least_separation(report), 0.25 * kGap);
}

// The shoulder drives the end against the wall while the elbow is commanded to give way.
TEST(JointSlide, FollowsTheWallWithoutSticking) {
  // An arm of three joints turns into a wall.
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  world->add({box_tree("wall", {40, 1, 4}), at(0, 1.0, 0), true});
  const MechanismHandle arm = world->add_mechanism({make_arm("arm", 3), {}, {0.05, 0, -0.1}});
  int slid = 0, stuck = 0;
  std::uint32_t limits = 0, steps = 0;
  std::uint64_t queries = 0;
  double worst = 1.0;
  // It slides along in each frame from the contact on.
  for (int frame = 1; frame <= 100; ++frame) {
    const double before = world->joint_values(arm)[0];
    const FrameReport report = move_joints(*world, arm, {0.05 + 0.004 * frame, 0, -0.1});
    slid += report.slide_steps > 0;
    steps += report.slide_steps;
    stuck += report.slide_steps > 0 && frame < 40 && world->joint_values(arm)[0] - before < 1e-4;
    limits += report.iteration_limits;
    queries = std::max(queries, report.queries);
    for (const ContactEvent& event : report.events) worst = std::min(worst, event.geometry.separation);
  }
  // Where it ends.
  const auto q = world->joint_values(arm);
  std::printf(
      "slid %d frames in %u sub-steps, ends at %.4f %.4f %.4f, least separation %.3f g, worst %llu queries\n",
      slid, steps, q[0], q[1], q[2], worst / kGap, static_cast<unsigned long long>(queries));
  EXPECT_GT(slid, 50);
  EXPECT_LT(steps, 1.2 * slid);  // others would only come down from where bends were cleared
  EXPECT_EQ(stuck, 0);
  EXPECT_EQ(limits, 0u);
  EXPECT_GE(worst, 0.25 * kGap);
}

// Weights decide which joints yield: the heavy one keeps to its command.
TEST(JointSlide, WeightsDecideWhichJointGivesWay) {
  double left[2][2];
  for (int heavy = 0; heavy < 2; ++heavy) {
    const auto world = make_world();
    world->set_default_rule(rule(ContactPolicy::slide));
    world->add({box_tree("wall", {40, 1, 4}), at(0, 1.0, 0), true});
    std::vector<double> weights(2, 1.0);
    weights[heavy] = 100.0;
    const MechanismHandle arm = world->add_mechanism({make_arm("arm", 2), {}, {}, {}, weights});
    for (int frame = 0; frame < 60; ++frame) move_joints(*world, arm, {0.12, 0.12});
    for (int k = 0; k < 2; ++k) left[heavy][k] = std::abs(0.12 - world->joint_values(arm)[k]);
  }
  EXPECT_LT(left[0][0], 0.1 * left[0][1]);
  EXPECT_LT(left[1][1], 0.1 * left[1][0]);
}

// Bar 3 pressed onto bar 1 slides along it while the elbow moves.
TEST(JointSlide, SlidesAlongItself) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  const MechanismHandle arm = world->add_mechanism({make_arm("arm", 3), {}, {0, 1.5, 1.0}});
  double worst = 1.0;
  int slid = 0;
  for (int frame = 1; frame <= 80; ++frame) {
    const FrameReport report = move_joints(*world, arm, {0, 1.5, std::min(3.0, 1.0 + 0.05 * frame)});
    slid += report.slide_steps > 0;
    for (const ContactEvent& event : report.events) worst = std::min(worst, event.geometry.separation);
  }
  EXPECT_GT(slid, 3);
  const double before = distance(*world, arm);
  for (int frame = 1; frame <= 80; ++frame) move_joints(*world, arm, {0, 1.5 - 0.002 * frame, 3.0});
  std::printf("slid %d frames; %.4f left, then %.4f; least separation %.3f g\n", slid, before,
              distance(*world, arm), worst / kGap);
  // As the elbow opens, bar 3 comes nearer to where it is commanded to be.
  EXPECT_NEAR(world->joint_values(arm)[1], 1.34, 0.1);
  EXPECT_LT(distance(*world, arm), before - 0.05);
  EXPECT_GE(worst, 0.25 * kGap);
}

/// A path bends by `bend` times the square of the row's length.
class GivenBends final : public JointBends {
 public:
  explicit GivenBends(double bend) : bend_(bend) {}
  void lay(const JointVector& dq) noexcept override { square_ = dq[0] * dq[0] + dq[1] * dq[1]; }
  double most(std::size_t) noexcept override { return bend_ * square_; }
  double bend(std::size_t) noexcept override { return bend_ * square_; }

 private:
  double bend_, square_ = 0.0;
};

// To clear the bends of 0.25 rad the second joint has to go by more than 1 rad, of half of that by 0.1.
TEST(JointSlide, PlansForHalfWhereThatGainsMore) {
  JointRow row;
  row.g[1] = 1.0;
  JointVector goal{};
  goal[0] = 1.0;
  const std::vector<double> weights{1.0, 1.0};
  GivenBends bends(8.0);
  const JointMetric metric{weights, nullptr};
  const JointSlidePlan plan = plan_joint_slide(goal, metric, {&row, 1}, bends);
  JointVector left = goal;
  for (int k = 0; k < 2; ++k) left[k] -= plan.dq[k];
  EXPECT_LT(joint_product(left, left, metric), 0.8);
}

// The distance to the command never grows along what is executed, and every part keeps its gap.
TEST(JointSlide, DistanceNeverGrows) {
  // An arm among boxes.
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  for (int i = 0; i < 12; ++i)
    world->add({box_tree("box " + std::to_string(i), {0.5, 0.5, 0.5}),
                at(5 * std::cos(0.5 * i), 5 * std::sin(0.5 * i), 0), true});
  const MechanismHandle arm = world->add_mechanism({make_arm("arm", 3)});
  double growth = 0.0;
  int slid = 0;
  // Commanded to and fro.
  for (int frame = 1; frame <= 200; ++frame) {
    const std::vector<double> goal = {3.0 * std::sin(0.02 * frame), 1.5 * std::sin(0.05 * frame),
                                      1.5 * std::cos(0.03 * frame)};
    const FrameReport report = move_joints(*world, arm, goal);
    slid += report.slide_steps > 0;
    // Along all that a frame executes, the way left in joint space gets no longer.
    double last = 1e9;
    for (std::size_t part = 0; part < world->executed_parts(); ++part)
      for (int i = 0; i <= 10; ++i) {
        std::array<double, 3> q;
        world->executed_joints(arm, part, 0.1 * i, q);
        double sum = 0.0;
        for (int k = 0; k < 3; ++k) sum += (goal[k] - q[k]) * (goal[k] - q[k]);
        const double now = std::sqrt(sum);
        growth = std::max(growth, now - last);
        last = now;
      }
  }
  std::printf("%d frames slid; largest growth %.3g\n", slid, growth);
  EXPECT_GT(slid, 20);
  EXPECT_LE(growth, 1e-15);
}

}  // namespace
}  // namespace touchstone

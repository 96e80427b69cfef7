#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/world/arms/arm_fixture.hpp"

// Mechanisms as movers of the contact world.

namespace touchstone {
namespace {

/// A wall whose face is the plane y = height, above it.
ObjectHandle add_wall(ContactWorld& world, double height) {
  return world.add({box_tree("wall", {40, 1, 4}), at(0, height + 0.5, 0), true});
}

/// The corner (reach, 0.1) of a straight arm that turns about the origin comes to y = height.
double contact_angle(double reach, double height) {
  return std::asin(height / std::hypot(reach, 0.1)) - std::atan2(0.1, reach);
}

double separation(ContactWorld& world, const FrameReport& report) {
  double least = kInfinity;
  for (const ContactEvent& event : report.events)
    if (event.kind == EventKind::blocked) least = std::min(least, event.geometry.separation);
  static_cast<void>(world);
  return least;
}

TEST(MechanismWorld, AdvancesToTheClosedFormContact) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  add_wall(*world, 0.5);
  const MechanismHandle arm = world->add_mechanism({make_arm("arm", 2)});
  const double angle = contact_angle(4, 0.5);
  const FrameReport report = move_joints(*world, arm, {0.3, 0.0});
  const double reached = world->joint_values(arm)[0];
  EXPECT_EQ(report.blocked_movers, 1u);
  // Never late; and within 2g of the wall, at the speed of the corner across it.
  EXPECT_LE(reached, angle);
  EXPECT_GE(reached, angle - 2 * kGap / 3.9);
  const double at_stop = separation(*world, report);
  EXPECT_GE(at_stop, 0.5 * kGap);
  EXPECT_LE(at_stop, kGap);
  // All links go to the same fraction, and the event names the one that met the wall.
  ASSERT_FALSE(report.events.empty());
  EXPECT_EQ(report.events[0].kind, EventKind::blocked);
  EXPECT_EQ(report.events[0].b, world->link(arm, "2"));
  EXPECT_NEAR(report.events[0].s, angle / 0.3, 1e-8);
}

TEST(MechanismWorld, OneFractionForAllJoints) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  add_wall(*world, 0.5);
  const MechanismHandle arm = world->add_mechanism({make_arm("arm", 2)});
  move_joints(*world, arm, {0.3, -0.2});
  const auto q = world->joint_values(arm);
  EXPECT_LT(q[0], 0.3);
  EXPECT_GT(q[0], 0.1);
  EXPECT_NEAR(q[1] / q[0], -0.2 / 0.3, 1e-14);
  // The corner (2, 0.1) of the second bar, turned by q0 + q1 about the elbow at (2 cos q0, 2 sin q0), or that
  // of the first.
  const double end = 2 * std::sin(q[0]) + 2 * std::sin(q[0] + q[1]) + 0.1 * std::cos(q[0] + q[1]);
  const double elbow = 2 * std::sin(q[0]) + 0.1 * std::cos(q[0]);
  EXPECT_NEAR(std::max(end, elbow), 0.5, 2 * kGap);
}

TEST(MechanismWorld, HoldRejectsTheWholeStep) {
  const auto world = make_world();
  add_wall(*world, 0.5);
  const MechanismHandle arm = world->add_mechanism({make_arm("arm", 2)});
  const FrameReport report = move_joints(*world, arm, {0.3, 0.1});
  EXPECT_EQ(report.blocked_movers, 1u);
  EXPECT_EQ(joints_of(*world, arm), (std::vector<double>{0, 0}));
  EXPECT_EQ(world->commanded_joints(arm)[0], 0.3);
  move_joints(*world, arm, {0.08, 0.01});
  EXPECT_EQ(joints_of(*world, arm), (std::vector<double>{0.08, 0.01}));
}

TEST(MechanismWorld, CueLetsItThroughAndReports) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::cue));
  add_wall(*world, 0.5);
  const MechanismHandle arm = world->add_mechanism({make_arm("arm", 2)});
  const FrameReport report = move_joints(*world, arm, {0.3, 0.0});
  EXPECT_EQ(world->joint_values(arm)[0], 0.3);
  // One bar after the other.
  ASSERT_EQ(kinds(report), (std::vector{EventKind::began, EventKind::began}));
  EXPECT_NEAR(report.events[0].s, contact_angle(2, 0.5) / 0.3, 1e-8);
  EXPECT_NEAR(report.events[1].s, contact_angle(4, 0.5) / 0.3, 1e-8);
}

// The box comes nearer while the arm rests, by less than it may before it is looked at; then the arm turns,
// by less than that, too. Its pairs with the wall, which never moves, say nothing about the box.
TEST(MechanismWorld, MeetsABoxThatCameNearerWhileItRested) {
  for (const bool box_first : {false, true}) {
    const auto world = make_world();
    world->set_default_rule(rule(ContactPolicy::cue));
    const MechanismHandle arm = world->add_mechanism({make_arm("arm", 1)});
    ObjectHandle box;
    const auto add_box = [&] { box = world->add({box_tree("box", {2, 2, 2}), at(1, 1.35, 0)}); };
    if (box_first) add_box();
    world->add({box_tree("wall", {2, 1, 2}), at(1, -0.7, 0), true});
    if (!box_first) add_box();
    // Beside so many objects the pairs of one that moves are found by themselves.
    for (int i = 0; i < 12; ++i)
      world->add({box_tree("far" + std::to_string(i), {1, 1, 1}), at(100 + 10 * i, 0, 0), true});
    world->frame({});
    EXPECT_TRUE(world->frame(std::array{world->move_by(box, {0, -0.2, 0}, {0, 0, 0})}).events.empty());
    for (int i = 0; i < 2; ++i) EXPECT_TRUE(world->frame({}).events.empty());
    // The box is 0.05 m above the bar, whose end rises by 0.06 m.
    EXPECT_EQ(kinds(move_joints(*world, arm, {0.03})), std::vector{EventKind::began}) << box_first;
    EXPECT_EQ(kinds(world->frame(std::array{world->move_by(box, {0, 0.2, 0}, {0, 0, 0})})),
              std::vector{EventKind::ended})
        << box_first;
    EXPECT_EQ(kinds(world->frame(std::array{world->move_by(box, {0, -0.2, 0}, {0, 0, 0})})),
              std::vector{EventKind::began})
        << box_first;
  }
}

// Bars 1 and 3 of an arm that folds: a triangle of sides 2, 2 closes when bar 3 turns onto bar 1.
TEST(MechanismWorld, StopsAtItself) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  const MechanismHandle arm = world->add_mechanism({make_arm("arm", 3), {}, {0, 1.5, 1.0}});
  FrameReport report;
  for (int k = 1; k <= 20; ++k) report = move_joints(*world, arm, {0, 1.5, 1.0 + 0.1 * k});
  EXPECT_EQ(report.blocked_movers, 1u);
  ASSERT_FALSE(report.events.empty());
  EXPECT_EQ(report.events[0].a, world->link(arm, "1"));
  EXPECT_EQ(report.events[0].b, world->link(arm, "3"));
  // Bar 3 starts at E = (2 + 2 cos 1.5, 2 sin 1.5) and turns by q about it from the direction of bar 2; its
  // corner at (2, 0.1), 180 deg on, is at E + R(1.5 + q) (2, 0.1), and meets bar 1's face y = 0.1.
  const double q = world->joint_values(arm)[2];
  EXPECT_LT(q, 3.0);
  const auto height = [&](double angle, double x, double y) {
    return 2 * std::sin(1.5) + x * std::sin(angle) + y * std::cos(angle);
  };
  EXPECT_NEAR(std::min(height(1.5 + q, 2, 0.1), height(1.5 + q, 2, -0.1)), 0.1, 2 * kGap);
  const double at_stop = separation(*world, report);
  EXPECT_GE(at_stop, 0.5 * kGap);
  EXPECT_LE(at_stop, kGap);

  // Folded onto itself it still turns as a whole, without coming nearer.
  for (int k = 1; k <= 10; ++k) {
    const FrameReport turned = move_joints(*world, arm, {0.2 * k, 1.5, q});
    EXPECT_EQ(turned.blocked_movers, 0u) << k;
    EXPECT_EQ(world->joint_values(arm)[0], 0.2 * k);
    ASSERT_EQ(kinds(turned), std::vector{EventKind::persists});
    EXPECT_GE(turned.events[0].geometry.separation, 0.25 * kGap);
  }
}

// 7 bars in a ring never meet where listed as exempt.
TEST(MechanismWorld, ExemptLinksPass) {
  MechanismDescription description = planar_arm("arm", 3);
  description.exempt_pairs.push_back({"1", "3"});
  const auto world = make_world();
  const MechanismHandle arm =
      world->add_mechanism({std::make_shared<const Mechanism>(description), {}, {0, 1.5, 1.0}});
  for (int k = 1; k <= 20; ++k)
    EXPECT_EQ(move_joints(*world, arm, {0, 1.5, 1.0 + 0.1 * k}).blocked_movers, 0u);
  EXPECT_EQ(world->joint_values(arm)[2], 3.0);
}

TEST(MechanismWorld, CarriesALatchedBox) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  add_wall(*world, 0.5);
  const MechanismHandle arm = world->add_mechanism({make_arm("arm", 2)});
  const ObjectHandle box = world->add({box_tree("box", {0.4, 0.4, 0.2}), at(4.21, 0, 0)});
  const ObjectHandle far = world->add({box_tree("lid", {0.2, 0.2, 0.2}), at(4.52, 0, 0)});
  world->latch(world->link(arm, "2"), box);
  world->latch(box, far);
  move_joints(*world, arm, {-0.4, 0.3});
  const Pose carried = compose(world->link_poses(arm)[2], at(2.21, 0, 0));
  EXPECT_LE(norm(world->actual_pose(box).p - carried.p), 1e-14);
  EXPECT_LE((world->actual_pose(box).R - carried.R).cwiseAbs().maxCoeff(), 1e-15);
  move_joints(*world, arm, {0, 0});
  // Of the two the box's corner (4.41, 0.2) meets the wall first.
  const double angle = std::asin(0.5 / std::hypot(4.41, 0.2)) - std::atan2(0.2, 4.41);
  const FrameReport report = move_joints(*world, arm, {0.3, 0.0});
  EXPECT_LE(world->joint_values(arm)[0], angle);
  EXPECT_GE(world->joint_values(arm)[0], angle - 2 * kGap / 4);
  ASSERT_FALSE(report.events.empty());
  EXPECT_EQ(report.events[0].b, box);
  EXPECT_THROW(world->remove_mechanism(arm), InputError);

  world->unlatch(box);
  const Pose left = world->actual_pose(box);
  move_joints(*world, arm, {0.0, 0.0});
  EXPECT_EQ(world->actual_pose(box).p, left.p);
  world->remove_mechanism(arm);
  EXPECT_FALSE(world->is_alive(arm));
  EXPECT_THROW(world->find("arm.1"), InputError);
  EXPECT_THROW(world->joint_values(arm), InputError);
  EXPECT_EQ(kinds(move_joints(*world, arm, {0, 0})).front(), EventKind::refused);
}

// An object latched to one end meets a link of the same arm.
TEST(MechanismWorld, CarriedBoxMeetsTheArm) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  const MechanismHandle arm = world->add_mechanism({make_arm("arm", 2), {}, {0, 1.0}});
  const Pose X = compose(world->link_poses(arm)[2], at(1, 0.31, 0));
  const ObjectHandle box = world->add({box_tree("box", {0.4, 0.4, 0.2}), X});
  world->latch(world->link(arm, "2"), box);
  FrameReport report;
  for (int k = 1; k <= 40 && report.blocked_movers == 0; ++k)
    report = move_joints(*world, arm, {0, 1.0 + 0.05 * k});
  EXPECT_EQ(report.blocked_movers, 1u);
  EXPECT_EQ(report.events[0].a, world->link(arm, "1"));
  EXPECT_EQ(report.events[0].b, box);
  // The box's corner (0.8, 0.51) in bar 2's frame comes down on y = 0.1.
  const double q = world->joint_values(arm)[1];
  EXPECT_NEAR(0.8 * std::sin(q) + 0.51 * std::cos(q), 0.1, 2 * kGap);
}

TEST(MechanismWorld, HeldByTheOtherEndItMovesTheSame) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  const MechanismHandle from_base = world->add_mechanism({make_arm("arm", 3)});
  const MechanismHandle from_tip = world->add_mechanism({make_arm("other", 3, "tip"), at(6, 0, 5)});
  const std::vector<double> q = {0.4, -0.3, 0.2};
  const std::array commands{JointCommand{from_base, q}, JointCommand{from_tip, q}};
  world->frame({}, commands);
  const auto X = world->link_poses(from_base), Y = world->link_poses(from_tip);
  EXPECT_EQ(Y[4].p, Vector3(6, 0, 5));
  EXPECT_EQ(joints_of(*world, from_tip), q);
  for (int link = 0; link < 5; ++link) {
    const Pose seen = compose(inverse(X[4]), X[link]), other = compose(inverse(Y[4]), Y[link]);
    EXPECT_LE(norm(seen.p - other.p), 1e-14);
  }
}

// Two arms of one world, mirrored about x = 0, close on each other.
TEST(MechanismWorld, TwoArmsStopEachOther) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  Pose left = at(-1, 0, 0), right = at(1, 0, 0);
  left.R = right.R = rotation_about(Vector3::UnitZ(), 90 * kDegree);
  const MechanismHandle a = world->add_mechanism({make_arm("left", 2), left});
  const MechanismHandle b = world->add_mechanism({make_arm("right", 2), right});
  const std::vector<double> in = {-0.4, 0.0}, out = {0.4, 0.0};
  const std::array commands{JointCommand{a, in}, JointCommand{b, out}};
  const FrameReport report = world->frame({}, commands);
  EXPECT_EQ(report.blocked_movers, 2u);
  const double q = world->joint_values(b)[0];
  EXPECT_NEAR(world->joint_values(a)[0], -q, 1e-9);
  // The corner (4, 0.1) comes to x = 0.
  EXPECT_NEAR(1 - 4 * std::sin(q) - 0.1 * std::cos(q), 0, 2 * kGap);
}

TEST(MechanismWorld, RefusesAndClamps) {
  const auto world = make_world();
  const MechanismHandle arm = world->add_mechanism({make_arm("arm", 2)});
  move_joints(*world, arm, {0.1, 0.2});
  const std::vector<double> good = {0.1, 0.2};
  for (const std::vector<double>& bad :
       {std::vector<double>{0.1, std::nan("")}, {0.1}, {0.1, 0.2, 0.3}, {kInfinity, 0.0}}) {
    const FrameReport report = move_joints(*world, arm, bad);
    EXPECT_EQ(kinds(report), std::vector{EventKind::refused});
    EXPECT_EQ(report.events[0].a, world->link(arm, "1"));
    EXPECT_EQ(joints_of(*world, arm), good);
    EXPECT_EQ(world->commanded_joints(arm)[1], 0.2);
  }
  const FrameReport report = move_joints(*world, arm, {0.1, -9});
  EXPECT_EQ(kinds(report).front(), EventKind::at_limit);
  EXPECT_EQ(report.events[0].a, world->link(arm, "2"));
  EXPECT_EQ(world->commanded_joints(arm)[1], -4.0);
  world->reset();
  EXPECT_EQ(joints_of(*world, arm), (std::vector<double>{0, 0}));
  EXPECT_EQ(world->actual_pose(world->link(arm, "2")).p, Vector3(2, 0, 0));
  // A link takes no command, cannot be carried or removed alone.
  const ObjectHandle link = world->link(arm, "1");
  const std::array push{world->move_by(link, {1, 0, 0}, {0, 0, 0})};
  EXPECT_EQ(kinds(world->frame(push)).front(), EventKind::refused);
  const ObjectHandle box = world->add({box_tree("box", {1, 1, 1}), at(0, 0, 9)});
  EXPECT_THROW(world->latch(box, link), InputError);
  EXPECT_THROW(world->remove(link), InputError);
  EXPECT_THROW(world->link(arm, "tip"), InputError);
  EXPECT_THROW(world->link(arm, "none"), InputError);
  EXPECT_THROW(world->joint_values({}), InputError);
  EXPECT_THROW(world->add_mechanism({make_arm("arm", 2)}), InputError);
  EXPECT_THROW(world->add_mechanism({nullptr}), InputError);
  EXPECT_THROW(world->add_mechanism({make_arm("b", 2), {}, {0}}), InputError);
  EXPECT_THROW(world->add_mechanism({make_arm("b", 2), {}, {0, 9}}), InputError);
  EXPECT_THROW(world->add_mechanism({make_arm("b", 2), {}, {}, {}, {1, 0}}), InputError);
  EXPECT_NO_THROW(world->add_mechanism({make_arm("b", 2), at(0, 0, 20)}));
}

// A mechanism is switched as all its links: the wall lets it through, and stops it again.
TEST(MechanismWorld, IsSwitchedAsAWholeByItsHandle) {
  for (const bool on_again : {false, true}) {
    const auto world = make_world();
    world->set_default_rule(rule(ContactPolicy::advance));
    add_wall(*world, 0.5);
    const MechanismHandle arm = world->add_mechanism({make_arm("arm", 3)});
    world->select(SelectionChange::of(arm, false));
    if (on_again) world->select(SelectionChange::of(arm, true));
    const FrameReport report = move_joints(*world, arm, {1.5, 0, 0});
    EXPECT_EQ(report.blocked_movers, on_again ? 1u : 0u);
    EXPECT_EQ(report.selections.size(), on_again ? 2u : 1u);
    world->remove_mechanism(arm);
    world->select(SelectionChange::of(arm, false));
    EXPECT_EQ(world->frame({}).refused_selections.size(), 1u);
  }
}

// The same set-up, commands and selections end in the same bits.
TEST(MechanismWorld, Replays) {
  std::vector<std::vector<double>> ends;
  std::vector<SelectionRecord> record;
  for (int run = 0; run < 2; ++run) {
    const auto world = make_world();
    world->set_default_rule(rule(ContactPolicy::slide));
    const ObjectHandle wall = add_wall(*world, 0.5);
    const MechanismHandle arm = world->add_mechanism({make_arm("arm", 3)});
    for (int frame = 0; frame < 60; ++frame) {
      if (run == 0 && frame == 20) world->select(SelectionChange::of(world->link(arm, "3"), wall, false));
      if (run == 1)
        for (const SelectionRecord& entry : record)
          if (entry.frame == static_cast<std::uint64_t>(frame)) world->select(entry.change);
      move_joints(*world, arm, {0.01 * frame, 0.02 * std::sin(0.3 * frame), -0.01 * frame});
    }
    if (run == 0) record.assign(world->selection_record().begin(), world->selection_record().end());
    ends.push_back(joints_of(*world, arm));
  }
  EXPECT_EQ(record.size(), 1u);
  EXPECT_EQ(ends[0], ends[1]);
}

}  // namespace
}  // namespace touchstone

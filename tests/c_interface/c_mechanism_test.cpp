#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "touchstone/adapters/c_interface/corners.hpp"
#include "touchstone/adapters/c_interface/touchstone.h"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/mechanism/arms/bundled_arms.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/tests/c_interface/owned_world.hpp"
#include "touchstone/tests/support/at.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/random.hpp"

namespace touchstone {
namespace {

using testing::HasSubstr;

OwnedWorld made_world() {
  touchstone_world* made = nullptr;
  EXPECT_EQ(touchstone_create_world("native", 0.0, &made), TOUCHSTONE_OK) << touchstone_error();
  return OwnedWorld(made);
}

std::vector<double> joints_of(const OwnedWorld& world, touchstone_mechanism arm) {
  const double* values = nullptr;
  size_t count = 0;
  EXPECT_EQ(touchstone_get_joints(world.get(), arm, &values, &count), TOUCHSTONE_OK) << touchstone_error();
  return {values, values + count};
}

touchstone_report moved(const OwnedWorld& world, touchstone_mechanism arm, const std::vector<double>& goal) {
  const touchstone_joint_command command{arm, goal.data(), goal.size()};
  touchstone_report report{};
  EXPECT_EQ(touchstone_frame_with_joints(world.get(), nullptr, 0, &command, 1, &report), TOUCHSTONE_OK)
      << touchstone_error();
  return report;
}

/// A post, a beam that turns about it and a slide on the beam, through C.
struct Crane {
  std::vector<double> post = corners(Hexahedron::from_size({0.2, 0.2, 1.0}));
  std::vector<double> beam = corners(Hexahedron::from_size({2.0, 0.1, 0.1}));
  std::vector<double> hook = corners(Hexahedron::from_size({0.1, 0.1, 0.1}));
  std::vector<touchstone_link> links;
  std::vector<touchstone_joint> joints;
  touchstone_mechanism_description description;

  Crane() {
    links = {{"post", post.data(), 1}, {"beam", beam.data(), 1}, {"hook", hook.data(), 1}};
    joints = {
        {"turn",
         "post",
         "beam",
         TOUCHSTONE_REVOLUTE,
         0,
         c_pose(at(0, 0, 0.6)),
         {0, 0, 1},
         -kInfinity,
         kInfinity},
        {"run", "beam", "hook", TOUCHSTONE_PRISMATIC, 0, c_pose(at(0.5, 0, -0.2)), {1, 0, 0}, -0.1, 0.4}};
    description = {"crane", links.data(), links.size(), joints.data(), joints.size(), nullptr};
  }
  static std::vector<double> corners(const Hexahedron& solid) { return c_interface::corners_of({&solid, 1}); }
};

/// A cube that stops the crane's beam.
void put_wall(const OwnedWorld& world, const Crane& crane, touchstone_mechanism arm, touchstone_object& wall,
              touchstone_object& beam) {
  const touchstone_pose aside = c_pose(at(0, 1.0, 0.6));
  ASSERT_EQ(touchstone_add_object(world.get(), "wall", crane.hook.data(), 1, &aside, 1, &wall),
            TOUCHSTONE_OK);
  ASSERT_EQ(touchstone_get_link(world.get(), arm, "beam", &beam), TOUCHSTONE_OK);
  ASSERT_EQ(touchstone_set_policy(world.get(), beam, wall, TOUCHSTONE_ADVANCE, 0.0), TOUCHSTONE_OK);
}

TEST(CMechanism, ACraneStopsAtAWallAndAtItsLimit) {
  const OwnedWorld world = made_world();
  const Crane crane;
  const touchstone_pose origin = c_pose(Pose{});
  touchstone_mechanism arm = 0;
  ASSERT_EQ(touchstone_add_mechanism(world.get(), &crane.description, &origin, nullptr, 0, &arm),
            TOUCHSTONE_OK)
      << touchstone_error();
  touchstone_object wall = 0, beam = 0;
  ASSERT_NO_FATAL_FAILURE(put_wall(world, crane, arm, wall, beam));
  const touchstone_report report = moved(world, arm, {1.5, 0.9});
  // The beam is 0.1 m wide and the wall a cube of 0.1 m at y = 1: they meet at the cube's corner (0.05,
  // 0.95).
  const double turn = joints_of(world, arm)[0];
  EXPECT_NEAR(0.95 * std::cos(turn) - 0.05 * std::sin(turn), 0.05, 1e-6);
  EXPECT_NEAR(joints_of(world, arm)[1] / turn, 0.4 / 1.5, 1e-12);  // evenly, to the limit of 0.4
  bool is_blocked = false, is_at_limit = false;
  for (size_t e = 0; e < report.event_count; ++e) {
    is_blocked |= report.events[e].kind == TOUCHSTONE_BLOCKED && report.events[e].a == beam &&
                  report.events[e].b == wall;
    is_at_limit |= report.events[e].kind == TOUCHSTONE_AT_LIMIT;
  }
  EXPECT_TRUE(is_blocked);
  EXPECT_TRUE(is_at_limit);
  EXPECT_EQ(report.blocked_movers, 1u);
  ASSERT_EQ(touchstone_remove_mechanism(world.get(), arm), TOUCHSTONE_OK);
  const double* values = nullptr;
  size_t count = 0;
  EXPECT_EQ(touchstone_get_joints(world.get(), arm, &values, &count), TOUCHSTONE_BAD_INPUT);
}

/// A slab at this pose in both worlds, on which all slides.
void add_floor(ContactWorld& cpp, const OwnedWorld& world, const Pose& X_WO) {
  const Hexahedron slab = Hexahedron::from_size({60, 60, 0.5});
  const auto tree =
      std::make_shared<const HexahedronTree>(std::vector<PlacedHexahedron>{{"0", slab, Pose{}}}, "slab");
  cpp.add({tree, X_WO, true, {}});
  const std::vector<double> corners = c_interface::corners_of({&slab, 1});
  const touchstone_pose c_X_WO = c_pose(X_WO);
  touchstone_object c_slab = 0;
  ASSERT_EQ(touchstone_add_object(world.get(), "slab", corners.data(), 1, &c_X_WO, 1, &c_slab),
            TOUCHSTONE_OK);
  PairRule slide;
  slide.policy = ContactPolicy::slide;
  slide.warn_distance = 0.0;
  cpp.set_default_rule(slide);
  ASSERT_EQ(
      touchstone_set_policy(world.get(), TOUCHSTONE_NO_OBJECT, TOUCHSTONE_NO_OBJECT, TOUCHSTONE_SLIDE, 0.0),
      TOUCHSTONE_OK);
}

/// The C world's hands feel what C++'s do, bit for bit.
void expect_same_feels(const OwnedWorld& world, std::span<const HandFeel> feels) {
  const touchstone_feel* felt = nullptr;
  size_t hands = 0;
  ASSERT_EQ(touchstone_get_feels(world.get(), &felt, &hands), TOUCHSTONE_OK);
  ASSERT_EQ(hands, feels.size());
  for (size_t i = 0; i < hands; ++i) {
    ASSERT_EQ(std::memcmp(felt[i].lag_W, feels[i].lag_W.data(), sizeof felt[i].lag_W), 0);
    ASSERT_EQ(std::memcmp(felt[i].force_W, feels[i].force_W.data(), sizeof felt[i].force_W), 0);
    ASSERT_EQ(std::memcmp(felt[i].moment_W, feels[i].moment_W.data(), sizeof felt[i].moment_W), 0);
  }
}

TEST(CMechanism, ARoundedBeamStopsAtItsRadius) {
  const OwnedWorld world = made_world();
  Crane crane;
  crane.beam = Crane::corners(Hexahedron::rounded_box({2.0, 0.0, 0.0}, 0.05));
  crane.links[1].corners = crane.beam.data();
  const double radius = 0.05;
  const std::array<const double*, 3> radii = {nullptr, &radius, nullptr};
  const touchstone_pose origin = c_pose(Pose{});
  touchstone_mechanism arm = 0;
  ASSERT_EQ(touchstone_add_rounded_mechanism(world.get(), &crane.description, radii.data(), nullptr, &origin,
                                             nullptr, 0, &arm),
            TOUCHSTONE_OK)
      << touchstone_error();
  touchstone_object wall = 0, beam = 0;
  ASSERT_NO_FATAL_FAILURE(put_wall(world, crane, arm, wall, beam));
  EXPECT_EQ(moved(world, arm, {1.5, 0.0}).blocked_movers, 1u);
  // The cube's corner at (0.05, 0.95) is the radius away from the beam's middle line, not from its rounded
  // end: 0.951 m along a line of 1 m.
  const double turn = joints_of(world, arm)[0];
  EXPECT_NEAR(0.95 * std::cos(turn) - 0.05 * std::sin(turn), 0.05, 1e-6);
}

TEST(CMechanism, ABundledArmSlidesAsThroughCpp) {
  // The same arm in both worlds.
  BackendRegistry registry;
  register_core(registry);
  ContactWorld cpp(make_native(), registry.make_broadphase("native"), kDefaultGap);
  const OwnedWorld world = made_world();
  MechanismDescription description = make_bundled_arm("ssrms");
  description.name = "arm";
  const std::string link = description.links.back().name;
  const MechanismHandle cpp_arm = cpp.add_mechanism({std::make_shared<const Mechanism>(description), Pose{}});
  const touchstone_pose origin = c_pose(Pose{});
  touchstone_mechanism arm = 0;
  ASSERT_EQ(touchstone_add_arm(world.get(), "arm", "ssrms", &origin, nullptr, 0, &arm), TOUCHSTONE_OK)
      << touchstone_error();
  ASSERT_TRUE(std::ranges::equal(joints_of(world, arm), cpp.joint_values(cpp_arm)));
  // The same floor to slide on, and the same hand.
  double lowest = 0.0;
  for (const Pose& X : cpp.link_poses(cpp_arm)) lowest = std::min(lowest, X.p.z());
  add_floor(cpp, world, at(0, 0, lowest - 2.0));
  ArmHandStiffness hand;
  hand.link = link;
  hand.X_LT = at(0.1, 0.2, 0.3);
  hand.turning = {50, 60, 70};
  cpp.set_hand(cpp_arm, hand);
  const touchstone_arm_hand c_hand{
      link.c_str(), c_pose(at(0.1, 0.2, 0.3)), {500, 500, 500}, {50, 60, 70}, nullptr, 0};
  ASSERT_EQ(touchstone_set_arm_hand(world.get(), arm, &c_hand), TOUCHSTONE_OK) << touchstone_error();
  // Random commands give the same poses, counts and forces.
  Random random(2131);
  std::vector<double> goal = joints_of(world, arm);
  std::uint32_t blocked = 0;
  std::size_t all_hands = 0;
  for (int frame = 0; frame < 20; ++frame) {
    for (double& value : goal) value += random.uniform(-0.5, 0.5);
    const JointCommand command{cpp_arm, goal};
    const FrameReport report = cpp.frame({}, {&command, 1});
    const touchstone_report got = moved(world, arm, goal);
    ASSERT_EQ(got.event_count, report.events.size()) << frame;
    ASSERT_EQ(got.queries, report.queries);
    ASSERT_TRUE(std::ranges::equal(joints_of(world, arm), cpp.joint_values(cpp_arm))) << frame;
    expect_same_feels(world, report.felt);
    all_hands += report.felt.size();
    blocked += got.blocked_movers;
  }
  EXPECT_GT(blocked, 0u);
  EXPECT_GT(all_hands, 0u);
}

TEST(CMechanism, FramesDoNotAllocate) {
  const OwnedWorld world = made_world();
  const Crane crane;
  const touchstone_pose origin = c_pose(Pose{});
  touchstone_mechanism arm = 0;
  ASSERT_EQ(touchstone_add_mechanism(world.get(), &crane.description, &origin, nullptr, 0, &arm),
            TOUCHSTONE_OK);
  ASSERT_EQ(touchstone_prepare(world.get()), TOUCHSTONE_OK);
  double goal[2] = {0.0, 0.0};
  const touchstone_joint_command command{arm, goal, 2};
  touchstone_report report;
  const auto step = [&](int frame) {
    goal[0] = 0.1 * frame;
    return touchstone_frame_with_joints(world.get(), nullptr, 0, &command, 1, &report);
  };
  for (int frame = 0; frame < 6; ++frame) ASSERT_EQ(step(frame), TOUCHSTONE_OK);
  const std::size_t before = allocation_count();
  for (int frame = 6; frame < 12; ++frame) ASSERT_EQ(step(frame), TOUCHSTONE_OK);
  EXPECT_EQ(allocation_count(), before);
}

// ---- options

/// The crane on its post, given options; its hook may be drawn in as far as the post.
class Options : public testing::Test {
 protected:
  OwnedWorld world = made_world();
  Crane crane;
  touchstone_pose origin = c_pose(Pose{});
  touchstone_mechanism_options options{};

  Options() {
    crane.joints[1].lower = -0.6;
    crane.joints[1].upper = 1.0;
  }
  touchstone_mechanism add(const std::vector<double>& values, int32_t policy) {
    touchstone_mechanism arm = 0;
    EXPECT_EQ(touchstone_add_mechanism_with(world.get(), &crane.description, &options, &origin, values.data(),
                                            values.size(), &arm),
              TOUCHSTONE_OK)
        << touchstone_error();
    EXPECT_EQ(touchstone_set_policy(world.get(), TOUCHSTONE_NO_OBJECT, TOUCHSTONE_NO_OBJECT, policy, 0.0),
              TOUCHSTONE_OK);
    return arm;
  }
};

TEST_F(Options, LinksThatAreExemptPassThroughEachOther) {
  const touchstone_mechanism checked = add({0, 0}, TOUCHSTONE_ADVANCE);
  moved(world, checked, {0, -0.5});
  EXPECT_NEAR(joints_of(world, checked)[1], -0.35, 1e-6);  // the post is 0.2 m wide, the hook 0.1
  ASSERT_EQ(touchstone_remove_mechanism(world.get(), checked), TOUCHSTONE_OK);

  const touchstone_link_pair pair = {"post/0", "hook"};
  options.exempt = &pair;
  options.exempt_count = 1;
  const touchstone_mechanism exempt = add({0, 0}, TOUCHSTONE_ADVANCE);
  moved(world, exempt, {0, -0.5});
  EXPECT_EQ(joints_of(world, exempt)[1], -0.5);
}

TEST_F(Options, WeightsDecideWhichJointYieldsAsInCpp) {
  const std::vector<double> start = {0.5, 0.0}, goal = {0.5, 0.8}, weights = {100.0, 1.0};
  const Hexahedron wall = Hexahedron::from_size({0.1, 4, 4});
  const Pose X_WWall = at(1.0, 0, 0);
  // Slides along the wall over C, with weights of its joints and without.
  const auto slid = [&](const std::vector<double>& given) {
    world = made_world();
    options.weights = given.data();
    options.weight_count = given.size();
    const touchstone_mechanism arm = add(start, TOUCHSTONE_SLIDE);
    const std::vector<double> corners = Crane::corners(wall);
    const touchstone_pose X = c_pose(X_WWall);
    touchstone_object made = 0;
    EXPECT_EQ(touchstone_add_object(world.get(), "wall", corners.data(), 1, &X, 1, &made), TOUCHSTONE_OK);
    for (int frame = 0; frame < 3; ++frame) moved(world, arm, goal);
    return joints_of(world, arm);
  };
  const std::vector<double> weighted = slid(weights), alike = slid({1.0, 1.0});
  EXPECT_LT(weighted[0] - 0.5, 0.5 * (alike[0] - 0.5));  // what is heavy turns less
  EXPECT_LT(weighted[1], alike[1]);

  // The same arm in C++.
  BackendRegistry registry;
  register_core(registry);
  ContactWorld cpp(make_native(), registry.make_broadphase("native"), kDefaultGap);
  MechanismDescription description{"crane", {}, {}};
  for (const touchstone_link& link : crane.links)
    description.links.push_back(
        {link.name, {{"0", c_interface::solids_from_corners({link.corners, 24}).front(), Pose{}}}});
  for (const touchstone_joint& joint : crane.joints) {
    JointDescription& out = description.joints.emplace_back();
    out = {joint.name, static_cast<JointKind>(joint.kind), joint.parent, joint.child};
    std::memcpy(static_cast<void*>(&out.X_PJ), &joint.X_PJ, sizeof out.X_PJ);
    out.axis_J = {joint.axis_J[0], joint.axis_J[1], joint.axis_J[2]};
    out.lower = joint.lower;
    out.upper = joint.upper;
  }
  const MechanismHandle arm = cpp.add_mechanism(
      {std::make_shared<const Mechanism>(std::move(description)), Pose{}, start, {}, weights});
  // The same wall, rule and command: the same bits.
  PairRule rule;
  rule.policy = ContactPolicy::slide;
  cpp.set_default_rule(rule);
  cpp.add({std::make_shared<const HexahedronTree>(std::vector<PlacedHexahedron>{{"0", wall, Pose{}}}, "wall"),
           X_WWall, true});
  const JointCommand command{arm, goal};
  for (int frame = 0; frame < 3; ++frame) cpp.frame({}, {&command, 1});
  EXPECT_TRUE(std::ranges::equal(weighted, cpp.joint_values(arm)));
}

TEST_F(Options, GroupsAreThoseOfEveryLink) {
  const char* groups[] = {"cranes"};
  options.groups = groups;
  options.group_count = 1;
  const touchstone_mechanism arm = add({0, 0}, TOUCHSTONE_ADVANCE);
  ASSERT_EQ(touchstone_set_group_policy(world.get(), "cranes", "cranes", TOUCHSTONE_CUE, 0.0), TOUCHSTONE_OK);
  moved(world, arm, {0, -0.5});
  EXPECT_EQ(joints_of(world, arm)[1], -0.5);
}

TEST_F(Options, WhatIsNoneIsRefusedByName) {
  touchstone_mechanism arm = 7;
  const auto refused = [&](const char* text) {
    EXPECT_EQ(
        touchstone_add_mechanism_with(world.get(), &crane.description, &options, &origin, nullptr, 0, &arm),
        TOUCHSTONE_BAD_INPUT);
    EXPECT_THAT(touchstone_error(), HasSubstr(text));
    EXPECT_EQ(arm, 7u);
  };
  options.weight_count = 2;
  refused("options: weights: is NULL");
  const double weights[] = {1.0, 0.0};
  options.weights = weights;
  refused("weight");
  options = {};
  touchstone_link_pair pair = {"post", nullptr};
  options.exempt_count = 1;
  refused("options: exempt: is NULL");
  options.exempt = &pair;
  refused("options: exempt: second: is NULL");
  pair.second = "nobody";
  refused("nobody");
}

class BadMechanisms : public testing::Test {
 protected:
  OwnedWorld world = made_world();
  Crane crane;
  touchstone_pose origin = c_pose(Pose{});
  touchstone_mechanism arm = 7;

  void refused(const char* text, const double* values = nullptr, size_t count = 0) {
    EXPECT_EQ(touchstone_add_mechanism(world.get(), &crane.description, &origin, values, count, &arm),
              TOUCHSTONE_BAD_INPUT);
    EXPECT_THAT(touchstone_error(), HasSubstr(text));
    EXPECT_EQ(arm, 7u);
  }
};

TEST_F(BadMechanisms, DescriptionsAreRefusedByName) {
  const double values[] = {0.0, 0.5};
  refused("beyond its limits", values, 2);  // of 0.4
  refused("values: is NULL", nullptr, 2);
  crane.joints[1].kind = 3;
  refused("kind: 3 is none");
  crane.joints[1].kind = TOUCHSTONE_PRISMATIC;
  crane.joints[1].parent = "nowhere";
  refused("nowhere");
  crane.joints[1].parent = nullptr;
  refused("joints: parent: is NULL");
  crane.description.joint_count = 1;
  refused("hook");  // no joint reaches it
  crane.links[2].corners = nullptr;
  refused("links: corners: is NULL");
  crane.description.links = nullptr;
  refused("links: is NULL");
  EXPECT_EQ(touchstone_add_arm(world.get(), "arm", "no_arm", &origin, nullptr, 0, &arm),
            TOUCHSTONE_BAD_INPUT);
  EXPECT_THAT(touchstone_error(), HasSubstr("no_arm"));
}

TEST_F(BadMechanisms, CommandsAreLookedAtBeforeAnythingMoves) {
  touchstone_object box = 0;
  const touchstone_pose away = c_pose(at(5, 0, 0)), further = c_pose(at(6, 0, 0));
  ASSERT_EQ(touchstone_add_mechanism(world.get(), &crane.description, &origin, nullptr, 0, &arm),
            TOUCHSTONE_OK);
  ASSERT_EQ(touchstone_add_object(world.get(), "box", crane.hook.data(), 1, &away, 0, &box), TOUCHSTONE_OK);
  const double goal[] = {0.1, kNaN};
  const touchstone_command command{box, further};
  const touchstone_joint_command nobody{arm + 1, goal, 2}, not_finite{arm, goal, 2}, nothing{arm, nullptr, 2};
  touchstone_report report{};
  EXPECT_EQ(touchstone_frame_with_joints(world.get(), &command, 1, &nobody, 1, &report),
            TOUCHSTONE_BAD_INPUT);
  EXPECT_EQ(touchstone_frame_with_joints(world.get(), &command, 1, &nothing, 1, &report),
            TOUCHSTONE_BAD_INPUT);
  EXPECT_EQ(touchstone_frame_with_joints(world.get(), &command, 1, nullptr, 1, &report),
            TOUCHSTONE_BAD_INPUT);
  touchstone_pose pose;
  ASSERT_EQ(touchstone_get_poses(world.get(), &box, 1, &pose), TOUCHSTONE_OK);
  EXPECT_EQ(pose.p[0], 5.0);
  ASSERT_EQ(touchstone_frame_with_joints(world.get(), &command, 1, &not_finite, 1, &report), TOUCHSTONE_OK);
  ASSERT_EQ(report.event_count, 1u);
  EXPECT_EQ(report.events[0].kind, TOUCHSTONE_REFUSED);
  EXPECT_EQ(joints_of(world, arm), (std::vector<double>{0.0, 0.0}));
}

}  // namespace
}  // namespace touchstone

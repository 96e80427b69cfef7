#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/adapters/c_interface/corners.hpp"
#include "touchstone/adapters/c_interface/touchstone.h"
#include "touchstone/contact_core/geometry/constants.hpp"
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

/// A world through C, and what is in it.
struct CWorld {
  OwnedWorld world;
  std::vector<touchstone_object> objects;

  explicit CWorld(double gap = 0.0) {
    touchstone_world* made = nullptr;
    EXPECT_EQ(touchstone_create_world("native", gap, &made), TOUCHSTONE_OK) << touchstone_error();
    world.reset(made);
  }
  touchstone_object add(const std::string& name, const Hexahedron& solid, const Pose& X_WO,
                        bool is_static = false) {
    const std::vector<double> corners = c_interface::corners_of({&solid, 1});
    const touchstone_pose X = c_pose(X_WO);
    touchstone_object made = TOUCHSTONE_NO_OBJECT;
    EXPECT_EQ(
        touchstone_add_object(world.get(), name.c_str(), corners.data(), 1, &X, is_static ? 1 : 0, &made),
        TOUCHSTONE_OK)
        << touchstone_error();
    objects.push_back(made);
    return made;
  }
  touchstone_report frame(const std::vector<touchstone_command>& commands) const {
    touchstone_report report{};
    EXPECT_EQ(touchstone_frame(world.get(), commands.data(), commands.size(), &report), TOUCHSTONE_OK)
        << touchstone_error();
    return report;
  }
  touchstone_pose pose(touchstone_object object) const {
    touchstone_pose out{};
    EXPECT_EQ(touchstone_get_poses(world.get(), &object, 1, &out), TOUCHSTONE_OK) << touchstone_error();
    return out;
  }
};

template <class X, class Y>
bool same_bits(const X& x, const Y& y) {
  static_assert(sizeof(X) == sizeof(Y));
  return std::memcmp(&x, &y, sizeof(X)) == 0;
}

// ---- the same as through C++

constexpr int kBoxes = 40;

Pose start_of(int i) { return at(1.2 * (i % 5), 1.2 * (i / 5 % 4), 1.2 * (i / 20)); }

class SameAsCpp : public testing::TestWithParam<ContactPolicy> {};

TEST_P(SameAsCpp, PosesAndEvents) {
  // The same boxes, rule and latch in both worlds.
  BackendRegistry registry;
  register_core(registry);
  ContactWorld cpp(make_native(), registry.make_broadphase("native"), kDefaultGap);
  CWorld c;
  std::vector<ObjectHandle> handles;
  for (int i = 0; i < kBoxes; ++i) {
    const Hexahedron box = Hexahedron::from_size({0.8, 0.9, 1.0});
    const std::string name = "box" + std::to_string(i);
    const auto tree =
        std::make_shared<const HexahedronTree>(std::vector<PlacedHexahedron>{{"0", box, Pose{}}}, name);
    handles.push_back(cpp.add({tree, start_of(i), i % 7 == 0, {}}));
    c.add(name, box, start_of(i), i % 7 == 0);
  }
  PairRule rule;
  rule.policy = GetParam();
  rule.warn_distance = 0.05;
  cpp.set_default_rule(rule);
  ASSERT_EQ(touchstone_set_policy(c.world.get(), TOUCHSTONE_NO_OBJECT, TOUCHSTONE_NO_OBJECT,
                                  static_cast<int32_t>(GetParam()), 0.05),
            TOUCHSTONE_OK);
  cpp.latch(handles[1], handles[2]);
  ASSERT_EQ(touchstone_latch(c.world.get(), c.objects[1], c.objects[2]), TOUCHSTONE_OK);
  Random random(2111);
  std::size_t events = 0;
  // The same commands; half of the way one pair is switched off.
  for (int frame = 0; frame < 25; ++frame) {
    if (frame == 12) {
      cpp.select(SelectionChange::of(handles[3], handles[4], false));
      ASSERT_EQ(touchstone_select(c.world.get(), c.objects[3], c.objects[4], 0), TOUCHSTONE_OK);
    }
    std::vector<MotionCommand> commands;
    std::vector<touchstone_command> c_commands;
    for (std::size_t i = 0; i < handles.size(); ++i) {
      if (i % 7 == 0 || i == 2) continue;
      Pose goal = cpp.actual_pose(handles[i]);
      goal.p += random.vector(0.2);
      commands.push_back(cpp.go_to(handles[i], goal));
      c_commands.push_back({c.objects[i], c_pose(goal)});
    }
    // Reports, events and poses have the same bits.
    const FrameReport report = cpp.frame(commands);
    const touchstone_report got = c.frame(c_commands);
    ASSERT_EQ(got.event_count, report.events.size()) << frame;
    ASSERT_EQ(got.queries, report.queries);
    ASSERT_EQ(got.blocked_movers, report.blocked_movers);
    EXPECT_EQ(got.is_proven, 1);
    for (std::size_t e = 0; e < report.events.size(); ++e) {
      ASSERT_EQ(got.events[e].kind, static_cast<int32_t>(report.events[e].kind)) << frame;
      ASSERT_TRUE(same_bits(got.events[e].geometry.separation, report.events[e].geometry.separation));
      ASSERT_TRUE(same_bits(got.events[e].s, report.events[e].s));
    }
    events += report.events.size();
    for (std::size_t i = 0; i < handles.size(); ++i)
      ASSERT_TRUE(same_bits(c.pose(c.objects[i]), cpp.actual_pose(handles[i]))) << frame << " " << i;
  }
  EXPECT_GT(events, 50u);
}

INSTANTIATE_TEST_SUITE_P(CWorld, SameAsCpp,
                         testing::Values(ContactPolicy::cue, ContactPolicy::hold, ContactPolicy::advance,
                                         ContactPolicy::slide),
                         [](const auto& param) { return std::string(to_string(param.param)); });

// ---- the simplest run, and what it costs

TEST(CWorld, AStepThroughAWallStopsAtIt) {
  CWorld c(1e-6);
  const auto box = c.add("box", Hexahedron::from_size({1, 1, 1}), at(0, 0, 0));
  const auto wall = c.add("wall", Hexahedron::from_size({0.01, 5, 5}), at(2, 0, 0), true);
  ASSERT_EQ(touchstone_set_policy(c.world.get(), box, wall, TOUCHSTONE_ADVANCE, 0.0), TOUCHSTONE_OK);
  const touchstone_report report = c.frame({{box, c_pose(at(4, 0, 0))}});
  EXPECT_EQ(report.blocked_movers, 1u);
  EXPECT_NEAR(c.pose(box).p[0], 2.0 - 0.005 - 0.5, 2e-6);
  EXPECT_LT(c.pose(box).p[0], 2.0 - 0.005 - 0.5);
  bool blocked = false;
  for (std::size_t e = 0; e < report.event_count; ++e) {
    const touchstone_event& event = report.events[e];
    if (event.kind != TOUCHSTONE_BLOCKED) continue;
    blocked = true;
    EXPECT_EQ(event.a, box);
    EXPECT_EQ(event.b, wall);
    EXPECT_NEAR(event.s, 1.495 / 4, 1e-6);
    EXPECT_EQ(event.geometry.n_AB_W[0], 1.0);
  }
  EXPECT_TRUE(blocked);
}

TEST(CWorld, ASphereAndACapsuleStopAtTheirRadius) {
  CWorld c(1e-6);
  const auto wall = c.add("wall", Hexahedron::from_size({0.01, 9, 9}), at(2, 0, 0), true);
  ASSERT_EQ(touchstone_set_policy(c.world.get(), TOUCHSTONE_NO_OBJECT, TOUCHSTONE_NO_OBJECT,
                                  TOUCHSTONE_ADVANCE, 0.0),
            TOUCHSTONE_OK);
  // The second is along z, and lies across the way.
  const std::vector<double> corners = c_interface::corners_of(
      std::vector<Hexahedron>{Hexahedron::sphere(0.5), Hexahedron::capsule(0.25, 1.0)});
  const std::array radii = {0.5, 0.25};
  std::array<touchstone_object, 2> movers{};
  for (std::size_t i = 0; i < 2; ++i) {
    const touchstone_pose X = c_pose(at(0, 3.0 * static_cast<double>(i), 0));
    ASSERT_EQ(touchstone_add_rounded_object(c.world.get(), i == 0 ? "sphere" : "capsule", &corners[24 * i],
                                            &radii[i], 1, &X, 0, nullptr, 0, &movers[i]),
              TOUCHSTONE_OK)
        << touchstone_error();
  }
  const touchstone_report report =
      c.frame({{movers[0], c_pose(at(4, 0, 0))}, {movers[1], c_pose(at(4, 3, 0))}});
  EXPECT_EQ(report.blocked_movers, 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(c.pose(movers[i]).p[0], 2.0 - 0.005 - radii[i], 2e-6);
    EXPECT_LT(c.pose(movers[i]).p[0], 2.0 - 0.005 - radii[i]);
  }
  static_cast<void>(wall);
}

TEST(CWorld, FramesDoNotAllocate) {
  CWorld c;
  for (int i = 0; i < kBoxes; ++i)
    c.add("box" + std::to_string(i), Hexahedron::from_size({0.8, 0.9, 1.0}), start_of(i));
  ASSERT_EQ(touchstone_prepare(c.world.get()), TOUCHSTONE_OK);
  std::vector<touchstone_command> commands;
  for (const touchstone_object object : c.objects) commands.push_back({object, c.pose(object)});
  touchstone_report report;
  const auto step = [&](int frame) {
    for (std::size_t i = 0; i < commands.size(); ++i)
      commands[i].X_WO.p[0] = start_of(static_cast<int>(i)).p.x() + 0.5 * ((frame + static_cast<int>(i)) % 3);
    return touchstone_frame(c.world.get(), commands.data(), commands.size(), &report);
  };
  for (int frame = 0; frame < 6; ++frame) ASSERT_EQ(step(frame), TOUCHSTONE_OK);
  const std::size_t before = allocation_count();
  for (int frame = 6; frame < 12; ++frame) ASSERT_EQ(step(frame), TOUCHSTONE_OK);
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(report.event_count, 0u);
}

// ---- groups, budgets and hands

/// The same crowd through C and C++: boxes in two groups that slide into each other.
struct TwoWorlds {
  BackendRegistry registry;
  std::unique_ptr<ContactWorld> cpp;
  CWorld c;
  std::vector<ObjectHandle> handles;
  Random random{2127};

  TwoWorlds() {
    register_core(registry);
    cpp = std::make_unique<ContactWorld>(make_native(), registry.make_broadphase("native"), kDefaultGap);
    for (int i = 0; i < kBoxes; ++i) {
      const Hexahedron box = Hexahedron::from_size({0.8, 0.9, 1.0});
      const std::string name = "box" + std::to_string(i), group = i % 2 == 0 ? "even" : "odd";
      const auto tree =
          std::make_shared<const HexahedronTree>(std::vector<PlacedHexahedron>{{"0", box, Pose{}}}, name);
      handles.push_back(cpp->add({tree, start_of(i), i % 7 == 0, {group}}));
      const std::vector<double> corners = c_interface::corners_of({&box, 1});
      const touchstone_pose X = c_pose(start_of(i));
      const char* groups[] = {group.c_str()};
      touchstone_object made = TOUCHSTONE_NO_OBJECT;
      EXPECT_EQ(touchstone_add_object_in_groups(c.world.get(), name.c_str(), corners.data(), 1, &X,
                                                i % 7 == 0 ? 1 : 0, groups, 1, &made),
                TOUCHSTONE_OK)
          << touchstone_error();
      c.objects.push_back(made);
    }
  }

  /// One frame of both; every pose, cut and hand must have the same bits. Returns how many were cut off.
  std::size_t step() {
    // The same random commands in both.
    std::vector<MotionCommand> commands;
    std::vector<touchstone_command> c_commands;
    for (std::size_t i = 0; i < handles.size(); ++i) {
      if (i % 7 == 0) continue;
      Pose goal = cpp->actual_pose(handles[i]);
      goal.p += random.vector(0.25);
      commands.push_back(cpp->go_to(handles[i], goal));
      c_commands.push_back({c.objects[i], c_pose(goal)});
    }
    const FrameReport report = cpp->frame(commands);
    c.frame(c_commands);
    // Movers that were cut off, and forces at hands.
    const touchstone_object* cut = nullptr;
    const touchstone_feel* felt = nullptr;
    std::size_t cuts = 99, feels = 99;
    EXPECT_EQ(touchstone_get_cut_off(c.world.get(), &cut, &cuts), TOUCHSTONE_OK);
    EXPECT_EQ(touchstone_get_feels(c.world.get(), &felt, &feels), TOUCHSTONE_OK);
    EXPECT_EQ(cuts, report.cut_off.size());
    EXPECT_EQ(feels, report.felt.size());
    for (std::size_t i = 0; i < std::min(cuts, report.cut_off.size()); ++i)
      EXPECT_TRUE(same_bits(cut[i], report.cut_off[i]));
    for (std::size_t i = 0; i < std::min(feels, report.felt.size()); ++i) {
      EXPECT_TRUE(same_bits(felt[i].object, report.felt[i].object));
      EXPECT_TRUE(same_bits(felt[i].lag_W, report.felt[i].lag_W));
      EXPECT_TRUE(same_bits(felt[i].turn_lag_W, report.felt[i].turn_lag_W));
      EXPECT_TRUE(same_bits(felt[i].force_W, report.felt[i].force_W));
      EXPECT_TRUE(same_bits(felt[i].moment_W, report.felt[i].moment_W));
      largest_force = std::max(largest_force, std::abs(felt[i].force_W[0]));
    }
    // Every object went as far in both worlds.
    for (std::size_t i = 0; i < handles.size(); ++i)
      EXPECT_TRUE(same_bits(c.pose(c.objects[i]), cpp->actual_pose(handles[i]))) << i;
    return cuts;
  }
  double largest_force = 0.0;
};

constexpr touchstone_hand kSoftHand{{}, 0, 0, {100, 200, 300}, {1, 2, 3}};

TEST(CWorldHands, SlidesYieldAndFeelAsThroughCpp) {
  TwoWorlds both;
  PairRule slide;
  slide.policy = ContactPolicy::slide;
  slide.warn_distance = 0.0;
  both.cpp->set_group_rule("even", "odd", slide);
  ASSERT_EQ(touchstone_set_group_policy(both.c.world.get(), "even", "odd", TOUCHSTONE_SLIDE, 0.0),
            TOUCHSTONE_OK);
  HandStiffness soft;
  soft.translation = {100, 200, 300};
  soft.turning = {1, 2, 3};
  both.cpp->set_default_hand(soft);
  ASSERT_EQ(touchstone_set_hand(both.c.world.get(), TOUCHSTONE_NO_OBJECT, &kSoftHand), TOUCHSTONE_OK);
  HandStiffness tool;
  tool.X_OT = at(0.1, 0.2, -0.3);
  both.cpp->set_hand(both.handles[3], tool);
  const touchstone_hand c_tool{c_pose(at(0.1, 0.2, -0.3)), 1, 0, {500, 500, 500}, {500, 500, 500}};
  ASSERT_EQ(touchstone_set_hand(both.c.world.get(), both.c.objects[3], &c_tool), TOUCHSTONE_OK);
  both.cpp->set_hand(both.handles[4], std::nullopt);
  ASSERT_EQ(touchstone_set_hand(both.c.world.get(), both.c.objects[4], nullptr), TOUCHSTONE_OK);
  for (int frame = 0; frame < 12; ++frame) both.step();
  EXPECT_GT(both.largest_force, 0.0);
}

TEST(CWorldHands, ABudgetCutsOffWhomItCutsInCpp) {
  TwoWorlds both;
  PairRule slide;
  slide.policy = ContactPolicy::slide;
  both.cpp->set_default_rule(slide);
  ASSERT_EQ(touchstone_set_policy(both.c.world.get(), TOUCHSTONE_NO_OBJECT, TOUCHSTONE_NO_OBJECT,
                                  TOUCHSTONE_SLIDE, 0.0),
            TOUCHSTONE_OK);
  touchstone_slide_budget budget{};
  ASSERT_EQ(touchstone_get_slide_budget(both.c.world.get(), &budget), TOUCHSTONE_OK);
  EXPECT_EQ(budget.pairs, UINT64_MAX);
  EXPECT_TRUE(std::isinf(budget.seconds));
  EXPECT_EQ(budget.mover_work, kMoverWork);
  budget.pairs = 60;
  both.cpp->set_slide_budget({60, kInfinity, kMoverWork});
  ASSERT_EQ(touchstone_set_slide_budget(both.c.world.get(), &budget), TOUCHSTONE_OK);
  std::size_t cuts = 0;
  for (int frame = 0; frame < 12; ++frame) cuts += both.step();
  EXPECT_GT(cuts, 10u);
  both.cpp->set_slide_budget({});
  ASSERT_EQ(touchstone_set_slide_budget(both.c.world.get(), nullptr), TOUCHSTONE_OK);
  cuts = 0;
  for (int frame = 0; frame < 6; ++frame) cuts += both.step();
  EXPECT_EQ(cuts, 0u);
}

TEST(CWorldHands, AGroupIsSwitchedOff) {
  TwoWorlds both;
  both.cpp->select(SelectionChange::of_group("odd", false));
  ASSERT_EQ(touchstone_select_group(both.c.world.get(), "odd", 0), TOUCHSTONE_OK);
  for (int frame = 0; frame < 8; ++frame) both.step();
  // One that is off goes into another.
  const Pose goal = both.cpp->actual_pose(both.handles[3]);
  const MotionCommand command = both.cpp->go_to(both.handles[1], goal);
  both.cpp->frame({&command, 1});
  both.c.frame({{both.c.objects[1], c_pose(goal)}});
  const Pose reached = both.cpp->actual_pose(both.handles[1]);
  EXPECT_TRUE(same_bits(both.c.pose(both.c.objects[1]), reached));
  EXPECT_LT((reached.p - goal.p).norm(), 1e-12);
}

// ---- bad calls

class BadWorldCalls : public testing::Test {
 protected:
  CWorld c;
  touchstone_object box = c.add("box", Hexahedron::from_size({1, 1, 1}), at(0, 0, 0));
  touchstone_object other = c.add("other", Hexahedron::from_size({1, 1, 1}), at(3, 0, 0));
  touchstone_report report{};

  static void refused(touchstone_code code, const char* text) {
    EXPECT_EQ(code, TOUCHSTONE_BAD_INPUT);
    EXPECT_THAT(touchstone_error(), HasSubstr(text));
  }
};

TEST(CWorldExemptions, AnExemptPairIsNotCheckedUntilItIsTakenBack) {
  CWorld c;
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1});
  const touchstone_object box = c.add("box", cube, at(0, 0, 0)),
                          wall = c.add("wall", cube, at(2, 0, 0), true);
  ASSERT_EQ(touchstone_set_policy(c.world.get(), TOUCHSTONE_NO_OBJECT, TOUCHSTONE_NO_OBJECT,
                                  TOUCHSTONE_ADVANCE, 0.0),
            TOUCHSTONE_OK);
  touchstone_object found = TOUCHSTONE_NO_OBJECT;
  ASSERT_EQ(touchstone_find_object(c.world.get(), "wall", &found), TOUCHSTONE_OK);
  EXPECT_EQ(found, wall);
  // By the solid's number of one of the two.
  const touchstone_exemption pair = {box, wall, "0", nullptr};
  ASSERT_EQ(touchstone_exempt(c.world.get(), &pair), TOUCHSTONE_OK) << touchstone_error();
  c.frame({{box, c_pose(at(4, 0, 0))}});
  EXPECT_EQ(c.pose(box).p[0], 4.0);
  ASSERT_EQ(touchstone_unexempt(c.world.get(), &pair), TOUCHSTONE_OK) << touchstone_error();
  c.frame({{box, c_pose(at(0, 0, 0))}});
  EXPECT_NEAR(c.pose(box).p[0], 3.0, 1e-6);

  EXPECT_EQ(touchstone_unexempt(c.world.get(), &pair), TOUCHSTONE_BAD_INPUT);
  const touchstone_exemption no_solid = {box, wall, "1", nullptr};
  EXPECT_EQ(touchstone_exempt(c.world.get(), &no_solid), TOUCHSTONE_BAD_INPUT);
  EXPECT_EQ(touchstone_exempt(c.world.get(), nullptr), TOUCHSTONE_BAD_INPUT);
  EXPECT_THAT(touchstone_error(), HasSubstr("pair: is NULL"));
  EXPECT_EQ(touchstone_find_object(c.world.get(), "nobody", &found), TOUCHSTONE_BAD_INPUT);
  EXPECT_EQ(found, wall);
}

TEST_F(BadWorldCalls, NullPointersAreNamed) {
  touchstone_world* made = nullptr;
  refused(touchstone_create_world(nullptr, 0.0, &made), "backend: is NULL");
  refused(touchstone_create_world("native", 0.0, nullptr), "out: is NULL");
  refused(touchstone_prepare(nullptr), "world: is NULL");
  refused(touchstone_frame(c.world.get(), nullptr, 1, &report), "commands: is NULL");
  refused(touchstone_frame(c.world.get(), nullptr, 0, nullptr), "out: is NULL");
}

TEST_F(BadWorldCalls, UnknownNamesAndFigures) {
  touchstone_world* made = nullptr;
  refused(touchstone_create_world("no_such_check", 0.0, &made), "no_such_check");
  refused(touchstone_create_world("native", -1.0, &made), "gap");
  refused(touchstone_create_world("native", kNaN, &made), "gap");
  EXPECT_EQ(made, nullptr);
  refused(touchstone_set_policy(c.world.get(), box, other, 4, 0.0), "policy: 4 is none");
  refused(touchstone_set_policy(c.world.get(), box, other, TOUCHSTONE_HOLD, kNaN), "warn");
  refused(touchstone_select(c.world.get(), TOUCHSTONE_NO_OBJECT, box, 1), "a: is no object");
}

TEST_F(BadWorldCalls, BudgetsHandsAndGroups) {
  // A budget of negative seconds is refused, and leaves none set.
  const touchstone_slide_budget backwards{1, -1.0, 1};
  refused(touchstone_set_slide_budget(c.world.get(), &backwards), "a slide budget of -1");
  touchstone_slide_budget budget{};
  ASSERT_EQ(touchstone_get_slide_budget(c.world.get(), &budget), TOUCHSTONE_OK);
  EXPECT_TRUE(std::isinf(budget.seconds));
  // A hand needs positive stiffness, a tool that is a pose, and an object.
  touchstone_hand hand = kSoftHand;
  hand.translation[1] = 0.0;
  EXPECT_EQ(touchstone_set_hand(c.world.get(), box, &hand), TOUCHSTONE_BAD_INPUT);
  hand = kSoftHand;
  hand.has_tool = 1;  // all zeros: no rotation
  EXPECT_EQ(touchstone_set_hand(c.world.get(), box, &hand), TOUCHSTONE_BAD_INPUT);
  hand.X_OT = c_pose(Pose{});
  EXPECT_EQ(touchstone_set_hand(c.world.get(), TOUCHSTONE_NO_OBJECT, &hand), TOUCHSTONE_BAD_INPUT);
  // Missing worlds and names, and policies that there are not.
  refused(touchstone_set_hand(nullptr, box, nullptr), "world: is NULL");
  refused(touchstone_set_group_policy(c.world.get(), "a", nullptr, TOUCHSTONE_HOLD, 0.0), "second: is NULL");
  refused(touchstone_set_group_policy(c.world.get(), "a", "b", 9, 0.0), "policy: 9 is none");
  refused(touchstone_select_group(c.world.get(), nullptr, 1), "group: is NULL");
  EXPECT_EQ(touchstone_select_group(c.world.get(), std::string(4096, 'x').c_str(), 1), TOUCHSTONE_BAD_INPUT);
  refused(touchstone_get_feels(c.world.get(), nullptr, nullptr), "out: is NULL");
  refused(touchstone_get_cut_off(c.world.get(), nullptr, nullptr), "out: is NULL");
  // A group without a name, when an object is added.
  const std::vector<double> good = c_interface::corners_of(std::vector{Hexahedron::from_size({1, 1, 1})});
  const touchstone_pose X = c_pose(at(9, 0, 0));
  touchstone_object made = 5;
  const char* none[] = {nullptr};
  refused(touchstone_add_object_in_groups(c.world.get(), "grouped", good.data(), 1, &X, 0, none, 1, &made),
          "groups: is NULL");
  EXPECT_EQ(made, 5u);
}

TEST_F(BadWorldCalls, AnObjectThatIsGoneMovesNothing) {
  ASSERT_EQ(touchstone_remove_object(c.world.get(), other), TOUCHSTONE_OK);
  const touchstone_command commands[] = {{box, c_pose(at(0.5, 0, 0))}, {other, c_pose(at(9, 0, 0))}};
  EXPECT_EQ(touchstone_frame(c.world.get(), commands, 2, &report), TOUCHSTONE_BAD_INPUT);
  EXPECT_EQ(c.pose(box).p[0], 0.0);
  touchstone_pose pose;
  EXPECT_EQ(touchstone_get_poses(c.world.get(), &other, 1, &pose), TOUCHSTONE_BAD_INPUT);
  EXPECT_EQ(touchstone_remove_object(c.world.get(), other), TOUCHSTONE_BAD_INPUT);
  EXPECT_EQ(touchstone_latch(c.world.get(), box, TOUCHSTONE_NO_OBJECT), TOUCHSTONE_BAD_INPUT);
}

TEST_F(BadWorldCalls, ANameTwiceAndNoHexahedron) {
  double corners[24] = {};
  const touchstone_pose X = c_pose(at(0, 0, 0));
  touchstone_object made = 5;
  EXPECT_EQ(touchstone_add_object(c.world.get(), "flat", corners, 1, &X, 0, &made), TOUCHSTONE_BAD_INPUT);
  refused(touchstone_add_object(c.world.get(), "flat", corners, 0, &X, 0, &made), "flat");
  const std::vector<double> good = c_interface::corners_of(std::vector{Hexahedron::from_size({1, 1, 1})});
  refused(touchstone_add_object(c.world.get(), "box", good.data(), 1, &X, 0, &made), "box");
  EXPECT_EQ(made, 5u);
}

TEST_F(BadWorldCalls, APoseThatIsNoneIsRefusedAndReported) {
  const touchstone_report got = c.frame({{box, c_pose(at(kNaN, 0, 0))}});
  ASSERT_EQ(got.event_count, 1u);
  EXPECT_EQ(got.events[0].kind, TOUCHSTONE_REFUSED);
  EXPECT_EQ(got.events[0].a, box);
  EXPECT_EQ(got.events[0].b, TOUCHSTONE_NO_OBJECT);
  EXPECT_EQ(c.pose(box).p[0], 0.0);
}

}  // namespace
}  // namespace touchstone

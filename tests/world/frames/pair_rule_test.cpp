#include "touchstone/contact_core/world/pairs/pair_rules.hpp"

#include <gmock/gmock.h>

#include <array>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

namespace touchstone {
namespace {

using ::testing::Contains;

// A box at the origin and a wall whose near face is at x = 2.5.
struct BoxAndWall {
  std::unique_ptr<ContactWorld> world = make_world();
  ObjectHandle box = world->add({box_tree("box", {1, 1, 1}), at(0, 0, 0), false, {"cargo", "heavy"}});
  ObjectHandle wall = world->add({box_tree("wall", {1, 4, 4}), at(3, 0, 0), true, {"scenery"}});

  FrameReport push(double by) { return world->frame(std::array{world->move_by(box, {by, 0, 0}, {0, 0, 0})}); }
  EffectiveRule rule_now() const { return world->rule_of(box, wall); }
};

// Taken whole, such a rule turned the pair's policy into `hold`: the box stayed where it was.
TEST(PairRule, WarnDistanceOfAPairLeavesTheDefaultsPolicy) {
  BoxAndWall scene;
  scene.world->set_default_rule({.policy = ContactPolicy::advance});
  scene.world->set_pair_rule(scene.box, scene.wall, {.warn_distance = 0.5});
  EXPECT_THAT(kinds(scene.push(1.6)), Contains(EventKind::near));
  EXPECT_THAT(kinds(scene.push(4)), Contains(EventKind::blocked));
  EXPECT_NEAR(scene.world->actual_pose(scene.box).p.x(), 2.0, 2 * kGap);
}

TEST(PairRule, FieldsComeFromThePairThenTheLastGroupThenTheDefault) {
  BoxAndWall scene;
  EXPECT_EQ(scene.rule_now().policy, ContactPolicy::hold);
  EXPECT_EQ(scene.rule_now().warn_distance, 0.0);
  EXPECT_FALSE(scene.rule_now().translation_only);
  scene.world->set_default_rule({ContactPolicy::slide, 0.1, true});
  scene.world->set_group_rule("cargo", "scenery", {ContactPolicy::advance, 0.2});
  scene.world->set_group_rule("scenery", "heavy", {.warn_distance = 0.3});
  EXPECT_EQ(scene.rule_now().policy, ContactPolicy::advance);
  EXPECT_EQ(scene.rule_now().warn_distance, 0.3);
  EXPECT_TRUE(scene.rule_now().translation_only);
  scene.world->set_pair_rule(scene.wall, scene.box, {.policy = ContactPolicy::cue});
  EXPECT_EQ(scene.rule_now().policy, ContactPolicy::cue);
  EXPECT_EQ(scene.rule_now().warn_distance, 0.3);
  EXPECT_TRUE(scene.rule_now().translation_only);
  scene.world->set_pair_rule(scene.wall, scene.box, {.translation_only = false});
  EXPECT_EQ(scene.rule_now().policy, ContactPolicy::advance);
  EXPECT_FALSE(scene.rule_now().translation_only);
}

TEST(PairRule, RuleThatIsSetAgainReplacesTheOneBeforeWhole) {
  BoxAndWall scene;
  scene.world->set_default_rule({ContactPolicy::advance, 0.1});
  scene.world->set_default_rule({.warn_distance = 0.2});
  EXPECT_EQ(scene.rule_now().policy, ContactPolicy::hold);
  scene.world->set_pair_rule(scene.box, scene.wall, {ContactPolicy::cue, 0.3});
  scene.world->set_pair_rule(scene.wall, scene.box, {.policy = ContactPolicy::slide});
  EXPECT_EQ(scene.rule_now().policy, ContactPolicy::slide);
  EXPECT_EQ(scene.rule_now().warn_distance, 0.2);
}

// A group rule that is given again counts as given last; the two names may come in either order.
TEST(PairRule, GroupRuleThatIsSetAgainMovesToTheFront) {
  BoxAndWall scene;
  scene.world->set_group_rule("cargo", "scenery", {.policy = ContactPolicy::cue});
  scene.world->set_group_rule("heavy", "scenery", {.policy = ContactPolicy::slide});
  EXPECT_EQ(scene.rule_now().policy, ContactPolicy::slide);
  scene.world->set_group_rule("scenery", "cargo", {.policy = ContactPolicy::advance});
  EXPECT_EQ(scene.rule_now().policy, ContactPolicy::advance);
}

TEST(PairRule, EmptyRulesTakeBackWhatWasSet) {
  BoxAndWall scene;
  scene.world->set_default_rule({.policy = ContactPolicy::advance});
  scene.world->set_group_rule("cargo", "scenery", {.policy = ContactPolicy::cue});
  scene.world->set_pair_rule(scene.box, scene.wall, {.policy = ContactPolicy::slide});
  scene.world->set_pair_rule(scene.box, scene.wall, {});
  EXPECT_EQ(scene.rule_now().policy, ContactPolicy::cue);
  scene.world->set_group_rule("scenery", "cargo", {});
  EXPECT_EQ(scene.rule_now().policy, ContactPolicy::advance);
  scene.world->set_default_rule({});
  EXPECT_EQ(scene.rule_now().policy, ContactPolicy::hold);
}

TEST(PairRule, RuleOfAPairEndsWithItsObjects) {
  BoxAndWall scene;
  scene.world->set_pair_rule(scene.box, scene.wall, {.policy = ContactPolicy::cue});
  scene.world->remove(scene.box);
  scene.box = scene.world->add({box_tree("next", {1, 1, 1}), at(0, 0, 0)});
  EXPECT_EQ(scene.rule_now().policy, ContactPolicy::hold);
}

TEST(PairRule, WarnDistanceThatIsNoLengthIsRefusedAndChangesNothing) {
  BoxAndWall scene;
  scene.world->set_default_rule({ContactPolicy::advance, 0.1});
  for (const double bad : {-1e-9, kNaN, kInfinity}) {
    EXPECT_THROW(scene.world->set_default_rule({.warn_distance = bad}), InputError);
    EXPECT_THROW(scene.world->set_group_rule("cargo", "scenery", {.warn_distance = bad}), InputError);
    EXPECT_THROW(scene.world->set_pair_rule(scene.box, scene.wall, {.warn_distance = bad}), InputError);
  }
  EXPECT_EQ(scene.rule_now().policy, ContactPolicy::advance);
  EXPECT_EQ(scene.rule_now().warn_distance, 0.1);
}

TEST(PairRule, OfOneObjectTwiceIsRefused) {
  BoxAndWall scene;
  EXPECT_THROW(scene.world->set_pair_rule(scene.box, scene.box, {}), InputError);
}

// How far an object looks follows the rules of its groups; of two groups the smaller one bears the rule.
TEST(PairRules, TheSmallerOfTwoGroupsLooksFurther) {
  ObjectTable objects;
  std::vector<ObjectHandle> handles;
  for (int i = 0; i < 6; ++i)
    handles.push_back(
        objects.add({box_tree(std::to_string(i), {1, 1, 1}), {}, false, {i < 2 ? "tools" : "parts"}}));
  const auto [tools, parts] = objects.groups_of("tools", "parts");
  PairRules rules;
  for (int k = 0; k < 100000; ++k) rules.set_for_groups(objects, parts, tools, {.warn_distance = 0.3});
  rules.set_for_pair(objects, handles[5], handles[4], {.warn_distance = 0.2});
  EXPECT_EQ(rules.bearer_of(tools, parts), tools);
  EXPECT_EQ(rules.largest_group_warn_distance(), 0.3);
  std::vector<double> reaches(6, 0.0);
  rules.find_reaches(objects, reaches);
  EXPECT_EQ(reaches, (std::vector{0.3, 0.3, 0.0, 0.0, 0.2, 0.0}));
  rules.set_for_groups(objects, tools, parts, {});
  EXPECT_EQ(rules.largest_group_warn_distance(), 0.0);
  EXPECT_EQ(rules.reach_of(objects, handles[0].slot), 0.0);
}

}  // namespace
}  // namespace touchstone

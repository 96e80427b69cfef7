#include "touchstone/contact_core/world/selection.hpp"

#include <gmock/gmock.h>

#include <array>
#include <thread>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

namespace touchstone {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A box at the origin and a wall whose near face is at x = 2.5: commanded to go 4 m, the box stops at x = 2.
struct BoxBeforeWall {
  std::unique_ptr<ContactWorld> world = make_world();
  ObjectHandle wall = world->add({box_tree("wall", {1, 4, 4}), at(3, 0, 0), true, {"scenery"}});
  ObjectHandle box = add_box("box");

  BoxBeforeWall() { world->set_default_rule(rule(ContactPolicy::advance)); }
  ObjectHandle add_box(const std::string& name) {
    return world->add({box_tree(name, {1, 1, 1}), at(0, 0, 0), false, {"cargo"}});
  }
  FrameReport push() { return world->frame(std::array{world->move_by(box, {4, 0, 0}, {0, 0, 0})}); }
  double x() const { return world->actual_pose(box).p.x(); }
};

// An object removed, another added, and a change that names the old one.
TEST(Selection, HandleOfARemovedObjectLeavesTheSlotsNextOneOn) {
  for (const bool is_pair : {false, true}) {
    BoxBeforeWall scene;
    scene.world->frame({});
    const ObjectHandle old = scene.box;
    scene.world->remove(old);
    scene.box = scene.add_box("next");
    ASSERT_EQ(scene.box.slot, old.slot);
    const SelectionChange off =
        is_pair ? SelectionChange::of(old, scene.wall, false) : SelectionChange::of(old, false);
    scene.world->select(off);
    const FrameReport report = scene.push();
    EXPECT_NEAR(scene.x(), 2.0, 2 * kGap);
    EXPECT_THAT(report.refused_selections, ElementsAre(off));
    EXPECT_THAT(report.selections, IsEmpty());
    EXPECT_THAT(scene.world->selection_record(), IsEmpty());
    EXPECT_EQ(scene.world->selections_left_out(), 0u);
  }
}

TEST(Selection, ChangeThatWaitsWhileItsObjectIsRemovedIsRefused) {
  BoxBeforeWall scene;
  const SelectionChange off = SelectionChange::of(scene.box, false);
  scene.world->select(off);
  scene.world->remove(scene.box);
  scene.box = scene.add_box("next");
  EXPECT_THAT(scene.push().refused_selections, ElementsAre(off));
  EXPECT_NEAR(scene.x(), 2.0, 2 * kGap);
  EXPECT_THAT(scene.push().refused_selections, IsEmpty());
}

TEST(Selection, WhatIsOffIsForgottenWithItsObject) {
  BoxBeforeWall scene;
  scene.world->select(SelectionChange::of(scene.box, false));
  scene.world->select(SelectionChange::of(scene.box, scene.wall, false));
  EXPECT_EQ(scene.world->frame({}).selections.size(), 2u);
  scene.world->remove(scene.box);
  scene.box = scene.add_box("next");
  scene.push();
  EXPECT_NEAR(scene.x(), 2.0, 2 * kGap);
}

// Two that came to overlap while they were off, and have rested since.
TEST(Selection, PairThatIsSwitchedOnAtRestIsFound) {
  BoxBeforeWall scene;
  scene.world->select(SelectionChange::of(scene.box, scene.wall, false));
  const std::array into{scene.world->move_by(scene.box, {2.5, 0, 0}, {0, 0, 0})};
  EXPECT_THAT(scene.world->frame(into).events, IsEmpty());
  for (int i = 0; i < 5; ++i) EXPECT_EQ(scene.world->frame({}).candidate_pairs, 0u);
  scene.world->select(SelectionChange::of(scene.box, scene.wall, true));
  const FrameReport report = scene.world->frame({});
  ASSERT_EQ(report.events.size(), 2u);
  EXPECT_EQ(report.events[0].kind, EventKind::penetrating_at_start);
  EXPECT_EQ(report.events[1].kind, EventKind::began);
}

TEST(Selection, GroupIsSwitchedByItsName) {
  BoxBeforeWall scene;
  scene.world->select(SelectionChange::of_group("cargo", false));
  EXPECT_EQ(scene.push().selections.size(), 1u);
  EXPECT_EQ(scene.x(), 4.0);
  BoxBeforeWall again;
  again.world->select(SelectionChange::of_group("scenery", false));
  again.world->select(SelectionChange::of_group("scenery", true));
  again.push();
  EXPECT_NEAR(again.x(), 2.0, 2 * kGap);
}

TEST(Selection, NamesThatNobodyHasAreRefused) {
  BoxBeforeWall scene;
  const std::array changes{SelectionChange::of_group("crago", false),
                           SelectionChange::of(ObjectHandle{}, false),
                           SelectionChange::of(MechanismHandle{}, false),
                           SelectionChange::of(scene.box, ObjectHandle{77, 1}, false),
                           SelectionChange::of(scene.box, scene.box, false)};
  for (const SelectionChange& change : changes) scene.world->select(change);
  const FrameReport report = scene.push();
  EXPECT_THAT(report.refused_selections, ::testing::ElementsAreArray(changes));
  EXPECT_THAT(report.selections, IsEmpty());
  EXPECT_NEAR(scene.x(), 2.0, 2 * kGap);
}

// Refused and accepted changes interleave: both keep their order.
TEST(Selection, ReportsKeepTheOrderInWhichChangesCame) {
  BoxBeforeWall scene;
  const SelectionChange box_off = SelectionChange::of(scene.box, false);
  const SelectionChange box_on = SelectionChange::of(scene.box, true);
  const SelectionChange none = SelectionChange::of_group("none", false);
  const SelectionChange nobody = SelectionChange::of(ObjectHandle{5, 5}, false);
  for (const SelectionChange& change : {none, box_off, nobody, box_on, none}) scene.world->select(change);
  const FrameReport report = scene.push();
  EXPECT_THAT(report.selections, ElementsAre(box_off, box_on));
  EXPECT_THAT(report.refused_selections, ElementsAre(none, nobody, none));
  EXPECT_EQ(scene.world->selection_record().size(), 2u);
}

TEST(Selection, GroupNamesHaveALengthThatAllOfThemShare) {
  const std::string longest(GroupName::kMostBytes, 'g'), longer = longest + "g";
  EXPECT_EQ(GroupName(longest).text(), longest);
  EXPECT_THROW(SelectionChange::of_group(longer, false), InputError);
  BoxBeforeWall scene;
  EXPECT_THROW(scene.world->add({box_tree("x", {1, 1, 1}), at(9, 9, 9), false, {longer}}), InputError);
  EXPECT_THROW(scene.world->set_group_rule("cargo", longer, rule(ContactPolicy::cue)), InputError);
  EXPECT_THROW(scene.world->set_group_rule("new", longer, rule(ContactPolicy::cue)), InputError);
  EXPECT_THROW(scene.world->set_group_rule("new", "cargo", rule(ContactPolicy::cue, -1)), InputError);
  scene.world->select(SelectionChange::of_group("new", false));  // no name of what was refused is known
  EXPECT_EQ(scene.world->frame({}).refused_selections.size(), 1u);
  scene.world->remove(scene.box);
  scene.box = scene.world->add({box_tree("box", {1, 1, 1}), at(0, 0, 0), false, {longest}});
  scene.world->select(SelectionChange::of_group(longest, false));
  scene.push();
  EXPECT_EQ(scene.x(), 4.0);
}

// The record holds names, not numbers: a world that names its groups in another order replays it.
TEST(Selection, RecordOutlivesItsWorldAndReplaysGroupsByName) {
  std::vector<SelectionRecord> record;
  {
    BoxBeforeWall scene;
    std::jthread([&] { scene.world->select(SelectionChange::of_group("cargo", false)); }).join();
    scene.world->frame({});
    record.assign(scene.world->selection_record().begin(), scene.world->selection_record().end());
  }
  ASSERT_EQ(record.size(), 1u);
  EXPECT_EQ(record[0].change.group.text(), "cargo");
  const auto world = make_world();
  const ObjectHandle box = world->add({box_tree("box", {1, 1, 1}), at(0, 0, 0), false, {"first", "cargo"}});
  world->add({box_tree("wall", {1, 4, 4}), at(3, 0, 0), true, {"scenery"}});
  world->select(record[0].change);
  world->frame(std::array{world->move_by(box, {4, 0, 0}, {0, 0, 0})});
  EXPECT_EQ(world->actual_pose(box).p.x(), 4.0);
}

}  // namespace
}  // namespace touchstone

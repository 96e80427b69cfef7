#include <gtest/gtest.h>

#include <array>

#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

namespace touchstone {
namespace {

class FrameAllocations : public ::testing::TestWithParam<ContactPolicy> {};

TEST_P(FrameAllocations, NoneWithAThousandObjects) {
  const auto world = make_world();
  world->set_default_rule(rule(GetParam(), 0.01));
  std::vector<ObjectHandle> objects;
  for (int i = 0; i < 1000; ++i) {
    objects.push_back(world->add({box_tree("box " + std::to_string(i), {1, 1, 1}),
                                  at(1.3 * (i % 10), 1.3 * (i / 10 % 10), 1.3 * (i / 100)), i % 10 == 0}));
  }
  std::vector<MotionCommand> commands;
  commands.reserve(1000);
  std::size_t before = 0;
  std::size_t blocked = 0;
  for (int frame = 0; frame < 40; ++frame) {
    if (frame == 20) before = allocation_count();
    commands.clear();
    for (int i = 0; i < 1000; ++i) {
      const double sign = (frame / 10 + i) % 2 ? 1.0 : -1.0;
      commands.push_back(
          world->move_by(objects[i], sign * Vector3(0.02, 0.01 * (i % 3), 0.015), {0, 0, sign * 0.02}));
    }
    blocked += world->frame(commands).blocked_movers;
  }
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(blocked, 0u);
}

INSTANTIATE_TEST_SUITE_P(Policies, FrameAllocations,
                         ::testing::Values(ContactPolicy::hold, ContactPolicy::advance, ContactPolicy::slide),
                         [](const auto& test) { return std::string(to_string(test.param)); });

TEST_P(FrameAllocations, NoneInTheFirstFramesAfterPrepare) {
  const auto world = make_world();
  world->set_default_rule(rule(GetParam()));
  world->add({box_tree("wall", {1, 6, 4}), at(2.5, 0, 0), true});
  const ObjectHandle box = world->add({box_tree("box", {0.6, 0.5, 0.4}), at(1.6, 0, 0)});
  world->prepare();
  for (int frame = 0; frame < 20; ++frame) {
    const std::array commands{world->move_by(box, {0.03, 0.01, 0}, {0, 0, 0.01})};
    const std::size_t before = allocation_count();
    world->frame(commands);
    EXPECT_EQ(allocation_count(), before) << "frame " << frame;
  }
}

// One that presses and slides in a corner, where every frame takes sub-steps.
TEST(SlideAllocations, NoneWhileSliding) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  world->add({box_tree("floor", {6, 6, 1}), at(0, 0, -0.5), true});
  world->add({box_tree("wall", {1, 6, 4}), at(2.5, 0, 2), true});
  const ObjectHandle box = world->add({box_tree("box", {0.6, 0.5, 0.4}), at(1.6, 0, 0.3)});
  std::size_t before = 0, slid = 0;
  for (int frame = 0; frame < 200; ++frame) {
    if (frame == 10) before = allocation_count();
    const double sign = frame / 20 % 2 ? 1.0 : -1.0;
    const std::array commands{world->move_by(box, {0.01, sign * 0.02, -0.01}, {0.01, 0, sign * 0.01})};
    slid += world->frame(commands).slide_steps > 0;
  }
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(slid, 150u);
}

struct SelectedRun {
  std::vector<SelectionRecord> kept;  // what the frames reported
  std::size_t recorded = 0, refused = 0, allocations = 0;
  std::uint64_t left_out = 0;
  std::vector<Pose> ends;
};

constexpr std::string_view kOdd = "every second cube, by a name that no short string holds";

// Cubes that fall onto one another while objects, pairs, a group and everything are switched off and on, and
// changes are refused.
SelectedRun fly_selected(int frames, std::size_t room, const SelectedRun* replay) {
  // Cubes above a floor, of which every other one is in a group.
  constexpr int kCubes = 24;
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  world->begin_selection_record(room);
  world->add({box_tree("floor", {20, 20, 1}), at(0, 0, -0.5), true});
  std::vector<ObjectHandle> cubes;
  for (int i = 0; i < kCubes; ++i)
    cubes.push_back(
        world->add({box_tree("cube " + std::to_string(i), {1, 1, 1}), at(0, 0, 1 + 1.5 * i), false,
                    i % 2 ? std::vector<std::string>{std::string(kOdd)} : std::vector<std::string>{}}));
  world->prepare();
  // Room for all that is kept.
  SelectedRun run;
  run.kept.reserve(6 * static_cast<std::size_t>(frames));
  std::vector<MotionCommand> commands;
  commands.reserve(kCubes);
  std::size_t before = 0, next = 0;
  // Selections of all scopes, good and bad, or those of a run before.
  for (int frame = 0; frame < frames; ++frame) {
    if (frame == 20) before = allocation_count();
    if (replay != nullptr) {
      for (; next < replay->kept.size() && replay->kept[next].frame == static_cast<std::uint64_t>(frame);)
        world->select(replay->kept[next++].change);
    } else {
      const std::uint32_t i = frame * 7 % kCubes, j = (frame * 11 + 1) % kCubes;
      world->select(SelectionChange::of(cubes[i], frame % 3 == 0));
      world->select(SelectionChange::of(cubes[i], cubes[i == j ? (j + 1) % kCubes : j], frame % 5 < 2));
      world->select(SelectionChange::of_everything(frame % 17 != 0));
      world->select(SelectionChange::of_group(frame % 2 == 0 ? kOdd : "a group of none", frame % 4 == 0));
      world->select(SelectionChange::of(ObjectHandle{cubes[i].slot, cubes[i].generation - 1}, false));
    }
    // All move in the frame.
    commands.clear();
    for (const ObjectHandle cube : cubes)
      commands.push_back(world->move_by(cube, {0, 0, -0.01}, {0, 0, 0.01}));
    const FrameReport report = world->frame(commands);
    for (const SelectionChange& change : report.selections) run.kept.push_back({report.frame, change});
    run.refused += report.refused_selections.size();
  }
  // Allocations once warm, records, and where cubes are.
  run.allocations = allocation_count() - before;
  run.recorded = world->selection_record().size(), run.left_out = world->selections_left_out();
  for (const ObjectHandle cube : cubes) run.ends.push_back(world->actual_pose(cube));
  return run;
}

// The record ends where its room does; what the frames report replays the whole run.
TEST(SelectionRecordRoom, NoFrameAllocatesAndTheRunReplays) {
  const SelectedRun flown = fly_selected(2000, 100, nullptr);
  EXPECT_EQ(flown.allocations, 0u);
  EXPECT_EQ(flown.kept.size(), 7000u);
  EXPECT_EQ(flown.refused, 3000u);
  EXPECT_EQ(flown.recorded, 100u);
  EXPECT_EQ(flown.left_out, 6900u);
  const SelectedRun again = fly_selected(2000, 0, &flown);
  EXPECT_EQ(again.allocations, 0u);
  EXPECT_EQ(again.recorded, 0u);
  EXPECT_EQ(again.refused, 0u);
  ASSERT_EQ(flown.ends.size(), again.ends.size());
  SelectedRun nothing;
  const SelectedRun unselected = fly_selected(2000, 0, &nothing);
  bool selections_matter = false;
  for (std::size_t i = 0; i < flown.ends.size(); ++i) {
    EXPECT_TRUE(flown.ends[i].p == again.ends[i].p && flown.ends[i].R == again.ends[i].R);
    selections_matter = selections_matter || flown.ends[i].p != unselected.ends[i].p;
  }
  EXPECT_TRUE(selections_matter);
}

TEST(SelectionRecordRoom, BeginsAnew) {
  const auto world = make_world();
  world->add({box_tree("box", {1, 1, 1}), at(0, 0, 0)});
  world->begin_selection_record(1);
  for (int i = 0; i < 3; ++i) world->select(SelectionChange::of_everything(i % 2 == 0));
  EXPECT_EQ(world->frame({}).selections.size(), 3u);
  EXPECT_EQ(world->selection_record().size(), 1u);
  EXPECT_EQ(world->selections_left_out(), 2u);
  world->begin_selection_record();
  EXPECT_TRUE(world->selection_record().empty());
  EXPECT_EQ(world->selections_left_out(), 0u);
  world->select(SelectionChange::of_everything(true));
  const FrameReport report = world->frame({});
  ASSERT_EQ(world->selection_record().size(), 1u);
  EXPECT_EQ(world->selection_record()[0].frame, report.frame);
}

}  // namespace
}  // namespace touchstone

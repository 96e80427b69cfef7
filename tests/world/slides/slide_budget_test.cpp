#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <limits>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/random_solid.hpp"
#include "touchstone/tests/world/near_spheres.hpp"
#include "touchstone/tests/world/world_fixture.hpp"
#ifdef TOUCHSTONE_HAS_EXACT
#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#endif

// A budget of slides: it cuts movers off at safe poses.

namespace touchstone {
namespace {

constexpr int kMovers = 3, kStanding = 100, kAll = kMovers + kStanding;

/// Three boxes commanded to go through a heap of a hundred others that stand close together.
struct Heap {
  std::unique_ptr<ContactWorld> world = make_world();
  std::vector<Hexahedron> solids;
  std::vector<ObjectHandle> objects = std::vector<ObjectHandle>(kAll);

  explicit Heap(bool reversed = false) {
    Random random(7);
    world->set_default_rule(rule(ContactPolicy::slide));
    std::vector<Pose> X_WO;
    for (int i = 0; i < kAll; ++i) {
      const bool moves = i < kMovers;
      solids.push_back(moves ? Hexahedron::from_size({0.3, 0.25, 0.2}) : random_solid(random, 1.0));
      X_WO.push_back(moves ? at(-2.2, 0.6 * (i - 1), 0.1 * i) : at(0, 0, 0));
      if (moves) continue;
      const int k = i - kMovers;
      X_WO.back() = at(1.2 * (k % 5), 1.2 * (k / 5 % 5 - 2), 1.2 * (k / 25 - 1.5));
    }
    for (int k = 0; k < kAll; ++k) {
      const int i = reversed ? kAll - 1 - k : k;
      const auto tree = std::make_shared<HexahedronTree>(
          std::vector<PlacedHexahedron>{{"solid", solids[i], Pose{}}}, "solid " + std::to_string(i));
      objects[i] = world->add({tree, X_WO[i], i >= kMovers});
    }
  }

  FrameReport frame(int number) {
    std::vector<MotionCommand> commands;
    for (int i = 0; i < kMovers; ++i)
      commands.push_back(world->move_by(objects[i],
                                        {0.4, 0.1 * std::sin(number + i), -0.05 * std::cos(2.0 * number + i)},
                                        {0.1, 0.2, 0.1}));
    return world->frame(commands);
  }
  double way() const {
    double sum = 0.0;
    for (int i = 0; i < kMovers; ++i) sum += world->actual_pose(objects[i]).p.x();
    return sum;
  }
};

struct HeapFigures {
  std::uint64_t most_pairs = 0, most_work = 0, cut_off = 0, steps = 0;
};

HeapFigures fly(Heap& heap, int frames) {
  HeapFigures out;
  for (int number = 0; number < frames; ++number) {
    const FrameReport report = heap.frame(number);
    out.most_pairs = std::max(out.most_pairs, report.slide_pairs);
    out.most_work = std::max(out.most_work, report.most_slide_work);
    out.cut_off += report.cut_off.size();
    out.steps += report.slide_steps;
  }
  return out;
}

SlideBudget pairs(std::uint64_t most) {
  SlideBudget budget;
  budget.pairs = most;
  return budget;
}

SlideBudget mover_work(std::uint64_t most) {
  SlideBudget budget;
  budget.mover_work = most;
  return budget;
}

const SlideBudget kNoBudget = mover_work(std::numeric_limits<std::uint64_t>::max());

TEST(SlideBudget, CutsOffWhatIsBeyondIt) {
  Heap free, narrow, none;
  free.world->set_slide_budget(kNoBudget);
  const HeapFigures unlimited = fly(free, 12);
  EXPECT_EQ(unlimited.cut_off, 0u);
  const std::uint64_t most = unlimited.most_pairs / 4;
  narrow.world->set_slide_budget(pairs(most));
  none.world->set_slide_budget(pairs(0));
  const HeapFigures cut = fly(narrow, 12), all_cut = fly(none, 12);
  std::cout << "pairs of slides, at most: " << unlimited.most_pairs << ", with a budget of " << most << ": "
            << cut.most_pairs << ", way " << free.way() << " and " << narrow.way() << " m\n";
  EXPECT_LE(cut.most_pairs, most);
  EXPECT_GT(cut.cut_off, 0u);
  EXPECT_GT(cut.steps, 0u);
  EXPECT_EQ(all_cut.steps, 0u);
  EXPECT_GT(all_cut.cut_off, 0u);
  EXPECT_GE(narrow.way(), none.way());
}

// Whatever is left, a mover goes on by one sub-step; what it took is reported.
TEST(SlideBudget, OfAMoverEndsItsSlide) {
  Heap free, narrow, none;
  EXPECT_EQ(free.world->slide_budget().mover_work, kMoverWork);
  free.world->set_slide_budget(kNoBudget);
  const HeapFigures all = fly(free, 12);
  narrow.world->set_slide_budget(mover_work(all.most_work / 4));
  none.world->set_slide_budget(mover_work(0));
  const HeapFigures cut = fly(narrow, 12), one_step = fly(none, 12);
  std::cout << "work of a mover, at most: " << all.most_work
            << ", with a budget of a quarter: " << cut.most_work << ", of 0: " << one_step.most_work
            << ", way " << free.way() << ", " << narrow.way() << " and " << none.way() << " m\n";
  EXPECT_EQ(all.cut_off, 0u);
  EXPECT_GT(cut.cut_off, 0u);
  EXPECT_LT(cut.most_work, all.most_work);
  EXPECT_LT(one_step.most_work, cut.most_work);
  EXPECT_GT(one_step.cut_off, 0u);
  EXPECT_GT(one_step.steps, 0u);
  EXPECT_LT(one_step.steps, cut.steps);
}

/// A box pressed into a corner of three others, and a second one into its own, far away.
struct TwoCorners {
  std::unique_ptr<ContactWorld> world = make_world();
  std::array<ObjectHandle, 2> movers;

  TwoCorners() {
    world->set_default_rule(rule(ContactPolicy::slide));
    for (int k = 0; k < 2; ++k) {
      const double x = 100.0 * k;
      const std::string name = std::to_string(k);
      movers[k] = world->add({box_tree("mover " + name, {0.3, 0.2, 0.2}), at(x, 0, 0.2), false});
      for (int i = 0; i < 3; ++i) {
        Pose X = at(x + 0.4 * i, 0.1 * i, -0.1);
        X.R = rotation_about(Vector3(2, -1, 2) / 3, 0.3 + 0.4 * i);
        world->add({box_tree("other " + name + std::to_string(i), {0.3, 0.4, 0.2}), X, true});
      }
    }
  }
  FrameReport press(std::size_t count) {
    std::vector<MotionCommand> commands;
    for (std::size_t k = 0; k < count; ++k)
      commands.push_back(world->move_by(movers[k], {0.08, 0.03, -0.1}, {0.1, 0.3, 0.1}));
    return world->frame(commands);
  }
};

// Where pairs and time are shared out, a mover's own work is its own.
TEST(SlideBudget, OfAMoverIsNotSharedWithOthers) {
  TwoCorners alone, beside;
  for (TwoCorners* corners : {&alone, &beside}) corners->world->set_slide_budget(mover_work(40));
  std::uint64_t cut_off = 0;
  for (int frame = 0; frame < 12; ++frame) {
    for (const ObjectHandle& object : alone.press(1).cut_off) cut_off += object == alone.movers[0];
    beside.press(2);
    const Pose &X = alone.world->actual_pose(alone.movers[0]),
               &Y = beside.world->actual_pose(beside.movers[0]);
    EXPECT_TRUE(X.p == Y.p && X.R == Y.R) << frame;
  }
  EXPECT_GT(cut_off, 0u);
}

/// A box that is pressed on a floor of tiles, and one that turns in a corner meanwhile.
struct RestingBeside {
  std::unique_ptr<ContactWorld> world = make_world();
  ObjectHandle resting, other;

  RestingBeside() {
    world->set_default_rule(rule(ContactPolicy::slide));
    resting = world->add({box_tree("resting", {0.9, 0.9, 0.2}), at(-100, 0, 0.1 + 1e-3), false});
    for (int i = 0; i < 25; ++i)
      world->add({box_tree("tile " + std::to_string(i), {0.18, 0.18, 0.2}),
                  at(-100 + 0.18 * (i % 5 - 2), 0.18 * (i / 5 - 2), -0.1), true});
    other = world->add({box_tree("other", {0.3, 0.2, 0.2}), at(0, 0, 0.2), false});
    for (int i = 0; i < 3; ++i) {
      Pose X = at(0.4 * i, 0.1 * i, -0.1);
      X.R = rotation_about(Vector3(2, -1, 2) / 3, 0.3 + 0.4 * i);
      world->add({box_tree("standing " + std::to_string(i), {0.3, 0.4, 0.2}), X, true});
    }
  }
  FrameReport press(bool with_other) {
    std::vector<MotionCommand> commands{world->move_by(resting, {0, 0, -0.1}, {0, 0, 0})};
    if (with_other) commands.push_back(world->move_by(other, {0.2, 0.1, -0.2}, {0.3, 0.6, 0.2}));
    return world->frame(commands);
  }
};

// A mover at rest is planned for as long as others slide, and may so spend its budget: that ended nothing.
TEST(SlideBudget, DoesNotNameWhoCameToRest) {
  RestingBeside alone, beside;
  int spent_at_rest = 0;
  for (int frame = 0; frame < 12; ++frame) {
    // The budget is just what it takes to come to rest.
    const FrameReport by_itself = alone.press(false);
    EXPECT_TRUE(by_itself.cut_off.empty());
    beside.world->set_slide_budget(mover_work(by_itself.most_slide_work));
    const FrameReport report = beside.press(true);
    // Planned for once more it has spent that, and once more it would be named.
    spent_at_rest += report.slide_steps >= by_itself.slide_steps + 2;
    for (const ObjectHandle& object : report.cut_off) EXPECT_NE(object, beside.resting) << frame;
  }
  EXPECT_GT(spent_at_rest, 0);
}

class SlideBudgetOrder : public ::testing::TestWithParam<bool> {};

TEST_P(SlideBudgetOrder, DoesNotShow) {
  Heap heap, reversed(true);
  std::uint64_t cut_off = 0;
  const SlideBudget budget = GetParam() ? mover_work(300) : pairs(90);
  heap.world->set_slide_budget(budget), reversed.world->set_slide_budget(budget);
  for (int number = 0; number < 20; ++number) {
    const FrameReport first = heap.frame(number);
    cut_off += first.cut_off.size();
    const std::uint64_t seen = first.slide_pairs;
    EXPECT_EQ(reversed.frame(number).slide_pairs, seen);
    for (int i = 0; i < kMovers; ++i) {
      const Pose &a = heap.world->actual_pose(heap.objects[i]),
                 &b = reversed.world->actual_pose(reversed.objects[i]);
      ASSERT_TRUE(a.p == b.p && a.R == b.R) << "frame " << number << " mover " << i;
    }
  }
  EXPECT_GT(cut_off, 0u);
}

INSTANTIATE_TEST_SUITE_P(Budgets, SlideBudgetOrder, ::testing::Bool(),
                         [](const auto& test) { return test.param ? "OfAMover" : "OfPairs"; });

TEST(SlideBudget, OfTimeEndsSlides) {
  Heap heap;
  SlideBudget budget;
  budget.seconds = 0.0;
  heap.world->set_slide_budget(budget);
  const HeapFigures none = fly(heap, 8);
  EXPECT_EQ(none.steps, 0u);
  EXPECT_GT(none.cut_off, 0u);
  budget.seconds = 3600.0;
  heap.world->set_slide_budget(budget);
  const HeapFigures all = fly(heap, 8);
  EXPECT_GT(all.steps, 0u);
  EXPECT_EQ(all.cut_off, 0u);
}

TEST(SlideBudget, RefusesWhatIsNoTime) {
  const auto world = make_world();
  SlideBudget budget;
  for (const double seconds : {-1.0, kNaN}) {
    budget.seconds = seconds;
    EXPECT_THROW(world->set_slide_budget(budget), InputError);
  }
}

TEST(SlideBudget, CostsNoAllocation) {
  Heap heap;
  heap.world->set_slide_budget(pairs(200));
  fly(heap, 6);
  std::vector<MotionCommand> commands;
  for (int i = 0; i < kMovers; ++i)
    commands.push_back(heap.world->move_by(heap.objects[i], {0.4, 0.02, -0.02}, {0.1, 0.2, 0.1}));
  const std::size_t before = allocation_count();
  std::size_t cut_off = 0;
  for (int k = 0; k < 10; ++k) cut_off += heap.world->frame(commands).cut_off.size();
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(cut_off, 0u);
}

#ifdef TOUCHSTONE_HAS_EXACT

/// The least separation of a mover from any other solid by `exact`, at samples of every part.
double least_executed(const Heap& heap, const Narrowphase& exact, Narrowphase::Workspace& workspace) {
  double least = kInfinity;
  Query query;
  query.kind = QueryKind::distance;
  std::vector<Pose> poses(kAll);
  for (std::size_t part = 0; part < heap.world->executed_parts(); ++part)
    for (const double s : {0.3, 0.7, 1.0}) {
      for (int i = 0; i < kAll; ++i) poses[i] = heap.world->executed_pose(heap.objects[i], part, s);
      for (SolidIndex a = 0; a < kMovers; ++a)
        for (SolidIndex b = a + 1; b < kAll; ++b) {
          if (!may_be_within(heap.solids[a], poses[a], heap.solids[b], poses[b])) continue;
          const SolidPair pair{a, b};
          PairStatus status{};
          PairGeometry geometry{};
          exact.evaluate({{&pair, 1}, poses, query}, {{&status, 1}, {&geometry, 1}, {}}, workspace);
          least = std::min(least, geometry.separation);
        }
    }
  return least;
}

// Whatever the budget, and cut off wherever that is: nothing merges.
TEST(SlideBudget, WhatIsCutOffStaysApart) {
  BackendRegistry registry;
  register_exact(registry);
  const auto exact = registry.make_narrowphase("exact");
  std::uint64_t cut_off = 0;
  for (const std::uint64_t most : {1, 5, 20, 60, 150, 400}) {
    Heap heap;
    exact->build(heap.solids);
    const auto workspace = exact->make_workspace();
    heap.world->set_slide_budget(pairs(most));
    for (int number = 0; number < 10; ++number) {
      cut_off += heap.frame(number).cut_off.size();
      ASSERT_GT(least_executed(heap, *exact, *workspace), 0.25 * kGap) << most << ", frame " << number;
    }
  }
  EXPECT_GT(cut_off, 0u);
}

#endif

}  // namespace
}  // namespace touchstone

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>

#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/random_solid.hpp"
#include "touchstone/tests/world/near_spheres.hpp"
#include "world_fixture.hpp"
#ifdef TOUCHSTONE_HAS_EXACT
#include "touchstone/adapters/exact/exact.hpp"
#endif

// Objects that go along with a mover, and others that stay.

namespace touchstone {
namespace {

PairRule going_along(ContactPolicy policy, Passive passive) {
  PairRule out = rule(policy);
  out.passive = passive;
  return out;
}

/// Boxes of 1 m in a row along x on a floor, a wall behind; `count` of them 0.5 m apart.
struct Row {
  std::unique_ptr<ContactWorld> world = make_world();
  std::vector<ObjectHandle> boxes;

  Row(int count, Passive passive, ContactPolicy policy = ContactPolicy::advance) {
    world->set_default_rule(going_along(policy, passive));
    world->add({box_tree("floor", {40, 40, 1}), at(0, 0, -1.0 - 1e-6), true});
    for (int i = 0; i < count; ++i)
      boxes.push_back(world->add({box_tree("box " + std::to_string(i), {1, 1, 1}), at(1.5 * i, 0, 0)}));
  }
  double x(int box) const { return world->actual_pose(boxes[box]).p.x(); }
  FrameReport push(double to) {
    const std::array commands{world->go_to(boxes[0], at(to, 0, 0))};
    return world->frame(commands);
  }
};

TEST(Shove, NothingIsCarriedByPairsThatHoldOrOnlyCue) {
  for (const ContactPolicy policy : {ContactPolicy::hold, ContactPolicy::cue}) {
    const auto world = make_world();
    world->set_default_rule(going_along(policy, Passive::carried));
    const ObjectHandle tray = world->add({box_tree("tray", {2, 2, 1}), at(0, 0, 0)});
    const ObjectHandle load = world->add({box_tree("load", {1, 1, 1}), at(0, 0, 1.0 + 0.75 * kGap)});
    for (const double x : {0.1, 0.2, 0.3}) {
      const std::array go{world->go_to(tray, at(x, 0, 0))};
      world->frame(go);
      EXPECT_EQ(world->actual_pose(load).p.x(), 0.0) << to_string(policy);
    }
  }
}

TEST(Shove, WhatStaysStops) {
  Row row(2, Passive::stays);
  row.push(2.0);
  EXPECT_NEAR(row.x(0), 0.5, 1e-6);
  EXPECT_EQ(row.x(1), 1.5);
}

TEST(Shove, TakesAlongOneAfterTheOther) {
  for (const ContactPolicy policy : {ContactPolicy::advance, ContactPolicy::slide}) {
    Row row(3, Passive::shoved, policy);
    row.push(3.0);
    EXPECT_EQ(row.x(0), 3.0);
    EXPECT_NEAR(row.x(1), 4.0, 1e-6);
    EXPECT_NEAR(row.x(2), 5.0, 1e-6);
    // Drawn back nothing follows.
    row.push(1.0);
    EXPECT_EQ(row.x(0), 1.0);
    EXPECT_NEAR(row.x(1), 4.0, 1e-6);
  }
}

TEST(Shove, EndsAtAWallForAll) {
  Row row(2, Passive::shoved);
  row.world->add({box_tree("wall", {1, 10, 10}), at(5.0, 0, 0), true});
  const FrameReport report = row.push(8.0);
  EXPECT_GT(report.blocked_movers, 0u);
  EXPECT_NEAR(row.x(1), 4.0, 1e-6);
  EXPECT_NEAR(row.x(0), 3.0, 1e-6);
  EXPECT_LT(row.x(0), 3.0);
}

// By a pair's rule alone; who has a command of its own is not passive, and not shoved.
TEST(Shove, IsChosenByPairAndOnlyOfThePassive) {
  Row row(3, Passive::stays);
  row.world->set_pair_rule(row.boxes[0], row.boxes[1], going_along(ContactPolicy::advance, Passive::shoved));
  row.push(3.0);
  EXPECT_NEAR(row.x(1), 2.0, 1e-6);
  EXPECT_NEAR(row.x(0), 1.0, 1e-6);
  EXPECT_EQ(row.x(2), 3.0);

  Row other(2, Passive::shoved);
  const std::array commands{other.world->go_to(other.boxes[0], at(3.0, 0, 0)),
                            other.world->go_to(other.boxes[1], at(1.5, 0, 0))};
  other.world->frame(commands);
  EXPECT_NEAR(other.x(0), 0.5, 1e-6);
  EXPECT_EQ(other.x(1), 1.5);
}

// Between two that come from either side it stays.
TEST(Shove, WhatTwoWantStays) {
  Row row(3, Passive::shoved);
  const std::array commands{row.world->go_to(row.boxes[0], at(1.5, 0, 0)),
                            row.world->go_to(row.boxes[2], at(1.5, 0, 0))};
  row.world->frame(commands);
  EXPECT_NEAR(row.x(1), 1.5, 1e-6);
  EXPECT_NEAR(row.x(0), 0.5, 1e-6);
  EXPECT_NEAR(row.x(2), 2.5, 1e-6);
}

TEST(Shove, ATrayCarriesItsLoad) {
  const auto world = make_world();
  world->set_default_rule(going_along(ContactPolicy::slide, Passive::carried));
  const ObjectHandle tray = world->add({box_tree("tray", {1, 1, 0.1}), {}});
  const ObjectHandle load = world->add({box_tree("load", {0.2, 0.2, 0.2}), at(0.2, 0.1, 0.15 + 0.75 * kGap)});
  const ObjectHandle top = world->add({box_tree("top", {0.1, 0.1, 0.1}), at(0.2, 0.1, 0.3 + 1.5 * kGap)});
  world->frame({});  // they are found in contact
  Pose goal;
  Random random(3);
  for (int frame = 0; frame < 200; ++frame) {
    goal = RigidPath::by(goal, random.vector(0.05), random.vector(0.05)).to();
    const std::array commands{world->go_to(tray, goal)};
    world->frame(commands);
    const Pose X_TL = compose(inverse(world->actual_pose(tray)), world->actual_pose(load));
    const Pose X_TU = compose(inverse(world->actual_pose(tray)), world->actual_pose(top));
    ASSERT_EQ(world->actual_pose(tray).p, goal.p) << frame;
    ASSERT_LT(norm(X_TL.p - Vector3(0.2, 0.1, 0.15)), 3 * kGap) << frame;
    ASSERT_LT(norm(X_TU.p - Vector3(0.2, 0.1, 0.3)), 4 * kGap) << frame;
    ASSERT_LT((X_TL.R - Matrix3::Identity()).cwiseAbs().maxCoeff(), 1e-12) << frame;
  }
}

constexpr int kMovers = 2, kAll = 14;

/// Two movers among twelve that are passive, in a box of a floor only.
struct Heap {
  std::unique_ptr<ContactWorld> world = make_world();
  std::vector<Hexahedron> solids;
  std::vector<ObjectHandle> objects = std::vector<ObjectHandle>(kAll);

  Heap(std::uint64_t seed, bool reversed) {
    Random random(seed);
    const ContactPolicy policy = random.one_in(2) ? ContactPolicy::slide : ContactPolicy::advance;
    world->set_default_rule(going_along(policy, random.one_in(2) ? Passive::shoved : Passive::carried));
    std::vector<Pose> X_WO;
    for (int i = 0; i < kAll; ++i) {
      solids.push_back(random_solid(random, 1.0));
      X_WO.push_back(at(1.3 * (i % 4), 1.3 * (i / 4), random.uniform(-0.1, 0.1)));
    }
    for (int k = 0; k < kAll; ++k) {
      const int i = reversed ? kAll - 1 - k : k;
      const auto tree = std::make_shared<HexahedronTree>(
          std::vector<PlacedHexahedron>{{"solid", solids[i], Pose{}}}, "solid " + std::to_string(i));
      objects[i] = world->add({tree, X_WO[i], i == kAll - 1});
    }
  }
  std::vector<MotionCommand> commands(Random& random) const {
    std::vector<MotionCommand> out;
    for (int i = 0; i < kMovers; ++i) {
      const Vector3 home = Vector3(2, 2, 0) - world->actual_pose(objects[i]).p;
      out.push_back(world->move_by(objects[i], 0.3 * home + random.vector(0.3), random.vector(0.3)));
    }
    return out;
  }
};

TEST(Shove, RegistrationOrderDoesNotShow) {
  int moved = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Heap first(seed, false), second(seed, true);
    Random random(seed);
    for (int frame = 0; frame < 8; ++frame) {
      const std::vector<MotionCommand> commands = first.commands(random);
      std::vector<MotionCommand> again;
      for (int i = 0; i < kMovers; ++i)
        again.insert(again.begin(), {second.objects[i], commands[static_cast<std::size_t>(i)].path});
      const Pose before = first.world->actual_pose(first.objects[5]);
      first.world->frame(commands), second.world->frame(again);
      moved += before.p != first.world->actual_pose(first.objects[5]).p;
      for (int i = 0; i < kAll; ++i) {
        const Pose &a = first.world->actual_pose(first.objects[i]),
                   &b = second.world->actual_pose(second.objects[i]);
        ASSERT_TRUE(a.p == b.p && a.R == b.R) << "seed " << seed << " frame " << frame << " object " << i;
      }
    }
  }
  EXPECT_GT(moved, 5);
}

TEST(Shove, CostsNoAllocation) {
  Heap heap(4, false);
  Random random(4);
  for (int frame = 0; frame < 20; ++frame) {
    const std::vector<MotionCommand> commands = heap.commands(random);
    const std::size_t before = allocation_count();
    heap.world->frame(commands);
    const std::size_t allocations = allocation_count() - before;
    if (frame > 0) {
      EXPECT_EQ(allocations, 0u) << frame;
    }
  }
}

#ifdef TOUCHSTONE_HAS_EXACT

bool is_apart(const Heap& heap, const Narrowphase& exact, Narrowphase::Workspace& workspace,
              std::span<const Pose> poses) {
  for (SolidIndex a = 0; a < kAll; ++a)
    for (SolidIndex b = a + 1; b < kAll; ++b) {
      if (!may_be_within(heap.solids[a], poses[a], heap.solids[b], poses[b])) continue;
      const SolidPair pair{a, b};
      PairStatus status{};
      PairGeometry geometry{};
      exact.evaluate({{&pair, 1}, poses, Query{}}, {{&status, 1}, {&geometry, 1}, {}}, workspace);
      if (status != PairStatus::separated) return false;
    }
  return true;
}

// Every pose that is executed, of those that go along too, judged by `exact`.
TEST(Shove, NothingMerges) {
  BackendRegistry registry;
  register_exact(registry);
  const auto exact = registry.make_narrowphase("exact");
  int went_along = 0;
  for (std::uint64_t seed = 100; seed < 125; ++seed) {
    Heap heap(seed, false);
    exact->build(heap.solids);
    const auto workspace = exact->make_workspace();
    std::vector<Pose> poses(kAll);
    const auto look = [&](std::size_t part, double s) {
      for (int i = 0; i < kAll; ++i) poses[i] = heap.world->executed_pose(heap.objects[i], part, s);
      return is_apart(heap, *exact, *workspace, poses);
    };
    Random random(seed);
    heap.world->frame({});
    if (!look(0, 0.0)) continue;  // overlaps from the start
    for (int frame = 0; frame < 10; ++frame) {
      std::array<Vector3, kAll> before;
      for (int i = 0; i < kAll; ++i) before[i] = heap.world->actual_pose(heap.objects[i]).p;
      heap.world->frame(heap.commands(random));
      for (int i = kMovers; i < kAll; ++i) {
        went_along += before[i] != heap.world->actual_pose(heap.objects[i]).p;
        ASSERT_EQ(heap.world->executed_pose(heap.objects[i], 0, 0.0).p, before[i]);
      }
      for (std::size_t part = 0; part < heap.world->executed_parts(); ++part)
        for (const double s : {0.25, 0.5, 0.75, 1.0})
          ASSERT_TRUE(look(part, s)) << "seed " << seed << " frame " << frame << " part " << part << " s "
                                     << s;
    }
  }
  EXPECT_GT(went_along, 30);
}

#endif

}  // namespace
}  // namespace touchstone

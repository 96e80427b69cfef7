#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>

#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/random_solid.hpp"
#include "touchstone/tests/world/arms/arm_fixture.hpp"
#include "touchstone/tests/world/near_spheres.hpp"
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

/// A tray with a load on it, and one on top of that, put together by set-up: no frame has seen them yet.
struct FreshTray {
  std::unique_ptr<ContactWorld> world = make_world();
  ObjectHandle tray, load, top;

  explicit FreshTray(ContactPolicy policy = ContactPolicy::slide) {
    world->set_default_rule(going_along(policy, Passive::carried));
    tray = world->add({box_tree("tray", {1, 1, 0.1}), {}});
    load = world->add({box_tree("load", {0.2, 0.2, 0.2}), at(0.2, 0.1, 0.15 + 0.75 * kGap)});
    top = world->add({box_tree("top", {0.1, 0.1, 0.1}), at(0.2, 0.1, 0.3 + 1.5 * kGap)});
  }
  FrameReport go_to(double x) {
    const std::array commands{world->go_to(tray, at(x, 0, 0))};
    return world->frame(commands);
  }
  double x(ObjectHandle object) const { return world->actual_pose(object).p.x(); }
};

TEST(Shove, ALoadIsCarriedFromTheFirstFrameOn) {
  FreshTray scene;
  const FrameReport report = scene.go_to(0.3);
  EXPECT_EQ(scene.x(scene.tray), 0.3);
  EXPECT_NEAR(scene.x(scene.load), 0.5, 1e-12);
  EXPECT_NEAR(scene.x(scene.top), 0.5, 1e-12);
  const std::vector<EventKind> reported = kinds(report);
  EXPECT_EQ(std::count(reported.begin(), reported.end(), EventKind::began), 2);
}

TEST(Shove, WhatSetUpPutsOnAMovingTrayIsCarriedAtOnce) {
  FreshTray scene;
  for (const double x : {0.1, 0.2}) scene.go_to(x);
  const ObjectHandle late = scene.world->add(
      {box_tree("late", {0.1, 0.1, 0.1}), at(scene.x(scene.tray) - 0.3, 0.1, 0.1 + 0.75 * kGap)});
  scene.go_to(0.4);
  EXPECT_NEAR(scene.x(late), 0.1, 1e-12);
  scene.world->select(SelectionChange::of(late, false));
  scene.go_to(0.5);
  EXPECT_NEAR(scene.x(late), 0.1, 1e-12);
  scene.world->select(SelectionChange::of(late, true));
  scene.go_to(0.7);
  EXPECT_NEAR(scene.x(late), 0.3, 1e-12);
}

TEST(Shove, WhatIsApartIsNotCarried) {
  FreshTray scene;
  const ObjectHandle apart =
      scene.world->add({box_tree("apart", {0.1, 0.1, 0.1}), at(-0.2, 0.1, 0.1 + 1.5 * kGap)});
  scene.go_to(0.3);
  EXPECT_EQ(scene.x(apart), -0.2);
}

/// An arm of three bars, the last from x = 4 to 6, and a box.
struct ArmScene {
  std::unique_ptr<ContactWorld> world = make_world();
  MechanismHandle arm;
  ObjectHandle box;

  ArmScene(ContactPolicy policy, Passive passive, const Pose& X_WO) {
    world->set_default_rule(going_along(policy, passive));
    arm = world->add_mechanism({make_arm("arm", 3), {}, {}});
    box = world->add({box_tree("box", {0.3, 0.3, 0.3}), X_WO});
  }
  Pose X_LO() const { return compose(inverse(world->link_poses(arm)[3]), world->actual_pose(box)); }
};

TEST(Shove, ALinkCarriesItsLoadHoweverItTurns) {
  ArmScene scene(ContactPolicy::slide, Passive::carried, at(5.5, 0, 0.25 + 0.75 * kGap));
  const Pose before = scene.X_LO();
  Random random(5);
  std::vector<double> joints{0, 0, 0};
  double gone = 0.0;
  for (int frame = 0; frame < 2000; ++frame) {
    for (double& q : joints) q = std::clamp(q + random.uniform(-0.1, 0.1), -1.0, 1.0);
    const Vector3 p = scene.world->actual_pose(scene.box).p;
    const FrameReport report = move_joints(*scene.world, scene.arm, joints);
    ASSERT_EQ(joints_of(*scene.world, scene.arm), joints) << frame;
    ASSERT_EQ(kinds(report), std::vector{frame == 0 ? EventKind::began : EventKind::persists}) << frame;
    gone += norm(scene.world->actual_pose(scene.box).p - p);
    // The executed poses are those that stand.
    const Pose end = scene.world->executed_pose(scene.box, scene.world->executed_parts() - 1, 1.0);
    ASSERT_LT(norm(end.p - scene.world->actual_pose(scene.box).p), 1e-14);
  }
  EXPECT_GT(gone, 100.0);
  EXPECT_LT(norm(scene.X_LO().p - before.p), 1e-13);
  EXPECT_LT((scene.X_LO().R - before.R).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(Shove, ALinkShovesWhatItMeets) {
  for (const ContactPolicy policy : {ContactPolicy::advance, ContactPolicy::slide}) {
    ArmScene scene(policy, Passive::shoved, at(5.0, 1.0, 0));
    const FrameReport report = move_joints(*scene.world, scene.arm, {0, 0, 1.2});
    EXPECT_GT(report.slide_steps, 0u);
    EXPECT_NEAR(joints_of(*scene.world, scene.arm)[2], 1.2, 1e-12) << to_string(policy);
    // It turned with the bar from where that met it.
    const Pose X_LO = scene.X_LO();
    const double turned =
        std::atan2(scene.world->actual_pose(scene.box).R(1, 0), scene.world->actual_pose(scene.box).R(0, 0));
    EXPECT_GT(turned, 0.3);
    EXPECT_LT(X_LO.p.y(), 0.1 + 0.15 * std::numbers::sqrt2);
    // Until then it stood.
    EXPECT_EQ(scene.world->executed_pose(scene.box, 0, 1.0).p, Vector3(5.0, 1.0, 0));
    // Drawn back nothing follows.
    const Pose left = scene.world->actual_pose(scene.box);
    move_joints(*scene.world, scene.arm, {0, 0, 0});
    EXPECT_EQ(scene.world->actual_pose(scene.box).p, left.p);
  }
}

TEST(Shove, AWallStopsALinkAndWhatItShoves) {
  ArmScene scene(ContactPolicy::advance, Passive::shoved, at(5.0, 1.0, 0));
  scene.world->add({box_tree("wall", {4, 0.2, 1}), at(5.0, 1.4, 0), true});
  const FrameReport report = move_joints(*scene.world, scene.arm, {0, 0, 1.2});
  EXPECT_EQ(report.blocked_movers, 1u);
  EXPECT_LT(joints_of(*scene.world, scene.arm)[2], 1.0);
  const double moved = norm(scene.world->actual_pose(scene.box).p - Vector3(5.0, 1.0, 0));
  EXPECT_GT(moved, 1e-3);
  EXPECT_LT(moved, 0.3);
}

// Two links that close on it both want it.
TEST(Shove, WhatTwoLinksSqueezeStays) {
  ArmScene scene(ContactPolicy::advance, Passive::shoved, at(3.3, 0.5, 0));
  // The last bar folds back onto the box, which lies on the second.
  scene.world->remove(scene.box);
  scene.box = scene.world->add({box_tree("box 2", {0.3, 0.3, 0.3}), at(3.0, 0.25 + 1e-7, 0)});
  move_joints(*scene.world, scene.arm, {0, 0, 2.5});
  const Vector3 before = scene.world->actual_pose(scene.box).p;
  move_joints(*scene.world, scene.arm, {0, 0, 3.1});
  const double stopped = joints_of(*scene.world, scene.arm)[2];
  EXPECT_LT(stopped, 3.1);
  // Bar 3 pushes it against bar 2 over the last 0.1 um, no further.
  EXPECT_LT(norm(scene.world->actual_pose(scene.box).p - before), 1e-5);
  move_joints(*scene.world, scene.arm, {0.2, 0.2, stopped});
  EXPECT_GT(joints_of(*scene.world, scene.arm)[0], 0.0);
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

constexpr int kLinks = 3, kLoose = 9, kParts = kLinks + kLoose;

/// An arm of three bars among solids that it shoves or carries, and a few that stand.
struct ArmHeap {
  std::unique_ptr<ContactWorld> world = make_world();
  std::vector<Hexahedron> solids;
  std::vector<ObjectHandle> objects = std::vector<ObjectHandle>(kParts);
  std::vector<Pose> X_OS = std::vector<Pose>(kParts);
  MechanismHandle arm;
  std::vector<double> joints{0, 0, 0};

  ArmHeap(std::uint64_t seed, bool reversed) {
    Random random(seed);
    const ContactPolicy policy = random.one_in(2) ? ContactPolicy::slide : ContactPolicy::advance;
    world->set_default_rule(going_along(policy, random.one_in(2) ? Passive::shoved : Passive::carried));
    const auto add_arm = [&] {
      arm = world->add_mechanism({make_arm("arm", kLinks), {}, {}});
      for (int k = 0; k < kLinks; ++k) objects[k] = world->link(arm, std::to_string(k + 1));
    };
    for (int k = 0; k < kLinks; ++k)
      solids.push_back(Hexahedron::from_size({2, 0.2, 0.2})), X_OS[k] = at(1, 0, 0);
    std::vector<ObjectDescription> loose;
    for (int i = 0; i < kLoose; ++i) {
      solids.push_back(random_solid(random, 0.4));
      const auto tree = std::make_shared<HexahedronTree>(
          std::vector<PlacedHexahedron>{{"solid", solids.back(), Pose{}}}, "solid " + std::to_string(i));
      const double side = i % 2 ? 0.9 : -0.9;
      loose.push_back({tree, at(1.5 + 0.5 * i, side + random.uniform(-0.1, 0.1), 0), i % 4 == 3});
    }
    if (!reversed) add_arm();
    for (int k = 0; k < kLoose; ++k) {
      const int i = reversed ? kLoose - 1 - k : k;
      objects[kLinks + i] = world->add(loose[i]);
    }
    if (reversed) add_arm();
  }
  FrameReport move(Random& random) {
    joints = joints_of(*world, arm);
    for (double& q : joints) q = std::clamp(q + random.uniform(-0.3, 0.3), -1.5, 1.5);
    return move_joints(*world, arm, joints);
  }
};

TEST(Shove, RegistrationOrderDoesNotShowOfWhatArmsTakeAlong) {
  int moved = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    ArmHeap first(seed, false), second(seed, true);
    Random random(seed), again(seed);
    for (int frame = 0; frame < 8; ++frame) {
      std::vector<Pose> before;
      for (const ObjectHandle object : first.objects) before.push_back(first.world->actual_pose(object));
      first.move(random), second.move(again);
      for (int i = 0; i < kParts; ++i) {
        const Pose &a = first.world->actual_pose(first.objects[i]),
                   &b = second.world->actual_pose(second.objects[i]);
        moved += i >= kLinks && before[i].p != a.p;
        ASSERT_TRUE(a.p == b.p && a.R == b.R) << "seed " << seed << " frame " << frame << " object " << i;
      }
    }
  }
  EXPECT_GT(moved, 20);
}

TEST(Shove, ArmsTakeAlongWithoutAllocation) {
  ArmHeap heap(3, false);
  Random random(4);
  for (int frame = 0; frame < 20; ++frame) {
    const std::size_t before = allocation_count();
    heap.world->frame({});
    const std::vector<double> joints{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    const std::size_t own = allocation_count();
    const JointCommand command{heap.arm, joints};
    heap.world->frame({}, {&command, 1});
    if (frame > 0) {
      EXPECT_EQ(allocation_count() - own, 0u) << frame;
    } else {
      EXPECT_GE(own, before);
    }
  }
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

/// @param first pairs of solids below this are no one's business.
bool is_apart(std::span<const Hexahedron> solids, SolidIndex first, const Narrowphase& exact,
              Narrowphase::Workspace& workspace, std::span<const Pose> poses) {
  for (SolidIndex a = 0; a < solids.size(); ++a)
    for (SolidIndex b = std::max(a + 1, first); b < solids.size(); ++b) {
      if (!may_be_within(solids[a], poses[a], solids[b], poses[b])) continue;
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
    // A heap, and `exact` for its poses on the way.
    Heap heap(seed, false);
    exact->build(heap.solids);
    const auto workspace = exact->make_workspace();
    std::vector<Pose> poses(kAll);
    const auto look = [&](std::size_t part, double s) {
      for (int i = 0; i < kAll; ++i) poses[i] = heap.world->executed_pose(heap.objects[i], part, s);
      return is_apart(heap.solids, 0, *exact, *workspace, poses);
    };
    Random random(seed);
    heap.world->frame({});
    if (!look(0, 0.0)) continue;  // overlaps from the start
    // Boxes that nobody commands go along from where they were.
    for (int frame = 0; frame < 10; ++frame) {
      std::array<Vector3, kAll> before;
      for (int i = 0; i < kAll; ++i) before[i] = heap.world->actual_pose(heap.objects[i]).p;
      heap.world->frame(heap.commands(random));
      for (int i = kMovers; i < kAll; ++i) {
        went_along += before[i] != heap.world->actual_pose(heap.objects[i]).p;
        ASSERT_EQ(heap.world->executed_pose(heap.objects[i], 0, 0.0).p, before[i]);
      }
      // Nothing overlaps within the frame.
      for (std::size_t part = 0; part < heap.world->executed_parts(); ++part)
        for (const double s : {0.25, 0.5, 0.75, 1.0})
          ASSERT_TRUE(look(part, s)) << "seed " << seed << " frame " << frame << " part " << part << " s "
                                     << s;
    }
  }
  EXPECT_GT(went_along, 30);
}

// The same of what an arm takes along.
TEST(Shove, NothingMergesThatArmsTakeAlong) {
  BackendRegistry registry;
  register_exact(registry);
  const auto exact = registry.make_narrowphase("exact");
  int went_along = 0, slid = 0;
  for (std::uint64_t seed = 200; seed < 260; ++seed) {
    // A heap about an arm, and `exact` for its poses on the way.
    ArmHeap heap(seed, false);
    exact->build(heap.solids);
    const auto workspace = exact->make_workspace();
    std::vector<Pose> poses(kParts);
    const auto look = [&](std::size_t part, double s) {
      for (int i = 0; i < kParts; ++i)
        poses[i] = compose(heap.world->executed_pose(heap.objects[i], part, s), heap.X_OS[i]);
      return is_apart(heap.solids, kLinks, *exact, *workspace, poses);
    };
    Random random(seed);
    heap.world->frame({});
    if (!look(0, 0.0)) continue;  // overlaps from the start
    // Boxes that the arm meets go along from where they were.
    for (int frame = 0; frame < 10; ++frame) {
      std::array<Vector3, kParts> before;
      for (int i = 0; i < kParts; ++i) before[i] = heap.world->actual_pose(heap.objects[i]).p;
      slid += heap.move(random).slide_steps > 0;
      for (int i = kLinks; i < kParts; ++i) {
        went_along += before[i] != heap.world->actual_pose(heap.objects[i]).p;
        ASSERT_LT(norm(heap.world->executed_pose(heap.objects[i], 0, 0.0).p - before[i]), 1e-14);
      }
      // Nothing overlaps within the frame.
      for (std::size_t part = 0; part < heap.world->executed_parts(); ++part)
        for (const double s : {0.25, 0.5, 0.75, 1.0})
          ASSERT_TRUE(look(part, s)) << "seed " << seed << " frame " << frame << " part " << part << " s "
                                     << s;
    }
  }
  EXPECT_GT(went_along, 30);
  EXPECT_GT(slid, 40);
}

#endif

}  // namespace
}  // namespace touchstone

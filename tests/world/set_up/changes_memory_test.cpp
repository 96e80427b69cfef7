#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <new>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/world/pairs/pair_rules.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/random.hpp"
#include "touchstone/tests/world/arms/arm_fixture.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

// Changes take place as a whole or not at all where memory ends, and what went leaves room for what comes.

namespace touchstone {
namespace {

// A mechanism that memory ends for is there as a whole, or not at all.
TEST(WorldChanges, AddAWholeArmOrNothingWhereMemoryEnds) {
  const auto mechanism = make_arm("arm", 3);
  bool is_added = false;
  for (std::size_t after = 0; !is_added; ++after) {
    ASSERT_LT(after, 5000u);
    const auto world = make_world();
    const ObjectHandle box = world->add({box_tree("box", {1, 1, 1}), at(1, 0, 9)});
    world->frame({});
    MechanismPlacement placement{mechanism, {}, {}, {"arms"}};
    MechanismHandle arm;
    try {
      const FailingAllocation failing(after);
      arm = world->add_mechanism(std::move(placement));
      is_added = true;
    } catch (const std::bad_alloc&) {
      EXPECT_THROW(world->find("arm.1"), InputError) << after;
      world->frame({});
      arm = world->add_mechanism({mechanism});
    }
    EXPECT_EQ(move_joints(*world, arm, {0.5, 0.5, 0.5}).blocked_movers, 0u) << after;
    EXPECT_EQ(joints_of(*world, arm), (std::vector<double>{0.5, 0.5, 0.5})) << after;
    EXPECT_TRUE(world->is_alive(box));
  }
}

// Where no memory is left at all, as where one allocation fails.
TEST(WorldChanges, AddAWholeArmOrNothingWhereNoMemoryIsLeft) {
  const auto mechanism = make_arm("arm", 3);
  bool is_added = false;
  for (std::size_t after = 0; !is_added; ++after) {
    ASSERT_LT(after, 5000u);
    const auto world = make_world();
    world->add({box_tree("box", {1, 1, 1}), at(1, 0, 9)});
    world->frame({});
    MechanismPlacement placement{mechanism, {}, {}, {"arms"}};
    try {
      const FailingAllocation failing(after, FailingAllocation::Fails::all);
      world->add_mechanism(std::move(placement));
      is_added = true;
    } catch (const std::bad_alloc&) {
      EXPECT_NO_THROW(world->frame({})) << after;
      EXPECT_NO_THROW(world->add_mechanism({mechanism})) << after;
    }
    EXPECT_TRUE(world->is_alive(world->find("arm.1")));
  }
}

// A mechanism is gone as a whole or still there, and what comes later in its places is checked.
TEST(WorldChanges, RemoveAWholeArmOrNothingWhereMemoryEnds) {
  using Fails = FailingAllocation::Fails;
  for (const Fails fails : {Fails::one, Fails::all}) {
    bool is_removed = false;
    for (std::size_t after = 0; !is_removed; ++after) {
      ASSERT_LT(after, 100u);
      const auto world = make_world();
      world->set_default_rule(rule(ContactPolicy::advance));
      const ObjectHandle box = world->add({box_tree("box", {1, 1, 1}), at(0, 0, 9)});
      const MechanismHandle arm = world->add_mechanism({make_arm("arm", 3)});
      world->exempt({box, world->link(arm, "1")});
      world->frame({});
      try {
        const FailingAllocation failing(after, fails);
        world->remove_mechanism(arm);
        is_removed = true;
      } catch (const std::bad_alloc&) {
        EXPECT_TRUE(world->is_alive(world->link(arm, "1"))) << after;
        EXPECT_EQ(move_joints(*world, arm, {0.5, 0.5, 0.5}).blocked_movers, 0u) << after;
        world->remove_mechanism(arm);
      }
      EXPECT_FALSE(world->is_alive(arm));
      // Boxes in the places of all links.
      for (int i = 0; i < 4; ++i)
        world->add({box_tree("wall " + std::to_string(i), {1, 1, 1}), at(2.0 + 1.5 * i, 0, 9)});
      const MotionCommand command = world->move_by(box, {9, 0, 0}, {0, 0, 0});
      EXPECT_EQ(world->frame({&command, 1}).blocked_movers, 1u) << after;
    }
  }
}

TEST(WorldChanges, RemoveAWholeObjectOrNothingWhereMemoryEnds) {
  bool is_removed = false;
  for (std::size_t after = 0; !is_removed; ++after) {
    ASSERT_LT(after, 100u);
    const auto world = make_world();
    const ObjectHandle first = world->add({box_tree("first", {1, 1, 1}), at(0, 0, 0)});
    const ObjectHandle second = world->add({box_tree("second", {1, 1, 1}), at(2, 0, 0)});
    world->exempt({first, second});
    world->frame({});
    try {
      const FailingAllocation failing(after, FailingAllocation::Fails::all);
      world->remove(second);
      is_removed = true;
    } catch (const std::bad_alloc&) {
      ASSERT_TRUE(world->is_alive(second)) << after;
      world->remove(second);
    }
    world->add({box_tree("third", {1, 1, 1}), at(2, 0, 0)});
    const MotionCommand command = world->move_by(first, {2, 0, 0}, {0, 0, 0});
    EXPECT_EQ(world->frame({&command, 1}).blocked_movers, 1u) << after;
  }
}

// Taken up again from where memory ended, an exemption counts once.
TEST(WorldChanges, TakeUpSetUpAnewWhereMemoryEnded) {
  bool is_taken_up = false;
  for (std::size_t after = 0; !is_taken_up; ++after) {
    ASSERT_LT(after, 5000u);
    // Changes of each kind wait for the next frame.
    const auto world = make_world();
    std::vector<ObjectHandle> boxes;
    for (int i = 0; i < 4; ++i)
      boxes.push_back(world->add({box_tree("box " + std::to_string(i), {1, 1, 1}), at(2.0 * i, 0, 0)}));
    world->frame({});
    const ObjectHandle added = world->add({box_tree("added", {1, 1, 1}), at(0, 5, 0)});
    world->remove(boxes[3]);
    world->exempt({boxes[0], boxes[1]});
    world->exempt({boxes[0], added});
    // Memory ends somewhere while they are taken up, and is there again.
    try {
      const FailingAllocation failing(after);
      world->prepare();
      is_taken_up = true;
    } catch (const std::bad_alloc&) {
      world->prepare();
    }
    // Exempt twice, a pair would still pass here.
    world->unexempt({boxes[0], boxes[1]});
    world->unexempt({boxes[0], added});
    for (const Vector3& there : {Vector3(2, 0, 0), Vector3(0, 5, 0)}) {
      const MotionCommand command = world->move_by(boxes[0], there, {0, 0, 0});
      EXPECT_EQ(world->frame({&command, 1}).blocked_movers, 1u) << after;
    }
  }
}

TEST(WorldChanges, ResetsNeedNoMemory) {
  const auto world = make_world();
  std::vector<ObjectHandle> boxes;
  for (int i = 0; i < 100; ++i)
    boxes.push_back(world->add({box_tree("box " + std::to_string(i), {1, 1, 1}), at(2 * i, 9, 0)}));
  const MechanismHandle arm = world->add_mechanism({make_arm("arm", 3)});
  for (int i = 0; i < 40; i += 2)
    world->latch(boxes[i], boxes[i + 1], {{boxes[i], boxes[90]}, {boxes[i + 1], boxes[90]}});
  world->frame({});
  move_joints(*world, arm, {0.5, 0.5, 0.5});
  const MotionCommand command = world->move_by(boxes[50], {0.5, 0, 0}, {0, 0, 0});
  world->frame({&command, 1});
  for (const ObjectHandle box : boxes) world->select({SelectionChange::Scope::object, false, box});
  {
    const FailingAllocation failing(0, FailingAllocation::Fails::all);
    world->reset();
  }
  world->frame({});
  EXPECT_EQ(joints_of(*world, arm), (std::vector<double>{0, 0, 0}));
  EXPECT_EQ(world->solid_poses(boxes[50])[0].p, Vector3(100, 9, 0));
  EXPECT_NO_THROW(world->latch(boxes[1], boxes[0]));
}

struct Grid {
  std::unique_ptr<ContactWorld> world = make_world();
  std::vector<ObjectHandle> objects;

  explicit Grid(int count) {
    world->set_default_rule(rule(ContactPolicy::advance));
    for (int i = 0; i < count; ++i)
      objects.push_back(world->add({box_tree("box " + std::to_string(i), {1, 1, 1}),
                                    at(1.2 * (i % 10), 1.2 * (i / 10 % 10), 1.2 * (i / 100)),
                                    false,
                                    {i % 2 == 0 ? "even" : "odd"}}));
    world->prepare();
  }
};

TEST(WorldChanges, PoliciesAllocateNothing) {
  Grid grid(200);
  const auto set_all = [&](ContactPolicy policy) {
    grid.world->set_default_rule(rule(policy));
    grid.world->set_group_rule("even", "odd", rule(policy));
    for (int i = 0; i < 100; ++i)
      grid.world->set_pair_rule(grid.objects[i], grid.objects[i + 1], rule(policy));
  };
  set_all(ContactPolicy::slide);
  grid.world->frame({});
  const std::size_t before = allocation_count();
  for (int frame = 0; frame < 20; ++frame) {
    set_all(frame % 2 == 0 ? ContactPolicy::advance : ContactPolicy::slide);
    grid.world->frame({});
  }
  EXPECT_EQ(allocation_count(), before);
}

/// A table of one object, beside another's slot if that is to be used again.
struct SmallTable {
  ObjectTable objects;

  explicit SmallTable(bool has_free_slot) {
    objects.add({box_tree("first", {1, 1, 1}), at(0, 0, 0), false, {"old"}});
    if (has_free_slot) objects.remove(objects.add({box_tree("gone", {1, 1, 1}), at(2, 0, 0)}));
    objects.forget_changes();
  }
};

void expect_nothing_was_added(const SmallTable& table, const SmallTable& before, std::size_t after) {
  const ObjectTable& objects = table.objects;
  ASSERT_EQ(objects.size(), before.objects.size()) << after;
  EXPECT_THROW(objects.find("box"), InputError) << after;
  EXPECT_FALSE(objects.find_group("new")) << after;
  EXPECT_EQ(objects.members_of_group(0).size(), 1u) << after;
  EXPECT_TRUE(objects.changes().empty()) << after;
  for (std::uint32_t slot = 1; slot < objects.size(); ++slot) EXPECT_FALSE(objects[slot].alive) << after;
  EXPECT_EQ(make_layout(objects).slots(), objects.size());
}

// Wherever memory ends while an object is added: it is there, or nothing of it is.
TEST(ObjectTable, AddsAWholeObjectOrNothingWhereMemoryEnds) {
  const auto tree = box_tree("box", {1, 1, 1});
  for (const bool has_free_slot : {false, true}) {
    const SmallTable before(has_free_slot);
    bool is_added = false;
    for (std::size_t after = 0; !is_added; ++after) {
      ASSERT_LT(after, 100u);
      SmallTable table(has_free_slot);
      ObjectDescription description{tree, at(0, 0, 0), false, {"old", "new"}};
      const ObjectDescription again = description;
      try {
        const FailingAllocation failing(after);
        table.objects.add(std::move(description));
        is_added = true;
      } catch (const std::bad_alloc&) {
        expect_nothing_was_added(table, before, after);
        table.objects.add(again);
      }
      EXPECT_EQ(table.objects.find("box").slot, 1u);
      EXPECT_EQ(table.objects.members_of_group(*table.objects.find_group("new")).size(), 1u);
    }
  }
}

// A reset notes its changes and frees carried objects, wherever memory ends.
TEST(ObjectTable, ResetsAsAWholeWhereMemoryEnds) {
  bool is_reset = false;
  for (std::size_t after = 0; !is_reset; ++after) {
    ASSERT_LT(after, 100u);
    ObjectTable objects;
    for (int i = 0; i < 4; ++i) objects.add({box_tree(std::to_string(i), {1, 1, 1}), at(2 * i, 0, 0)});
    objects.latch(objects.handle(0), objects.handle(1),
                  std::array{Exemption{objects.handle(1), objects.handle(3)}});
    objects.latch(objects.handle(1), objects.handle(2), {});
    objects.forget_changes();
    for (const std::uint32_t slot : {0, 1, 2}) objects[slot].X_WO = at(0, 2 * slot, 5);
    try {
      const FailingAllocation failing(after, FailingAllocation::Fails::all);
      objects.reset();
      is_reset = true;
    } catch (const std::bad_alloc&) {
      objects.reset();
    }
    EXPECT_EQ(objects.changes().moved, (std::vector<std::uint32_t>{0, 1, 2})) << after;
    for (const std::uint32_t slot : {1, 2}) {
      EXPECT_EQ(objects[slot].body, slot) << after;
      EXPECT_EQ(std::count(objects.changes().rebodied.begin(), objects.changes().rebodied.end(), slot), 1);
    }
  }
}

// Of more than a hundred lists a few take more memory at a time: frames after an object came cost about as
// much, however many come.
TEST(WorldChanges, MakeFewListsGrowAtATime) {
  constexpr int kCount = 300;
  Grid grid(kCount);
  for (int i = kCount; i < 5 * kCount; ++i) {
    grid.world->add({box_tree("box " + std::to_string(i), {1, 1, 1}),
                     at(1.2 * (i % 10), 1.2 * (i / 10 % 10), 1.2 * (i / 100)), i % 5 == 0});
    const std::size_t before = allocation_count();
    grid.world->frame({});
    EXPECT_LE(allocation_count() - before, 24u) << "object " << i;
  }
}

TEST(WorldChanges, AMillionRulesTakeNoMoreMemoryThanThoseInForce) {
  Grid grid(50);
  const auto set = [&](int i) {
    const ObjectHandle a = grid.objects[i % 50], b = grid.objects[(i * 7 + 1) % 50];
    if (a != b) grid.world->set_pair_rule(a, b, i % 3 == 0 ? PairRule{} : rule(ContactPolicy::slide, 0.1));
    grid.world->set_group_rule("even", i % 2 == 0 ? "odd" : "even",
                               rule(ContactPolicy::hold, 0.01 * (i % 2)));
    if (i % 1000 == 0) grid.world->frame({});
  };
  for (int i = 0; i < 10000; ++i) set(i);
  const std::size_t before = allocation_count();
  for (int i = 0; i < 1000000; ++i) set(i);
  EXPECT_EQ(allocation_count(), before);
}

TEST(PairRules, OfObjectsThatAreGoneMakeRoom) {
  ObjectTable objects;
  PairRules rules;
  const ObjectHandle stays = objects.add({box_tree("stays", {1, 1, 1}), {}});
  for (int i = 0; i < 100000; ++i) {
    const ObjectHandle goes = objects.add({box_tree("goes", {1, 1, 1}), {}});
    rules.set_for_pair(objects, goes, stays, rule(ContactPolicy::slide));
    EXPECT_EQ(rules.find(objects, goes.slot, stays.slot).policy, ContactPolicy::slide);
    objects.remove(goes);
  }
  EXPECT_LE(rules.room(), 16u);
  const ObjectHandle next = objects.add({box_tree("next", {1, 1, 1}), {}});
  EXPECT_EQ(rules.find(objects, next.slot, stays.slot).policy, ContactPolicy::hold);
}

// Rules of pairs come and go at random; a table with open addressing must lose none.
TEST(PairRules, AreFoundWhateverWasTakenBack) {
  Random random(5);
  ObjectTable objects;
  PairRules rules;
  std::vector<ObjectHandle> handles;
  for (int i = 0; i < 30; ++i) handles.push_back(objects.add({box_tree(std::to_string(i), {1, 1, 1}), {}}));
  std::vector<int> expected(30 * 30, 0);
  for (int i = 0; i < 20000; ++i) {
    std::uint32_t a = random.below(30), b = random.below(30);
    if (a == b) continue;
    if (a > b) std::swap(a, b);
    const bool on = random.below(2) == 0;
    rules.set_for_pair(objects, handles[b], handles[a], on ? rule(ContactPolicy::slide) : PairRule{});
    expected[30 * a + b] = on ? 1 : 0;
    const std::uint32_t c = random.below(30), d = random.below(30);
    if (c >= d) continue;
    ASSERT_EQ(rules.find(objects, c, d).policy == ContactPolicy::slide, expected[30 * c + d] == 1);
  }
}

TEST(WorldChanges, NamesAndSlotsOfObjectsThatWentAreUsedAgain) {
  Grid grid(20);
  const std::uint32_t slot = grid.objects[7].slot;
  grid.world->remove(grid.objects[7]);
  EXPECT_FALSE(grid.world->is_alive(grid.objects[7]));
  const ObjectHandle next = grid.world->add({box_tree("box 7", {1, 1, 1}), at(0, 0, 9)});
  EXPECT_EQ(next.slot, slot);
  EXPECT_NE(next.generation, grid.objects[7].generation);
  EXPECT_EQ(grid.world->find("box 7"), next);
  EXPECT_TRUE(grid.world->solid_poses(next).empty());
  grid.world->frame({});
  EXPECT_EQ(grid.world->solid_poses(next)[0].p, Vector3(0, 0, 9));
}

}  // namespace
}  // namespace touchstone

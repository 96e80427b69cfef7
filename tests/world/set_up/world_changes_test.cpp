#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <new>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/world/pairs/pair_rules.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/random.hpp"
#include "touchstone/tests/world/arms/arm_fixture.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

// A world that changes at run time answers as one that is built anew for every frame.

namespace touchstone {
namespace {

bool is_same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool is_same(const PairGeometry& a, const PairGeometry& b) {
  bool same = is_same(a.separation, b.separation);
  for (int i = 0; i < 3; ++i)
    same = same && is_same(a.n_AB_W(i), b.n_AB_W(i)) && is_same(a.p_A_W(i), b.p_A_W(i)) &&
           is_same(a.p_B_W(i), b.p_B_W(i));
  return same;
}

bool is_same(const ContactEvent& a, const ContactEvent& b) {
  return a.kind == b.kind && a.a == b.a && a.b == b.b && a.solids == b.solids && is_same(a.s, b.s) &&
         a.part == b.part && is_same(a.geometry, b.geometry) && is_same(a.geometry_at_end, b.geometry_at_end);
}

/// One world that takes up what changes, and one to which the same is done and whose backends are new in
/// every frame.
class Twins {
 public:
  std::array<std::unique_ptr<ContactWorld>, 2> worlds{make_world(), make_world()};
  std::vector<ObjectHandle> objects;  // of those there are, but for links
  std::vector<MechanismHandle> arms;

  explicit Twins(std::uint64_t seed) : random_(seed) {
    for (auto& world : worlds) world->set_default_rule(rule(ContactPolicy::slide, 0.02));
    for (int i = 0; i < 24; ++i) add();
  }

  void change() {
    const ObjectHandle a = any(), b = any();
    switch (random_.below(16)) {
      case 0:
      case 1:
        return add();
      case 2:
      case 3:
        return remove(a);
      case 4:
        return latch(a, b);
      case 5:
        return attempt([&](ContactWorld& world) { world.unlatch(a); });
      case 6:
        return attempt([&](ContactWorld& world) { world.exempt({a, b}); });
      case 7:
        return attempt([&](ContactWorld& world) { world.unexempt({a, b}); });
      case 8: {
        const PairRule rule = any_rule();
        return attempt([&](ContactWorld& world) { world.set_pair_rule(a, b, rule); });
      }
      case 9: {
        const PairRule rule = any_rule();
        const std::string first = any_group(), second = any_group();
        return attempt([&](ContactWorld& world) { world.set_group_rule(first, second, rule); });
      }
      case 11:
        return arms.size() < 3 ? add_arm() : remove_arm();
      case 12:
        if (random_.one_in(3)) remove_arm();
        return;
      case 13:
        if (!arms.empty()) latch(worlds[0]->link(any_arm(), "3"), a);
        return;
      case 14:
        if (random_.one_in(8)) attempt([](ContactWorld& world) { world.reset(); });
        return;
      case 10: {
        const bool on = random_.below(2) == 0;
        return attempt([&](ContactWorld& world) { world.select(SelectionChange::of(a, on)); });
      }
      default: {
        const PairRule rule = any_rule();
        if (random_.below(8) == 0) attempt([&](ContactWorld& world) { world.set_default_rule(rule); });
      }
    }
  }

  void fly(int frame) {
    std::vector<MotionCommand> commands;
    for (const ObjectHandle& object : objects)
      if (random_.below(3) == 0)
        commands.push_back(worlds[0]->move_by(object, random_.vector(0.3), random_.vector(0.2)));
    std::vector<std::vector<double>> values;
    for (const MechanismHandle arm : arms) {
      values.push_back(joints_of(*worlds[0], arm));
      for (double& q : values.back()) q = std::clamp(q + random_.uniform(-0.2, 0.2), -3.0, 3.0);
    }
    std::vector<JointCommand> joints;
    for (std::size_t i = 0; i < arms.size(); ++i) joints.push_back({arms[i], values[i]});
    worlds[1]->set_broadphase(make_native_broadphase());
    worlds[1]->set_narrowphase(make_native());
    const FrameReport one = worlds[0]->frame(commands, joints), other = worlds[1]->frame(commands, joints);
    for (const MechanismHandle arm : arms)
      ASSERT_EQ(joints_of(*worlds[0], arm), joints_of(*worlds[1], arm)) << "frame " << frame;
    for (const ObjectHandle& object : objects)
      ASSERT_TRUE(is_same(worlds[0]->actual_pose(object), worlds[1]->actual_pose(object)))
          << "frame " << frame << ", " << worlds[0]->name_of(object);
    ASSERT_EQ(one.events.size(), other.events.size()) << "frame " << frame;
    for (std::size_t i = 0; i < one.events.size(); ++i)
      ASSERT_TRUE(is_same(one.events[i], other.events[i])) << "frame " << frame << ", event " << i;
    ASSERT_EQ(one.blocked_movers, other.blocked_movers);
    events += one.events.size();
  }

  std::size_t events = 0;

 private:
  template <class Change>
  void attempt(Change change) {
    std::array<bool, 2> refused{};
    for (std::size_t i = 0; i < 2; ++i) {
      try {
        change(*worlds[i]);
      } catch (const std::exception&) {
        refused[i] = true;
      }
    }
    ASSERT_EQ(refused[0], refused[1]);
  }

  MechanismHandle any_arm() { return arms[random_.below(static_cast<std::uint32_t>(arms.size()))]; }
  ObjectHandle any() { return objects[random_.below(static_cast<std::uint32_t>(objects.size()))]; }
  std::string any_group() { return std::string(1, static_cast<char>('a' + random_.below(3))); }

  PairRule any_rule() {
    PairRule rule;
    constexpr std::array kPolicies{ContactPolicy::cue, ContactPolicy::hold, ContactPolicy::advance,
                                   ContactPolicy::slide};
    if (random_.below(3) != 0) rule.policy = kPolicies[random_.below(4)];
    if (random_.below(2) != 0) rule.warn_distance = 0.1 * random_.below(8);
    return rule;
  }

  void add() {
    std::vector<PlacedHexahedron> solids;
    const std::uint32_t count = 1 + random_.below(3) / 2 * 2;  // 1 or 3
    for (std::uint32_t i = 0; i < count; ++i) {
      const Vector3 size = Vector3::Constant(0.6) + random_.vector(0.3);
      solids.push_back({"solid " + std::to_string(i), Hexahedron::from_size(size), at(0.7 * i, 0, 0)});
    }
    const auto tree = std::make_shared<HexahedronTree>(solids, "object " + std::to_string(named_++));
    const Vector3 p = random_.vector(2.5);
    const ObjectDescription description{tree, at(p.x(), p.y(), p.z()), random_.below(6) == 0, {any_group()}};
    const ObjectHandle one = worlds[0]->add(description), other = worlds[1]->add(description);
    ASSERT_EQ(one, other);
    objects.push_back(one);
  }

  void add_arm() {
    const auto mechanism = make_arm("arm " + std::to_string(named_++), 3);
    const Vector3 p = random_.vector(2.5);
    const MechanismPlacement placement{mechanism, at(p.x(), p.y(), p.z()), {}, {any_group()}};
    const MechanismHandle one = worlds[0]->add_mechanism(placement);
    ASSERT_EQ(one, worlds[1]->add_mechanism(placement));
    arms.push_back(one);
  }

  void remove_arm() {
    if (arms.empty()) return;
    const MechanismHandle arm = any_arm();
    bool gone = false;
    attempt([&](ContactWorld& world) {
      world.remove_mechanism(arm);
      gone = true;
    });
    if (gone) std::erase(arms, arm);
  }

  void remove(ObjectHandle object) {
    if (objects.size() < 12) return;
    bool gone = false;
    attempt([&](ContactWorld& world) {
      world.remove(object);
      gone = true;
    });
    if (gone) std::erase(objects, object);
  }

  void latch(ObjectHandle carrier, ObjectHandle carried) {
    const ObjectHandle third = any();
    const bool allows = random_.below(2) == 0 && third != carried;
    attempt([&](ContactWorld& world) {
      if (allows)
        world.latch(carrier, carried, {{carried, third}});
      else
        world.latch(carrier, carried);
    });
  }

  Random random_;
  int named_ = 0;
};

TEST(WorldChanges, AnswerAsAWorldBuiltAnew) {
  std::size_t events = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Twins twins(seed);
    for (int frame = 0; frame < 60; ++frame) {
      for (int i = frame % 4; i > 0; --i) twins.change();
      twins.fly(frame);
      if (::testing::Test::HasFatalFailure()) FAIL() << "seed " << seed;
    }
    events += twins.events;
  }
  EXPECT_GT(events, 5000u);
}

// Many more objects than come or go at once: what a small world builds anew is taken up here.
TEST(WorldChanges, OfACrowdAnswerAsAWorldBuiltAnew) {
  Twins twins(77);
  for (int i = 0; i < 300; ++i) twins.change();
  for (int frame = 0; frame < 40; ++frame) {
    twins.change();
    twins.fly(frame);
    if (::testing::Test::HasFatalFailure()) FAIL();
  }
}

/// Native, and how often it was built.
class CountsBuilds final : public Narrowphase {
 public:
  explicit CountsBuilds(std::shared_ptr<int> builds) : builds_(std::move(builds)) {}
  std::string_view name() const noexcept override { return "counts_builds"; }
  const Capabilities& capabilities() const noexcept override { return native_->capabilities(); }
  void build(std::span<const Hexahedron> solids) override {
    ++*builds_;
    native_->build(solids);
  }
  bool set_solids(SolidIndex first, std::span<const Hexahedron> solids) override {
    return native_->set_solids(first, solids);
  }
  std::unique_ptr<Workspace> make_workspace() const override { return native_->make_workspace(); }
  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    native_->evaluate(input, output, workspace);
  }

 private:
  std::unique_ptr<Narrowphase> native_ = make_native();
  std::shared_ptr<int> builds_;
};

TEST(WorldChanges, OfArmsWarnDistancesAndResetsBuildNothingAnew) {
  const auto builds = std::make_shared<int>(0);
  const auto world = make_world();
  world->set_narrowphase(std::make_unique<CountsBuilds>(builds));
  for (int i = 0; i < 20; ++i)
    world->add({box_tree("box " + std::to_string(i), {1, 1, 1}), at(1.2 * i, 9, 0)});
  world->frame({});
  ASSERT_EQ(*builds, 1);
  // Arms come and go, in the places of others too.
  const MechanismHandle first = world->add_mechanism({make_arm("first", 3)});
  world->frame({});
  world->add_mechanism({make_arm("second", 3), at(0, 3, 0)});
  world->remove_mechanism(first);
  world->frame({});
  const MechanismHandle third = world->add_mechanism({make_arm("third", 2)});
  EXPECT_EQ(move_joints(*world, third, {0.5, 0.5}).blocked_movers, 0u);
  EXPECT_EQ(*builds, 1);
  // All are watched further out, or stand elsewhere.
  world->set_default_rule(rule(ContactPolicy::slide, 0.3));
  EXPECT_FALSE(world->frame({}).events.empty());  // boxes 0.2 m apart
  world->reset();
  world->frame({});
  EXPECT_EQ(joints_of(*world, third), (std::vector<double>{0, 0}));
  EXPECT_EQ(*builds, 1);
}

/// The native one, which counts the objects that it is given as moved.
class CountsMoved final : public Broadphase {
 public:
  explicit CountsMoved(std::shared_ptr<std::size_t> moved) : moved_(std::move(moved)) {
    BackendRegistry registry;
    register_broadphases(registry);
    native_ = registry.make_broadphase("native");
  }
  std::string_view name() const noexcept override { return "counts_moved"; }
  void build(const BroadphaseInput& input) override { native_->build(input); }
  void update(std::span<const Pose> poses, std::span<const std::uint32_t> moved) noexcept override {
    *moved_ += moved.size();
    native_->update(poses, moved);
  }
  bool update_paths(const SolidPaths& paths, std::span<const std::uint32_t> moved) noexcept override {
    *moved_ += moved.size();
    return native_->update_paths(paths, moved);
  }
  bool set_object(std::uint32_t object, const HexahedronTree* tree, bool is_static) override {
    return native_->set_object(object, tree, is_static);
  }
  bool find_partners(SolidIndex solid, std::vector<SolidIndex>& out) noexcept override {
    return native_->find_partners(solid, out);
  }
  bool find_moved_pairs(std::vector<SolidPair>& out) noexcept override {
    return native_->find_moved_pairs(out);
  }
  std::size_t find_pairs(PairCursor& cursor, std::span<SolidPair> block) noexcept override {
    return native_->find_pairs(cursor, block);
  }

 private:
  std::unique_ptr<Broadphase> native_;
  std::shared_ptr<std::size_t> moved_;
};

// Of many objects the few that moved stand where they began, what they touched is reported anew, and what was
// carried is free.
TEST(WorldChanges, OfResetsTouchWhatMoved) {
  const auto moved = std::make_shared<std::size_t>(0);
  const auto world = make_world();
  world->set_broadphase(std::make_unique<CountsMoved>(moved));
  world->set_default_rule(rule(ContactPolicy::slide));
  std::vector<ObjectHandle> boxes;
  for (int i = 0; i < 200; ++i)
    boxes.push_back(world->add({box_tree("box " + std::to_string(i), {1, 1, 1}), at(1.2 * i, 0, 0)}));
  world->frame({});
  world->latch(boxes[5], boxes[6]);
  const MotionCommand command = world->move_by(boxes[3], {0.5, 0, 0}, {0, 0, 0});
  for (int run = 0; run < 3; ++run) {
    const FrameReport report = world->frame({&command, 1});
    ASSERT_EQ(report.blocked_movers, 1u) << run;
    EXPECT_EQ(kinds(report), (std::vector{EventKind::blocked, EventKind::began})) << run;
    world->frame({});
    world->reset();
    EXPECT_TRUE(world->solid_poses(boxes[0]).empty());
    *moved = 0;
    EXPECT_TRUE(world->frame({}).events.empty()) << run;
    EXPECT_GE(*moved, 1u) << run;
    EXPECT_LE(*moved, 3u) << run;  // the one that moved, and the two that were latched
    EXPECT_EQ(world->actual_pose(boxes[3]).p, Vector3(1.2 * 3, 0, 0));
    EXPECT_EQ(world->solid_poses(boxes[3])[0].p, Vector3(1.2 * 3, 0, 0));
    EXPECT_NO_THROW(world->latch(boxes[5], boxes[6]));
  }
}

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
    const auto world = make_world();
    std::vector<ObjectHandle> boxes;
    for (int i = 0; i < 4; ++i)
      boxes.push_back(world->add({box_tree("box " + std::to_string(i), {1, 1, 1}), at(2.0 * i, 0, 0)}));
    world->frame({});
    const ObjectHandle added = world->add({box_tree("added", {1, 1, 1}), at(0, 5, 0)});
    world->remove(boxes[3]);
    world->exempt({boxes[0], boxes[1]});
    world->exempt({boxes[0], added});
    try {
      const FailingAllocation failing(after);
      world->prepare();
      is_taken_up = true;
    } catch (const std::bad_alloc&) {
      world->prepare();
    }
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

// An arm that is refused, here as a link's name is taken, leaves no group.
TEST(WorldChanges, RefusedArmsLeaveNoGroups) {
  const auto world = make_world();
  const auto mechanism = make_arm("arm", 3);
  const ObjectHandle taken = world->add({box_tree("arm.2", {1, 1, 1}), at(0, 0, 9)});
  for (int i = 0; i < 70; ++i)
    EXPECT_THROW(world->add_mechanism({mechanism, {}, {}, {"group " + std::to_string(i)}}), InputError);
  world->remove(taken);
  EXPECT_NO_THROW(world->add_mechanism({mechanism, {}, {}, {"arms"}}));
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

// What a reset changes is noted, and carried objects are free, wherever memory ends.
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

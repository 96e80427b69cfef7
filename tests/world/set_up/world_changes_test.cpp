#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
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

  explicit Twins(std::uint64_t seed, int count = 24) : random_(seed) {
    for (auto& world : worlds) world->set_default_rule(rule(ContactPolicy::slide, 0.02));
    for (int i = 0; i < count; ++i) add();
  }

  void change() {
    const ObjectHandle a = any(), b = any();
    // One of all changes, where there is something to change.
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
    // Commands at random.
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
    fly(frame, commands, joints);
  }

  void fly(int frame, const std::vector<MotionCommand>& commands, const std::vector<JointCommand>& joints) {
    // One world goes on; the other's backends are new.
    worlds[1]->set_broadphase(make_native_broadphase());
    worlds[1]->set_narrowphase(make_native());
    const FrameReport one = worlds[0]->frame(commands, joints), other = worlds[1]->frame(commands, joints);
    // Poses and events have the same bits.
    for (const MechanismHandle arm : arms)
      ASSERT_EQ(joints_of(*worlds[0], arm), joints_of(*worlds[1], arm)) << "frame " << frame;
    for (const ObjectHandle& object : objects)
      ASSERT_TRUE(is_same(worlds[0]->actual_pose(object), worlds[1]->actual_pose(object)))
          << "frame " << frame << ", " << worlds[0]->name_of(object);
    ASSERT_EQ(one.events.size(), other.events.size()) << "frame " << frame;
    for (std::size_t i = 0; i < one.events.size(); ++i)
      ASSERT_TRUE(is_same(one.events[i], other.events[i])) << "frame " << frame << ", event " << i;
    ASSERT_EQ(one.blocked_movers, other.blocked_movers);
    events += one.events.size(), blocked += one.blocked_movers;
  }

  std::size_t events = 0, blocked = 0;

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

 private:
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

/// An arm along x and two boxes beside it, of which one moves to and fro and then rests.
class ArmAndResting {
 public:
  enum class Between { nothing, carried, reset };

  ArmAndResting() {
    const auto arm = make_arm("arm", 2);
    for (const double y : {1.5, -1.5}) {
      const ObjectDescription box{box_tree("box " + std::to_string(y), {0.4, 0.4, 0.4}), at(2, y, 0)};
      for (auto& world : twins_.worlds) box_.at(y > 0 ? 0 : 1) = world->add(box);
    }
    for (auto& world : twins_.worlds) arm_ = world->add_mechanism({arm});
    // So many others that the pairs of what moves are found by themselves.
    for (int i = 0; i < 20; ++i)
      for (auto& world : twins_.worlds)
        world->add({box_tree("far box " + std::to_string(i), {0.4, 0.4, 0.4}), at(i, 30, 0)});
    twins_.objects = {box_[0], box_[1]}, twins_.arms = {arm_};
  }

  /// The box goes, rests for more than 8 frames, and is met by the arm. @return how often it stopped the arm.
  std::size_t go_rest_and_meet(Between between) {
    // It goes much further than it is from the arm, and ends where it was.
    for (int i = 0; i < 20; ++i) move_box(i % 2 == 0 ? 0.2 : -0.2);
    if (between == Between::reset) twins_.attempt([](ContactWorld& world) { world.reset(); });
    if (between == Between::carried) {
      const ObjectHandle link = twins_.worlds[0]->link(arm_, "2");
      twins_.attempt([&](ContactWorld& world) { world.latch(link, box_[0]); });
      for (const double by : {0.1, 0.1, -0.1, -0.1}) turn_arm(by);
      twins_.attempt([&](ContactWorld& world) { world.unlatch(box_[0]); });
    }
    for (int i = 0; i < 12; ++i) turn_arm(i % 2 == 0 ? 0.001 : -0.001);
    // The arm comes, and goes home.
    const std::size_t before = twins_.blocked;
    for (int i = 0; i < 8; ++i) turn_arm(0.1);
    const std::size_t stopped = twins_.blocked - before;
    for (int i = 0; i < 8; ++i) go({}, {0.0, 0.0});
    return stopped;
  }

 private:
  void move_box(double by) { go({twins_.worlds[0]->move_by(box_[0], {by, 0, 0}, {0, 0, 0})}, joints()); }
  void turn_arm(double by) { go({}, {joints()[0] + by, joints()[1]}); }
  std::vector<double> joints() const { return joints_of(*twins_.worlds[0], arm_); }
  void go(const std::vector<MotionCommand>& commands, const std::vector<double>& values) {
    if (!::testing::Test::HasFatalFailure()) twins_.fly(frame_++, commands, {{arm_, values}});
  }

  Twins twins_{1, 0};
  std::array<ObjectHandle, 2> box_;
  MechanismHandle arm_;
  int frame_ = 0;
};

TEST(WorldChanges, WhatRestsIsMetByAnArmAsInAWorldBuiltAnew) {
  ArmAndResting scene;
  using Between = ArmAndResting::Between;
  for (const Between between : {Between::nothing, Between::carried, Between::reset, Between::nothing}) {
    EXPECT_GT(scene.go_rest_and_meet(between), 0u);
    if (::testing::Test::HasFatalFailure()) FAIL();
  }
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

// Boxes in a row, 0.2 m apart and 1 mm more from one to the next: what lies between an old warn distance and
// a larger one is reported, and the next ones like it search for nothing.
TEST(WorldChanges, OfWarnDistancesReportWhatIsNewWithoutBuilding) {
  const auto moved = std::make_shared<std::size_t>(0);
  const auto world = make_world();
  world->set_broadphase(std::make_unique<CountsMoved>(moved));
  world->set_default_rule(rule(ContactPolicy::slide, 0.05));
  constexpr int kBoxes = 100;
  const auto gap_after = [](int i) { return 0.2 + 0.001 * i; };
  const auto is_static = [](int i) { return i % 7 < 2; };
  double x = 0.0;
  for (int i = 0; i < kBoxes; ++i) {
    world->add({box_tree("box " + std::to_string(i), {1, 1, 1}), at(x, 0, 0), is_static(i)});
    x += 1.0 + gap_after(i);
  }
  EXPECT_TRUE(world->frame({}).events.empty());
  bool is_first = true;
  for (const double warn : {0.2505, 0.2525, 0.2705, 0.2205, 0.2405, 0.2755}) {
    *moved = 0;
    world->set_default_rule(rule(ContactPolicy::slide, warn));
    std::size_t near = 0;
    for (int i = 0; i + 1 < kBoxes; ++i) near += gap_after(i) < warn && !(is_static(i) && is_static(i + 1));
    EXPECT_EQ(kinds(world->frame({})), std::vector(near, EventKind::near)) << warn;
    EXPECT_EQ(*moved > 0, is_first) << warn;
    is_first = false;
  }
}

// Of many objects the few that moved stand where they began, what they touched is reported anew, and what was
// carried is free.
TEST(WorldChanges, OfResetsTouchWhatMoved) {
  // A row of boxes, of which one moves into its neighbour and two are latched.
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
  // The same frame three times, each after a reset.
  for (int run = 0; run < 3; ++run) {
    const FrameReport report = world->frame({&command, 1});
    ASSERT_EQ(report.blocked_movers, 1u) << run;
    EXPECT_EQ(kinds(report), (std::vector{EventKind::blocked, EventKind::began})) << run;
    world->frame({});
    world->reset();
    // The reset has moved those few alone.
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

}  // namespace
}  // namespace touchstone

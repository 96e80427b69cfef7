#include "touchstone/contact_core/broadphase/native/object_forest.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <new>
#include <numeric>

#include "touchstone/contact_core/broadphase/native/morton_sort.hpp"
#include "touchstone/tests/broadphase/random_scene.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/random.hpp"

// The native broadphase's trees, renewed bit by bit while objects come, go and move.

namespace touchstone {
namespace {

using namespace broadphase_tests;

/// Single boxes in bounds and forest, every fifth of them static.
class Wood {
 public:
  explicit Wood(std::uint32_t objects, std::uint64_t seed, double extent = 30.0)
      : extent_(extent), random_(seed) {
    for (std::uint32_t object = 0; object < objects; ++object) add_to_scene();
    const std::vector<const HexahedronTree*> trees = scene_.tree_pointers();
    for (std::uint32_t object = 0; object < objects; ++object) is_static_.push_back(object % 5 == 0);
    BroadphaseInput input;
    input.trees = trees, input.margin = kMargin, input.is_static = is_static_;
    bounds_ = std::make_unique<SolidBounds>(input);
    forest_ = std::make_unique<ObjectForest>(*bounds_, nullptr);
    bounds_->start_poses();
    for (std::uint32_t object = 0; object < objects; ++object) bounds_->place(object, scene_.poses);
    forest_->update_all();
  }

  const ObjectForest& forest() const { return *forest_; }
  std::uint32_t objects() const { return bounds_->objects(); }
  bool is_gone(std::uint32_t object) const { return bounds_->is_gone(object); }
  std::uint32_t any() { return static_cast<std::uint32_t>(random_() % objects()); }

  void add() {
    const std::uint32_t object = objects();
    add_to_scene();
    come(object, random_() % 5 == 0);
  }
  void come(std::uint32_t object, bool is_static) {
    bounds_->set_object(object, &scene_.trees[object], is_static);
    forest_->insert(object);
    move(object);
  }
  void go(std::uint32_t object) {
    const bool was_static = bounds_->is_static(object);
    bounds_->set_object(object, nullptr, false);
    forest_->erase(object, was_static);
  }
  void move(std::uint32_t object) {
    scene_.place(object, random_pose(random_, extent_));
    moved_.push_back(object);
  }
  void update() {
    std::erase_if(moved_, [&](std::uint32_t object) { return is_gone(object); });
    for (const std::uint32_t object : moved_) bounds_->place(object, scene_.poses);
    forest_->update(moved_);
    moved_.clear();
  }

  /// The trees name the partners that trying all does.
  void expect_partners_of(std::uint32_t object) const {
    std::vector<std::uint32_t> found, wanted;
    forest_->for_each_partner(object, 0, [&](std::uint32_t other) {
      found.push_back(other);
      return true;
    });
    for (std::uint32_t other = 0; other < objects() && !is_gone(object); ++other)
      if (other != object && !is_gone(other) && bounds_->may_pair(object, other) &&
          !(bounds_->is_static(object) && bounds_->is_static(other)))
        wanted.push_back(other);
    std::sort(found.begin(), found.end());
    ASSERT_EQ(found, wanted) << object;
  }

  /// Asked about together, objects have the partners that they have one by one. Returns how many.
  std::size_t expect_pairs_of(std::span<const std::uint32_t> objects) const {
    std::vector<SolidPair> together, one_by_one;
    forest_->for_each_pair_of(objects, [&](std::uint32_t object, std::uint32_t other) {
      together.push_back({object, other});
      return true;
    });
    for (const std::uint32_t object : objects)
      forest_->for_each_partner(object, 0, [&](std::uint32_t other) {
        one_by_one.push_back({object, other});
        return true;
      });
    std::sort(together.begin(), together.end());
    std::sort(one_by_one.begin(), one_by_one.end());
    EXPECT_EQ(together, one_by_one);
    return together.size();
  }

 private:
  static constexpr double kMargin = 0.5;

  /// One solid each, so that spheres alone decide which objects pair.
  void add_to_scene() {
    const Vector3 size = Vector3::Constant(1.5) + random_vector(random_, 1.4);
    scene_.add({{"", Hexahedron::from_size(size), {}}}, random_pose(random_, extent_));
  }

  double extent_;  // [m]
  std::mt19937_64 random_;
  Scene scene_;
  std::vector<std::uint8_t> is_static_;
  std::unique_ptr<SolidBounds> bounds_;
  std::unique_ptr<ObjectForest> forest_;
  std::vector<std::uint32_t> moved_;
};

TEST(ObjectForest, SeveralObjectsHaveThePartnersOfEach) {
  for (const double extent : {30.0, 1.0}) {  // few partners; all of them, more than are kept of several
    Wood wood(3000, 65, extent);
    for (std::uint32_t object = 0; object < 300; object += 7) wood.go(object);
    wood.update();
    std::vector<std::uint32_t> asked;
    for (std::uint32_t count : {0u, 1u, 8u, 9u, 43u}) {
      asked.clear();
      for (std::uint32_t k = 0; k < count; ++k) asked.push_back(k == 3 ? 7 : wood.any());
      const std::size_t pairs = wood.expect_pairs_of(asked);
      EXPECT_GE(pairs, extent < 2.0 ? 1000 * count : count / 2);
    }
    // Told that it is enough, it ends.
    const auto ends_when_told = [&] {
      int told = 0;
      EXPECT_FALSE(
          wood.forest().for_each_pair_of(asked, [&](std::uint32_t, std::uint32_t) { return ++told < 3; }));
      EXPECT_EQ(told, 3);
    };
    ends_when_told();
    if (extent < 2.0) continue;  // no crowd for the grid
    // While the grid stands in, too: with static objects, gone ones and some that moved since.
    for (const std::uint32_t nth : {1u, 50u}) {
      for (std::uint32_t object = nth; object < wood.objects(); object += nth)
        if (!wood.is_gone(object)) wood.move(object);
      wood.update();
      ASSERT_NE(wood.forest().grid(), nullptr);
      EXPECT_GE(wood.expect_pairs_of(asked), asked.size() / 2);
      ends_when_told();
    }
  }
}

// Few of them have left their places in the grid by then: it is not made anew.
TEST(ObjectForest, IsRenewedBeforeAQuarterHasMoved) {
  Wood wood(20000, 67, 65.0);
  for (std::uint32_t object = 0; object < wood.objects(); ++object) wood.move(object);
  wood.update();
  ASSERT_NE(wood.forest().grid(), nullptr);
  for (std::uint32_t frame = 0; frame < 25; ++frame) {
    for (std::uint32_t object = frame; object < wood.objects(); object += 100) wood.move(object);
    wood.update();
  }
  EXPECT_EQ(wood.forest().grid(), nullptr);
}

// The frame in which few move after many did is none that sorts all.
TEST(ObjectForest, IsNeverSortedAtOnceWhereFewMoveAfterMany) {
  Wood wood(2000, 64);
  for (int turn = 0; turn < 3; ++turn) {
    for (std::uint32_t object = 0; object < wood.objects(); ++object)
      if (!wood.is_gone(object)) wood.move(object);
    wood.update();
    ASSERT_NE(wood.forest().grid(), nullptr);
    const std::size_t sorts = wood.forest().sorts(), renewals = wood.forest().renewals();
    for (int frame = 0; frame < 100; ++frame) {
      for (int i = 0; i < 8; ++i) wood.move(wood.any());
      wood.go(static_cast<std::uint32_t>(100 * turn + frame));
      wood.update();
      wood.add();
      wood.update();
      for (int i = 0; i < 4; ++i) wood.expect_partners_of(wood.any());
    }
    EXPECT_EQ(wood.forest().grid(), nullptr);
    EXPECT_EQ(wood.forest().sorts(), sorts);
    EXPECT_GT(wood.forest().renewals(), renewals);
  }
}

TEST(ObjectForest, IsNeverSortedAtOnceWhileObjectsComeOneByOne) {
  Wood wood(2000, 61);
  const std::size_t sorts = wood.forest().sorts();
  for (int i = 0; i < 4000; ++i) {
    wood.add();
    wood.update();
    if (i % 16 == 0) wood.expect_partners_of(wood.any());
  }
  EXPECT_EQ(wood.forest().sorts(), sorts);
  EXPECT_GT(wood.forest().renewals(), 8u);
}

TEST(ObjectForest, KnowsWhatComesGoesAndMovesWhileItIsRenewed) {
  Wood wood(1500, 62);
  std::mt19937_64 random(63);
  const std::size_t sorts = wood.forest().sorts();
  for (int i = 0; i < 6000; ++i) {
    const std::uint32_t object = wood.any();
    const std::uint64_t kind = random() % 4;
    if (wood.is_gone(object))
      wood.come(object, random() % 5 == 0);
    else if (kind == 0)
      wood.go(object);
    else if (kind == 1)
      wood.add();
    else
      wood.move(object);
    if (random() % 3 == 0) continue;  // several changes at once
    wood.update();
    wood.expect_partners_of(object);
    if (i % 8 == 0) wood.expect_partners_of(wood.any());
  }
  EXPECT_EQ(wood.forest().sorts(), sorts);
  EXPECT_GT(wood.forest().renewals(), 8u);
}

// Objects that replace others need no more room; those that come afterwards do, in the middle of a renewal.
TEST(ObjectForest, MakesRoomForWhatComesAfterReplacements) {
  Wood wood(1500, 65);
  for (int round = 0; round < 6; ++round) {
    for (int i = 0; i < 700; ++i) {
      const std::uint32_t object = wood.any();
      if (!wood.is_gone(object)) wood.go(object);
      wood.come(object, object % 5 == 0);
      wood.update();
    }
    for (int i = 0; i < 30 + 20 * round; ++i) {
      wood.add();
      wood.update();
      wood.expect_partners_of(wood.any());
    }
  }
  EXPECT_GT(wood.forest().renewals(), 8u);
}

TEST(ObjectForest, RenewsWithoutAllocationsWhileObjectsMove) {
  Wood wood(1500, 64);
  const std::size_t sorts = wood.forest().sorts();
  wood.move(0), wood.update();
  const std::size_t before = allocation_count();
  for (int i = 0; i < 6000; ++i) wood.move(wood.any()), wood.update();
  EXPECT_EQ(allocation_count(), before);
  EXPECT_EQ(wood.forest().sorts(), sorts);
  EXPECT_GT(wood.forest().renewals(), 2u);
}

// A second try after memory ran out has room for all.
TEST(MortonSort, HasRoomWhereverMemoryEnded) {
  constexpr std::uint32_t kCount = 2000;
  Random random(66);
  std::vector<Sphere> spheres(kCount);
  for (Sphere& sphere : spheres) sphere = {random.vector(10.0), 1.0};
  for (std::size_t after = 0; after < 4; ++after) {
    MortonSort sort;
    {
      const FailingAllocation failing(after);
      EXPECT_THROW(sort.reserve(kCount), std::bad_alloc);
    }
    const std::size_t before = allocation_count();
    sort.reserve(kCount);
    EXPECT_GT(allocation_count(), before) << after;
    std::vector<std::uint32_t> order(kCount);
    std::iota(order.begin(), order.end(), 0u);
    std::size_t work = MortonSort::kAll;
    sort.begin(kCount);
    EXPECT_TRUE(sort.go_on(spheres, order, work));
    std::sort(order.begin(), order.end());
    for (std::uint32_t i = 0; i < kCount; ++i) ASSERT_EQ(order[i], i);
  }
}

}  // namespace
}  // namespace touchstone

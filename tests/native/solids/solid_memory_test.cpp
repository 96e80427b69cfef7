#include "touchstone/contact_core/native/engine/solid_memory.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <thread>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone::native {
namespace {

SolidContent box(double x, double y, double z) {
  SolidContent content;
  content.is_box = true;
  content.points[0] = {x, y, z};
  return content;
}

std::vector<SolidContent> random_boxes(std::size_t count) {
  std::mt19937_64 random(7);
  std::vector<SolidContent> boxes;
  while (boxes.size() < count) {
    const Vector3 sides = random_vector(random, 0.5, 2.0);
    boxes.push_back(box(sides.x(), sides.y(), sides.z()));
  }
  return boxes;
}

TEST(SolidMemory, HoldsTheLastThousandWhateverTheirSizes) {
  std::vector<SolidContent> contents = random_boxes(SolidMemory::kPlaces / 2);
  for (std::size_t i = 0; contents.size() < SolidMemory::kPlaces; ++i)  // round sizes: few bits differ
    contents.push_back(box(0.25 * static_cast<double>(1 + i % 8), 0.25 * static_cast<double>(1 + i / 8 % 8),
                           0.25 * static_cast<double>(1 + i / 64)));
  const auto store = std::make_shared<SolidStore>();
  SolidMemory memory(store);
  for (const SolidContent& content : contents) ASSERT_TRUE(memory.find(content));
  EXPECT_EQ(store->size(), SolidMemory::kPlaces);
  const std::size_t before = allocation_count();
  for (std::size_t i = 0; i < contents.size(); ++i) {
    const auto solid = memory.find(contents[i * 389 % contents.size()]);
    ASSERT_TRUE(solid);
    EXPECT_EQ(*solid->content, contents[i * 389 % contents.size()]);
  }
  EXPECT_EQ(allocation_count() - before, 0u);
}

TEST(SolidMemory, HoldsBothSolidsOfAPairWhateverOthersAcquire) {
  const std::array<SolidContent, 6> contents = {box(1, 1, 1),   box(1, 1, 2),    box(1, 1, 0.5),
                                                box(1, 1, 1.5), box(1, 1, 1.25), box(1, 1, 3)};
  const auto store = std::make_shared<SolidStore>();
  SolidMemory memory(store);
  for (const SolidContent& a : contents) {
    for (const SolidContent& b : contents) {
      const auto first = memory.find(a), second = memory.find(b);
      const auto others = store->acquire(box(5, 6, 7));  // as another thread may at any time
      EXPECT_EQ(2.0 * store->solid(*first).half_extents().z(), a.points[0][2]);
      EXPECT_EQ(2.0 * store->solid(*second).half_extents().z(), b.points[0][2]);
      store->release(*others);
    }
  }
}

TEST(SolidMemory, WhatIsNotANumberIsNobodyElsesSolid) {
  SolidStore store;
  ASSERT_TRUE(store.acquire(box(1, 2, 3)));
  for (int k = 0; k < 3; ++k) {
    SolidContent content = box(1, 2, 3);
    content.points[0][k] = kNaN;
    EXPECT_FALSE(store.acquire(content)) << k;
  }
  EXPECT_EQ(store.size(), 1u);
}

/// With a corner at zero, so that the memory guesses the same place for all of them.
SolidContent box_at_corner(const SolidContent& box) {
  const auto& [x, y, z] = box.points[0];
  const auto vertices = Hexahedron::from_size({x, y, z}).vertices();
  SolidContent content;
  for (std::size_t i = 0; i < content.points.size(); ++i)
    for (int k = 0; k < 3; ++k) content.points[i][k] = vertices[i][k] - vertices[0][k];
  return content;
}

/// The points' separations of the solid on itself, turned and 0.9 m aside.
std::vector<double> depths_of(const SolidStore& store, const SolidHandle& solid) {
  Pose X_WA, X_WB;
  X_WA.R = rotation_from_quaternion(1.0, 0.1, 0.2, 0.3);
  X_WB.p = {0.9, 0.1, 0.0};
  PairAnswer answer;
  store.compute_manifold(solid, X_WA, solid, X_WB, {QueryKind::manifold, 0.0, kMaxManifoldPoints, 0.0},
                         answer);
  std::vector<double> depths{answer.geometry.separation};
  for (int i = 0; i < answer.geometry.point_count; ++i) depths.push_back(answer.points[i].separation);
  return depths;
}

TEST(SolidStore, AnswersStayTheSameWhileOthersComeAndGo) {
  SolidStore store;
  SolidContent hull = box_at_corner(box(1, 1, 1));
  hull.points[7][0] += 0.5;
  const SolidHandle a = *store.acquire(box(1, 1.5, 2)), b = *store.acquire(hull);
  const std::vector<double> of_box = depths_of(store, a), of_hull = depths_of(store, b);
  ASSERT_GT(of_box.size(), 1u);
  ASSERT_GT(of_hull.size(), 1u);
  // One thread asks while this one brings as many as make the store larger several times.
  std::atomic<bool> goes_on = true;
  std::atomic<int> wrong = 0, asked = 0;
  std::thread asks([&] {
    for (; goes_on; ++asked)
      if (depths_of(store, a) != of_box || depths_of(store, b) != of_hull) ++wrong;
  });
  const auto wait_for_question = [&asked] {
    for (const int before = asked; asked == before;) std::this_thread::yield();
  };
  std::vector<SolidHandle> others;
  for (const SolidContent& other : random_boxes(300)) {
    if (others.size() % 32 == 0) wait_for_question();
    others.push_back(*store.acquire(other));
    others.push_back(*store.acquire(box_at_corner(other)));
    if (others.size() % 3 == 0) store.release(others.back()), others.pop_back();
  }
  while (asked < 100) std::this_thread::yield();
  goes_on = false;
  asks.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(store.size(), others.size() + 2);
  for (const SolidHandle& other : others) store.release(other);
}

TEST(SolidMemory, ForgetsWhatWasAskedForLongestAgo) {
  const std::vector<SolidContent> contents = random_boxes(SolidMemory::kPlaces + 1);
  const auto store = std::make_shared<SolidStore>();
  const auto is_held = [&](const SolidContent& content) {
    const std::size_t size = store->size();
    const auto solid = store->acquire(content);
    const bool held = store->size() == size;
    store->release(*solid);
    return held;
  };
  {
    SolidMemory memory(store);
    for (std::size_t i = 0; i < SolidMemory::kPlaces; ++i) memory.find(contents[i]);
    memory.find(contents[0]);
    memory.find(contents.back());
    EXPECT_EQ(store->size(), SolidMemory::kPlaces);
    EXPECT_TRUE(is_held(contents[0]));
    EXPECT_FALSE(is_held(contents[1]));
    EXPECT_TRUE(is_held(contents[2]));
  }
  EXPECT_EQ(store->size(), 0u);
}

TEST(SolidMemory, WhatIsForgottenIsTakenAnew) {
  const auto store = std::make_shared<SolidStore>();
  SolidMemory memory(store);
  const SolidContent first = box(1, 2, 3);
  ASSERT_TRUE(memory.find(first));
  for (const SolidContent& other : random_boxes(SolidMemory::kPlaces))
    ASSERT_TRUE(memory.find(box_at_corner(other)));
  const std::size_t released = store->size();
  EXPECT_EQ(memory.find_box(first.points[0].data())->content->points, first.points);
  EXPECT_EQ(store->size(), released);  // in the place of the oldest of the others
  const auto held = store->acquire(first);
  EXPECT_EQ(store->size(), released);
  store->release(*held);
}

TEST(SolidMemory, AHullIsTheSolidOfItsVerticesAndOfNoOthers) {
  const auto store = std::make_shared<SolidStore>();
  SolidMemory memory(store);
  // The first vertex is that of all; a box of these sides is remembered in the same place.
  const double sides[3] = {2, 3, 4};
  ASSERT_TRUE(memory.find_box(sides));
  const SolidMemory::Corners first = {2, 3, 4, 3, 3, 4, 2, 5, 4, 3, 5, 4, 2, 3, 7, 3, 3, 7, 2, 5, 7, 3, 5, 7};
  for (std::size_t moved = 3; moved < first.size(); ++moved) {
    ASSERT_TRUE(memory.find_hull(first.data()));
    SolidMemory::Corners corners = first;
    corners[moved] += 0x1p-20F;
    SolidContent content;
    for (std::size_t i = 0; i < corners.size(); ++i)
      content.points[i / 3][i % 3] = static_cast<double>(corners[i]);
    const auto solid = memory.find_hull(corners.data());
    ASSERT_TRUE(solid) << moved;
    EXPECT_EQ(*solid->content, content) << moved;
    EXPECT_EQ(memory.find_hull(corners.data())->content, solid->content) << moved;
    EXPECT_EQ(memory.find(content)->content, solid->content) << moved;
  }
  EXPECT_EQ(store->size(), first.size() - 3 + 2);
}

TEST(SolidMemory, RemembersWhatIsNoHexahedron) {
  const auto store = std::make_shared<SolidStore>();
  SolidMemory memory(store);
  const SolidContent flat = box(1, 1, 0), none = box(1, 1, kNaN);
  EXPECT_FALSE(memory.find(flat));
  EXPECT_FALSE(memory.find(none));
  const std::size_t before = allocation_count();
  EXPECT_FALSE(memory.find(flat));
  EXPECT_FALSE(memory.find(none));
  EXPECT_EQ(allocation_count() - before, 0u);
}

}  // namespace
}  // namespace touchstone::native

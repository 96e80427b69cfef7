#include <gtest/gtest.h>

#include <numeric>

#include "touchstone/contact_core/threads/thread_team.hpp"
#include "touchstone/tests/broadphase/random_scene.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone {
namespace {

using namespace broadphase_tests;

constexpr std::uint32_t kObjects = 2500;

struct Frames {
  double extent;
  Scene scene;
  std::vector<std::uint8_t> is_static = std::vector<std::uint8_t>(kObjects);
  std::mt19937_64 random{42};

  explicit Frames(bool is_for_grid)
      : extent(is_for_grid ? 12.0 : 130.0),
        scene(is_for_grid ? even_scene(kObjects, extent, 41) : random_scene(kObjects, extent, 0, 41)) {
    for (std::size_t i = 0; i < kObjects; i += 6) is_static[i] = 1;
  }

  std::vector<std::uint32_t> step(std::uint32_t nth) {
    std::vector<std::uint32_t> moved;
    for (std::uint32_t object = 1; object < kObjects; object += nth)
      scene.place(object, random_pose(random, extent)), moved.push_back(object);
    return moved;
  }
};

void compare_with_one_thread(bool is_for_grid) {
  for (std::size_t count : {2, 3, 8}) {
    // The same scene on one thread and on several.
    ThreadTeam team(count);
    Frames frames(is_for_grid);
    const auto alone = make("native", frames.scene, 0.1, frames.is_static);
    const auto together = make("native", frames.scene, 0.1, frames.is_static, &team);
    // Pairs of poses, in both orders.
    for (std::uint32_t nth : {1u, 1u, 2u, 500u, 40u, 1u}) {
      const std::vector<std::uint32_t> moved = frames.step(nth);
      alone->update(frames.scene.poses, moved), together->update(frames.scene.poses, moved);
      const Pairs pairs = sweep(*alone, 256);
      ASSERT_GT(pairs.size(), 1000u);
      ASSERT_EQ(sweep(*together, 256), pairs) << count << " threads, one in " << nth << " moved";
      Pairs by_place, by_one;
      together->find_pairs_by_place(by_place), alone->find_pairs_by_place(by_one);
      ASSERT_EQ(by_place, by_one) << count << " threads, one in " << nth << " moved";
      EXPECT_EQ(is_by_place(by_place), is_for_grid);
    }
    // Pairs of paths.
    for (std::uint32_t nth : {1u, 700u, 1u}) {
      const std::vector<std::uint32_t> moved = frames.step(nth);
      std::vector<Pose> to = frames.scene.poses;
      for (Pose& X_WS : to) X_WS.p.x() += 3.0;
      const SolidPaths paths{frames.scene.poses, to};
      alone->update_paths(paths, moved), together->update_paths(paths, moved);
      ASSERT_EQ(sweep(*together, 4096), sweep(*alone, 4096)) << count << " threads, paths";
    }
  }
}

TEST(NativeBroadphaseThreads, AnyNumberOfThreadsGivesThePairsOfOne) { compare_with_one_thread(false); }
TEST(NativeBroadphaseThreads, AnyNumberOfThreadsGivesThePairsOfOneInTheGrid) {
  compare_with_one_thread(true);
}

TEST(NativeBroadphaseThreads, CrowdsBeyondTheListGiveThePairsOfOneThread) {
  ThreadTeam team(4);
  Scene scene;
  std::mt19937_64 random(43);
  for (int i = 0; i < 700; ++i)  // every cube meets every other
    scene.add({{"", Hexahedron::from_size({1, 1, 1}), {}}}, random_pose(random, 0.3));
  const Pairs pairs = sweep(*make("native", scene, 0.1), 4096);
  ASSERT_EQ(pairs.size(), 700u * 699u / 2);
  EXPECT_EQ(sweep(*make("native", scene, 0.1, {}, &team), 4096), pairs);
}

TEST(NativeBroadphaseThreads, FramesDoNotAllocate) {
  ThreadTeam team(2);
  Frames frames(false);
  const auto broadphase = make("native", frames.scene, 0.1, frames.is_static, &team);
  Pairs block(256);
  for (std::uint32_t nth : {1u, 1u, 100u}) {
    const std::vector<std::uint32_t> moved = frames.step(nth);
    const std::size_t before = allocation_count();
    broadphase->update(frames.scene.poses, moved);
    for (PairCursor cursor; !cursor.done;) broadphase->find_pairs(cursor, block);
    EXPECT_EQ(allocation_count(), before);
  }
}

}  // namespace
}  // namespace touchstone

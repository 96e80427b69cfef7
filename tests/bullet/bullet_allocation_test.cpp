#include <LinearMath/btAlignedAllocator.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "touchstone/tests/bullet/backend_under_test.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

// Counts operator new, and what Bullet takes through its own allocator (malloc underneath).

namespace {
std::atomic<std::size_t> bullet_allocations{0};

void* counted_for_bullet(size_t size) {
  ++bullet_allocations;
  return std::malloc(size);
}

std::size_t allocations() { return touchstone::allocation_count() + bullet_allocations; }
}  // namespace

namespace touchstone::test {
namespace {

struct CountBulletToo {
  CountBulletToo() { btAlignedAllocSetCustom(counted_for_bullet, std::free); }
  ~CountBulletToo() { btAlignedAllocSetCustom(nullptr, nullptr); }
};

TEST(TOUCHSTONE_SUITE, EvaluateAllocatesNothing) {
  const CountBulletToo guard;
  std::mt19937_64 random(4);
  const auto make_solid = [&](SolidIndex i) {
    const Hexahedron box = Hexahedron::from_size(random_vector(random, 0.5, 1.5));
    return i % 2 ? box : Hexahedron::from_vertices(box.vertices());
  };
  const AllPairs scene = all_pairs(60, make_solid, [&] { return random_pose(random, 2); });
  Answers answers;
  for (const std::string& backend : {kBackend, kGjk}) {
    const auto narrowphase = make_registry().make_narrowphase(backend);
    narrowphase->build(scene.solids);
    const auto workspace = narrowphase->make_workspace();
    for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold}) {
      const Query query{.kind = kind};
      evaluate(*narrowphase, scene.pairs, scene.poses, query, *workspace, answers);
      const std::size_t before = allocations();
      evaluate(*narrowphase, scene.pairs, scene.poses, query, *workspace, answers);
      EXPECT_EQ(allocations() - before, 0u) << backend << " " << to_string(kind);
    }
  }
}

TEST(TOUCHSTONE_SUITE, BroadphaseAllocatesNothingAfterTheFirstUpdate) {
  const CountBulletToo guard;
  // 200 objects in one place.
  std::mt19937_64 random(5);
  std::vector<HexahedronTree> trees;
  std::vector<std::uint32_t> moved;
  std::vector<Pose> poses(200);
  for (std::uint32_t i = 0; i < 200; ++i) {
    trees.emplace_back(std::vector<PlacedHexahedron>{{"box", Hexahedron::from_size({1, 1, 1}), Pose{}}});
    moved.push_back(i);
  }
  std::vector<const HexahedronTree*> pointers;
  for (const HexahedronTree& tree : trees) pointers.push_back(&tree);
  // Ten updates as they come apart and together, each asked for all pairs.
  {
    const auto broadphase = make_registry().make_broadphase(kBackend);
    broadphase->build({pointers, 0.1});
    broadphase->update(poses, {});
    std::vector<SolidPair> block(64);
    const std::size_t before = allocations();
    for (int step = 0; step < 10; ++step) {
      for (Pose& X : poses) X = {random_rotation(random), random_vector(random, -10 + step, 10 - step)};
      broadphase->update(poses, moved);
      for (PairCursor cursor; !cursor.done;) broadphase->find_pairs(cursor, block);
    }
    EXPECT_EQ(allocations() - before, 0u);
  }
}

}  // namespace
}  // namespace touchstone::test

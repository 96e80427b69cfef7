#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/bullet/backend_under_test.hpp"

namespace touchstone::test {
namespace {

struct Scene {
  std::vector<HexahedronTree> trees;
  std::vector<const HexahedronTree*> pointers;
  std::vector<Hexahedron> solids;
  std::vector<std::uint32_t> object_of;
  std::vector<Pose> poses;
};

Scene make_scene(int objects, double spread, double offset, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Scene scene;
  for (int i = 0; i < objects; ++i) {
    std::vector<PlacedHexahedron> parts;
    for (int k = 0; k <= i % 3; ++k)
      parts.push_back(
          {"part" + std::to_string(k), Hexahedron::from_size(random_vector(random, 0.2, 2.0)), Pose{}});
    scene.trees.emplace_back(parts, "object" + std::to_string(i));
    for (const PlacedHexahedron& part : parts) {
      scene.solids.push_back(part.solid);
      scene.object_of.push_back(static_cast<std::uint32_t>(i));
      scene.poses.push_back({random_rotation(random),
                             Vector3(offset, offset, offset) + random_vector(random, -spread, spread)});
    }
  }
  for (const HexahedronTree& tree : scene.trees) scene.pointers.push_back(&tree);
  return scene;
}

/// Every pair of different objects whose world bounding boxes are within the margin, by the definition.
std::vector<SolidPair> brute_force(const Scene& scene, double margin) {
  std::vector<Vector3> low, high;
  for (std::size_t i = 0; i < scene.solids.size(); ++i) {
    WorldVertices v;
    world_vertices(scene.solids[i], scene.poses[i], v);
    low.push_back(v.vertex(0)), high.push_back(v.vertex(0));
    for (int k = 1; k < 8; ++k)
      low[i] = low[i].cwiseMin(v.vertex(k)), high[i] = high[i].cwiseMax(v.vertex(k));
  }
  std::vector<SolidPair> pairs;
  for (SolidIndex a = 0; a < scene.solids.size(); ++a)
    for (SolidIndex b = a + 1; b < scene.solids.size(); ++b)
      if (scene.object_of[a] != scene.object_of[b] && ((low[a] - high[b]).array() <= margin).all() &&
          ((low[b] - high[a]).array() <= margin).all())
        pairs.push_back({a, b});
  return pairs;
}

std::vector<SolidPair> all_pairs(Broadphase& broadphase, std::size_t block_size) {
  std::vector<SolidPair> block(block_size), pairs;
  PairCursor cursor;
  while (!cursor.done) {
    const std::size_t found = broadphase.find_pairs(cursor, block);
    EXPECT_TRUE(found == block_size || cursor.done);
    pairs.insert(pairs.end(), block.begin(), block.begin() + static_cast<std::ptrdiff_t>(found));
  }
  return pairs;
}

TEST(TOUCHSTONE_SUITE, BroadphaseNeverMissesAPairAndIsStrictlyAscending) {
  for (const double offset : {0.0, 17.0, 1e4}) {
    for (const double margin : {0.0, 0.1}) {
      const Scene scene = make_scene(120, 8.0, offset, 5);
      const auto broadphase = make_registry().make_broadphase(kBackend);
      broadphase->build({scene.pointers, margin});
      broadphase->update(scene.poses, {});
      const std::vector<SolidPair> found = all_pairs(*broadphase, 64);
      const std::vector<SolidPair> expected = brute_force(scene, margin);
      EXPECT_GT(expected.size(), 100u);
      EXPECT_TRUE(std::includes(found.begin(), found.end(), expected.begin(), expected.end()));
      EXPECT_EQ(std::adjacent_find(found.begin(), found.end(), std::greater_equal<>()), found.end());
      if (kDouble) {
        EXPECT_EQ(found, expected);
      }
      for (const SolidPair& pair : found) EXPECT_NE(scene.object_of[pair.a], scene.object_of[pair.b]);
    }
  }
}

TEST(TOUCHSTONE_SUITE, BroadphaseFindsBoxesThatTouchAtTheMargin) {
  for (const double margin : {0.0, 0.1, 1e-9}) {
    for (const double offset : {0.0, 17.3, 1e6}) {
      Scene scene = make_scene(2, 0.0, 0.0, 1);
      std::vector<PlacedHexahedron> cube{{"cube", Hexahedron::from_size({1, 1, 1}), Pose{}}};
      const HexahedronTree a(cube, "a"), b(cube, "b");
      const std::vector<const HexahedronTree*> trees{&a, &b};
      const auto broadphase = make_registry().make_broadphase(kBackend);
      broadphase->build({trees, margin});
      broadphase->update(std::vector<Pose>{at(offset, 0, 0), at(offset + (1.0 + margin), 0, 0)}, {});
      const double gap = ((offset + (1.0 + margin)) - 0.5) - (offset + 0.5);
      if (gap <= margin) {
        EXPECT_EQ(all_pairs(*broadphase, 4).size(), 1u) << margin << " " << offset;
      }
    }
  }
}

TEST(TOUCHSTONE_SUITE, BroadphaseSequenceIsTheSameForEveryBlockSize) {
  const Scene scene = make_scene(40, 4.0, 0.0, 9);
  const auto broadphase = make_registry().make_broadphase(kBackend);
  broadphase->build({scene.pointers, 0.05});
  broadphase->update(scene.poses, {});
  const std::vector<SolidPair> whole = all_pairs(*broadphase, 10000);
  ASSERT_GT(whole.size(), 50u);
  for (std::size_t size = 1; size <= whole.size() + 1; ++size)
    ASSERT_EQ(all_pairs(*broadphase, size), whole) << size;
}

TEST(TOUCHSTONE_SUITE, BroadphaseFollowsTheMovedObjectsOnly) {
  Scene scene = make_scene(60, 5.0, 0.0, 11);
  const auto broadphase = make_registry().make_broadphase(kBackend);
  broadphase->build({scene.pointers, 0.0});
  broadphase->update(scene.poses, {});
  std::mt19937_64 random(12);
  for (int step = 0; step < 20; ++step) {
    const std::vector<std::uint32_t> moved{static_cast<std::uint32_t>(step),
                                           static_cast<std::uint32_t>(2 * step + 7)};
    for (std::size_t i = 0; i < scene.poses.size(); ++i)
      if (std::find(moved.begin(), moved.end(), scene.object_of[i]) != moved.end())
        scene.poses[i] = {random_rotation(random), random_vector(random, -5, 5)};
    broadphase->update(scene.poses, moved);
    const std::vector<SolidPair> found = all_pairs(*broadphase, 32);
    const std::vector<SolidPair> expected = brute_force(scene, 0.0);
    ASSERT_TRUE(std::includes(found.begin(), found.end(), expected.begin(), expected.end())) << step;
  }
}

TEST(TOUCHSTONE_SUITE, BroadphaseRefusesBadInputAndKeepsThePreviousBuild) {
  const Scene scene = make_scene(20, 2.0, 0.0, 2);
  const auto broadphase = make_registry().make_broadphase(kBackend);
  broadphase->build({scene.pointers, 0.0});
  broadphase->update(scene.poses, {});
  const std::vector<SolidPair> before = all_pairs(*broadphase, 16);
  const std::vector<const HexahedronTree*> null{nullptr};
  EXPECT_THROW(broadphase->build({null, 0.0}), InputError);
  EXPECT_THROW(broadphase->build({scene.pointers, -1.0}), InputError);
  EXPECT_THROW(broadphase->build({scene.pointers, std::nan("")}), InputError);
  EXPECT_EQ(all_pairs(*broadphase, 16), before);
}

TEST(TOUCHSTONE_SUITE, BroadphaseOfNothingIsDoneAtOnce) {
  const auto broadphase = make_registry().make_broadphase(kBackend);
  broadphase->build({});
  broadphase->update({}, {});
  EXPECT_TRUE(all_pairs(*broadphase, 4).empty());
}

}  // namespace
}  // namespace touchstone::test

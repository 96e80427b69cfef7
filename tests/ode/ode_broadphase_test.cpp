#include <gtest/gtest.h>

#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/ode/ode_scenes.hpp"
#include "touchstone/tests/ode/random_scene.hpp"

namespace touchstone::ode_test {
namespace {

struct Aabb {
  Vector3 low, high;
};

std::vector<Aabb> bounds(const Scene& scene) {
  std::vector<Aabb> boxes;
  for (const HexahedronTree& tree : scene.trees) {
    for (const PlacedHexahedron& placed : tree.solids()) {
      WorldVertices v;
      world_vertices(placed.solid, scene.poses[boxes.size()], v);
      Aabb box{v.vertex(0), v.vertex(0)};
      for (int i = 1; i < 8; ++i) {
        box.low = box.low.cwiseMin(v.vertex(i));
        box.high = box.high.cwiseMax(v.vertex(i));
      }
      boxes.push_back(box);
    }
  }
  return boxes;
}

std::vector<SolidPair> brute_force(const Scene& scene, double margin) {
  const std::vector<Aabb> boxes = bounds(scene);
  std::vector<SolidPair> pairs;
  for (std::uint32_t a = 0; a < boxes.size(); ++a) {
    for (std::uint32_t b = a + 1; b < boxes.size(); ++b) {
      if (scene.object[a] == scene.object[b]) continue;
      const bool near = (boxes[a].low.array() - margin <= boxes[b].high.array()).all() &&
                        (boxes[b].low.array() - margin <= boxes[a].high.array()).all();
      if (near) pairs.push_back({a, b});
    }
  }
  return pairs;
}

std::vector<SolidPair> sweep(Broadphase& broadphase, std::size_t block_size) {
  std::vector<SolidPair> pairs, block(block_size);
  for (PairCursor cursor; !cursor.done;) {
    const std::size_t count = broadphase.find_pairs(cursor, block);
    pairs.insert(pairs.end(), block.begin(), block.begin() + static_cast<std::ptrdiff_t>(count));
  }
  return pairs;
}

TEST(OdeBroadphase, NeverMissesAPairNearOrFarFromTheOriginAsObjectsMove) {
  std::mt19937_64 random(3);
  for (const double offset : {0.0, 1e3, 1e6, -1e9}) {
    for (const double margin : {0.0, 0.1}) {
      Scene scene = random_scene(80, {offset, offset, offset}, random);
      const auto broadphase = registry().make_broadphase("ode");
      broadphase->build({scene.pointers, margin});
      std::vector<std::uint32_t> moved;
      for (int frame = 0; frame < 5; ++frame) {
        // All pairs of brute force are found; at the origin no others.
        broadphase->update(scene.poses, moved);
        const std::vector<SolidPair> found = sweep(*broadphase, 64);
        const std::vector<SolidPair> expected = brute_force(scene, margin);
        EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
        EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end());
        EXPECT_TRUE(std::includes(found.begin(), found.end(), expected.begin(), expected.end())) << offset;
        EXPECT_GT(expected.size(), 10u);
        if (offset == 0.0) {
          EXPECT_EQ(found, expected);
        }
        for (const SolidPair& pair : found) EXPECT_NE(scene.object[pair.a], scene.object[pair.b]);
        // A fifth of the objects move on.
        moved.clear();
        for (std::uint32_t i = 0; i < scene.poses.size(); ++i) {
          if (scene.object[i] % 5 != static_cast<std::uint32_t>(frame)) continue;
          scene.poses[i] = random_pose(random, {offset, offset, offset}, 4.0);
          if (moved.empty() || moved.back() != scene.object[i]) moved.push_back(scene.object[i]);
        }
      }
    }
  }
}

TEST(OdeBroadphase, BlockSizeDoesNotShow) {
  std::mt19937_64 random(4);
  const Scene scene = random_scene(40, Vector3::Zero(), random);
  const auto broadphase = registry().make_broadphase("ode");
  broadphase->build({scene.pointers, 0.0});
  broadphase->update(scene.poses, {});
  const std::vector<SolidPair> all = sweep(*broadphase, 100000);
  for (std::size_t size = 1; size <= all.size() + 1; ++size) EXPECT_EQ(sweep(*broadphase, size), all);
}

TEST(OdeBroadphase, RefusedInputLeavesThePreviousBuildInForce) {
  std::mt19937_64 random(5);
  const Scene scene = random_scene(40, Vector3::Zero(), random);
  const auto broadphase = registry().make_broadphase("ode");
  broadphase->build({scene.pointers, 0.0});
  broadphase->update(scene.poses, {});
  const std::vector<SolidPair> before = sweep(*broadphase, 64);
  const std::array<const HexahedronTree*, 1> null_tree = {nullptr};
  EXPECT_THROW(broadphase->build({null_tree, 0.0}), InputError);
  EXPECT_THROW(broadphase->build({scene.pointers, -1.0}), InputError);
  EXPECT_THROW(broadphase->build({scene.pointers, std::nan("")}), InputError);
  broadphase->update(scene.poses, {});
  EXPECT_EQ(sweep(*broadphase, 64), before);
}

}  // namespace
}  // namespace touchstone::ode_test

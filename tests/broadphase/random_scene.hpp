#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/contact_core/broadphase/broadphase.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone::broadphase_tests {

using Pairs = std::vector<SolidPair>;

struct Scene {
  std::vector<HexahedronTree> trees;
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<std::uint32_t> object_of;

  std::vector<const HexahedronTree*> tree_pointers() const {
    std::vector<const HexahedronTree*> pointers;
    for (const HexahedronTree& tree : trees) pointers.push_back(&tree);
    return pointers;
  }

  void add(std::vector<PlacedHexahedron> placed, const Pose& X_WO) {
    for (const PlacedHexahedron& p : placed) {
      solids.push_back(p.solid);
      object_of.push_back(static_cast<std::uint32_t>(trees.size()));
    }
    trees.emplace_back(std::move(placed));
    poses.resize(solids.size());
    place(static_cast<std::uint32_t>(trees.size()) - 1, X_WO);
  }

  std::size_t first_solid(std::uint32_t object) const {
    return static_cast<std::size_t>(std::lower_bound(object_of.begin(), object_of.end(), object) -
                                    object_of.begin());
  }

  void place(std::uint32_t object, const Pose& X_WO) {
    const std::size_t count = trees[object].solids().size();
    find_global_positions(trees[object], X_WO, std::span(poses).subspan(first_solid(object), count));
  }
};

// Objects of one to five boxes, sizes over two decades, about `offset` from the origin.
inline Scene random_scene(int objects, double extent, double offset, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<int> parts(1, 5);
  std::uniform_real_distribution<double> decade(-1.0, 1.0);
  Scene scene;
  for (int object = 0; object < objects; ++object) {
    const double scale = std::pow(10.0, decade(random));
    std::vector<PlacedHexahedron> placed;
    for (int part = parts(random); part > 0; --part) {
      const Vector3 size = Vector3::Constant(1.1) + random_vector(random, 1.0);
      placed.push_back({"", Hexahedron::from_size(scale * size), random_pose(random, 2 * scale)});
    }
    Pose X_WO = random_pose(random, extent);
    X_WO.p += Vector3(offset, -2 * offset, 0.5 * offset);
    scene.add(std::move(placed), X_WO);
  }
  return scene;
}

/// Objects of one box each, much the same in size and evenly spread: what native's grid is for.
inline Scene even_scene(int objects, double extent, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Scene scene;
  for (int object = 0; object < objects; ++object)
    scene.add({{"", Hexahedron::from_size({1, 1.2, uniform(random, 0.6, 1)}), {}}},
              random_pose(random, extent));
  return scene;
}

/// Those of `pairs` with a solid of an object that moved.
inline Pairs pairs_of(const Scene& scene, const std::vector<std::uint32_t>& moved, Pairs pairs) {
  std::vector<bool> did_move(scene.trees.size());
  for (const std::uint32_t object : moved) did_move[object] = true;
  std::erase_if(pairs, [&](const SolidPair& pair) {
    return !did_move[scene.object_of[pair.a]] && !did_move[scene.object_of[pair.b]];
  });
  return pairs;
}

/// Whether native's grid serves: then the order of places is not the ascending one.
inline bool is_by_place(const Pairs& pairs) { return !std::is_sorted(pairs.begin(), pairs.end()); }

/// Built, without poses.
inline std::unique_ptr<Broadphase> build(const std::string& name, const Scene& scene, double margin,
                                         std::span<const std::uint8_t> is_static = {},
                                         TaskRunner* threads = nullptr) {
  BackendRegistry registry;
  register_core(registry);
  auto broadphase = registry.make_broadphase(name);
  const auto trees = scene.tree_pointers();
  broadphase->build({trees, margin, is_static, threads});
  return broadphase;
}

/// Built and at the scene's poses.
inline std::unique_ptr<Broadphase> make(const std::string& name, const Scene& scene, double margin,
                                        std::span<const std::uint8_t> is_static = {},
                                        TaskRunner* threads = nullptr) {
  auto broadphase = build(name, scene, margin, is_static, threads);
  broadphase->update(scene.poses, {});
  return broadphase;
}

inline Pairs sweep(Broadphase& broadphase, std::size_t block_size) {
  Pairs all;
  Pairs block(block_size);
  for (PairCursor cursor; !cursor.done;) {
    const std::size_t count = broadphase.find_pairs(cursor, block);
    all.insert(all.end(), block.begin(), block.begin() + static_cast<std::ptrdiff_t>(count));
  }
  return all;
}

}  // namespace touchstone::broadphase_tests

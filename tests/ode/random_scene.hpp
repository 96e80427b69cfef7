#pragma once

#include <random>
#include <string>
#include <utility>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"
#include "touchstone/tests/ode/ode_scenes.hpp"

namespace touchstone::ode_test {

struct Scene {
  std::vector<HexahedronTree> trees;
  std::vector<const HexahedronTree*> pointers;
  std::vector<Pose> poses;
  std::vector<std::uint32_t> object;
};

inline Scene random_scene(std::uint32_t objects, const Vector3& centre, std::mt19937_64& random) {
  Scene scene;
  for (std::uint32_t i = 0; i < objects; ++i) {
    std::vector<PlacedHexahedron> solids;
    for (int k = 0; k <= static_cast<int>(i % 2); ++k) {
      solids.push_back({std::to_string(k), Hexahedron::from_size(random_vector(random, 0.2, 1.5)), Pose{}});
      scene.poses.push_back(random_pose(random, centre, 4.0));
      scene.object.push_back(i);
    }
    scene.trees.emplace_back(std::move(solids));
  }
  for (const HexahedronTree& tree : scene.trees) scene.pointers.push_back(&tree);
  return scene;
}

}  // namespace touchstone::ode_test

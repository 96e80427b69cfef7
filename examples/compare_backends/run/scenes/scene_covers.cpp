#include "touchstone/examples/compare_backends/run/scenes/scene_covers.hpp"

#include <algorithm>

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone::comparison {
namespace {

using Node = HexahedronTree::Node;

int depth(const HexahedronTree& tree, std::int32_t at) {
  const Node& node = tree.nodes()[static_cast<std::size_t>(at)];
  return node.solid >= 0 ? 0 : 1 + std::max(depth(tree, node.left), depth(tree, node.right));
}

struct Box {
  Vector3 low = Vector3::Constant(kInfinity);
  Vector3 high = -low;
};

void enclose(const HexahedronTree& tree, std::int32_t at, Box& box) {
  const Node& node = tree.nodes()[static_cast<std::size_t>(at)];
  if (node.solid < 0) {
    enclose(tree, node.left, box);
    enclose(tree, node.right, box);
    return;
  }
  const PlacedHexahedron& placed = tree.solids()[static_cast<std::size_t>(node.solid)];
  for (const Vector3& vertex : placed.solid.vertices()) {
    const Vector3 p_O = transform(placed.X_OS, vertex);
    for (int axis = 0; axis < 3; ++axis) {
      box.low(axis) = std::min(box.low(axis), p_O(axis));
      box.high(axis) = std::max(box.high(axis), p_O(axis));
    }
  }
}

void cut(const HexahedronTree& tree, std::int32_t at, int level, std::vector<PlacedHexahedron>& out) {
  const Node& node = tree.nodes()[static_cast<std::size_t>(at)];
  if (node.solid >= 0) {
    out.push_back(tree.solids()[static_cast<std::size_t>(node.solid)]);
  } else if (level > 0) {
    cut(tree, node.left, level - 1, out);
    cut(tree, node.right, level - 1, out);
  } else {
    Box box;
    enclose(tree, at, box);
    // A name that no hexahedron of a file has: theirs are not empty before the dot.
    const std::string name = ".cover" + std::to_string(at);
    out.push_back({name,
                   Hexahedron::from_size(box.high - box.low, name),
                   {Matrix3::Identity(), 0.5 * (box.low + box.high)}});
  }
}

bool names_a_hexahedron(const std::vector<ExemptPair>& pairs) {
  return std::any_of(pairs.begin(), pairs.end(), [](const ExemptPair& pair) {
    return (pair.first + pair.second).find('/') != std::string::npos;
  });
}

}  // namespace

int cover_levels(const Scene& scene) {
  if (names_a_hexahedron(scene.exempt_pairs)) return 0;
  for (const SceneLatch& latch : scene.latches)
    if (names_a_hexahedron(latch.allowed)) return 0;
  int levels = 0;
  for (const SceneObject& object : scene.objects) levels = std::max(levels, depth(object.tree, 0));
  return levels;
}

Scene with_covers(const Scene& scene, int level) {
  Scene covered = scene;
  covered.facet_figures.clear();
  for (SceneObject& object : covered.objects) {
    std::vector<PlacedHexahedron> solids;
    cut(object.tree, 0, level, solids);
    object.tree = HexahedronTree(std::move(solids), object.tree.name());
  }
  return covered;
}

}  // namespace touchstone::comparison

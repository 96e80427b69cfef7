#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_set>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

// A node's sphere is computed from object-frame vertices; a placed solid's world vertices are rounded twice
// more (the composed pose, the transform). Each coordinate's rounding is below 16 ulp of the object's extent,
// which this covers; rounding by the world position is the broadphase's to add, as only it knows how far from
// the origin the object is.
constexpr double kSphereSlack = 32 * std::numeric_limits<double>::epsilon();

/// |v| for lengths of any size: Eigen's stableNorm() changes its rounding with the instruction set.
double length_of(const Vector3& v) {
  const double largest = std::max({std::abs(v.x()), std::abs(v.y()), std::abs(v.z())});
  if (!(largest > 0.0) || std::isinf(largest)) return largest;
  const int exponent = std::ilogb(largest);
  const Vector3 scaled(std::scalbn(v.x(), -exponent), std::scalbn(v.y(), -exponent),
                       std::scalbn(v.z(), -exponent));
  return std::scalbn(norm(scaled), exponent);
}

Sphere enclosing_sphere(std::span<const Vector3> points) {
  Vector3 low = points[0];
  Vector3 high = points[0];
  for (const Vector3& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  Sphere sphere{0.5 * low + 0.5 * high, 0.0};
  double extent = 0.0;
  for (const Vector3& p : points) {
    sphere.radius = std::max(sphere.radius, length_of(p - sphere.centre));
    extent = std::max({extent, std::abs(p.x()), std::abs(p.y()), std::abs(p.z())});
  }
  sphere.radius += kSphereSlack * (sphere.radius + extent);
  return sphere;
}

struct TreeBuilder {
  const std::vector<std::vector<Vector3>>& vertices_O;
  std::vector<HexahedronTree::Node>& nodes;

  std::int32_t build(std::span<std::int32_t> solids) {
    const auto index = static_cast<std::int32_t>(nodes.size());
    nodes.emplace_back();
    std::vector<Vector3> all;
    for (std::int32_t s : solids) all.insert(all.end(), vertices_O[s].begin(), vertices_O[s].end());
    nodes[index].sphere_O = enclosing_sphere(all);
    if (solids.size() == 1) {
      nodes[index].solid = solids[0];
      return index;
    }
    const int axis = longest_axis_of_centres(solids);
    const auto middle = solids.begin() + static_cast<std::ptrdiff_t>(solids.size() / 2);
    std::sort(solids.begin(), solids.end(), [&](std::int32_t a, std::int32_t b) {
      const double ca = centre(a)(axis);
      const double cb = centre(b)(axis);
      return ca != cb ? ca < cb : a < b;
    });
    const std::int32_t left = build({solids.begin(), middle});
    const std::int32_t right = build({middle, solids.end()});
    nodes[index].left = left;
    nodes[index].right = right;
    return index;
  }

  Vector3 centre(std::int32_t solid) const {
    Vector3 sum = Vector3::Zero();
    for (const Vector3& p : vertices_O[solid]) sum += 0.125 * p;
    return sum;
  }

  int longest_axis_of_centres(std::span<const std::int32_t> solids) const {
    Vector3 low = centre(solids[0]);
    Vector3 high = low;
    for (std::int32_t s : solids) low = low.cwiseMin(centre(s)), high = high.cwiseMax(centre(s));
    const Vector3 extent = high - low;
    int axis = 0;
    for (int i = 1; i < 3; ++i)
      if (extent(i) > extent(axis)) axis = i;
    return axis;
  }
};

}  // namespace

HexahedronTree::HexahedronTree(std::vector<PlacedHexahedron> solids, std::string name)
    : name_(std::move(name)), solids_(std::move(solids)) {
  if (solids_.empty()) throw InputError("object '" + name_ + "': no hexahedron");
  std::unordered_set<std::string> names;
  std::vector<std::vector<Vector3>> vertices_O;
  for (const PlacedHexahedron& placed : solids_) {
    if (!placed.name.empty() && !names.insert(placed.name).second)
      throw InputError("object '" + name_ + "': hexahedron name '" + placed.name + "' occurs twice");
    validate_pose(placed.X_OS, "object '" + name_ + "', hexahedron '" + placed.name + "'");
    std::vector<Vector3>& vertices = vertices_O.emplace_back();
    for (const Vector3& p : placed.solid.vertices()) vertices.push_back(transform(placed.X_OS, p));
  }
  std::vector<std::int32_t> order(solids_.size());
  std::iota(order.begin(), order.end(), 0);
  nodes_.reserve(2 * solids_.size() - 1);
  TreeBuilder{vertices_O, nodes_}.build(order);
}

namespace {

void place_below(const HexahedronTree& tree, std::int32_t node_index, const Pose& X_WO, std::span<Pose> out) {
  const HexahedronTree::Node& node = tree.nodes()[node_index];
  if (node.solid >= 0) {
    out[node.solid] = compose(X_WO, tree.solids()[node.solid].X_OS);
    return;
  }
  place_below(tree, node.left, X_WO, out);
  place_below(tree, node.right, X_WO, out);
}

}  // namespace

void find_global_positions(const HexahedronTree& tree, const Pose& X_WO, std::span<Pose> out) {
  place_below(tree, 0, X_WO, out);
}

}  // namespace touchstone

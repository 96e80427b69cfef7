#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_set>
#include <utility>

#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

// A node's sphere is computed from object-frame vertices; a placed solid's world vertices are rounded twice
// more (the composed pose, the transform). Each coordinate's rounding is below 16 ulp of the object's extent,
// which this covers; rounding by the world position is the broadphase's to add, as only it knows how far from
// the origin the object is.
constexpr double kSphereSlack = 32 * std::numeric_limits<double>::epsilon();

/// A solid's eight corners: spheres of its radius about its vertices, whose hull it is.
using Corners = std::vector<Sphere>;

Sphere enclosing_sphere(std::span<const Sphere> corners) {
  Vector3 low = corners[0].centre;
  Vector3 high = corners[0].centre;
  for (const Sphere& each : corners) {
    const Vector3 around = Vector3::Constant(each.radius);
    low = low.cwiseMin(each.centre - around), high = high.cwiseMax(each.centre + around);
  }
  Sphere sphere{0.5 * low + 0.5 * high, 0.0};
  double extent = 0.0;
  for (const auto& [p, radius] : corners) {
    sphere.radius = std::max(sphere.radius, safe_norm(p - sphere.centre) + radius);
    extent = std::max(extent, norm_inf(p) + radius);
  }
  sphere.radius += kSphereSlack * (sphere.radius + extent);
  return sphere;
}

struct TreeBuilder {
  const std::vector<Corners>& corners_O;
  std::vector<HexahedronTree::Node>& nodes;

  std::int32_t build(std::span<std::int32_t> solids) {
    const auto index = static_cast<std::int32_t>(nodes.size());
    nodes.emplace_back();
    Corners all;
    for (std::int32_t s : solids) all.insert(all.end(), corners_O[s].begin(), corners_O[s].end());
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
    for (const Sphere& corner : corners_O[solid]) sum += 0.125 * corner.centre;
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

/// Numbers the nodes of a user's layout in the order of a walk, and finds their spheres.
struct LayoutBuilder {
  const std::string& name;
  std::span<const HexahedronTree::Node> layout;
  const std::vector<Corners>& corners_O;
  std::vector<HexahedronTree::Node>& nodes;
  std::vector<char> is_reached = std::vector<char>(layout.size(), 0);
  std::vector<char> is_held = std::vector<char>(corners_O.size(), 0);
  Corners placed_O{};  // of the leaves so far: those below a node come one after the other

  std::int32_t build(std::int32_t given, int level) {
    check_node(given, level);
    const HexahedronTree::Node& from = layout[static_cast<std::size_t>(given)];
    const auto index = static_cast<std::int32_t>(nodes.size());
    const std::size_t first = placed_O.size();
    nodes.emplace_back();
    if (from.left < 0 && from.right < 0) {
      hold(given, from.solid);
      nodes[index].solid = from.solid;
    } else {
      if (from.solid >= 0) fail(given, "holds a solid and has children");
      const std::int32_t left = build(from.left, level + 1);
      const std::int32_t right = build(from.right, level + 1);
      nodes[index].left = left;
      nodes[index].right = right;
    }
    nodes[index].sphere_O = enclosing_sphere(std::span<const Sphere>(placed_O).subspan(first));
    return index;
  }

  void check_all_held() const {
    const auto missing = std::find(is_held.begin(), is_held.end(), 0);
    if (missing != is_held.end())
      throw InputError("object '" + name + "': no node of the tree holds hexahedron " +
                       std::to_string(missing - is_held.begin()));
    const auto apart = std::find(is_reached.begin(), is_reached.end(), 0);
    if (apart != is_reached.end())
      fail(static_cast<std::int32_t>(apart - is_reached.begin()), "is not reached from the root");
  }

 private:
  [[noreturn]] void fail(std::int32_t node, const std::string& what) const {
    throw InputError("object '" + name + "': tree node " + std::to_string(node) + " " + what);
  }

  void check_node(std::int32_t given, int level) {
    if (given < 0 || static_cast<std::size_t>(given) >= layout.size()) fail(given, "does not exist");
    if (std::exchange(is_reached[static_cast<std::size_t>(given)], 1)) fail(given, "is reached twice");
    if (level >= HexahedronTree::kMostLevels)
      fail(given, "is below level " + std::to_string(HexahedronTree::kMostLevels));
  }

  void hold(std::int32_t node, std::int32_t solid) {
    if (solid < 0 || static_cast<std::size_t>(solid) >= corners_O.size())
      fail(node, "holds hexahedron " + std::to_string(solid) + ", which does not exist");
    if (std::exchange(is_held[static_cast<std::size_t>(solid)], 1))
      fail(node, "holds hexahedron " + std::to_string(solid) + ", as another does");
    const Corners& corners = corners_O[static_cast<std::size_t>(solid)];
    placed_O.insert(placed_O.end(), corners.begin(), corners.end());
  }
};

}  // namespace

std::vector<std::vector<Sphere>> HexahedronTree::checked_corners() const {
  if (solids_.empty()) throw InputError("object '" + name_ + "': no hexahedron");
  std::unordered_set<std::string> names;
  std::vector<Corners> corners_O;
  for (const PlacedHexahedron& placed : solids_) {
    if (!placed.name.empty() && !names.insert(placed.name).second)
      throw InputError("object '" + name_ + "': hexahedron name '" + placed.name + "' occurs twice");
    validate_pose(placed.X_OS, "object '" + name_ + "', hexahedron '" + placed.name + "'");
    Corners& corners = corners_O.emplace_back();
    for (const Vector3& p : placed.solid.vertices())
      corners.push_back({transform(placed.X_OS, p), placed.solid.radius()});
  }
  return corners_O;
}

HexahedronTree::HexahedronTree(std::vector<PlacedHexahedron> solids, std::string name)
    : name_(std::move(name)), solids_(std::move(solids)) {
  const std::vector<Corners> corners_O = checked_corners();
  std::vector<std::int32_t> order(solids_.size());
  std::iota(order.begin(), order.end(), 0);
  nodes_.reserve(2 * solids_.size() - 1);
  TreeBuilder{corners_O, nodes_}.build(order);
}

HexahedronTree::HexahedronTree(std::vector<PlacedHexahedron> solids, std::span<const Node> layout,
                               std::string name)
    : name_(std::move(name)), solids_(std::move(solids)) {
  const std::vector<Corners> corners_O = checked_corners();
  nodes_.reserve(layout.size());
  LayoutBuilder builder{name_, layout, corners_O, nodes_};
  builder.build(0, 0);
  builder.check_all_held();
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

void refuse_rounded(const HexahedronTree& tree, std::string_view user) {
  const std::string others = user.starts_with("backend ") ? " (native and exact do)" : "";
  for (const PlacedHexahedron& placed : tree.solids())
    if (placed.solid.is_rounded())
      throw InputError("object '" + tree.name() + "': hexahedron '" + placed.name + "' is rounded (radius " +
                       figure(placed.solid.radius()) + " m), which " + std::string(user) + " does not take" +
                       others + "; model it by hexahedra, robots by --sphere-facets 8");
}

}  // namespace touchstone

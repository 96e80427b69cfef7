#include "touchstone/contact_core/world/objects/object_levels.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/numerics/exact_predicates.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"

namespace touchstone {
namespace {

/// As in hexahedron_tree.cpp: what world vertices round, seen from the object.
constexpr double kSlack = 32 * std::numeric_limits<double>::epsilon();

using Corners = std::vector<Sphere>;

Corners corners_of(const PlacedHexahedron& placed) {
  Corners out;
  for (const Vector3& p : placed.solid.vertices())
    out.push_back({transform(placed.X_OS, p), placed.solid.radius()});
  return out;
}

std::vector<Corners> corners_of(const HexahedronTree& tree) {
  std::vector<Corners> out;
  for (const PlacedHexahedron& placed : tree.solids()) out.push_back(corners_of(placed));
  return out;
}

WorldVertices vertices_of(const Corners& corners) {
  WorldVertices out;
  for (std::size_t i = 0; i < out.x.size(); ++i)
    out.x[i] = corners[i].centre.x(), out.y[i] = corners[i].centre.y(), out.z[i] = corners[i].centre.z();
  return out;
}

struct Box {
  Vector3 low = Vector3::Constant(kInfinity);
  Vector3 high = Vector3::Constant(-kInfinity);

  void add(const Sphere& corner) {
    low = low.cwiseMin(corner.centre - Vector3::Constant(corner.radius));
    high = high.cwiseMax(corner.centre + Vector3::Constant(corner.radius));
  }
  bool holds(const Vector3& p) const {
    return (p.array() >= low.array()).all() && (p.array() <= high.array()).all();
  }
};

/// Exactly.
bool holds(const WorldVertices& hull, const Vector3& p) {
  WorldVertices point;
  point.x.fill(p.x()), point.y.fill(p.y()), point.z.fill(p.z());
  return numerics::hulls_intersect(hull, point);
}

/// A hexahedron of a coarser level. Rounded, it holds what is no more rounded and whose core its core holds.
struct Holder {
  WorldVertices vertices;
  Box box;
  double radius;

  explicit Holder(const Corners& corners) : vertices(vertices_of(corners)), radius(corners[0].radius) {
    for (const Sphere& corner : corners) box.add({corner.centre, 0.0});
  }
  bool holds_all(const Corners& corners) const {
    return std::all_of(corners.begin(), corners.end(), [&](const Sphere& corner) {
      return corner.radius <= radius && box.holds(corner.centre) && holds(vertices, corner.centre);
    });
  }
};

/// "hexahedron 'h3' (index 3)".
std::string name_of(const HexahedronTree& tree, std::size_t index) {
  return "hexahedron '" + tree.solids()[index].name + "' (index " + std::to_string(index) + ")";
}

ObjectLevels::Shape shape_of(const PlacedHexahedron& placed, const Corners& corners) {
  ObjectLevels::Shape shape{vertices_of(corners), {}, placed.solid.radius()};
  for (int face = 0; face < 6; ++face)
    shape.normals_O[static_cast<std::size_t>(face)] =
        rotate(placed.X_OS.R, placed.solid.face_plane(face).normal);
  return shape;
}

HexahedronTree box_about(const HexahedronTree& tree) {
  // Grown by more than all that follows rounds.
  Box box;
  for (const PlacedHexahedron& placed : tree.solids())
    for (const Sphere& corner : corners_of(placed)) box.add(corner);
  const Vector3 size = box.high - box.low;
  const double slack = kSlack * (norm_inf(size) + std::max(norm_inf(box.low), norm_inf(box.high)));
  Pose X_OS;
  X_OS.p = 0.5 * box.low + 0.5 * box.high;
  const Hexahedron solid = Hexahedron::from_size(size + Vector3::Constant(2.0 * slack), tree.name());
  return HexahedronTree({{"box", solid, X_OS}}, tree.name());
}

}  // namespace

void validate_levels(const HexahedronTree& tree,
                     std::span<const std::shared_ptr<const HexahedronTree>> levels) {
  static_cast<void>(ObjectLevels(tree, levels));
}

ObjectLevels::ObjectLevels(const HexahedronTree& tree,
                           std::span<const std::shared_ptr<const HexahedronTree>> levels)
    : box_(box_about(tree)) {
  // Each hexahedron is found a holder in the next level, the first that holds it.
  trees_.push_back(&tree);
  corners_.push_back(corners_of(tree));
  members_.emplace_back();
  for (const auto& coarser : levels) {
    const std::string level = "level " + std::to_string(trees_.size());
    if (!coarser) throw InputError("object '" + tree.name() + "': " + level + " is null");
    std::vector<Holder> holders;
    corners_.push_back(corners_of(*coarser));
    for (const Corners& corners : corners_.back()) holders.emplace_back(corners);
    Members members(holders.size());
    for (std::size_t i = 0; i < corners_[trees_.size() - 1].size(); ++i) {
      const Corners& corners = corners_[trees_.size() - 1][i];
      const auto holder = std::find_if(holders.begin(), holders.end(),
                                       [&](const Holder& each) { return each.holds_all(corners); });
      if (holder == holders.end())
        throw InputError("object '" + tree.name() + "': " + name_of(*trees_.back(), i) + " of level " +
                         std::to_string(trees_.size() - 1) + " lies in no hexahedron of " + level);
      const bool is_empty = trees_.size() > 1 && members_.back()[i].empty();  // another held all of it first
      if (!is_empty)
        members[static_cast<std::size_t>(holder - holders.begin())].push_back(static_cast<std::int32_t>(i));
    }
    members_.push_back(std::move(members));
    trees_.push_back(coarser.get());
  }
  // The nodes are built from the coarsest level down.
  std::vector<std::int32_t> coarsest;
  for (std::size_t i = 0; i < corners_.back().size(); ++i)
    if (trees_.size() == 1 || !members_.back()[i].empty()) coarsest.push_back(static_cast<std::int32_t>(i));
  build(trees_.size() - 1, coarsest);
  // Figures of all hexahedra are noted.
  const PlacedHexahedron& box = box_.solids().front();
  sphere_O_ = {transform(box.X_OS, box.solid.bounding_sphere().centre),
               box.solid.bounding_sphere().radius * (1.0 + kSlack)};
  for (const PlacedHexahedron& placed : tree.solids()) {
    const Sphere& sphere = placed.solid.bounding_sphere();
    extent_ = std::max(extent_, norm(placed.X_OS.p) + norm(sphere.centre) + 2.0 * sphere.radius);
    mean_radius_ += sphere.radius / static_cast<double>(tree.solids().size());
  }
  corners_.clear(), members_.clear(), trees_.clear(), placed_.clear();
}

/// Halves them at the median of the longest side of their centres' box. @returns the node's index.
std::int32_t ObjectLevels::build(std::size_t level, std::span<std::int32_t> hexahedra) {
  if (hexahedra.size() == 1) return build_below(level, hexahedra[0]);
  const std::vector<Corners>& corners = corners_[level];
  const auto centre_of = [&](std::int32_t i) {
    Vector3 sum = Vector3::Zero();
    for (const Sphere& corner : corners[static_cast<std::size_t>(i)]) sum += 0.125 * corner.centre;
    return sum;
  };
  Box centres;
  for (const std::int32_t i : hexahedra) centres.add({centre_of(i), 0.0});
  const Vector3 sides = centres.high - centres.low;
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (sides(i) > sides(axis)) axis = i;
  std::sort(hexahedra.begin(), hexahedra.end(), [&](std::int32_t a, std::int32_t b) {
    const double at_a = centre_of(a)(axis), at_b = centre_of(b)(axis);
    return at_a != at_b ? at_a < at_b : a < b;
  });
  // A node stands before those below it.
  const auto index = static_cast<std::int32_t>(nodes_.size());
  const std::size_t first_placed = placed_.size();
  nodes_.emplace_back();
  const std::int32_t left = build(level, hexahedra.first(hexahedra.size() / 2));
  const std::int32_t right = build(level, hexahedra.subspan(hexahedra.size() / 2));
  Node& node = nodes_[static_cast<std::size_t>(index)];
  node.left = left, node.right = right;
  node.sphere_O = sphere_about(first_placed);
  return index;
}

/// The node of one hexahedron of a level: a solid, or all that it holds.
std::int32_t ObjectLevels::build_below(std::size_t level, std::int32_t hexahedron) {
  const auto i = static_cast<std::size_t>(hexahedron);
  if (level > 0) {
    const std::int32_t index = build(level - 1, members_[level][i]);
    Node& node = nodes_[static_cast<std::size_t>(index)];
    if (node.solid >= 0 || node.shape >= 0) return index;  // what it holds is one, and bounds better
    node.shape = static_cast<std::int32_t>(shapes_.size());
    shapes_.push_back(shape_of(trees_[level]->solids()[i], corners_[level][i]));
    return index;
  }
  const auto index = static_cast<std::int32_t>(nodes_.size());
  const std::size_t first_placed = placed_.size();
  placed_.push_back(hexahedron);
  nodes_.emplace_back().solid = hexahedron;
  nodes_.back().sphere_O = sphere_about(first_placed);
  return index;
}

Sphere ObjectLevels::sphere_about(std::size_t first_placed) const {
  Box box;
  for (std::size_t k = first_placed; k < placed_.size(); ++k)
    for (const Sphere& corner : corners_[0][static_cast<std::size_t>(placed_[k])]) box.add(corner);
  Sphere sphere{0.5 * box.low + 0.5 * box.high, 0.0};
  double extent = 0.0;
  for (std::size_t k = first_placed; k < placed_.size(); ++k)
    for (const Sphere& corner : corners_[0][static_cast<std::size_t>(placed_[k])]) {
      sphere.radius = std::max(sphere.radius, safe_norm(corner.centre - sphere.centre) + corner.radius);
      extent = std::max(extent, norm_inf(corner.centre) + corner.radius);
    }
  sphere.radius += kSlack * (sphere.radius + extent);
  return sphere;
}

}  // namespace touchstone

#include "touchstone/contact_core/fit/levels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <tuple>

#include "touchstone/contact_core/fit/excess.hpp"
#include "touchstone/contact_core/fit/space/six_planes.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/geometry/orientation.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using fit::SixPlanes;
using Vertices = std::array<Vector3, 8>;

/// Faces stand so far outside of what they hold at first, of the largest coordinate: as fit_hexahedra()'s do.
constexpr double kMargin = 0x1p-45;
/// An excess is known to this share of the error.
constexpr double kResolution = 1.0 / 8.0;
/// Tetrahedra that one look at a box may take: what is not known by then is not merged.
constexpr std::size_t kMostPieces = 500;

/// One hexahedron of a level.
struct Group {
  Vertices vertices;
  std::vector<Vector3> points;  // vertices of what it holds of the level before
  std::array<Vector3, 3> axes;  // of a box about it, orthonormal
  double volume = 0.0;          // of that box
  Bounds bounds = {};           // of the points
  double excess = -1.0;         // no point is farther from the solid; negative: not known [m]
  bool is_merged = false;       // into another
};

/// Exactly; may say no where a face bends. What is behind both triangles of a face, whichever diagonal
/// divides it, is behind the hull's.
bool holds(const Vertices& hull, std::span<const Vector3> points) {
  constexpr std::array<std::array<std::size_t, 3>, 4> kTriangles = {
      {{0, 1, 2}, {0, 2, 3}, {0, 1, 3}, {1, 2, 3}}};
  for (const auto& loop : Hexahedron::kFaceVertices)
    for (const auto& [i, j, k] : kTriangles)
      for (const Vector3& p : points)
        if (numerics::orient3d_sign(hull[loop[i]], hull[loop[j]], hull[loop[k]], p) > 0) return false;
  return true;
}

double extent_along(const Vector3& axis, std::span<const Vector3> points) {
  double low = dot(axis, points[0]), high = low;
  for (const Vector3& p : points) low = std::min(low, dot(axis, p)), high = std::max(high, dot(axis, p));
  return high - low;
}

double box_volume(const std::array<Vector3, 3>& axes, std::span<const Vector3> points) {
  return extent_along(axes[0], points) * extent_along(axes[1], points) * extent_along(axes[2], points);
}

const std::array<Vector3, 3> kObjectAxes = {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)};

/// Those of a hexahedron's faces; the object's where two of these collapsed.
std::array<Vector3, 3> axes_of(const Hexahedron& solid, const Matrix3& R) {
  const Vector3 x = rotate(R, solid.face_plane(1).normal), y = rotate(R, solid.face_plane(3).normal);
  const Vector3 z = cross(x, y);
  if (!(norm(z) > 0.1) || !(norm(x) > 0.5)) return kObjectAxes;
  const Vector3 unit_x = x / norm(x), unit_z = z / norm(z);
  return {unit_x, cross(unit_z, unit_x), unit_z};
}

/// A box along the axes that holds all points, grown until it does exactly.
Vertices box_about(const std::array<Vector3, 3>& axes, std::span<const Vector3> points) {
  double largest = 0.0;
  for (const Vector3& p : points) largest = std::max(largest, norm_inf(p));
  const std::array<Vector3, 6> normals = {Vector3(-axes[0]), axes[0],           Vector3(-axes[1]),
                                          axes[1],           Vector3(-axes[2]), axes[2]};
  const SixPlanes closest = fit::enclosing(normals, points);
  for (double margin = kMargin * largest;; margin *= 2.0) {
    SixPlanes box = closest;
    for (Plane& plane : box.planes) plane.offset -= margin;
    const Vertices vertices = box.corners();
    if (holds(vertices, points)) return vertices;
    if (!(margin < largest)) reject("levels", "no box holds what it is about");  // not finite
  }
}

TriangleMesh surface_of(const HexahedronTree& tree) {
  TriangleMesh mesh;
  for (const PlacedHexahedron& placed : tree.solids()) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Vector3& p : placed.solid.vertices()) mesh.vertices.push_back(transform(placed.X_OS, p));
    for (const auto& [a, b, c, d] : Hexahedron::kFaceVertices) {
      mesh.triangles.push_back({first + a, first + b, first + c});
      mesh.triangles.push_back({first + a, first + c, first + d});
    }
  }
  return mesh;
}

/// Merges the groups of one level into those of the next.
class Merger {
 public:
  Merger(const MeshDistance& solid, double over, std::vector<Group>& groups)
      : solid_(solid), over_(over), groups_(groups) {}

  void run() {
    const auto count = static_cast<std::uint32_t>(groups_.size());
    for (std::uint32_t a = 0; a < count; ++a)
      for (std::uint32_t b = a + 1; b < count; ++b) propose(a, b);
    while (!proposals_.empty()) {
      const auto [growth, a, b] = proposals_.top();
      proposals_.pop();
      if (!groups_[a].is_merged && !groups_[b].is_merged) merge(a, b);
    }
    std::erase_if(groups_, [](const Group& group) { return group.is_merged; });
  }

 private:
  using Proposal = std::tuple<double, std::uint32_t, std::uint32_t>;  // growth of the volume, groups

  std::vector<Vector3> points_of(std::uint32_t a, std::uint32_t b) const {
    std::vector<Vector3> points = groups_[a].points;
    points.insert(points.end(), groups_[b].points.begin(), groups_[b].points.end());
    return points;
  }

  /// The axes that make the smallest box: those of one of the two, or the object's.
  std::pair<std::array<Vector3, 3>, double> best_axes(std::uint32_t a, std::uint32_t b,
                                                      std::span<const Vector3> points) const {
    std::pair best{kObjectAxes, box_volume(kObjectAxes, points)};
    for (const std::uint32_t group : {a, b}) {
      const double volume = box_volume(groups_[group].axes, points);
      if (volume < best.second) best = {groups_[group].axes, volume};
    }
    return best;
  }

  /// Those that are further apart than twice the error share no box within it, but for a few.
  bool are_near(std::uint32_t a, std::uint32_t b) const {
    const Bounds &x = groups_[a].bounds, &y = groups_[b].bounds;
    return (x.low - y.high).maxCoeff() <= 2.0 * over_ && (y.low - x.high).maxCoeff() <= 2.0 * over_;
  }

  void propose(std::uint32_t a, std::uint32_t b) {
    if (!are_near(a, b)) return;
    const double volume = best_axes(a, b, points_of(a, b)).second;
    proposals_.push({volume - groups_[a].volume - groups_[b].volume, a, b});
  }

  void merge(std::uint32_t a, std::uint32_t b) {
    Group both;
    both.points = points_of(a, b);
    std::tie(both.axes, both.volume) = best_axes(a, b, both.points);
    for (const Vector3& p : both.points) both.bounds.add(p);
    both.vertices = box_about(both.axes, both.points);
    const ExcessBound excess =
        bound_excess(solid_, both.vertices, kResolution * over_, over_, nullptr, kMostPieces);
    if (!(excess.most <= over_)) return;
    both.excess = excess.most;
    groups_[a].is_merged = groups_[b].is_merged = true;
    groups_.push_back(std::move(both));
    const auto last = static_cast<std::uint32_t>(groups_.size() - 1);
    for (std::uint32_t other = 0; other < last; ++other)
      if (!groups_[other].is_merged) propose(other, last);
  }

  const MeshDistance& solid_;
  double over_;
  std::vector<Group>& groups_;
  std::priority_queue<Proposal, std::vector<Proposal>, std::greater<>> proposals_;
};

CoarserLevel level_of(std::vector<Group>& groups, const MeshDistance& solid, double over,
                      const std::string& name) {
  CoarserLevel level{nullptr, 0.0};
  std::vector<PlacedHexahedron> solids;
  for (Group& group : groups) {
    const std::string own = "h" + std::to_string(solids.size());
    solids.push_back(
        {own, Hexahedron::from_vertices(group.vertices, WarpPolicy::accept, name + "/" + own), Pose()});
    if (group.excess < 0.0) group.excess = bound_excess(solid, group.vertices, kResolution * over, over).most;
    level.excess = std::max(level.excess, group.excess);
  }
  level.tree = std::make_shared<const HexahedronTree>(std::move(solids), name);
  return level;
}

}  // namespace

std::vector<CoarserLevel> coarser_levels(const HexahedronTree& tree, const MeshDistance& solid,
                                         std::span<const double> overs) {
  refuse_rounded(tree, "coarser_levels()");
  double before = 0.0;
  for (const double over : overs) {
    if (!(over > before) || !std::isfinite(over))
      reject("levels", "error " + figure(over) + " m is not above " + figure(before) + " m and finite");
    before = over;
  }
  // Each hexahedron is a group at first.
  std::vector<Group> groups;
  for (const PlacedHexahedron& placed : tree.solids()) {
    Group group;
    for (std::size_t i = 0; i < 8; ++i)
      group.vertices[i] = transform(placed.X_OS, placed.solid.vertices()[i]);
    group.axes = axes_of(placed.solid, placed.X_OS.R);
    groups.push_back(std::move(group));
  }
  // Each level goes on from the one before.
  std::vector<CoarserLevel> levels;
  for (const double over : overs) {
    for (Group& group : groups) {
      group.points.assign(group.vertices.begin(), group.vertices.end());
      group.volume = box_volume(group.axes, group.points);
      for (const Vector3& p : group.points) group.bounds.add(p);
    }
    Merger(solid, over, groups).run();
    levels.push_back(level_of(groups, solid, over, tree.name()));
  }
  return levels;
}

std::vector<CoarserLevel> coarser_levels(const HexahedronTree& tree, std::span<const double> overs) {
  refuse_rounded(tree, "coarser_levels()");
  return coarser_levels(tree, MeshDistance(weld(surface_of(tree))), overs);
}

}  // namespace touchstone

#include "touchstone/contact_core/fit/cells.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "touchstone/contact_core/fit/excess.hpp"

namespace touchstone::fit {
namespace {

constexpr std::size_t kMostPieces = 100;  // a box that takes more to tell is divided
// A cell so many times as wide as the smallest is looked at as a whole before it is divided.
constexpr double kWorthIt = 2.0;
// Of the limit: what a wall across an axis may lean in a cell; how near to its sides no wall is looked at,
// and what the box about a cell may leave beside the solid.
constexpr double kLevel = 1e-3, kStep = 0.1;

using Polygon = std::vector<Vector3>;

struct ByCoordinates {
  bool operator()(const Vector3& a, const Vector3& b) const {
    if (a.x() != b.x()) return a.x() < b.x();
    return a.y() != b.y() ? a.y() < b.y() : a.z() < b.z();
  }
};

// The part of a polygon on one side of a plane across an axis; sign +1 keeps what is above. A polygon in the
// plane belongs to both sides.
Polygon clipped(const Polygon& polygon, Eigen::Index axis, double at, double sign) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double hp = sign * (p(axis) - at), hq = sign * (q(axis) - at);
    if (hp >= 0.0) kept.push_back(p);
    if ((hp > 0.0 && hq < 0.0) || (hp < 0.0 && hq > 0.0)) {
      Vector3 cut = p + (q - p) * (hp / (hp - hq));
      cut(axis) = at;
      kept.push_back(cut);
    }
  }
  return kept;
}

// The part on the side of a plane that `sign` names.
Polygon clipped(const Polygon& polygon, const Plane& plane, double sign) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double hp = sign * plane.signed_distance(p), hq = sign * plane.signed_distance(q);
    if (hp >= 0.0) kept.push_back(p);
    if ((hp > 0.0 && hq < 0.0) || (hp < 0.0 && hq > 0.0)) kept.push_back(p + (q - p) * (hp / (hp - hq)));
  }
  return kept;
}

std::vector<Polygon> between(const std::vector<Polygon>& polygons, const Plane& from, const Plane& to) {
  std::vector<Polygon> kept;
  for (const Polygon& polygon : polygons) {
    Polygon part = clipped(clipped(polygon, from, 1.0), to, -1.0);
    if (!part.empty()) kept.push_back(std::move(part));
  }
  return kept;
}

Vector3 corner_of(const Vector3& low, const Vector3& high, int i) {
  return {(i & 4) != 0 ? high.x() : low.x(), (i & 2) != 0 ? high.y() : low.y(),
          (i & 1) != 0 ? high.z() : low.z()};
}

// Whether none of the box is on the side of a plane that `sign` names, or on the plane.
bool is_beyond(const Vector3& low, const Vector3& high, const Plane& plane, double sign) {
  const Vector3 middle = 0.5 * (low + high), size = 0.5 * (high - low);
  return -sign * plane.signed_distance(middle) > (1.0 + 1e-9) * dot(plane.normal.cwiseAbs(), size);
}

std::vector<Polygon> faces_of(const Vector3& low, const Vector3& high) {
  std::vector<Polygon> faces;
  for (const auto& loop : Hexahedron::kFaceVertices) {
    Polygon& face = faces.emplace_back();
    for (const int i : loop) face.push_back(corner_of(low, high, i));
  }
  return faces;
}

// Whether all corners are within `thickness` of one plane.
bool is_flat(const std::vector<Polygon>& polygons, double thickness) {
  Vector3 normal = Vector3::Zero();
  for (const Polygon& polygon : polygons) {
    for (std::size_t i = 2; i < polygon.size(); ++i) {
      const Vector3 n = cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
      normal += dot(n, normal) < 0.0 ? Vector3(-n) : n;
    }
  }
  const double length = norm(normal);
  if (length == 0.0) return false;
  normal /= length;
  double low = 1e300, high = -1e300;
  for (const Polygon& polygon : polygons) {
    for (const Vector3& p : polygon) {
      low = std::min(low, dot(normal, p));
      high = std::max(high, dot(normal, p));
    }
  }
  return high - low <= thickness;
}

}  // namespace

class CellBuilder {
 public:
  CellBuilder(Cells& cells, const MeshDistance& mesh, const AllowedSpace& allowed, double over,
              std::span<const Sectors> sectors)
      : cells_(cells),
        mesh_(mesh),
        allowed_(allowed),
        sectors_(sectors),
        largest_(std::max(over / std::sqrt(3.0), mesh.bounds().diagonal() / 100.0)) {}

  void build(double shift) {
    std::vector<Polygon> polygons;
    for (const auto& t : mesh_.mesh().triangles)
      polygons.push_back(
          {mesh_.mesh().vertices[t[0]], mesh_.mesh().vertices[t[1]], mesh_.mesh().vertices[t[2]]});
    const Vector3 margin = Vector3::Constant(1e-3 * largest_);
    const Vector3 shifted = shift * largest_ * Vector3(1.0, 0.7, 0.4);  // no two axes alike
    divide(mesh_.bounds().low - margin - shifted, mesh_.bounds().high + margin, polygons);
  }

 private:
  void divide(const Vector3& low, const Vector3& high, const std::vector<Polygon>& polygons) {
    const Vector3 middle = 0.5 * (low + high);
    if (polygons.empty() && !mesh_.is_inside(middle)) return;
    Eigen::Index axis = 0;
    const double size = (high - low).maxCoeff(&axis);
    if (!is_split(low, high, size, polygons)) return add_box(low, high, polygons);
    // It is cut in the middle, or along a wall across an axis: then what is on either side may be one box.
    double at = middle(axis);
    const double limit = allowed_.limit_at(middle);
    if (size <= largest_ && is_worth_it(size, limit)) cut_along_wall(low, high, polygons, limit, axis, at);
    std::array<std::vector<Polygon>, 2> halves;
    for (const Polygon& polygon : polygons) {
      for (int side = 0; side < 2; ++side) {
        Polygon part = clipped(polygon, axis, at, side == 0 ? -1.0 : 1.0);
        if (!part.empty()) halves[side].push_back(std::move(part));
      }
    }
    Vector3 cut_high = high, cut_low = low;
    cut_high(axis) = cut_low(axis) = at;
    divide(low, cut_high, halves[0]);
    divide(cut_low, high, halves[1]);
  }

  bool is_split(const Vector3& low, const Vector3& high, double size, const std::vector<Polygon>& polygons) {
    if (polygons.empty()) return size > 2.0 * largest_;
    if (size > largest_) return true;
    const Vector3 middle = 0.5 * (low + high);
    const double limit = allowed_.limit_at(middle);
    if (size <= limit / std::sqrt(3.0) || is_flat(polygons, 0.25 * limit)) return false;
    return !is_worth_it(size, limit) ||
           !is_one_box(low, high, polygons, kStep * allowed_.least_limit(middle, 0.5 * size));
  }

  static bool is_worth_it(double size, double limit) { return size > kWorthIt * limit / std::sqrt(3.0); }

  // The wall nearest to the middle that is not at a side already.
  static void cut_along_wall(const Vector3& low, const Vector3& high, const std::vector<Polygon>& polygons,
                             double limit, Eigen::Index& axis, double& at) {
    double nearest = 1e300;
    for (const Polygon& polygon : polygons) {
      Bounds box;
      for (const Vector3& p : polygon) box.add(p);
      for (int i = 0; i < 3; ++i) {
        const double wall = 0.5 * (box.low(i) + box.high(i)), off = std::abs(wall - 0.5 * (low(i) + high(i)));
        if (box.high(i) - box.low(i) > kLevel * limit || off >= nearest) continue;
        if (std::min(wall - low(i), high(i) - wall) < kStep * limit) continue;
        nearest = off;
        axis = i;
        at = wall;
      }
    }
  }

  // Whether the box about what is in a cell keeps to the limit: then one hexahedron can hold it, however
  // large it is. Along straight edges of walls that face the axes it does.
  bool is_one_box(const Vector3& low, const Vector3& high, const std::vector<Polygon>& polygons,
                  double limit) {
    Bounds box;
    for (const Polygon& polygon : polygons)
      for (const Vector3& p : polygon) box.add(p);
    for (int i = 0; i < 8; ++i)
      if (const Vector3 corner = corner_of(low, high, i); is_inside(corner)) box.add(corner);
    std::array<Vector3, 8> corners;
    for (int i = 0; i < 8; ++i) corners[i] = corner_of(box.low, box.high, i);
    const auto is_near = [&](const Vector3& p) { return mesh_.nearest(p).distance <= limit || is_inside(p); };
    return std::all_of(corners.begin(), corners.end(), is_near) &&
           bound_excess(mesh_, corners, 0.125 * limit, limit, nullptr, kMostPieces).most <= limit;
  }

  bool is_inside(const Vector3& p) {
    const auto [known, is_new] = inside_.try_emplace(p, false);
    if (is_new) known->second = mesh_.is_inside(p);
    return known->second;
  }

  void add_box(const Vector3& low, const Vector3& high, const std::vector<Polygon>& polygons) {
    for (const Sectors& sectors : sectors_)  // of two bores that are near the first divides
      if (sectors.touches(low, high)) return add_sectors(low, high, polygons, sectors);
    std::vector<Vector3> corners;
    for (int i = 0; i < 8; ++i) corners.push_back(corner_of(low, high, i));
    add(corners, polygons);
  }

  // A sector's part of the box is convex, and its corners are on the box's faces.
  void add_sectors(const Vector3& low, const Vector3& high, const std::vector<Polygon>& polygons,
                   const Sectors& sectors) {
    const std::vector<Polygon> faces = faces_of(low, high);
    for (int i = 0; i < sectors.count; ++i) {
      const Plane from = sectors.border(i), to = sectors.border((i + 1) % sectors.count);
      if (is_beyond(low, high, from, 1.0) || is_beyond(low, high, to, -1.0)) continue;
      std::vector<Vector3> corners;
      for (const Polygon& face : between(faces, from, to))
        corners.insert(corners.end(), face.begin(), face.end());
      if (corners.empty()) continue;
      std::sort(corners.begin(), corners.end(), ByCoordinates());
      corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
      const std::vector<Polygon> part = between(polygons, from, to);
      Vector3 middle = Vector3::Zero();
      for (const Vector3& p : corners) middle += p / static_cast<double>(corners.size());
      if (!part.empty() || mesh_.is_inside(middle)) add(corners, part);
    }
  }

  void add(const std::vector<Vector3>& corners, const std::vector<Polygon>& polygons) {
    std::vector<Vector3> points;
    for (const Polygon& polygon : polygons) points.insert(points.end(), polygon.begin(), polygon.end());
    for (const Vector3& corner : corners)
      if (polygons.empty() || is_inside(corner)) points.push_back(corner);
    std::sort(points.begin(), points.end(), ByCoordinates());
    points.erase(std::unique(points.begin(), points.end()), points.end());
    Bounds box;
    for (const Vector3& p : points) box.add(p);
    cells_.cells_.push_back({box.low, box.high, static_cast<std::uint32_t>(cells_.points_.size()),
                             static_cast<std::uint32_t>(points.size()), !polygons.empty()});
    cells_.points_.insert(cells_.points_.end(), points.begin(), points.end());
  }

  Cells& cells_;
  const MeshDistance& mesh_;
  const AllowedSpace& allowed_;
  std::span<const Sectors> sectors_;
  double largest_;
  std::map<Vector3, bool, ByCoordinates> inside_;
};

Cells::Cells(const MeshDistance& mesh, const AllowedSpace& allowed, double over,
             std::span<const Sectors> sectors, double shift) {
  CellBuilder(*this, mesh, allowed, over, sectors).build(shift);
  index(0, static_cast<std::uint32_t>(cells_.size()));
}

// Cells come in the order of the tree that made them: neighbours in number are neighbours in space.
void Cells::index(std::uint32_t first, std::uint32_t end) {
  const std::size_t self = nodes_.size();
  Bounds box;
  for (std::uint32_t i = first; i < end; ++i) {
    box.add(cells_[i].low);
    box.add(cells_[i].high);
  }
  nodes_.push_back({box.low, box.high, first, end, 0});
  if (end - first <= 4) return;
  const std::uint32_t middle = first + (end - first) / 2;
  index(first, middle);
  nodes_[self].right = static_cast<std::uint32_t>(nodes_.size());
  index(middle, end);
}

bool Cells::holds(const SixPlanes& solid, std::size_t i) const {
  for (const Vector3& p : points(i))
    if (solid.above(p) > 0.0) return false;
  return true;
}

void Cells::held(const SixPlanes& solid, std::vector<std::uint32_t>& out) const { held(solid, 0, out); }

void Cells::held(const SixPlanes& solid, std::uint32_t index, std::vector<std::uint32_t>& out) const {
  const Node& node = nodes_[index];
  const Vector3 middle = 0.5 * (node.low + node.high), half = 0.5 * (node.high - node.low);
  bool is_within = true;
  for (const Plane& plane : solid.planes) {
    const double height = plane.signed_distance(middle);
    const Vector3 n = plane.normal.cwiseAbs();
    const double reach = dot(n, half);
    if (height - reach > 0.0) return;
    is_within = is_within && height + reach <= 0.0;
  }
  if (is_within) {
    for (std::uint32_t i = node.first; i < node.end; ++i) out.push_back(i);
  } else if (node.right == 0) {
    for (std::uint32_t i = node.first; i < node.end; ++i)
      if (holds(solid, i)) out.push_back(i);
  } else {
    held(solid, index + 1, out);
    held(solid, node.right, out);
  }
}

}  // namespace touchstone::fit

#include "touchstone/contact_core/fit/search/cells.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "touchstone/contact_core/fit/excess.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::fit {
namespace {

constexpr std::size_t kMostPieces = 100;  // a box that takes more to tell is divided
// A cell this many times as wide as the smallest is looked at as a whole before it is divided.
constexpr double kWorthIt = 2.0;
// Of the limit: what a wall across an axis may lean in a cell; how near to its sides no wall is looked at,
// and what the box about a cell may leave beside the solid.
constexpr double kLevel = 1e-3, kStep = 0.1;
// Of the limit: how far a rectangle's corners may be off what is flat, a quarter of the limit thick; the rest
// is left to the steps that hexahedra are judged in.
constexpr double kBeside = 0.75;
constexpr double kPieces = 12.0;  // that a prism is cut into along its axis, at most

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

// The normal of a plane that all corners are within `thickness` of.
std::optional<Vector3> flat_normal(const std::vector<Polygon>& polygons, double thickness) {
  Vector3 normal = Vector3::Zero();
  for (const Polygon& polygon : polygons) {
    for (std::size_t i = 2; i < polygon.size(); ++i) {
      const Vector3 n = cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
      normal += dot(n, normal) < 0.0 ? Vector3(-n) : n;
    }
  }
  const double length = norm(normal);
  if (length == 0.0) return std::nullopt;
  normal /= length;
  double low = 1e300, high = -1e300;
  for (const Polygon& polygon : polygons) {
    for (const Vector3& p : polygon) {
      low = std::min(low, dot(normal, p));
      high = std::max(high, dot(normal, p));
    }
  }
  if (high - low > thickness) return std::nullopt;
  return normal;
}

}  // namespace

class CellBuilder {
 public:
  /// @param largest a cell's width, at most [m]
  CellBuilder(Cells& cells, const MeshDistance& mesh, const AllowedSpace& allowed, double largest,
              std::span<const Sectors> sectors, std::size_t most)
      : cells_(cells), mesh_(mesh), allowed_(allowed), sectors_(sectors), largest_(largest), most_(most) {}

  void build(double shift) {
    std::vector<Polygon> polygons;
    for (const auto& t : mesh_.mesh().triangles)
      polygons.push_back(
          {mesh_.mesh().vertices[t[0]], mesh_.mesh().vertices[t[1]], mesh_.mesh().vertices[t[2]]});
    const Vector3 margin = Vector3::Constant(1e-3 * largest_);
    const Vector3 shifted = shift * largest_ * Vector3(1.0, 0.7, 0.4);  // no two axes alike
    divide(mesh_.bounds().low - margin - shifted, mesh_.bounds().high + margin, polygons);
  }

  /// A cell a strip of its section, and a piece of its length. Its ends are not cut: no corner of a piece's
  /// room is inside.
  void add_prism(const Prism& prism, std::uint32_t index) {
    const double length = prism.high - prism.low;
    const double pieces = std::ceil(std::min(length / largest_, kPieces));
    for (std::size_t strip = 0; strip < prism.strips(); ++strip) {
      std::vector<Polygon> rest = prism.surface;
      const auto level = [&](std::size_t i) { return prism.plane_through({1.0, 0.0}, prism.borders[i]); };
      if (strip > 0) rest = parts_of(rest, level(strip - 1), 1.0);
      if (strip < prism.borders.size()) rest = parts_of(rest, level(strip), -1.0);
      for (double piece = 1.0; piece <= pieces; piece += 1.0) {
        const Plane end = {prism.axis, -(prism.low + piece / pieces * length)};
        const std::vector<Polygon> part = piece < pieces ? parts_of(rest, end, -1.0) : rest;
        if (!part.empty())
          add({}, part);
        else  // towards a tip an outer strip may end before: it has no more than the piece before
          cells_.cells_.push_back(Cells::Cell(cells_.cells_.back()));
        cells_.cells_.back().prism = index;
        cells_.cells_.back().strip = static_cast<std::uint32_t>(strip);
        rest = parts_of(rest, end, 1.0);
      }
    }
  }

  /// Cells of each sector's part of its shell, cut across the axis too.
  void add_ring(const TriangleMesh& mesh, const Sectors& sectors, std::uint32_t index) {
    const std::vector<Polygon> shell = sectors.surface(mesh);
    const double pieces = std::ceil(std::min(sectors.bore.length / largest_, kPieces));
    const double foot = dot(sectors.bore.axis, sectors.bore.foot);
    for (int i = 0; i < sectors.count; ++i) {
      std::vector<Polygon> rest = sectors.part_of(shell, i);
      for (double piece = 1.0; piece <= pieces; piece += 1.0) {
        const Plane end = {sectors.bore.axis, -(foot + piece / pieces * sectors.bore.length)};
        const std::vector<Polygon> part = piece < pieces ? parts_of(rest, end, -1.0) : rest;
        rest = parts_of(rest, end, 1.0);
        if (part.empty()) continue;
        add({}, part);
        cells_.cells_.back().ring = index;
        cells_.cells_.back().strip = static_cast<std::uint32_t>(i);
      }
    }
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
    const double limit = allowed_.least_limit(middle, 0.5 * size);
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
    // One that a smaller error reaches into keeps to it, or a hexahedron that holds it would not.
    const double limit = allowed_.least_limit(middle, 0.5 * size);
    if (size <= limit / std::sqrt(3.0) || is_plate(polygons, limit)) return false;
    return !is_worth_it(size, limit) ||
           !is_one_box(low, high, polygons, kStep * allowed_.least_limit(middle, 0.5 * size));
  }

  // Whether what is in a cell is flat, and a rectangle about it leaves no corner that is not allowed: one
  // that stands as a hexahedron that starts from the cell does. At a slanted rim of a face there is none.
  bool is_plate(const std::vector<Polygon>& polygons, double limit) const {
    const std::optional<Vector3> normal = flat_normal(polygons, 0.25 * limit);
    if (!normal) return false;
    Eigen::Index across = 0;
    normal->cwiseAbs().minCoeff(&across);
    Vector3 longest = Vector3::Unit(across);
    if (is_rectangle(polygons, *normal, longest)) return true;
    if (norm_inf(*normal) >= 0.9999) return false;
    double length = 0.0;
    for (const Polygon& polygon : polygons) {
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vector3 edge = polygon[(i + 1) % polygon.size()] - polygon[i];
        if (norm(edge) <= length) continue;
        length = norm(edge);
        longest = edge;
      }
    }
    return is_rectangle(polygons, *normal, longest);
  }

  bool is_rectangle(const std::vector<Polygon>& polygons, const Vector3& normal, const Vector3& hint) const {
    Vector3 x = hint - dot(hint, normal) * normal;
    x /= norm(x);
    const Vector3 y = cross(normal, x), &foot = polygons.front().front();
    Bounds box;
    for (const Polygon& polygon : polygons)
      for (const Vector3& p : polygon) box.add({dot(x, p - foot), dot(y, p - foot), 0.0});
    for (const double u : {box.low.x(), box.high.x()}) {
      for (const double v : {box.low.y(), box.high.y()}) {
        const Vector3 p = foot + u * x + v * y;
        if (!mesh_.is_near(p, kBeside * allowed_.limit_at(p)) && !mesh_.is_inside(p)) return false;
      }
    }
    return true;
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
           !find_beyond(mesh_, corners, limit, 0.125 * limit, nullptr, kMostPieces);
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
      for (const Polygon& face : sectors.part_of(faces, i))
        corners.insert(corners.end(), face.begin(), face.end());
      if (corners.empty()) continue;
      std::sort(corners.begin(), corners.end(), ByCoordinates());
      corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
      const std::vector<Polygon> part = sectors.part_of(polygons, i);
      Vector3 middle = Vector3::Zero();
      for (const Vector3& p : corners) middle += p / static_cast<double>(corners.size());
      if (!part.empty() || mesh_.is_inside(middle)) add(corners, part);
    }
  }

  void add(const std::vector<Vector3>& corners, const std::vector<Polygon>& polygons) {
    if (cells_.size() >= most_)
      reject("fit", "more than " + std::to_string(most_) + " pieces of a mesh of " +
                        figure(mesh_.bounds().diagonal()) +
                        " m: ask for a larger error, or for it in smaller regions");
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
  std::size_t most_;
  std::map<Vector3, bool, ByCoordinates> inside_;
};

Cells::Cells(const MeshDistance& mesh, const AllowedSpace& allowed, double over,
             std::span<const Sectors> sectors, double shift, std::span<const Prism> prisms,
             std::size_t most) {
  const double largest = std::max(over / std::sqrt(3.0), mesh.bounds().diagonal() / 100.0);
  // Prisms and rings are cut by themselves, all the rest by boxes.
  std::vector<std::uint8_t> is_out(mesh.mesh().triangles.size(), 0);
  for (const Prism& prism : prisms)
    for (const std::uint32_t t : prism.triangles) is_out[t] = 1;
  for (const Sectors& each : sectors)
    for (const std::uint32_t t : each.shell) is_out[t] = 1;
  const bool is_all = std::find(is_out.begin(), is_out.end(), 1) == is_out.end();
  const std::optional<MeshDistance> rest = is_all ? std::nullopt : without(mesh, is_out);
  if (is_all || rest) CellBuilder(*this, rest ? *rest : mesh, allowed, largest, sectors, most).build(shift);
  CellBuilder builder(*this, mesh, allowed, largest, sectors, most);
  for (std::uint32_t i = 0; i < prisms.size(); ++i) builder.add_prism(prisms[i], i);
  for (std::uint32_t i = 0; i < sectors.size(); ++i)
    if (sectors[i].has_shell()) builder.add_ring(mesh.mesh(), sectors[i], i);
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

struct Cells::Holder {
  const SixPlanes& solid;
  std::array<Vector3, 6> sizes;  // of the planes' normals: how far they reach over half a box
  std::vector<std::uint32_t>& out;

  /// Whether all of a box is outside of one of these faces, by their bits. Those that have all of it inside
  /// are taken out: none of them is asked of what is in the box.
  bool is_beyond(const Vector3& low, const Vector3& high, unsigned& faces) const {
    const Vector3 middle = 0.5 * (low + high), half = 0.5 * (high - low);
    for (int f = 0; f < 6; ++f) {
      if ((faces >> f & 1U) == 0) continue;
      const double height = solid.planes[f].signed_distance(middle), reach = dot(sizes[f], half);
      if (height - reach > 0.0) return true;
      if (height + reach <= 0.0) faces &= ~(1U << f);
    }
    return false;
  }
  bool holds(std::span<const Vector3> points, unsigned faces) const {
    for (int f = 0; f < 6; ++f) {
      if ((faces >> f & 1U) == 0) continue;
      for (const Vector3& p : points)
        if (solid.planes[f].signed_distance(p) > 0.0) return false;
    }
    return true;
  }
};

void Cells::held(const SixPlanes& solid, std::vector<std::uint32_t>& out) const {
  Holder holder{solid, {}, out};
  for (int f = 0; f < 6; ++f) holder.sizes[f] = solid.planes[f].normal.cwiseAbs();
  held(holder, 0, 0x3fU);
}

void Cells::held(const Holder& holder, std::uint32_t index, unsigned faces) const {
  const Node& node = nodes_[index];
  if (holder.is_beyond(node.low, node.high, faces)) return;
  if (faces == 0) {
    for (std::uint32_t i = node.first; i < node.end; ++i) holder.out.push_back(i);
  } else if (node.right == 0) {
    for (std::uint32_t i = node.first; i < node.end; ++i) {
      unsigned left = faces;
      if (!holder.is_beyond(cells_[i].low, cells_[i].high, left) && holder.holds(points(i), left))
        holder.out.push_back(i);
    }
  } else {
    held(holder, index + 1, faces);
    held(holder, node.right, faces);
  }
}

}  // namespace touchstone::fit

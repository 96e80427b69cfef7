#include "touchstone/contact_core/geometry/hexahedron.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/corner_order.hpp"
#include "touchstone/contact_core/geometry/face_plane.hpp"
#include "touchstone/contact_core/geometry/orientation.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

// How far a vertex may lie from its face's plane, per metre of size, before the face counts as warped.
// Corners computed as R v + t in doubles are off by at most (4 + 3) eps/2 per coordinate of a size-long
// vector; 32 eps leaves room for one more such transform and for the plane's own rounding.
constexpr double kPlanarTolerance = 32 * std::numeric_limits<double>::epsilon();

// See Hexahedron::bend_tolerance().
constexpr double kBendOfSize = 0.01;
constexpr double kBendOfCoordinate = 0x1p-23;
constexpr double kLargestBendOfSize = 0.05;

// An order given by the user stays unless another bends this many times less: a choice that rounding makes
// must not rename the faces of a sheet hardly thicker than its rounding.
constexpr double kClearlyFlatter = 4.0;

// Of two orders that bend about as much, neither is the one that the file rounded.
constexpr double kAmbiguous = 2.0;

double largest_coordinate(const Corners& vertices) {
  double largest = 0.0;
  for (const Vector3& v : vertices)
    largest = std::max({largest, std::abs(v.x()), std::abs(v.y()), std::abs(v.z())});
  return largest;
}

double largest_vertex_distance(const Corners& vertices) {
  double largest = 0.0;
  for (int i = 0; i < 8; ++i)
    for (int j = i + 1; j < 8; ++j) largest = std::max(largest, norm(vertices[i] - vertices[j]));
  return largest;
}

// All four vertices on one line. A bow-tie's diagonals are parallel as well, yet it is no face at all.
bool is_collapsed(const Corners& v, const std::array<std::uint8_t, 4>& quad, double tolerance) {
  for (int k = 0; k < 4; ++k) {
    const Vector3& corner = v[quad[k]];
    const Vector3 next = v[quad[(k + 1) & 3]] - corner;
    const Vector3 last = v[quad[(k + 3) & 3]] - corner;
    if (norm(cross(next, last)) > tolerance * std::max(norm(next), norm(last))) return false;
  }
  return true;
}

// Relative to vertex 0 and scaled by a power of two to about 1: no square overflows or underflows, and
// rounding is relative to the size, wherever the vertices lie. unit * 2^exponent are metres.
struct UnitCorners {
  Corners corners;
  int exponent;
};

void scale(Corners& vertices, int exponent) {
  for (Vector3& p : vertices)
    p = {std::scalbn(p.x(), exponent), std::scalbn(p.y(), exponent), std::scalbn(p.z(), exponent)};
}

UnitCorners to_unit(Corners vertices) {
  const int first = std::ilogb(largest_coordinate(vertices));
  scale(vertices, -first);
  const Vector3 origin = vertices[0];
  for (Vector3& p : vertices) p -= origin;
  const int second = std::ilogb(largest_coordinate(vertices));
  scale(vertices, -second);
  return {vertices, first + second};
}

// Every vertex below every face plane by tolerance, all faces planar to tolerance.
bool is_planar_hexahedron(const Corners& v, double tolerance) {
  for (int f = 0; f < 6; ++f) {
    const auto& quad = Hexahedron::kFaceVertices[f];
    const Plane plane = face_plane(v, f);
    if (plane.normal == Vector3::Zero()) {
      if (!is_collapsed(v, quad, tolerance)) return false;
      continue;
    }
    for (int i = 0; i < 8; ++i) {
      const double height = plane.signed_distance(v[i]);
      const bool on_face = std::find(quad.begin(), quad.end(), i) != quad.end();
      if (on_face ? std::abs(height) > tolerance : height > tolerance) return false;
    }
  }
  return true;
}

double signed_volume(const Corners& v) {
  Vector3 centre = Vector3::Zero();
  for (const Vector3& p : v) centre += 0.125 * p;
  double volume = 0.0;
  for (const auto& quad : Hexahedron::kFaceVertices) {
    const Vector3 a = v[quad[0]] - centre, b = v[quad[1]] - centre, c = v[quad[2]] - centre,
                  d = v[quad[3]] - centre;
    volume += dot(a, cross(b, c)) + dot(a, cross(c, d)) + dot(b, cross(c, d)) + dot(a, cross(b, d));
  }
  return volume;
}

// Not mirrored: kFaceVertices are counter-clockwise seen from outside.
CornerOrder upright(const Corners& points, CornerOrder order) {
  if (signed_volume(in_order(points, order)) < 0.0)
    for (int i = 0; i < 4; ++i) std::swap(order[i], order[i ^ 4]);
  return order;
}

// The input of find_order(). Bends and tolerances are in the units of `unit`.
struct OrderSearch {
  Corners points;     // upright
  UnitCorners unit;   // the same
  CornerOrder given;  // how the user counts them
  double planar, tolerance;
  WarpPolicy warp;
};

// "face 5 (vertices 1 5 7 3) is warped: a vertex is 0.12 m out of plane", the vertices as the user counts
// them.
std::string worst_face(const OrderSearch& search, const CornerOrder& order) {
  const Corners corners = in_order(search.unit.corners, order);
  int worst = 0;
  for (int f = 1; f < 6; ++f)
    if (face_bend(corners, f) > face_bend(corners, worst)) worst = f;
  std::string text = "face " + std::to_string(worst) + " (vertices";
  for (int i : Hexahedron::kFaceVertices[worst]) text += " " + std::to_string(search.given[order[i]]);
  return text + ") is warped: a vertex is " +
         figure(std::scalbn(face_bend(corners, worst), search.unit.exponent)) + " m out of plane";
}

[[noreturn]] void reject_bent(const OrderSearch& search, const CornerOrder& order, std::string_view name) {
  const bool refuse = search.warp == WarpPolicy::refuse;
  const double limit = std::scalbn(refuse ? search.planar : search.tolerance, search.unit.exponent);
  reject(name, worst_face(search, order) + (refuse ? ", planar up to " : ", tolerated up to ") +
                   figure(limit) + " m; accept warped solids explicitly to have them checked triangulated");
}

[[noreturn]] void reject_orders(const OrderSearch& search, const FlattestOrder& flattest,
                                std::string_view name) {
  const std::string no_hexahedron =
      "no convex hexahedron: in the given vertex order its quads are not faces of the hull, and ";
  if (flattest.bend == kInfinity) reject(name, no_hexahedron + "in no order of the vertices are they");
  reject(name, no_hexahedron + "no order of the vertices gives six faces planar up to " +
                   figure(std::scalbn(search.warp == WarpPolicy::refuse ? search.planar : search.tolerance,
                                      search.unit.exponent)) +
                   " m; in the one that bends least " + worst_face(search, flattest.order));
}

// The order of search.points in which they are a hexahedron.
CornerOrder find_order(const OrderSearch& search, std::string_view name) {
  constexpr CornerOrder kAsGiven = {0, 1, 2, 3, 4, 5, 6, 7};
  // A solid is convex only if all eight vertices are vertices of their hull.
  const HullEdges hull = hull_edges(search.points);
  for (int i = 0; i < 8; ++i)
    if (!(hull.on_hull >> i & 1))
      reject(name,
             "not convex: vertex " + std::to_string(search.given[i]) + " lies inside the hull of the others");
  // The given order is weighed against the flattest one.
  const bool given_fits = fits_hull(hull, kAsGiven);
  const double given_bend = largest_bend(search.unit.corners);
  const FlattestOrder flattest =
      hull.coincident ? FlattestOrder{} : flattest_order(search.unit.corners, hull);

  // Vertices get a new order only if it is clearly flatter, and the only one as flat.
  const double limit = search.warp == WarpPolicy::refuse ? search.planar : search.tolerance;
  const bool relabel =
      flattest.bend <= limit &&
      !(given_fits && given_bend <= std::max(kClearlyFlatter * flattest.bend, search.planar));
  const bool ambiguous = flattest.next_bend <= std::max(kAmbiguous * flattest.bend, search.planar);
  if (relabel && !ambiguous) return flattest.order;
  if (given_fits && (given_bend <= limit || search.warp == WarpPolicy::accept)) return kAsGiven;
  if (given_fits) reject_bent(search, kAsGiven, name);
  if (!relabel) reject_orders(search, flattest, name);
  reject(name, "no unique hexahedron: two orders of the vertices give faces that bend by " +
                   figure(std::scalbn(flattest.bend, search.unit.exponent)) + " m and " +
                   figure(std::scalbn(flattest.next_bend, search.unit.exponent)) +
                   " m; give them in the order of Hexahedron");
}

// Finite, eight, and not all in one plane.
Corners checked_points(std::span<const Vector3> given, std::string_view name) {
  if (given.size() != 8)
    reject(name, "has " + std::to_string(given.size()) + " vertices, a hexahedron has 8");
  Corners points;
  for (int i = 0; i < 8; ++i) {
    if (!is_finite(given[i])) reject(name, "vertex " + std::to_string(i) + " is not finite");
    points[i] = given[i];
  }
  if (!numerics::has_volume(points)) reject(name, "zero volume: its vertices are coplanar");
  return points;
}

}  // namespace

Hexahedron Hexahedron::from_size(const Vector3& size, std::string_view name) {
  constexpr std::array<const char*, 3> kAxis = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    const std::string side = std::string("size along ") + kAxis[i] + " is ";
    if (!std::isfinite(size(i))) reject(name, side + "not finite");
    if (!(size(i) > 0.0)) reject(name, side + figure(size(i)) + ", must be > 0");
    if (0.5 * size(i) == 0.0) reject(name, side + figure(size(i)) + ", its half is zero in double");
  }
  return centred_box(0.5 * size);
}

Hexahedron Hexahedron::centred_box(const Vector3& half) {
  Corners vertices;
  for (int i = 0; i < 8; ++i)
    vertices[i] = {i & 4 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 1 ? half.z() : -half.z()};
  Hexahedron box;
  box.is_box_ = true;
  box.half_extents_ = half;
  box.finish(vertices);
  box.out_of_plane_ = 0.0;
  return box;
}

Hexahedron Hexahedron::sphere(double radius, std::string_view name) {
  return rounded_box(Vector3::Zero(), radius, name);
}

Hexahedron Hexahedron::capsule(double radius, double length, std::string_view name) {
  if (!std::isfinite(length)) reject(name, "length is not finite");
  if (!(length >= 0.0)) reject(name, "length is " + figure(length) + ", must be >= 0");
  return rounded_box({0.0, 0.0, length}, radius, name);
}

Hexahedron Hexahedron::rounded_box(const Vector3& core_size, double radius, std::string_view name) {
  constexpr std::array<const char*, 3> kAxis = {"x", "y", "z"};
  Vector3 half;
  for (int i = 0; i < 3; ++i) {
    const std::string side = std::string("size along ") + kAxis[i] + " is ";
    if (!std::isfinite(core_size(i))) reject(name, side + "not finite");
    if (!(core_size(i) >= 0.0)) reject(name, side + figure(core_size(i)) + ", must be >= 0");
    half(i) = 0.5 * std::abs(core_size(i));
    if (core_size(i) > 0.0 && half(i) == 0.0)
      reject(name, side + figure(core_size(i)) + ", its half is zero in double");
  }
  return centred_box(half).padded(radius, name);
}

Hexahedron Hexahedron::padded(double radius, std::string_view name) const {
  if (!std::isfinite(radius)) reject(name, "radius is not finite");
  if (!(radius > 0.0)) reject(name, "radius is " + figure(radius) + ", must be > 0");
  Hexahedron out = *this;
  out.radius_ = radius_ + radius;
  out.bounding_sphere_.radius =
      (bounding_sphere_.radius + radius) * (1.0 + 2 * std::numeric_limits<double>::epsilon());
  if (!std::isfinite(out.radius_) || !std::isfinite(out.bounding_sphere_.radius))
    reject(name, "radius is " + figure(radius) + ", too large");
  return out;
}

void refuse_rounded(std::span<const Hexahedron> solids, std::string_view user) {
  for (std::size_t i = 0; i < solids.size(); ++i)
    if (solids[i].is_rounded())
      throw InputError(std::string(user) + ": solid " + std::to_string(i) + " is rounded (radius " +
                       figure(solids[i].radius()) + " m), which it does not take");
}

double Hexahedron::bend_tolerance(double size, double largest_coordinate) {
  return std::min(kBendOfSize * size + kBendOfCoordinate * largest_coordinate, kLargestBendOfSize * size);
}

Hexahedron Hexahedron::from_vertices(std::span<const Vector3> given, WarpPolicy warp, std::string_view name) {
  const Corners points = checked_points(given, name);
  UnitCorners unit = to_unit(points);
  const CornerOrder upright_order = upright(unit.corners, {0, 1, 2, 3, 4, 5, 6, 7});
  unit.corners = in_order(unit.corners, upright_order);

  const double size = largest_vertex_distance(unit.corners);
  const double planar = kPlanarTolerance * size;
  const double tolerance = bend_tolerance(size, std::scalbn(largest_coordinate(points), -unit.exponent));
  Hexahedron solid;
  if (is_planar_hexahedron(unit.corners, planar)) {
    solid.finish(in_order(points, upright_order));
    return solid;
  }
  const OrderSearch search{in_order(points, upright_order), unit, upright_order, planar, tolerance, warp};
  const CornerOrder order = upright(unit.corners, find_order(search, name));
  solid.is_warped_ = !is_planar_hexahedron(in_order(unit.corners, order), planar);
  solid.finish(in_order(search.points, order));
  return solid;
}

void Hexahedron::finish(const Corners& vertices) {
  vertices_ = vertices;
  bounding_sphere_ = {vertices[0], std::numeric_limits<double>::denorm_min()};
  if (largest_coordinate(vertices_) == 0.0) {  // a sphere's core: nothing to scale
    planes_.fill({Vector3::Zero(), 0.0});
    return;
  }
  const auto [unit, exponent] = to_unit(vertices);
  const int scale_back = exponent;
  const auto restore = [scale_back](double value) { return std::scalbn(value, scale_back); };

  size_ = restore(largest_vertex_distance(unit));
  for (int f = 0; f < 6; ++f) {
    const Plane plane = touchstone::face_plane(unit, f);
    planes_[f] = {plane.normal, restore(plane.offset) - dot(plane.normal, vertices[0])};
    out_of_plane_ = std::max(out_of_plane_, restore(face_bend(unit, f)));
  }
  Vector3 low = vertices[0];
  Vector3 high = vertices[0];
  for (const Vector3& p : vertices) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Vector3 centre = 0.5 * low + 0.5 * high;
  Corners from_centre;
  for (int i = 0; i < 8; ++i) {
    const Vector3 arm = vertices[i] - centre;
    from_centre[i] = {std::scalbn(arm.x(), -exponent), std::scalbn(arm.y(), -exponent),
                      std::scalbn(arm.z(), -exponent)};
  }
  double radius = 0.0;
  for (const Vector3& arm : from_centre) radius = std::max(radius, norm(arm));
  // One rounding in each difference, three in the squares, one in the root: 4 eps encloses every vertex.
  // Scaling back may lose half a denormal step.
  radius *= 1.0 + 4 * std::numeric_limits<double>::epsilon();
  bounding_sphere_ = {centre, restore(radius) + std::numeric_limits<double>::denorm_min()};
}

EdgeLine Hexahedron::edge_line(int edge) const {
  const Vector3& start = vertices_[kEdgeVertices[edge][0]];
  return {start, vertices_[kEdgeVertices[edge][1]] - start};
}

void world_vertices(const Hexahedron& solid, const Pose& X_WS, WorldVertices& out) {
  for (int i = 0; i < 8; ++i) {
    const Vector3 p = transform(X_WS, solid.vertices()[i]);
    out.x[i] = p.x(), out.y[i] = p.y(), out.z[i] = p.z();
  }
}

double largest_coordinate(const WorldVertices& vertices) {
  double largest = 0.0;
  for (int i = 0; i < 8; ++i)
    largest = std::max({largest, std::abs(vertices.x[i]), std::abs(vertices.y[i]), std::abs(vertices.z[i])});
  return largest;
}

}  // namespace touchstone

#include "touchstone/contact_core/geometry/hexahedron.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/numerics/exact_predicates.hpp"

namespace touchstone {
namespace {

using Vertices = std::array<Vector3, 8>;

// How far a vertex may lie from its face's plane, per metre of size, before the face counts as warped.
// Vertices computed as R v + t in doubles are off by at most (4 + 3) eps/2 per coordinate of a size-long
// vector; 32 eps leaves room for one more such transform and for the plane's own rounding.
constexpr double kPlanarTolerance = 32 * std::numeric_limits<double>::epsilon();

// What rounding to single precision leaves of planar faces is planar to so many times this.
constexpr double kSinglePrecision =
    static_cast<double>(std::numeric_limits<float>::epsilon()) / std::numeric_limits<double>::epsilon();

double largest_coordinate(const Vertices& vertices) {
  double largest = 0.0;
  for (const Vector3& v : vertices)
    largest = std::max({largest, std::abs(v.x()), std::abs(v.y()), std::abs(v.z())});
  return largest;
}

double largest_vertex_distance(const Vertices& vertices) {
  double largest = 0.0;
  for (int i = 0; i < 8; ++i)
    for (int j = i + 1; j < 8; ++j) largest = std::max(largest, norm(vertices[i] - vertices[j]));
  return largest;
}

// Unit normal of a vector of any magnitude; zero for zero.
Vector3 direction_of(const Vector3& v) {
  const double largest = std::max({std::abs(v.x()), std::abs(v.y()), std::abs(v.z())});
  if (largest == 0.0) return Vector3::Zero();
  const int exponent = -std::ilogb(largest);
  const Vector3 scaled(std::scalbn(v.x(), exponent), std::scalbn(v.y(), exponent),
                       std::scalbn(v.z(), exponent));
  return scaled / norm(scaled);
}

Plane quad_plane(const Vertices& v, const std::array<std::uint8_t, 4>& quad) {
  const Vector3 normal = direction_of(cross(v[quad[2]] - v[quad[0]], v[quad[3]] - v[quad[1]]));
  const Vector3 centroid = 0.25 * ((v[quad[0]] + v[quad[1]]) + (v[quad[2]] + v[quad[3]]));
  return {normal, -dot(normal, centroid)};
}

double quad_out_of_plane(const Vertices& v, const std::array<std::uint8_t, 4>& quad) {
  const Plane plane = quad_plane(v, quad);
  double largest = 0.0;
  for (std::uint8_t i : quad) largest = std::max(largest, std::abs(plane.signed_distance(v[i])));
  return largest;
}

// All four vertices on one line. A bow-tie's diagonals are parallel as well, yet it is no face at all.
bool is_collapsed(const Vertices& v, const std::array<std::uint8_t, 4>& quad, double tolerance) {
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
struct UnitVertices {
  Vertices vertices;
  int exponent;
};

void scale(Vertices& vertices, int exponent) {
  for (Vector3& p : vertices)
    p = {std::scalbn(p.x(), exponent), std::scalbn(p.y(), exponent), std::scalbn(p.z(), exponent)};
}

UnitVertices to_unit(Vertices vertices) {
  const int first = std::ilogb(largest_coordinate(vertices));
  scale(vertices, -first);
  const Vector3 origin = vertices[0];
  for (Vector3& p : vertices) p -= origin;
  const int second = std::ilogb(largest_coordinate(vertices));
  scale(vertices, -second);
  return {vertices, first + second};
}

// Every vertex below every face plane by tolerance, all faces planar to tolerance.
bool is_planar_hexahedron(const Vertices& v, double tolerance) {
  for (const auto& quad : Hexahedron::kFaceVertices) {
    const Plane plane = quad_plane(v, quad);
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

bool has_volume(const Vertices& v) {
  for (int i = 0; i < 8; ++i)
    for (int j = i + 1; j < 8; ++j)
      for (int k = j + 1; k < 8; ++k)
        for (int l = k + 1; l < 8; ++l)
          if (numerics::orient3d_sign(v[i], v[j], v[k], v[l]) != 0) return true;
  return false;
}

bool collinear(const Vector3& a, const Vector3& b, const Vector3& c, const Vertices& all) {
  // With positive volume, a, b, c are collinear exactly when they span no volume with any vertex.
  return std::all_of(all.begin(), all.end(),
                     [&](const Vector3& d) { return numerics::orient3d_sign(a, b, c, d) == 0; });
}

// True if the plane through i, j, k supports the hull (all vertices on one side, exactly).
bool supports_hull(const Vertices& v, int i, int j, int k) {
  if (collinear(v[i], v[j], v[k], v)) return false;
  bool above = false;
  bool below = false;
  for (int l = 0; l < 8; ++l) {
    const int side = numerics::orient3d_sign(v[i], v[j], v[k], v[l]);
    above = above || side > 0;
    below = below || side < 0;
  }
  return !(above && below);
}

bool is_on_hull(const Vertices& v, int i) {
  for (int j = 0; j < 8; ++j)
    for (int k = j + 1; k < 8; ++k)
      if (j != i && k != i && supports_hull(v, i, j, k)) return true;
  return false;
}

bool is_hull_edge(const Vertices& v, int i, int j) {
  if (v[i] == v[j]) return true;
  for (int k = 0; k < 8; ++k)
    if (k != i && k != j && supports_hull(v, i, j, k)) return true;
  return false;
}

// The hull of a warped hexahedron, exactly: every vertex on it, every one of the twelve edges on it.
bool is_warped_hexahedron(const Vertices& v) {
  for (const auto& edge : Hexahedron::kEdgeVertices)
    if (!is_hull_edge(v, edge[0], edge[1])) return false;
  // A quad's diagonals may both lie below the hull only if the quad is not part of the boundary at all.
  for (const auto& quad : Hexahedron::kFaceVertices) {
    const bool split_02 = is_hull_edge(v, quad[0], quad[2]);
    const bool split_13 = is_hull_edge(v, quad[1], quad[3]);
    if (!split_02 && !split_13) return false;
  }
  return true;
}

double signed_volume(const Vertices& v) {
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

Vertices mirrored(const Vertices& v) {
  Vertices out;
  for (int i = 0; i < 8; ++i) out[i] = v[i ^ 4];
  return out;
}

// Bit 1 << i for every vertex of each planar supporting quad.
std::vector<unsigned> planar_hull_quads(const Vertices& v, double tolerance) {
  std::vector<unsigned> quads;
  for (int i = 0; i < 8; ++i) {
    for (int j = i + 1; j < 8; ++j) {
      for (int k = j + 1; k < 8; ++k) {
        const Vector3 normal = direction_of(cross(v[j] - v[i], v[k] - v[i]));
        unsigned on = 0;
        bool above = false, below = false;
        for (int l = 0; l < 8; ++l) {
          const double height = dot(normal, v[l] - v[i]);
          if (std::abs(height) <= tolerance) on |= 1u << l;
          above = above || height > tolerance;
          below = below || height < -tolerance;
        }
        if (above && below) continue;
        if (std::popcount(on) != 4) continue;
        if (std::find(quads.begin(), quads.end(), on) == quads.end()) quads.push_back(on);
      }
    }
  }
  return quads;
}

// Labels the vertices of a planar-faced hexahedron given in any order; nothing when its faces are not a
// cube's.
std::optional<std::array<int, 8>> relabelled(const Vertices& v, double tolerance) {
  const std::vector<unsigned> quads = planar_hull_quads(v, tolerance);
  if (quads.size() != 6) return std::nullopt;
  const auto faces_of = [&](int i) {
    unsigned faces = 0;
    for (unsigned f = 0; f < 6; ++f)
      if (quads[f] >> i & 1u) faces |= 1u << f;
    return faces;
  };
  std::array<int, 8> label{};
  label.fill(-1);
  const unsigned faces_of_first = faces_of(0);
  if (std::popcount(faces_of_first) != 3) return std::nullopt;
  // A vertex is off the first one along x, y, z exactly when it is not on the first one's x-, y-, z-face.
  std::array<unsigned, 3> first_faces{};
  for (unsigned f = 0, found = 0; f < 6; ++f)
    if (faces_of_first >> f & 1u) first_faces[found++] = f;
  for (int i = 0; i < 8; ++i) {
    int bits = 0;
    for (int axis = 0; axis < 3; ++axis)
      if (!(quads[first_faces[axis]] >> i & 1u)) bits |= 4 >> axis;
    if (label[bits] >= 0) return std::nullopt;
    label[bits] = i;
  }
  return label;
}

Vertices permuted(const Vertices& v, const std::array<int, 8>& label) {
  Vertices out;
  for (int bits = 0; bits < 8; ++bits) out[bits] = v[label[bits]];
  return out;
}

struct OrderedVertices {
  Vertices vertices, unit;
};

// In the order of Hexahedron and not mirrored; nothing when the hull's faces to `tolerance` are not a cube's.
std::optional<OrderedVertices> in_order(const Vertices& vertices, const Vertices& unit, double tolerance) {
  const std::optional<std::array<int, 8>> label = relabelled(unit, tolerance);
  if (!label) return std::nullopt;
  OrderedVertices out{permuted(vertices, *label), permuted(unit, *label)};
  if (signed_volume(out.unit) < 0.0) out = {mirrored(out.vertices), mirrored(out.unit)};
  return out;
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
  Vertices vertices;
  const Vector3 half = 0.5 * size;
  for (int i = 0; i < 8; ++i)
    vertices[i] = {i & 4 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 1 ? half.z() : -half.z()};
  Hexahedron box;
  box.is_box_ = true;
  box.half_extents_ = half;
  box.finish(vertices);
  box.out_of_plane_ = 0.0;
  return box;
}

Hexahedron Hexahedron::from_vertices(std::span<const Vector3> given, WarpPolicy warp, std::string_view name) {
  if (given.size() != 8)
    reject(name, "has " + std::to_string(given.size()) + " vertices, a hexahedron has 8");
  Vertices vertices;
  for (int i = 0; i < 8; ++i) {
    if (!is_finite(given[i])) reject(name, "vertex " + std::to_string(i) + " is not finite");
    vertices[i] = given[i];
  }
  if (!has_volume(vertices)) reject(name, "zero volume: its vertices are coplanar");

  UnitVertices scaled = to_unit(vertices);
  Vertices& unit = scaled.vertices;
  if (signed_volume(unit) < 0.0) vertices = mirrored(vertices), unit = mirrored(unit);
  const double tolerance = kPlanarTolerance * largest_vertex_distance(unit);

  Hexahedron solid;
  if (is_planar_hexahedron(unit, tolerance)) {
    solid.finish(vertices);
    return solid;
  }
  if (const auto ordered = in_order(vertices, unit, tolerance);
      ordered && is_planar_hexahedron(ordered->unit, tolerance)) {
    solid.finish(ordered->vertices);
    return solid;
  }
  for (int i = 0; i < 8; ++i)
    if (!is_on_hull(vertices, i))
      reject(name, "not convex: vertex " + std::to_string(i) + " lies inside the hull of the others");
  bool is_hexahedron = is_warped_hexahedron(vertices);
  if (!is_hexahedron && warp == WarpPolicy::accept) {
    if (const auto ordered = in_order(vertices, unit, kSinglePrecision * tolerance)) {
      vertices = ordered->vertices, unit = ordered->unit;
      is_hexahedron = is_warped_hexahedron(vertices);
    }
  }
  if (!is_hexahedron)
    reject(name,
           "no convex hexahedron: in the given vertex order its quads are not faces of the hull, and no "
           "order of "
           "the vertices gives six planar faces");
  int worst_face = 0;
  std::array<double, 6> out_of_plane{};
  for (int f = 0; f < 6; ++f) {
    out_of_plane[f] = std::scalbn(quad_out_of_plane(unit, kFaceVertices[f]), scaled.exponent);
    if (out_of_plane[f] > out_of_plane[worst_face]) worst_face = f;
  }
  if (warp == WarpPolicy::refuse)
    reject(name, "face " + std::to_string(worst_face) + " is warped: a vertex is " +
                     figure(out_of_plane[worst_face]) + " m out of plane, planar up to " +
                     figure(std::scalbn(tolerance, scaled.exponent)) +
                     " m; accept warped solids explicitly to have them checked triangulated");
  solid.is_warped_ = true;
  solid.finish(vertices);
  return solid;
}

void Hexahedron::finish(const Vertices& vertices) {
  vertices_ = vertices;
  const auto [unit, exponent] = to_unit(vertices);
  const int scale_back = exponent;
  const auto restore = [scale_back](double value) { return std::scalbn(value, scale_back); };

  size_ = restore(largest_vertex_distance(unit));
  for (int f = 0; f < 6; ++f) {
    const Plane plane = quad_plane(unit, kFaceVertices[f]);
    planes_[f] = {plane.normal, restore(plane.offset) - dot(plane.normal, vertices[0])};
    out_of_plane_ = std::max(out_of_plane_, restore(quad_out_of_plane(unit, kFaceVertices[f])));
  }
  Vector3 low = vertices[0];
  Vector3 high = vertices[0];
  for (const Vector3& p : vertices) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Vector3 centre = 0.5 * low + 0.5 * high;
  Vertices from_centre;
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

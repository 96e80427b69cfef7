#include "touchstone/examples/measures/accuracy/surface_measure.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/orientation.hpp"

namespace touchstone::measures {
namespace {

// Slivers lose as many bits as their sides' ratio has: 64-bit mantissas tell nothing of sides of 1 and 1e-12.
#if defined(__SIZEOF_FLOAT128__)
__extension__ using Wide = __float128;
#else
using Wide = long double;
#endif

constexpr std::size_t kMostTriangles = 56;  // of eight points

struct Wide3 {
  Wide x, y, z;
};

Wide3 minus(const Vector3& p, const Vector3& q) {
  return {static_cast<Wide>(p.x()) - q.x(), static_cast<Wide>(p.y()) - q.y(),
          static_cast<Wide>(p.z()) - q.z()};
}
Wide inner(const Wide3& u, const Wide3& v) { return (u.x * v.x + u.y * v.y) + u.z * v.z; }
Wide3 outer(const Wide3& u, const Wide3& v) {
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

Wide squared_distance_to_edge(const Vector3& a, const Vector3& b, const Vector3& p) {
  const Wide3 d = minus(b, a), q = minus(p, a);
  const Wide length2 = inner(d, d);
  Wide t = length2 > 0 ? inner(q, d) / length2 : 0;
  t = t < 0 ? 0 : (t > 1 ? 1 : t);
  const Wide3 off = {q.x - t * d.x, q.y - t * d.y, q.z - t * d.z};
  return inner(off, off);
}

// ---- bounds in doubles, which tell what need not be measured

double length_bound(const Vector3& v) { return std::abs(v.x()) + std::abs(v.y()) + std::abs(v.z()); }

/// At most the distance of p to the edge; 0 where that is not known.
double least_distance_to_edge(const Vector3& a, const Vector3& b, const Vector3& p) {
  const Vector3 d = b - a, q = p - a;
  const double length2 = dot(d, d);
  // Outside, squares are not what they round to.
  constexpr double kLeastSquare = 0x1p-900, kMostSquare = 0x1p1000, kMostLength = 0x1p500;
  if (!(length2 > kLeastSquare && length2 < kMostSquare)) return 0.0;
  const double distance = norm(q - d * std::clamp(dot(q, d) / length2, 0.0, 1.0));
  if (!(distance < kMostLength)) return 0.0;
  // The foot is off by at most 13 roundings of |q|; with those of the distance fewer than 32 of |q| + |d|.
  return std::max(0.0, distance - 0x1p-46 * (length_bound(q) + length_bound(d)));
}

/// True where p's foot in the plane of normal n = u x v lies outside an edge for sure.
bool is_outside(const Vector3& n, double n_bound, const Vector3& from, const Vector3& to, const Vector3& p) {
  const Vector3 along = to - from, q = p - from;
  // n is off by at most 6 roundings of |u| |v|, the triple product by fewer than 64 of all four lengths.
  const double product = n_bound * length_bound(along) * length_bound(q);
  return product > 0x1p-900 && dot(cross(n, along), q) < -0x1p-45 * product;
}

/// The lesser of `least` and p's squared distance to the triangle. The edges always count; the plane where
/// p's foot lies inside all three.
Wide nearer(const std::array<Vector3, 3>& triangle, const Vector3& p, Wide least) {
  const auto& [a, b, c] = triangle;
  // The plane first: where p lies over the triangle the edges are farther away.
  const Vector3 u = b - a, v = c - a, n = cross(u, v);
  const double n_bound = length_bound(u) * length_bound(v);
  if (!is_outside(n, n_bound, a, b, p) && !is_outside(n, n_bound, b, c, p) &&
      !is_outside(n, n_bound, c, a, p)) {
    const Wide3 normal = outer(minus(b, a), minus(c, a));
    const auto inside = [&](const Vector3& from, const Vector3& to) {
      return inner(outer(normal, minus(to, from)), minus(p, from)) >= 0;
    };
    if (inside(a, b) && inside(b, c) && inside(c, a)) {
      const Wide height = inner(normal, minus(p, a));
      least = std::min(least, height * height / inner(normal, normal));
    }
  }
  // The nearest edge, then those that may be nearer.
  const std::array<double, 3> bounds = {least_distance_to_edge(a, b, p), least_distance_to_edge(b, c, p),
                                        least_distance_to_edge(c, a, p)};
  const auto first =
      static_cast<std::size_t>(std::min_element(bounds.begin(), bounds.end()) - bounds.begin());
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t edge = (first + k) % 3;
    if (static_cast<Wide>(bounds[edge]) * bounds[edge] >= least) continue;
    least = std::min(least, squared_distance_to_edge(triangle[edge], triangle[(edge + 1) % 3], p));
  }
  return least;
}

/// At most the distance of p to the plane of a triangle; 0 where that is not known.
double least_height(const Vector3& normal, double normal_error, const Vector3& corner, const Vector3& p) {
  const Vector3 q = p - corner;
  return std::max(0.0, std::abs(dot(normal, q)) - normal_error * length_bound(q));  // of what is no number: 0
}

}  // namespace

SurfaceMeasure::SurfaceMeasure(const WorldVertices& solid) {
  for (int i = 0; i < 8; ++i) {
    for (int j = i + 1; j < 8; ++j) {
      for (int k = j + 1; k < 8; ++k) {
        bool above = false, below = false;
        for (int l = 0; l < 8 && !(above && below); ++l) {
          if (l == i || l == j || l == k) continue;
          const int sign =
              numerics::orient3d_sign(solid.vertex(i), solid.vertex(j), solid.vertex(k), solid.vertex(l));
          above |= sign > 0;
          below |= sign < 0;
        }
        if (above != below) add_triangle({solid.vertex(i), solid.vertex(j), solid.vertex(k)});
      }
    }
  }
}

void SurfaceMeasure::add_triangle(const std::array<Vector3, 3>& corners) {
  const Vector3 u = corners[1] - corners[0], v = corners[2] - corners[0], n = cross(u, v);
  const double sides = norm(u) * norm(v), length = norm(n);
  // Below, squares are not what they round to.
  constexpr double kLeastLength = 0x1p-450;
  // A component of n is off by at most 7 roundings of the sides' product; with those of the height 20 in all.
  const double error = length > kLeastLength ? 0x1p-48 * sides / length : kInfinity;
  triangles_.push_back({corners, n / length, error});
}

double SurfaceMeasure::distance(const Vector3& p) const {
  if (triangles_.empty()) return kInfinity;
  // The triangle whose plane is nearest first: most of the others' planes are then too far away.
  std::array<double, kMostTriangles> heights;
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    const Triangle& each = triangles_[i];
    heights[i] = least_height(each.normal, each.normal_error, each.corners[0], p);
    if (heights[i] < heights[nearest]) nearest = i;
  }
  Wide least = nearer(triangles_[nearest].corners, p, kInfinity);
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    if (i == nearest || static_cast<Wide>(heights[i]) * heights[i] >= least) continue;
    least = nearer(triangles_[i].corners, p, least);
  }
  return static_cast<double>(std::sqrt(static_cast<long double>(least)));
}

double separation_along(const WorldVertices& a, const WorldVertices& b, const Vector3& n) {
  const Wide3 direction = {n.x(), n.y(), n.z()};
  Wide highest = -kInfinity, lowest = -highest;
  for (int i = 0; i < 8; ++i) {
    highest = std::max(highest, inner(direction, minus(a.vertex(i), Vector3::Zero())));
    lowest = std::min(lowest, inner(direction, minus(b.vertex(i), Vector3::Zero())));
  }
  const auto length = std::sqrt(static_cast<long double>(inner(direction, direction)));
  return static_cast<double>(static_cast<long double>(lowest - highest) / length);
}

}  // namespace touchstone::measures

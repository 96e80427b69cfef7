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

/// The edges always count; the plane where p's foot lies inside all three.
Wide squared_distance(const std::array<Vector3, 3>& triangle, const Vector3& p) {
  const auto& [a, b, c] = triangle;
  Wide least = std::min({squared_distance_to_edge(a, b, p), squared_distance_to_edge(b, c, p),
                         squared_distance_to_edge(c, a, p)});
  const Wide3 normal = outer(minus(b, a), minus(c, a));
  const auto inside = [&](const Vector3& from, const Vector3& to) {
    return inner(outer(normal, minus(to, from)), minus(p, from)) >= 0;
  };
  if (inside(a, b) && inside(b, c) && inside(c, a)) {
    const Wide height = inner(normal, minus(p, a));
    least = std::min(least, height * height / inner(normal, normal));
  }
  return least;
}

/// At most the distance of p to the plane of a triangle; 0 where that is not known.
double least_height(const Vector3& normal, double normal_error, const Vector3& corner, const Vector3& p) {
  const Vector3 q = p - corner;
  const double length = std::abs(q.x()) + std::abs(q.y()) + std::abs(q.z());
  return std::max(0.0, std::abs(dot(normal, q)) - normal_error * length);  // of what is no number: 0
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
  Wide least = squared_distance(triangles_[nearest].corners, p);
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    if (i == nearest || static_cast<Wide>(heights[i]) * heights[i] >= least) continue;
    least = std::min(least, squared_distance(triangles_[i].corners, p));
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

#include "examples/measures/surface_measure.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact_core/numerics/exact_predicates.hpp"

namespace touchstone::comparison {
namespace {

struct Wide {
  long double x, y, z;
};

Wide wide(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
Wide minus(const Wide& u, const Wide& v) { return {u.x - v.x, u.y - v.y, u.z - v.z}; }
Wide along(const Wide& u, const Wide& v, long double t) {
  return {u.x + v.x * t, u.y + v.y * t, u.z + v.z * t};
}
long double inner(const Wide& u, const Wide& v) { return u.x * v.x + u.y * v.y + u.z * v.z; }

// The widest type there is: a sliver's normal loses as many bits as its sides' ratio has.
#if defined(__SIZEOF_FLOAT128__)
__extension__ using Widest = __float128;
#else
using Widest = long double;
#endif

// Squared distance from the origin to the plane through a with the directions u and v.
long double squared_height(const Wide& a, const Wide& u, const Wide& v) {
  const Widest ux = u.x, uy = u.y, uz = u.z, vx = v.x, vy = v.y, vz = v.z;
  const Widest nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
  const Widest height = (nx * a.x + ny * a.y) + nz * a.z;
  return static_cast<long double>(height * height / ((nx * nx + ny * ny) + nz * nz));
}

// Squared distance from the origin to the triangle a, b, c (Ericson, Real-Time Collision Detection, 5.1.5).
long double squared_distance(const Wide& a, const Wide& b, const Wide& c) {
  const Wide ab = minus(b, a), ac = minus(c, a);
  const long double d1 = -inner(ab, a), d2 = -inner(ac, a);
  if (d1 <= 0 && d2 <= 0) return inner(a, a);
  const long double d3 = -inner(ab, b), d4 = -inner(ac, b);
  if (d3 >= 0 && d4 <= d3) return inner(b, b);
  const auto at = [](const Wide& p) { return inner(p, p); };
  const long double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return at(along(a, ab, d1 / (d1 - d3)));
  const long double d5 = -inner(ab, c), d6 = -inner(ac, c);
  if (d6 >= 0 && d5 <= d6) return inner(c, c);
  const long double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return at(along(a, ac, d2 / (d2 - d6)));
  const long double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return at(along(b, minus(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6))));
  }
  return squared_height(a, ab, ac);
}

}  // namespace

SurfaceMeasure::SurfaceMeasure(const WorldVertices& solid)
    : resolution_(0x1p-60 * largest_coordinate(solid)) {
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
        if (above != below) triangles_.push_back({solid.vertex(i), solid.vertex(j), solid.vertex(k)});
      }
    }
  }
}

double SurfaceMeasure::distance(const Vector3& p) const {
  long double least = std::numeric_limits<long double>::infinity();
  const Wide origin = wide(p);
  for (const auto& [a, b, c] : triangles_) {
    least = std::min(
        least, squared_distance(minus(wide(a), origin), minus(wide(b), origin), minus(wide(c), origin)));
  }
  const auto distance = static_cast<double>(std::sqrt(least));
  return distance < resolution_ ? 0.0 : distance;
}

double separation_along(const WorldVertices& a, const WorldVertices& b, const Vector3& n) {
  const Wide direction = wide(n);
  long double highest = -std::numeric_limits<long double>::infinity(), lowest = -highest;
  for (int i = 0; i < 8; ++i) {
    highest = std::max(highest, inner(direction, wide(a.vertex(i))));
    lowest = std::min(lowest, inner(direction, wide(b.vertex(i))));
  }
  return static_cast<double>((lowest - highest) / std::sqrt(inner(direction, direction)));
}

}  // namespace touchstone::comparison

#pragma once

#include <gmpxx.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/vector.hpp"

// Private to this folder: hulls, and polygons less hulls, in integers.

namespace touchstone::cover_proof {

/// Homogeneous: the point is (x, y, z) / w on the grid, w > 0.
struct Point {
  mpz_class x, y, z, w;
};
using Polygon = std::vector<Point>;

/// A plane of a hull's facet: x n.x + y n.y + z n.z + w d is positive outside.
struct FacetPlane {
  mpz_class x, y, z, d;
  Vector3 normal;            ///< the same direction in doubles, largest component about 1
  Vector3 foot;              ///< one of the hull's vertices in it, exactly [m]
  std::vector<int> corners;  ///< hull vertices in it, counter-clockwise from outside
};

/// The hull of eight points.
struct Hull {
  std::vector<FacetPlane> planes;
  std::array<Point, 8> points;
  Vector3 low, high;  ///< [m]
};

/// All doubles on one grid: integers times 2^exponent.
class Grid {
 public:
  void include(const Vector3& p);
  /// With w = 1 for what was included.
  Point on_grid(const Vector3& p) const;
  double to_metres(const mpz_class& numerator, const mpz_class& denominator) const;
  Vector3 to_metres(const Point& p) const;

 private:
  long exponent_ = 0;
  bool is_empty_ = true;
};

/// Empty planes: no volume.
Hull make_hull(const std::array<Vector3, 8>& vertices, const Grid& grid);

/// Sign of where p is: +1 outside of the facet's plane.
int side(const FacetPlane& plane, const Point& p);
/// The same for a point given in doubles: a filter, then integers.
int side(const FacetPlane& plane, const Vector3& p, const Grid& grid);

/// Appends the parts of a polygon in a plane that none of the hulls `others` holds; parts without area are
/// nothing. @return false when stopped by `most_left` parts.
bool subtract(const Polygon& polygon, std::span<const Hull* const> others, std::size_t most_left,
              std::vector<Polygon>& left);

/// Divides convex parts of a facet by the plane of a triangle, those whose inside the triangle meets. A
/// triangle that reaches no point above the facet's plane, or none of the plane, divides nothing.
/// @param triangle with w = 1
void divide(std::vector<Polygon>& parts, const FacetPlane& facet, const std::array<Point, 3>& triangle);

/// A place as reasons print it: "(1, 2, 3)".
std::string text_of(const Vector3& p);

}  // namespace touchstone::cover_proof

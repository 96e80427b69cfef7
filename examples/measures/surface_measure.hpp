#pragma once

#include <array>
#include <vector>

#include "contact_core/geometry/hexahedron.hpp"

// Error measures for many points: 64-bit mantissas where `exact` would use integers. Good to about 2^-60 of
// the largest coordinate, 1/100 of a double's rounding there.

namespace touchstone::comparison {

/// The surface of the convex hull of eight world vertices, as triangles chosen by exact orientation signs.
class SurfaceMeasure {
 public:
  explicit SurfaceMeasure(const WorldVertices& solid);
  /// True when the hull has no volume; distance() may not be used then.
  bool is_flat() const { return triangles_.empty(); }
  /// From p to the surface, from inside too [m]. Below 2^-60 of the largest coordinate it is 0.
  double distance(const Vector3& p) const;

 private:
  std::vector<std::array<Vector3, 3>> triangles_;
  double resolution_;
};

/// h(n) = (min_j n.b_j - max_i n.a_i) / |n| [m].
double separation_along(const WorldVertices& a, const WorldVertices& b, const Vector3& n);

}  // namespace touchstone::comparison

#pragma once

#include <array>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

// Error measures for many points: 113-bit mantissas where `exact` would use integers (64-bit ones where the
// machine has no wider type: then slivers are measured too coarsely).

namespace touchstone::measures {

/// The surface of the convex hull of eight world vertices, as triangles chosen by exact orientation signs.
class SurfaceMeasure {
 public:
  explicit SurfaceMeasure(const WorldVertices& solid);
  /// True when the hull has no volume; distance() is infinite then.
  bool is_flat() const { return triangles_.empty(); }
  /// From p to the surface, from inside too [m].
  double distance(const Vector3& p) const;

 private:
  struct Triangle {
    std::array<Vector3, 3> corners;
    Vector3 normal;  ///< unit, in double precision
    /// Bounds the normal's error, and a height's by it, a unit of length of p - corners[0].
    double normal_error;
  };

  void add_triangle(const std::array<Vector3, 3>& corners);

  std::vector<Triangle> triangles_;
};

/// h(n) = (min_j n.b_j - max_i n.a_i) / |n| [m].
double separation_along(const WorldVertices& a, const WorldVertices& b, const Vector3& n);

}  // namespace touchstone::measures

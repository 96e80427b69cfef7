#pragma once

#include <array>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

// Private to contact_core/fit.

namespace touchstone::fit {

/// A hexahedron while it grows: outward planes of -x, +x, -y, +y, -z, +z, as Hexahedron's faces. Its corners
/// are where three of them meet.
struct SixPlanes {
  std::array<Plane, 6> planes;

  /// Corner i with Hexahedron's bits (x y z).
  std::array<Vector3, 8> corners() const;
  /// Farthest any of the planes is below p [m]; below 0 the point is inside by as much.
  double above(const Vector3& p) const;
  /// Of three unit normals at a corner: corners stay within 10 offsets' errors.
  static constexpr double kLeastDeterminant = 0.2;
  /// Whether the corners are a hexahedron's: each within all six planes, and no two planes nearly parallel at
  /// a corner.
  bool is_hexahedron(double least_determinant = kLeastDeterminant) const;
};

/// The box in `frame` (columns: its axes, orthonormal) that just holds the points.
template <class Points>
SixPlanes enclosing(const std::array<Vector3, 6>& normals, const Points& points) {
  SixPlanes solid;
  for (int f = 0; f < 6; ++f) {
    double reach = -1e300;
    for (const Vector3& p : points) reach = std::max(reach, dot(normals[f], p));
    solid.planes[f] = {normals[f], -reach};
  }
  return solid;
}

using Polygon = std::vector<Vector3>;  ///< convex, in a plane

/// The parts of polygons on the side of a plane that `sign` names; one in the plane is on both.
std::vector<Polygon> parts_of(const std::vector<Polygon>& polygons, const Plane& plane, double sign);

}  // namespace touchstone::fit

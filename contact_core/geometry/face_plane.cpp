#include "touchstone/contact_core/geometry/face_plane.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/norms.hpp"

namespace touchstone {

Plane face_plane(const Corners& corners, int face) {
  const auto& quad = Hexahedron::kFaceVertices[face];
  const Vector3 &a = corners[quad[0]], &b = corners[quad[1]], &c = corners[quad[2]], &d = corners[quad[3]];
  const Vector3 normal = safe_unit(cross(c - a, d - b));
  const Vector3 centroid = 0.25 * ((a + b) + (c + d));
  return {normal, -dot(normal, centroid)};
}

double face_bend(const Corners& corners, int face) {
  const Plane plane = face_plane(corners, face);
  double largest = 0.0;
  for (int i : Hexahedron::kFaceVertices[face])
    largest = std::max(largest, std::abs(plane.signed_distance(corners[i])));
  return largest;
}

double largest_bend(const Corners& corners) {
  double largest = 0.0;
  for (int face = 0; face < 6; ++face) largest = std::max(largest, face_bend(corners, face));
  return largest;
}

}  // namespace touchstone

#pragma once

#include <array>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone::ode {

/// Vertex counts and loops of the six faces, as dConvex reads them.
inline constexpr std::array<unsigned int, 30> kConvexPolygons = [] {
  std::array<unsigned int, 30> polygons{};
  std::size_t next = 0;
  for (const auto& face : Hexahedron::kFaceVertices) {
    polygons[next++] = 4;
    for (const std::uint8_t vertex : face) polygons[next++] = vertex;
  }
  return polygons;
}();

/// The arrays that a dConvex points into: it copies nothing, so this has to outlive the geom. Needs no header
/// of ODE; double is the dReal of the ODE that the adapter accepts.
struct ConvexData {
  Vector3 centre;                 ///< origin of the geom in the solid's frame [m]
  std::array<double, 24> points;  ///< vertices about `centre`
  std::array<double, 24> planes;  ///< n . p = d about `centre`: ODE's offset is the negative of Plane::offset

  explicit ConvexData(const Hexahedron& solid, const Vector3& about = Vector3::Zero()) : centre(about) {
    for (int i = 0; i < Hexahedron::kVertices; ++i)
      for (int k = 0; k < 3; ++k) points[3 * i + k] = solid.vertices()[i][k] - centre[k];
    for (int f = 0; f < 6; ++f) {
      const Plane& plane = solid.face_plane(f);
      for (int k = 0; k < 3; ++k) planes[4 * f + k] = plane.normal[k];
      planes[4 * f + 3] = -plane.signed_distance(centre);
    }
  }
};

/// Mean of the vertices: ODE wants a convex about an inner point.
inline Vector3 mean_vertex(const Hexahedron& solid) {
  Vector3 mean = Vector3::Zero();
  for (const Vector3& vertex : solid.vertices()) mean += vertex / 8.0;
  return mean;
}

}  // namespace touchstone::ode

#pragma once

#include <span>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone::ode_plugin {

/// Where a segment comes nearest to a convex solid.
struct Nearest {
  double distance;     ///< below 0: the penetration depth [m]
  Vector3 n;           ///< unit, from the solid to the segment
  Vector3 on_segment;  ///< the point of the segment
};

/// Of the segment from a to b (a point where they are the same) and the hull of a hexahedron. All axes of
/// the two are tried, so that depths are exact; bent faces count as the planes through them.
/// @param planes {n, d} of the faces that are not collapsed, n . p <= d within
Nearest nearest(const Vector3& a, const Vector3& b, std::span<const Vector3, Hexahedron::kVertices> vertices,
                std::span<const double> planes);

}  // namespace touchstone::ode_plugin

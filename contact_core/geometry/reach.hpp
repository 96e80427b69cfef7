#pragma once

#include <algorithm>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"

namespace touchstone {

/// Largest |coordinate| of the vertices in the solid's frame, and at least its size [m].
inline double reach_of(const Hexahedron& solid) {
  double reach = solid.size();
  for (const Vector3& vertex : solid.vertices()) reach = std::max(reach, norm_inf(vertex));
  return reach;
}

}  // namespace touchstone

#pragma once

#include <algorithm>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone {

/// S of the error measures: max(size of the pair, largest |world coordinate|) [m].
inline double scale_of(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB) {
  WorldVertices va, vb;
  world_vertices(a, X_WA, va);
  world_vertices(b, X_WB, vb);
  return std::max({a.size() + 2.0 * a.radius(), b.size() + 2.0 * b.radius(), largest_coordinate(va),
                   largest_coordinate(vb)});
}

}  // namespace touchstone

#pragma once

#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone {

/// 1 m wide and high, its upper face half as wide.
inline Hexahedron frustum() {
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i) {
    const double w = (i & 1) != 0 ? 0.25 : 0.5;
    v[i] = {(i & 4) != 0 ? w : -w, (i & 2) != 0 ? w : -w, (i & 1) != 0 ? 0.5 : -0.5};
  }
  return Hexahedron::from_vertices(v);
}

}  // namespace touchstone

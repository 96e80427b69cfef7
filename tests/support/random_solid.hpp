#pragma once

#include <array>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/tests/support/random.hpp"

namespace touchstone {

/// A box of 0.4 to 1.4 m, or one whose upper corners are drawn in: a frustum, or a wedge.
/// @param thin of its height.
inline Hexahedron random_solid(Random& random, double thin) {
  const double hx = random.uniform(0.2, 0.7), hy = random.uniform(0.2, 0.7), hz = random.uniform(0.2, 0.7);
  const Vector3 half(hx, hy, hz * thin);
  const double x = random.uniform(0, 1) < 0.5 ? 1.0 : random.uniform(0.2, 1.0);
  const double y = random.uniform(0, 1) < 0.5 ? 1.0 : random.uniform(0.2, 1.0);
  if (x == 1.0 && y == 1.0) return Hexahedron::from_size(2.0 * half);
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i) {
    const bool up = i & 1;
    v[i] = {(i & 4 ? 1 : -1) * half.x() * (up ? x : 1.0), (i & 2 ? 1 : -1) * half.y() * (up ? y : 1.0),
            (up ? 1 : -1) * half.z()};
  }
  return Hexahedron::from_vertices(v, WarpPolicy::accept);
}

}  // namespace touchstone

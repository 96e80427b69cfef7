#pragma once

#include <array>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/examples/measures/common/random.hpp"

// Solids as the families of pairs and of paths draw them.

namespace touchstone::measures {

/// 0.2 to 2 m a side.
Hexahedron random_box(Random& random);
std::array<Vector3, 8> box_vertices(const Vector3& half);
/// 0.125 to 1 m, multiples of 2^-6.
Vector3 dyadic_half(Random& random);
Hexahedron sheared_box(Random& random);
/// A frustum with a rectangular base, its top shrunk and moved sideways.
Hexahedron tapered_box(Random& random);
/// One side (slab) or two sides (needle) 1e-2 to 1e-6 of the others.
Hexahedron thin_box(Random& random);

}  // namespace touchstone::measures

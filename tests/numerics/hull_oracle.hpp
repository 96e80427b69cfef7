#pragma once

#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone::numerics {

/// The same question as hulls_intersect(), as a linear program decided in integers (GMP): are there convex
/// combinations of the two vertex sets that coincide? Whatever the simplex method answers is proved before it
/// is returned: by the combinations themselves, or by a plane with the sets strictly on its two sides.
/// @throws std::logic_error when the proof does not hold.
bool hulls_intersect_by_linear_program(const WorldVertices& a, const WorldVertices& b);

/// Sign of det[b - a, c - a, d - a] in integers.
int orient3d_sign_in_integers(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d);

}  // namespace touchstone::numerics

#pragma once

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/vector.hpp"

/// @file
/// Signs decided exactly, for every finite double input (denormals to 1e308, mixed freely). No heap, no
/// state: any thread may call at any time.

namespace touchstone::numerics {

/// Sign (-1, 0, +1) of det[b - a, c - a, d - a]: +1 when d lies on the side that (b-a) x (c-a) points to.
int orient3d_sign(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) noexcept;

/// True when the convex hulls of the two vertex sets have a point in common (closed sets: touching counts).
/// Any rank is legal: rounding may flatten a hull to a polygon, a segment or a point.
bool hulls_intersect(const WorldVertices& a, const WorldVertices& b) noexcept;

}  // namespace touchstone::numerics

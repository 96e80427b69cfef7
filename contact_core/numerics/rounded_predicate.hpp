#pragma once

#include "touchstone/contact_core/geometry/hexahedron.hpp"

/// @file
/// Decided exactly, for every finite double input. No heap, no state: any thread may call at any time that
/// has 256 kB of stack left, as the integers are there.

namespace touchstone::numerics {

/// True when the hulls' distance is at most radius_a + radius_b, by comparing squares in integers: whether
/// two rounded solids of these cores meet (closed sets: touching counts).
/// Any rank is legal: hulls may be polygons, segments or points.
/// @pre radii finite and >= 0, not both 0.
bool rounded_hulls_intersect(const WorldVertices& a, double radius_a, const WorldVertices& b,
                             double radius_b) noexcept;

}  // namespace touchstone::numerics

#pragma once

#include "touchstone/contact_core/geometry/hexahedron.hpp"

/// @file
/// Decided exactly, for every finite double input (denormals to 1e308, mixed freely). No heap, no
/// state: any thread may call at any time.

namespace touchstone::numerics {

struct ExactPair;

/// True when the convex hulls of the two vertex sets have a point in common (closed sets: touching counts).
/// Any rank is legal: rounding may flatten a hull to a polygon, a segment or a point.
bool hulls_intersect(const WorldVertices& a, const WorldVertices& b) noexcept;
/// The same of a pair whose integers other predicates may have made.
bool hulls_intersect(ExactPair& pair) noexcept;

}  // namespace touchstone::numerics

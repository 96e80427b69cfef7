#pragma once

#include "touchstone/contact_core/geometry/hexahedron.hpp"

// A slow, independent answer for the hulls of two sets of world vertices, in long double: no filters, no hull
// topology, every direction that could matter.

namespace touchstone {

/// Signed distance [m]. Overlap and distance are both the greatest separation over directions: the normals of
/// all vertex triples, crosses of all vertex pairs, all vertex-vertex and vertex-line directions.
long double reference_signed_distance(const WorldVertices& a, const WorldVertices& b);

/// Separation of the projections along n [m].
long double reference_separation_along(const WorldVertices& a, const WorldVertices& b, const Vector3& n);

/// How far p lies outside the hull, > 0, or how deep inside, < 0 [m]. A bound from below outside (plane
/// distance).
long double reference_height(const WorldVertices& hull, const Vector3& p);

}  // namespace touchstone

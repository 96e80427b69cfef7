#pragma once

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/numerics/certified.hpp"

namespace touchstone::native {

using numerics::Certified;

/// Hulls of eight vertices each that nearly are boxes along the world's axes, by comparing coordinates:
/// exact, also for flush faces. Unknown for others, and where the vertices' rounding decides.
///
/// A hull with a vertex in each octant around a box, beyond its corner there in every coordinate, holds the
/// box: along any direction the vertex of the octant that it points to lies beyond all of the box. So hulls
/// meet whose inner boxes do, or of which a vertex lies in the other's inner box; they are apart where their
/// coordinates' intervals do not meet.
Certified certify_aligned(const WorldVertices& a_W, const WorldVertices& b_W);

}  // namespace touchstone::native

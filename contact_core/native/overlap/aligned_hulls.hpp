#pragma once

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/contact_core/numerics/certified.hpp"

namespace touchstone::native {

using numerics::Certified;

/// Hulls of eight vertices each that nearly are boxes along the world's axes, by comparing coordinates:
/// exact, also for flush faces. Unknown for others, and where the vertices' rounding decides.
///
/// A hull with a vertex in each octant around a box, beyond its corner there in every coordinate, holds the
/// box: along any direction the vertex of the octant that it points to lies beyond all of the box. So hulls
/// meet whose inner boxes do, or of which a vertex, or a line between two, goes through the other's inner
/// box; they are apart where their coordinates' intervals do not meet.
Certified certify_aligned(const WorldVertices& a_W, const WorldVertices& b_W);
/// Whether their coordinates' intervals alone show hulls to be apart.
bool are_apart_by_coordinates(const WorldVertices& a_W, const WorldVertices& b_W);

/// Boxes by their half-extents: never unknown where each axis of either is exactly one of the world's. World
/// vertices then are p +- half, rounded once, and the hulls are boxes: comparing their intervals is exact.
/// Quicker than the above, which takes the vertices. Unknown for others. @pre ordinary magnitudes.
Certified certify_aligned_boxes(const Vector3& half_a, const Pose& X_WA, const Vector3& half_b,
                                const Pose& X_WB);

}  // namespace touchstone::native

#pragma once

#include <span>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

/// @file
/// Turns answers about the cores of rounded solids into answers about the solids. Of cores at
/// signed distance d, the solids are at d - (radius_a + radius_b): the difference of the solids is that of
/// the cores grown by a ball, which moves every support plane by its radius. That holds whether the cores are
/// apart, touch, cross or overlap.

namespace touchstone {

/// A solid in the world.
struct RoundedHull {
  const WorldVertices& core_W;
  double radius;  ///< [m]; 0: not rounded
};

/// Moves the geometry of the cores out to the rounded surfaces: separation and witness points; the normal is
/// the cores'. All that is not finite stays.
void grow_by_radii(double radius_a, double radius_b, PairGeometry& geometry);

/// The manifold of a pair whose geometry is known. Of each core take what supports it along the normal: a
/// face within kManifoldCosine of it, else an edge as flat against it, else a vertex. Faces and edges clip
/// each other along n; the corners of that clip, moved out by the radii along n, are the points: exactly on
/// the surfaces where the faces are square to n, and below them by (1 - cosine) of the radius at most where
/// they are tilted. Edges that cross, and vertices, have the witness points alone. Of (b, a) the same points,
/// A and B exchanged, in the same order.
/// @pre 1 <= query.max_points <= kMaxManifoldPoints
/// @param points at least query.max_points. @returns how many were written; at least one.
int find_rounded_points(const RoundedHull& a, const RoundedHull& b, const PairGeometry& geometry,
                        const Query& query, std::span<ContactPoint> points);

/// Least cosine between normals that count as one in manifolds (2.56 degrees): of a core's face and the pair,
/// and of the triangles of a bent face. Bullet's when it makes faces of a hull's triangles
/// (btPolyhedralContactClipping). Six digits on a face bend it by 1e-5, four decimals on one of 0.05 m by
/// 4e-3.
inline constexpr double kManifoldCosine = 0.999;

}  // namespace touchstone

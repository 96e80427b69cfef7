#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone {

/// Bounds of the largest distance of a convex solid's points from a mesh's solid.
struct ExcessBound {
  double least;                     ///< distance of `where` [m]
  double most;                      ///< no point is farther, rounding included [m]
  Vector3 where = Vector3::Zero();  ///< in the mesh's frame
  std::size_t pieces = 0;           ///< tetrahedra looked at
};

/// Bounds the largest distance of a point of the hull of eight vertices (Hexahedron's order, faces may bend)
/// to the solid of the mesh.
///
/// Branch and bound over tetrahedra that fill the hull. The distance to *one* triangle is a convex function,
/// so over a tetrahedron it is largest at a corner: this bounds flat stretches at once, where a Lipschitz
/// bound alone would need ever smaller pieces. Where corners are inside, or near the surface, and the
/// tetrahedron of these corners and of their nearest surface points is inside as a whole, no point is farther
/// than the corners are from theirs.
/// @param box only points in it count; nullptr: all. Tetrahedra that it cuts are looked at as a whole.
/// @param resolution stops when most - least is at most this [m]
/// @param enough if not 0, stops when most is at most this, or least above it [m]: what is asked is then
/// known
/// @param most_pieces stops then, with bounds that hold
/// @param known no point is farther, as is known already [m]: `most` is at most this, and the bound stops
/// once `least` is within the resolution of it, after some hundred pieces that may bound it closer
ExcessBound bound_excess(const MeshDistance& mesh, const std::array<Vector3, 8>& vertices, double resolution,
                         double enough = 0.0, const Bounds* box = nullptr, std::size_t most_pieces = 200000,
                         double known = kInfinity);

/// Returns nothing where no point of the hull is farther than the limit; else the farthest point found, which
/// may be nearer where resolution or pieces ran out. Takes the less time the farther below the limit all
/// points are.
/// @param limit, resolution [m]; > 0
/// @param looked_at the tetrahedra looked at are added to it; nullptr: not counted
std::optional<Vector3> find_beyond(const MeshDistance& mesh, const std::array<Vector3, 8>& vertices,
                                   double limit, double resolution, const Bounds* box = nullptr,
                                   std::size_t most_pieces = 200000, std::uint64_t* looked_at = nullptr);

/// bound_excess() to tell whether a limit is kept: where find_beyond() proves it, `most` is at most the
/// limit, even if bounds of this resolution leave it open.
/// @param limit, resolution [m]; > 0
ExcessBound judge_excess(const MeshDistance& mesh, const std::array<Vector3, 8>& vertices, double limit,
                         double resolution, const Bounds* box = nullptr, std::size_t most_pieces = 200000);

}  // namespace touchstone

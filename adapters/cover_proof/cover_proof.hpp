#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "touchstone/contact_core/fit/triangle_mesh.hpp"
#include "touchstone/contact_core/geometry/vector.hpp"

/// @file
/// Proves that hexahedra cover a mesh, and how far they are outside of it. It shares the plain mesh with
/// contact_core/fit, and no code.

namespace touchstone {

/// The claims about a cover. The mesh's frame; metres.
struct CoverClaim {
  /// A claim of a part of space.
  struct Region {
    std::string name;
    Vector3 low, high;  ///< corners of its box [m]
    double excess;      ///< no point of the cover in it is farther from the solid [m]
  };

  std::vector<std::array<Vector3, 8>> hexahedra;  ///< each the hull of its eight vertices, in any order
  double excess = 0.0;                            ///< no point of the cover is farther from the solid [m]
  std::vector<Region> regions;
};

/// The outcome of a check.
struct CoverVerdict {
  bool is_proven = false;
  std::string reason;                 ///< what failed, one line: the triangle or hexahedron, and a point
  std::size_t in_one_hexahedron = 0;  ///< triangles
  std::size_t cut = 0;                ///< triangles that took several hexahedra
  std::size_t outer_pieces = 0;       ///< of hexahedra's faces, that no other hexahedron covers
  std::size_t tetrahedra = 0;         ///< of the bound on the excess
};

/// Checks three things; all must hold.
///
/// 1. Every triangle is a subset of the union. Exact: triangles are cut by the planes of the hulls' facets,
///    in integers on a common grid; no part may remain outside all hexahedra.
/// 2. So is the inside of every closed shell (see MeshShells). Exact: were a part of it not covered, that
///    part would be bounded by pieces of hexahedra's faces which no other hexahedron covers, since the
///    surface is covered by 1. Each such piece's outer side must have winding number 0. The surface can pass
///    into the outer side of a piece, along a segment where another hexahedron touches it without area: there
///    it is divided, and one ray from one point of each part decides.
/// 3. No point of the union is farther than claimed from the solid. By branch and bound over tetrahedra that
///    fill the hulls, the distance to one triangle being convex; in doubles, 2^-45 of the largest coordinate
///    added against rounding.
///
/// A claim that is true can fail only in 3, by less than that margin, or where a hull takes more than
/// `most_tetrahedra`.
/// @throws InputError: a bad mesh, no hexahedron, a coordinate that is not finite or beyond 1e70, a hull
/// without volume, an excess that is not positive and finite (a region's may be 0), a region's box that is
/// none.
CoverVerdict check_cover(const TriangleMesh& mesh, const CoverClaim& claim,
                         std::size_t most_tetrahedra = 4000000);

}  // namespace touchstone

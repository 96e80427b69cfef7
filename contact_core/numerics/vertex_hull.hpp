#pragma once

#include <array>
#include <cstdint>

#include "touchstone/contact_core/geometry/difference_determinant.hpp"

namespace touchstone::numerics {

/// The convex hull of eight of a DifferenceDeterminant's points, found exactly. Points may coincide, lie on
/// faces or edges or inside, and the hull may be a polygon, a segment or a point.
struct VertexHull {
  using Difference = DifferenceDeterminant::Difference;

  /// Three points that span the facet's plane; the others lie on it or where sign(j - i, k - i, l - i) is
  /// `inner`.
  struct Facet {
    int i, j, k;
    int inner;
    std::uint8_t on_plane;  ///< bit l: point first + l is on the plane
  };
  /// Two different points on the edge's line. `facets` are the two that meet there; -1 when the rank is
  /// below 3.
  struct Edge {
    Difference line;
    std::array<int, 2> facets;
  };

  int first = 0;                 ///< the points are first ... first + 7
  int rank = 0;                  ///< dimension of the hull: 0 to 3
  std::array<Facet, 12> facets;  ///< rank 3: all facets, one per plane
  int facet_count = 0;
  std::array<Edge, 28>
      edges;  ///< rank 3: all edges; 2: all sides of the polygon, some perhaps repeated; 1: the segment
  int edge_count = 0;
  std::array<Difference, 2> span;  ///< rank 1 and 2: differences that span the hull's directions
  int plane_axis = -1;             ///< rank 2: the component of span[0] x span[1] that is not zero
};

/// @param first 0 or 8.
VertexHull make_vertex_hull(DifferenceDeterminant& determinant, int first) noexcept;

}  // namespace touchstone::numerics

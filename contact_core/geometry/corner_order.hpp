#pragma once

#include <array>
#include <cstdint>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/face_plane.hpp"

/// @file
/// Assigns eight points to the corners of a hexahedron. The hull of the points is found exactly. Of the 840
/// cubes as which eight points can be labelled, those count whose edges are all edges of the hull, and of
/// these the one whose faces bend least is taken.

namespace touchstone {

/// order[i]: the point that is vertex i of Hexahedron.
using CornerOrder = std::array<int, Hexahedron::kVertices>;

/// The points in that order.
Corners in_order(const Corners& points, const CornerOrder& order);

/// The edges of eight points' hull. In a flat facet of more than three points every pair of its points counts
/// as an edge, and so do coincident points.
struct HullEdges {
  std::array<std::uint8_t, Hexahedron::kVertices> to{};  ///< bit j of to[i]: an edge joins i and j
  std::uint8_t on_hull = 0;                              ///< bit i: point i is on the hull's surface
  bool coincident = false;                               ///< two points are the same

  bool has(int i, int j) const { return (to[i] >> j & 1) != 0; }
};

/// @pre The points are not all in one plane.
HullEdges hull_edges(const Corners& points);

/// True if the twelve edges and a diagonal of each of the six faces are edges of the hull.
bool fits_hull(const HullEdges& hull, const CornerOrder& order);

/// The cube that bends least among those that fit the hull.
struct FlattestOrder {
  CornerOrder order{};
  double bend = kInfinity;       ///< infinite: none fits
  double next_bend = kInfinity;  ///< of the cube that bends least but for it
};

/// Point 0 becomes vertex 0, or, where the order would be mirrored, vertex 4.
/// @pre No two points coincide.
FlattestOrder flattest_order(const Corners& points, const HullEdges& hull);

}  // namespace touchstone

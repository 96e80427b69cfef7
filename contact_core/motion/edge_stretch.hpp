#pragma once

#include <array>

#include "touchstone/contact_core/motion/clear_stretch.hpp"

// How far two moving solids that touch at edges go on before they could come nearer than a threshold, by the
// plane that the two edges span.

namespace touchstone {

/// An edge of a solid that is its extreme along a direction.
struct ExtremeEdge {
  unsigned vertices = 0;            ///< the bits of its two; 0: no edge is the extreme
  Vector3 along = Vector3::Zero();  ///< from the one of the lower number to the other
};

/// The edge that is a solid's extreme along n, to `tolerance`. None if a vertex or a face is.
ExtremeEdge extreme_edge(const PlacedSolid& placed, const Vector3& n, double tolerance);

/// All edges that are extreme: one, or a face's.
struct ExtremeEdges {
  int count = 0;
  std::array<ExtremeEdge, 4> edge;
};
ExtremeEdges extreme_edges(const PlacedSolid& placed, const Vector3& n, double tolerance);

/// Two edges, and the points at which their lines are closest.
struct EdgePair {
  ExtremeEdge of_a, of_b;
  Vector3 p, q;
};
/// Sets p and q. False: the edges are nearly parallel.
bool cross_lines(const PlacedSolid& a, const PlacedSolid& b, EdgePair& edges);

/// How far the plane that two edges in contact span keeps the bodies apart, however unevenly they turn; at
/// most `longest`.
/// @param tolerance to which other vertices lie behind the edges [m].
Stretch edge_stretch(const PlacedSolid& a, const PlacedSolid& b, const EdgePair& pair, const Vector3& n_AB_W,
                     double tolerance, double threshold, double longest);

}  // namespace touchstone

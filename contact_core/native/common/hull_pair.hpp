#pragma once

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"

// Two hulls of eight vertices each, and their projections on an axis.

namespace touchstone::native {

/// u: the largest relative error of one rounding.
inline constexpr double kRoundoff = 0x1p-53;

/// The solid's local vertices, laid out for world_vertices() below.
WorldVertices in_columns(const Hexahedron& solid);
/// The same bits as touchstone::world_vertices() of the solid.
void world_vertices(const WorldVertices& vertices_S, const Pose& X_WS, WorldVertices& out);

/// The vertices of both solids about a common origin (see shift_to_common_origin).
struct HullPair {
  WorldVertices a;
  WorldVertices b;
  /// At least every |coordinate| of a and b.
  double extent;
};

/// Subtracts A's vertex 0 from all vertices: each coordinate then is within u * extent of the exact
/// difference, however far from the world's origin the pair is.
void shift_to_common_origin(const WorldVertices& a_W, const WorldVertices& b_W, HullPair& pair);

/// Least and greatest axis . vertex.
struct Interval {
  double low;
  double high;
};
Interval project(const WorldVertices& vertices, const Vector3& axis);

/// Index of the vertex with the greatest (least) axis . vertex, the lowest on ties, and that value.
struct Support {
  int index;
  double value;
};
Support support_high(const WorldVertices& vertices, const Vector3& axis);
Support support_low(const WorldVertices& vertices, const Vector3& axis);

/// Bound on the error of (low of B) - (high of A) along `axis`, against the exact hulls of the world
/// vertices: the shift is off by u * extent a coordinate, the dot product by 3 u * sum |axis_k| |v_k| (three
/// roundings a term, second order included in the fourth), twice, and the difference by u * 2 * extent: at
/// most 10 u * |axis|_1 * extent, and 2 for second order.
inline double projection_error(const Vector3& axis, double extent) {
  return 12 * kRoundoff * extent * norm_1(axis);
}

/// The gap between the projections of A and B on n (unit, A to B); negative when they overlap.
inline double separation_along(const HullPair& pair, const Vector3& n) {
  return support_low(pair.b, n).value - support_high(pair.a, n).value;
}

}  // namespace touchstone::native

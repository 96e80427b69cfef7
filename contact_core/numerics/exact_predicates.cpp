#include "touchstone/contact_core/numerics/exact_predicates.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

#include "touchstone/contact_core/geometry/difference_determinant.hpp"
#include "touchstone/contact_core/numerics/exact_pair.hpp"
#include "touchstone/contact_core/numerics/flat_hulls.hpp"
#include "touchstone/contact_core/numerics/projection_filter.hpp"
#include "touchstone/contact_core/numerics/vertex_hull.hpp"

namespace touchstone::numerics {
namespace {

using Difference = VertexHull::Difference;
using Direction = ProjectionFilter::Direction;
using Projections = ProjectionFilter::Projections;

constexpr int kFirstOfB = ExactPair::kFirstOfB;

// The sides of u x v on which B may be sought.
enum Sides : unsigned { kAlong = 1, kAgainst = 2, kBoth = 3 };

/// The data of one pair that every step needs.
struct Pair {
  DifferenceDeterminant& determinant;
  ProjectionFilter filter;

  explicit Pair(ExactPair& exact) : determinant(exact.determinant), filter(exact.points) {}
};

/// Intervals that do not meet on a coordinate axis: comparisons of doubles are exact.
bool apart_on_an_axis(const WorldVertices& a, const WorldVertices& b) {
  const auto apart = [](const std::array<double, 8>& p, const std::array<double, 8>& q) {
    const auto [p_low, p_high] = std::minmax_element(p.begin(), p.end());
    const auto [q_low, q_high] = std::minmax_element(q.begin(), q.end());
    return *p_high < *q_low || *q_high < *p_low;
  };
  return apart(a.x, b.x) || apart(a.y, b.y) || apart(a.z, b.z);
}

bool share_a_vertex(const WorldVertices& a, const WorldVertices& b) {
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j)
      if (a.x[i] == b.x[j] && a.y[i] == b.y[j] && a.z[i] == b.z[j]) return true;
  return false;
}

/// True if every b_j - a_i is strictly on the `side` (+1 or -1) of u x v: exact arithmetic for what the
/// projections leave open, least difference first.
bool separates_exactly(DirectionSigns& signs, const Projections& projections, int side) {
  std::array<double, 16> along;
  for (int i = 0; i < 16; ++i) along[i] = side * projections.along[i];
  const auto highest_a = std::max_element(along.begin(), along.begin() + kFirstOfB) - along.begin();
  const auto lowest_b = std::min_element(along.begin() + kFirstOfB, along.end()) - along.begin();
  if (signs.sign({static_cast<int>(highest_a), static_cast<int>(lowest_b)}) != side) return false;
  for (int i = 0; i < kFirstOfB; ++i) {
    for (int j = kFirstOfB; j < 16; ++j) {
      if (along[j] - along[i] > projections.error) continue;
      if (signs.sign({i, j}) != side) return false;
    }
  }
  return true;
}

bool separates(Pair& pair, Difference u, Difference v, const Direction& direction, unsigned sides) {
  const Projections p = pair.filter.project(direction);
  const double along = p.low_b - p.high_a, against = p.low_a - p.high_b;
  if (along > p.error || against > p.error) return true;
  const bool may_along = (sides & kAlong) != 0 && along >= -p.error;
  const bool may_against = (sides & kAgainst) != 0 && against >= -p.error;
  if (!may_along && !may_against) return false;
  DirectionSigns signs(pair.determinant, u, v);
  return (may_along && separates_exactly(signs, p, 1)) || (may_against && separates_exactly(signs, p, -1));
}

using FacetDirections = std::array<Direction, 12>;

/// A facet of A (rank 3), B beyond it; or the plane of A (rank 2), B on either side; and the same with A and
/// B exchanged.
bool facet_separates(Pair& pair, const VertexHull& hull, FacetDirections& directions) {
  if (hull.rank == 2) {
    const auto [u, v] = hull.span;
    return separates(pair, u, v, pair.filter.direction(u, v), kBoth);
  }
  for (int f = 0; f < hull.facet_count; ++f) {
    const VertexHull::Facet& facet = hull.facets[f];
    const Difference u{facet.i, facet.j}, v{facet.i, facet.k};
    directions[f] = pair.filter.direction(u, v);
    const bool b_beyond_is_along = (facet.inner < 0) == (hull.first == 0);
    if (separates(pair, u, v, directions[f], b_beyond_is_along ? kAlong : kAgainst)) return true;
  }
  return false;
}

/// True if the point is in the solid hull: beyond no facet.
bool contains(Pair& pair, const VertexHull& hull, int point) {
  for (int f = 0; f < hull.facet_count; ++f) {
    const VertexHull::Facet& facet = hull.facets[f];
    const int side = pair.determinant.sign({facet.i, facet.j}, {facet.i, facet.k}, {facet.i, point});
    if (side == -facet.inner) return false;
  }
  return true;
}

bool contains_a_vertex(Pair& pair, const VertexHull& hull, const VertexHull& of) {
  if (hull.rank < 3) return false;
  for (int p = of.first; p < of.first + 8; ++p)
    if (contains(pair, hull, p)) return true;
  return false;
}

/// Facets of a hull, as bits: those whose outward normal certainly has a positive (negative) product with a
/// line.
struct FacetSigns {
  std::uint16_t positive = 0, negative = 0;
};

FacetSigns facet_signs(const Pair& pair, const VertexHull& hull, const FacetDirections& directions,
                       Difference line) {
  FacetSigns out;
  for (int f = 0; f < hull.facet_count; ++f) {
    const int sign = -hull.facets[f].inner * pair.filter.certain_sign(directions[f], line);
    if (sign > 0) out.positive |= static_cast<std::uint16_t>(1 << f);
    if (sign < 0) out.negative |= static_cast<std::uint16_t>(1 << f);
  }
  return out;
}

/// False if the outward normals at `edge` certainly lie on one side of the plane across the other hull's
/// line: then none of the directions between them (those in which the edge is extreme) is perpendicular to
/// that line.
bool may_be_perpendicular(const VertexHull::Edge& edge, const FacetSigns& line) {
  if (edge.facets[0] < 0) return true;
  const int both = 1 << edge.facets[0] | 1 << edge.facets[1];
  return (line.positive & both) != both && (line.negative & both) != both;
}

bool edge_pair_separates(Pair& pair, const VertexHull& a, const FacetDirections& directions_a,
                         const VertexHull& b, const FacetDirections& directions_b) {
  std::array<FacetSigns, 28> signs_of_b_for_edge_of_a;
  for (int i = 0; i < a.edge_count; ++i)
    signs_of_b_for_edge_of_a[i] = facet_signs(pair, b, directions_b, a.edges[i].line);
  for (int j = 0; j < b.edge_count; ++j) {
    const VertexHull::Edge& edge_b = b.edges[j];
    const FacetSigns signs_of_a = facet_signs(pair, a, directions_a, edge_b.line);
    for (int i = 0; i < a.edge_count; ++i) {
      const VertexHull::Edge& edge_a = a.edges[i];
      if (!may_be_perpendicular(edge_a, signs_of_a) ||
          !may_be_perpendicular(edge_b, signs_of_b_for_edge_of_a[i]))
        continue;
      const Direction direction = pair.filter.direction(edge_a.line, edge_b.line);
      if (separates(pair, edge_a.line, edge_b.line, direction, kBoth)) return true;
    }
  }
  return false;
}

}  // namespace

// Complete: two compact convex sets without a common point have the origin outside their Minkowski difference
// D = {b - a}. When D has volume, the origin is strictly beyond some facet of D, that is, all b_j - a_i are
// strictly on one side along the facet's outward normal -n (so B is beyond A along n). The facet is the sum
// of the faces of B and -A extreme along n, two-dimensional, so
//  * A's face has dimension 2: n is an outward normal of a facet of A (rank 3) or normal to A's plane (rank
//    2), or
//  * B's face has dimension 2: likewise, or
//  * neither has, and each has dimension 1: they are edges (rank 3), sides (rank 2) or the segment itself
//    (rank 1) with independent directions, and n is along their cross product. At an edge of rank 3, n is a
//    non-negative combination of the two facets' outward normals and perpendicular to the other edge.
// All of these are tried. When D has no volume, flat_hulls_intersect() decides. Common vertices and vertices
// inside the other hull only end the search early.
bool hulls_intersect(ExactPair& exact) noexcept {
  if (apart_on_an_axis(exact.a, exact.b)) return false;
  if (share_a_vertex(exact.a, exact.b)) return true;
  Pair pair(exact);
  const VertexHull hull_a = make_vertex_hull(pair.determinant, 0);
  const VertexHull hull_b = make_vertex_hull(pair.determinant, kFirstOfB);
  if (span_no_volume(pair.determinant, hull_a, hull_b))
    return flat_hulls_intersect(pair.determinant, hull_a, hull_b);

  FacetDirections directions_a, directions_b;
  if (facet_separates(pair, hull_a, directions_a) || facet_separates(pair, hull_b, directions_b))
    return false;
  if (contains_a_vertex(pair, hull_a, hull_b) || contains_a_vertex(pair, hull_b, hull_a)) return true;
  return !edge_pair_separates(pair, hull_a, directions_a, hull_b, directions_b);
}

bool hulls_intersect(const WorldVertices& a, const WorldVertices& b) noexcept {
  ExactPair pair(a, b);
  return hulls_intersect(pair);
}

}  // namespace touchstone::numerics

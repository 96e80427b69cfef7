#include "contact_core/numerics/exact_predicates.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "contact_core/numerics/difference_determinant.hpp"

namespace touchstone::numerics {
namespace {

using Difference = DifferenceDeterminant::Difference;

// Points 0-7 are A's, 8-15 B's.
constexpr int kFirstOfB = 8;

// A plane through three vertices of one hull, all of whose vertices lie on it or on its inner side.
struct Facet {
  int i, j, k;        // as points of the determinant
  unsigned vertices;  // of the hull, by bit, that lie on the plane
  int inner_side;     // sign of det [j - i, k - i, inner vertex - i]; 0 for a hull without volume
};

// All facets' planes and all edges of a hull. For a hull without volume: every triple and every pair of
// vertices, as every supporting plane may hold all of them.
struct HullFeatures {
  std::array<Facet, 56> facets;
  int facet_count = 0;
  std::array<Difference, 28> edges;
  int edge_count = 0;
  bool has_volume = false;
};

HullFeatures all_triples_and_pairs(int first) {
  HullFeatures hull;
  for (int i = first; i < first + 8; ++i) {
    for (int j = i + 1; j < first + 8; ++j) {
      hull.edges[hull.edge_count++] = {i, j};
      for (int k = j + 1; k < first + 8; ++k) hull.facets[hull.facet_count++] = {i, j, k, 0, 0};
    }
  }
  return hull;
}

// A pair of vertices in two facets' planes is an edge (or part of one).
void find_edges(HullFeatures& hull, int first) {
  for (int i = 0; i < 8; ++i) {
    for (int j = i + 1; j < 8; ++j) {
      const unsigned both = 1u << i | 1u << j;
      int planes = 0;
      for (int f = 0; f < hull.facet_count; ++f) planes += (hull.facets[f].vertices & both) == both;
      if (planes >= 2) hull.edges[hull.edge_count++] = {first + i, first + j};
    }
  }
}

// A hull whose boundary is the six quads of Hexahedron, each plane or folded along a diagonal; false for any
// other. Every facet taken has all other vertices strictly inside its plane, so it is a facet of the hull.
// Each cube edge lies in two such planes, hence on the boundary of both facets; so the facets' polygons are
// bounded by cube edges and folds alone, each shared by two facets taken. As facets of a polytope are
// connected across edges, there are no others.
bool quad_features(DifferenceDeterminant& determinant, int first, HullFeatures& hull) {
  const auto add_facet = [&](int i, int j, int k, unsigned on_plane) {
    const Facet facet{first + i, first + j, first + k, on_plane, -1};
    hull.facets[hull.facet_count++] = facet;
    const unsigned others = 0xffu & ~on_plane;
    return determinant.sides({facet.i, facet.j}, {facet.i, facet.k}, facet.i, first, others).below == others;
  };
  for (const auto& q : Hexahedron::kFaceVertices) {
    const unsigned all = 1u << q[0] | 1u << q[1] | 1u << q[2] | 1u << q[3];
    const int fold = determinant.sign({first + q[0], first + q[1]}, {first + q[0], first + q[2]},
                                      {first + q[0], first + q[3]});
    if (fold == 0) {
      if (!add_facet(q[0], q[1], q[2], all)) return false;
      continue;
    }
    const int s = fold > 0 ? 1 : 0;  // the fold runs from q[s] to q[s + 2]
    const int i = q[s], j = q[s + 1], k = q[s + 2], l = q[(s + 3) % 4];
    if (!add_facet(i, j, k, all & ~(1u << l)) || !add_facet(i, k, l, all & ~(1u << j))) return false;
    hull.edges[hull.edge_count++] = {first + i, first + k};
  }
  for (const auto& edge : Hexahedron::kEdgeVertices)
    hull.edges[hull.edge_count++] = {first + edge[0], first + edge[1]};
  hull.has_volume = true;
  return true;
}

HullFeatures general_features(DifferenceDeterminant& determinant, int first) {
  HullFeatures hull;
  std::array<unsigned, 56> known_planes;  // vertices of planes met before, supporting or not
  int known_count = 0;
  for (int i = 0; i < 8; ++i) {
    for (int j = i + 1; j < 8; ++j) {
      for (int k = j + 1; k < 8; ++k) {
        const unsigned triple = 1u << i | 1u << j | 1u << k;
        if (std::any_of(known_planes.begin(), known_planes.begin() + known_count,
                        [&](unsigned plane) { return (plane & triple) == triple; }))
          continue;
        unsigned on_plane = triple;
        bool above = false, below = false;
        const Difference u{first + i, first + j}, v{first + i, first + k};
        for (int l = 0; l < 8 && !(above && below); ++l) {
          if (triple >> l & 1u) continue;
          const int side = determinant.sign(u, v, {first + i, first + l});
          above = above || side > 0;
          below = below || side < 0;
          if (side == 0) on_plane |= 1u << l;
        }
        hull.has_volume = hull.has_volume || above || below;
        if (above == below)
          continue;  // cut by its plane; or no side at all: collinear, or a hull without volume
        known_planes[known_count++] = on_plane;
        hull.facets[hull.facet_count++] = {first + i, first + j, first + k, on_plane, above ? 1 : -1};
      }
    }
  }
  if (!hull.has_volume) return all_triples_and_pairs(first);
  find_edges(hull, first);
  return hull;
}

HullFeatures hull_features(DifferenceDeterminant& determinant, int first) {
  HullFeatures hull;
  if (quad_features(determinant, first, hull)) return hull;
  return general_features(determinant, first);
}

// Projections of the 16 points on directions u x v, in doubles about a reference point, with an error bound.
class Projector {
 public:
  explicit Projector(const DifferenceDeterminant& determinant) : determinant_(determinant) {
    for (int i = 0; i < 16; ++i) {
      offset_[i] = determinant.scaled(i) - determinant.scaled(0);
      extent_ = extent_.cwiseMax(offset_[i].cwiseAbs());
    }
  }

  struct Gap {
    double low_b_minus_high_a;
    double low_a_minus_high_b;
    double error;
  };

  // A projection is the determinant [u v offset] with the offset's own rounding: b - a computed as (b - r) -
  // (a - r) has an error of at most 3 u of the two offsets' magnitudes instead of u of their difference. 4 *
  // determinant_error of the largest permanent covers it (each of two projections: 8 roundings as in the
  // determinant's filter, plus the last subtraction).
  Gap gap(Difference u, Difference v) const {
    const Vector3 a = determinant_.scaled(u.q) - determinant_.scaled(u.p);
    const Vector3 b = determinant_.scaled(v.q) - determinant_.scaled(v.p);
    const Vector3 n = cross(a, b);
    const Vector3 magnitude(std::abs(a.y() * b.z()) + std::abs(a.z() * b.y()),
                            std::abs(a.z() * b.x()) + std::abs(a.x() * b.z()),
                            std::abs(a.x() * b.y()) + std::abs(a.y() * b.x()));
    double low_a = dot(n, offset_[0]), high_a = low_a;
    for (int i = 1; i < kFirstOfB; ++i) {
      const double s = dot(n, offset_[i]);
      low_a = std::min(low_a, s), high_a = std::max(high_a, s);
    }
    double low_b = dot(n, offset_[kFirstOfB]), high_b = low_b;
    for (int i = kFirstOfB + 1; i < 16; ++i) {
      const double s = dot(n, offset_[i]);
      low_b = std::min(low_b, s), high_b = std::max(high_b, s);
    }
    return {low_b - high_a, low_a - high_b, 4.0 * determinant_error(dot(magnitude, extent_))};
  }

  // The pairs (a_i, b_j) whose projected difference may be the least along n (or -n), nearest first, are few;
  // all others are certified by the gap's error.
  double projection(Difference u, Difference v, int i) const {
    return dot(cross(determinant_.scaled(u.q) - determinant_.scaled(u.p),
                     determinant_.scaled(v.q) - determinant_.scaled(v.p)),
               offset_[i]);
  }

 private:
  const DifferenceDeterminant& determinant_;
  std::array<Vector3, 16> offset_;
  Vector3 extent_ = Vector3::Zero();
};

// True if every b_j - a_i is strictly on the `side` (+1 or -1) of u x v, exactly.
bool separates_exactly(DifferenceDeterminant& determinant, const Projector& projector, Difference u,
                       Difference v, int side, double error) {
  std::array<double, 16> along;
  for (int i = 0; i < 16; ++i) along[i] = side * projector.projection(u, v, i);
  const double high_a = *std::max_element(along.begin(), along.begin() + kFirstOfB);
  const double low_b = *std::min_element(along.begin() + kFirstOfB, along.end());
  for (int i = 0; i < kFirstOfB; ++i) {
    if (along[i] < high_a - 2.0 * error) continue;
    for (int j = kFirstOfB; j < 16; ++j) {
      if (along[j] > low_b + 2.0 * error || along[j] - along[i] > error) continue;
      if (determinant.sign(u, v, {i, j}) != side) return false;
    }
  }
  return true;
}

enum class Axis { separating, not_separating };

Axis test_axis(DifferenceDeterminant& determinant, const Projector& projector, Difference u, Difference v) {
  const Projector::Gap gap = projector.gap(u, v);
  if (gap.low_b_minus_high_a > gap.error || gap.low_a_minus_high_b > gap.error) return Axis::separating;
  for (int side : {1, -1}) {
    const double value = side > 0 ? gap.low_b_minus_high_a : gap.low_a_minus_high_b;
    if (value < -gap.error) continue;
    if (separates_exactly(determinant, projector, u, v, side, gap.error)) return Axis::separating;
  }
  return Axis::not_separating;
}

// True if point p is in the solid hull: on the inner side of, or on, every facet's plane.
bool contains(DifferenceDeterminant& determinant, const HullFeatures& hull, int p) {
  for (int f = 0; f < hull.facet_count; ++f) {
    const Facet& facet = hull.facets[f];
    const int side = determinant.sign({facet.i, facet.j}, {facet.i, facet.k}, {facet.i, p});
    if (side != 0 && side != facet.inner_side) return false;
  }
  return true;
}

// Where the vertices of one hull lie against the facets of the other.
struct SideTable {
  std::array<unsigned, 56> outside;  // by facet: vertices strictly beyond its plane
  std::array<unsigned, 56> inside;
  unsigned outside_any = 0;
  bool separated = false;  // by some facet's plane
};

void fill(DifferenceDeterminant& determinant, const HullFeatures& hull, int first, SideTable& table) {
  for (int f = 0; f < hull.facet_count; ++f) {
    const Facet& facet = hull.facets[f];
    const auto sides = determinant.sides({facet.i, facet.j}, {facet.i, facet.k}, facet.i, first, 0xffu);
    table.outside[f] = facet.inner_side > 0 ? sides.below : sides.above;
    table.inside[f] = facet.inner_side > 0 ? sides.above : sides.below;
    table.outside_any |= table.outside[f];
    table.separated = table.outside[f] == 0xffu;
    if (table.separated) return;
  }
}

// True if the line through the edge, which crosses the facet's plane, meets triangle i, j, k of its vertices:
// it passes all three sides on one hand. A collinear triple counts as no triangle: the facet's others cover
// it.
bool pierces_triangle(DifferenceDeterminant& determinant, Difference edge, int i, int j, int k) {
  bool left = false, right = false;
  for (const Difference side : {Difference{i, j}, Difference{j, k}, Difference{k, i}}) {
    const int s = determinant.sign(edge, {edge.p, side.p}, {edge.p, side.q});
    left = left || s > 0;
    right = right || s < 0;
    if (left && right) return false;
  }
  return left || right;
}

bool pierces(DifferenceDeterminant& determinant, Difference edge, const Facet& facet) {
  const int first = facet.i < kFirstOfB ? 0 : kFirstOfB;
  for (int i = 0; i < 8; ++i) {
    if (!(facet.vertices >> i & 1u)) continue;
    for (int j = i + 1; j < 8; ++j) {
      if (!(facet.vertices >> j & 1u)) continue;
      for (int k = j + 1; k < 8; ++k)
        if (facet.vertices >> k & 1u && pierces_triangle(determinant, edge, first + i, first + j, first + k))
          return true;
    }
  }
  return false;
}

// Edges of `other` (whose vertices the table places) against the facets of `hull`.
bool some_edge_pierces(DifferenceDeterminant& determinant, const HullFeatures& other,
                       const HullFeatures& hull, const SideTable& table) {
  for (int e = 0; e < other.edge_count; ++e) {
    const Difference edge = other.edges[e];
    const unsigned p = 1u << edge.p % 8, q = 1u << edge.q % 8, both = p | q;
    bool beyond = false;
    for (int f = 0; f < hull.facet_count && !beyond; ++f) beyond = (table.outside[f] & both) == both;
    for (int f = 0; f < hull.facet_count && !beyond; ++f) {
      const unsigned out = table.outside[f] & both;
      const bool crosses = (out == p && (table.inside[f] & q)) || (out == q && (table.inside[f] & p));
      if (crosses && pierces(determinant, edge, hull.facets[f])) return true;
    }
  }
  return false;
}

// Complete: if A and B meet, their intersection has an extreme point x, and {x} is the meeting of the affine
// hulls of a face F of A and a face G of B that have x in their relative interiors. So F and G are a vertex
// and anything; an edge and a facet, which it crosses from strictly one side to the other; or two edges that
// cross: then one of the two facets of B at G is not parallel to F, and F crosses its plane at x.
bool solid_hulls_intersect(DifferenceDeterminant& determinant, const HullFeatures& hull_a,
                           const HullFeatures& hull_b) {
  SideTable b_against_a, a_against_b;
  fill(determinant, hull_a, kFirstOfB, b_against_a);
  if (b_against_a.separated) return false;
  if (b_against_a.outside_any != 0xffu) return true;
  fill(determinant, hull_b, 0, a_against_b);
  if (a_against_b.separated) return false;
  if (a_against_b.outside_any != 0xffu) return true;
  return some_edge_pierces(determinant, hull_b, hull_a, b_against_a) ||
         some_edge_pierces(determinant, hull_a, hull_b, a_against_b);
}

// Where the Minkowski difference {b_j - a_i} itself has no volume, A and B lie in two parallel planes (or
// lines, or points).

// Differences that span the directions of both hulls.
std::array<Difference, 14> spanning_differences() {
  std::array<Difference, 14> spanning;
  for (int i = 0; i < 7; ++i) {
    spanning[i] = {0, i + 1};
    spanning[7 + i] = {kFirstOfB, kFirstOfB + i + 1};
  }
  return spanning;
}

bool spans_volume(DifferenceDeterminant& determinant) {
  const auto spanning = spanning_differences();
  for (std::size_t i = 0; i < spanning.size(); ++i)
    for (std::size_t j = i + 1; j < spanning.size(); ++j)
      for (std::size_t k = j + 1; k < spanning.size(); ++k)
        if (determinant.sign(spanning[i], spanning[j], spanning[k]) != 0) return true;
  return false;
}

// Both hulls are in one plane u x v, projected along `axis`, which is injective on it: separated iff some
// difference of two vertices of one hull has all b_j - a_i strictly on one side (the facets of a polygon are
// its edges).
bool polygons_intersect(DifferenceDeterminant& determinant, int axis) {
  const auto separates = [&](Difference u) {
    int side = 0;
    for (int i = 0; i < kFirstOfB; ++i) {
      for (int j = kFirstOfB; j < 16; ++j) {
        const int s = determinant.cross_sign(u, {i, j}, axis);
        if (s == 0 || s == -side) return false;
        side = s;
      }
    }
    return true;
  };
  for (int first : {0, kFirstOfB})
    for (int p = first; p < first + 8; ++p)
      for (int q = p + 1; q < first + 8; ++q)
        if (!determinant.is_zero({p, q}) && separates({p, q})) return false;
  return true;
}

// Both hulls are on one line that is injective along `axis`: intervals.
bool segments_intersect(DifferenceDeterminant& determinant, int axis) {
  bool some_b_not_below = false, some_b_not_above = false;
  for (int i = 0; i < kFirstOfB; ++i) {
    for (int j = kFirstOfB; j < 16; ++j) {
      const int s = determinant.component_sign({i, j}, axis);
      some_b_not_below = some_b_not_below || s >= 0;
      some_b_not_above = some_b_not_above || s <= 0;
    }
  }
  return some_b_not_below && some_b_not_above;
}

bool flat_hulls_intersect(DifferenceDeterminant& determinant) {
  const auto spanning = spanning_differences();
  const Difference b_minus_a{0, kFirstOfB};
  for (std::size_t i = 0; i < spanning.size(); ++i) {
    for (std::size_t j = i + 1; j < spanning.size(); ++j) {
      for (int axis = 0; axis < 3; ++axis) {
        if (determinant.cross_sign(spanning[i], spanning[j], axis) == 0) continue;
        if (determinant.sign(spanning[i], spanning[j], b_minus_a) != 0)
          return false;  // different parallel planes
        return polygons_intersect(determinant, axis);
      }
    }
  }
  for (const Difference& u : spanning) {
    for (int axis = 0; axis < 3; ++axis) {
      if (determinant.component_sign(u, axis) == 0) continue;
      for (int k = 0; k < 3; ++k)
        if (determinant.cross_sign(u, b_minus_a, k) != 0) return false;  // different parallel lines
      return segments_intersect(determinant, axis);
    }
  }
  return determinant.is_zero(b_minus_a);
}

// True if q - p has no rounding error (the error term of Knuth's two-difference is zero). Overflow makes it
// false.
bool is_exact_difference(const Vector3& q, const Vector3& p, const Vector3& difference) {
  for (int axis = 0; axis < 3; ++axis) {
    const double p_virtual = q(axis) - difference(axis);
    const double q_virtual = difference(axis) + p_virtual;
    if (p_virtual != p(axis) || q_virtual != q(axis)) return false;
  }
  return true;
}

bool are_exactly_equal_or_opposite(const DifferenceDeterminant& determinant, Difference u, Difference v) {
  const Vector3 a = determinant.point(u.q) - determinant.point(u.p);
  const Vector3 b = determinant.point(v.q) - determinant.point(v.p);
  if (a != b && a != Vector3(-b)) return false;
  return is_exact_difference(determinant.point(u.q), determinant.point(u.p), a) &&
         is_exact_difference(determinant.point(v.q), determinant.point(v.p), b);
}

void drop_repeated_directions(const DifferenceDeterminant& determinant, HullFeatures& hull) {
  int kept = 0;
  for (int e = 0; e < hull.edge_count; ++e) {
    if (determinant.is_zero(hull.edges[e])) continue;
    bool repeated = false;
    for (int k = 0; k < kept && !repeated; ++k)
      repeated = are_exactly_equal_or_opposite(determinant, hull.edges[k], hull.edges[e]);
    if (!repeated) hull.edges[kept++] = hull.edges[e];
  }
  hull.edge_count = kept;
}

}  // namespace

int orient3d_sign(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  const std::array points = {a, b, c, d};
  return DifferenceDeterminant(points).sign({0, 1}, {0, 2}, {0, 3});
}

// Of two hulls with volume: solid_hulls_intersect(). Otherwise by axes.
// Complete: two compact convex sets without a common point have 0 outside their Minkowski difference D = {b -
// a}. When D has volume, 0 is then strictly beyond some facet of D. That facet is the sum of the faces of B
// and -A extreme along its normal n, so its two-dimensional directions come from two vertex differences u, v
// within those two faces: n is parallel to u x v with u, v both from a facet of A, both from a facet of B, or
// one from an edge of each. All of these are tried. When D has no volume, A and B lie in parallel planes,
// lines or points: flat_hulls_intersect().
bool hulls_intersect(const WorldVertices& a, const WorldVertices& b) {
  std::array<Vector3, 16> points;
  for (int i = 0; i < 8; ++i) points[i] = a.vertex(i), points[kFirstOfB + i] = b.vertex(i);
  DifferenceDeterminant determinant(points);
  HullFeatures hull_a = hull_features(determinant, 0);
  HullFeatures hull_b = hull_features(determinant, kFirstOfB);
  if (hull_a.has_volume && hull_b.has_volume) return solid_hulls_intersect(determinant, hull_a, hull_b);

  const Projector projector(determinant);
  for (const HullFeatures* hull : {&hull_a, &hull_b}) {
    for (int f = 0; f < hull->facet_count; ++f) {
      const Facet& facet = hull->facets[f];
      if (test_axis(determinant, projector, {facet.i, facet.j}, {facet.i, facet.k}) == Axis::separating)
        return false;
    }
  }
  if (hull_a.has_volume)
    for (int p = kFirstOfB; p < 16; ++p)
      if (contains(determinant, hull_a, p)) return true;
  if (hull_b.has_volume)
    for (int p = 0; p < kFirstOfB; ++p)
      if (contains(determinant, hull_b, p)) return true;

  drop_repeated_directions(determinant, hull_a);
  drop_repeated_directions(determinant, hull_b);
  for (int i = 0; i < hull_a.edge_count; ++i)
    for (int j = 0; j < hull_b.edge_count; ++j)
      if (test_axis(determinant, projector, hull_a.edges[i], hull_b.edges[j]) == Axis::separating)
        return false;

  if (hull_a.has_volume || hull_b.has_volume || spans_volume(determinant)) return true;
  return flat_hulls_intersect(determinant);
}

}  // namespace touchstone::numerics

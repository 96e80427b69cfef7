#pragma once

#include "touchstone/contact_core/native/simd/hull_faces.hpp"

// Facets of the Minkowski difference of two hexahedra across an edge of each: edges whose arcs on the sphere
// of normals cross (Gregorius, GDC 2013). With e the edge's direction along the loop of its first face, u1,
// u2 the outward normals beside it, and f, w1, w2 the same of B, the arcs cross when f . u1, f . u2 and e .
// w1, e . w2 have the signs +, -, +, - or all of them turned; the outward normal is e x f or its negative.
//
// Most edges are out of question. The overlap along a normal n of the arc of A's edge is at least n . (v -
// p), v on the edge, p any vertex of B; n is a u1 + b u2 with a, b >= 0, a + b >= 1 however far apart u1 and
// u2 are. So where some vertex of B lies deeper below both faces than the least overlap known, no overlap on
// the arc is less, and the edge is passed over. So for B. Depths as computed must exceed that by what they
// may be off: a normal by 32 u (16 of them facets that count as one, solid_features.hpp), vertices beside the
// plane by 16 u, for points up to 2 sqrt(3) extent apart, and the products by 12 u extent: 180 u extent; the
// projections that overlaps are compared by take 36 u extent twice; and by what the world vertices' rounding
// takes.
//
// A pair of edges whose signs are uncertain (closer to 0 than 2^-40) is kept. The separation of two edges'
// own vertices along their common normal is never less than that of the hulls, so a kept pair is out of
// question when its own overlap, less its rounding, exceeds the best; else the hulls are projected, and what
// counts is the projections' separation. No answer rests on the signs but through what they leave out. Edges
// at a sine below 2^-4 that could be the best leave the pair to scalar code; below 4 u they carry no
// direction.

namespace touchstone::native::TOUCHSTONE_ISA {

constexpr double kPruneRoundoffs = 512.0;
constexpr double kEdgeRoundoffs = 64.0;
constexpr double kUncertainSign = 0x1p-40;
constexpr double kShortCross2 = 0x1p-8;
constexpr double kNoCross2 = 16 * kU * kU;

/// Some of a solid's edges; lanes beyond the last have any of its edges.
struct EdgeList {
  static constexpr int kMost = 24;  // as lanes are filled

  int count;
  std::uint8_t edge[kMost];
};

#if defined(__SSSE3__)
/// As below, of the first 16 edges.
TOUCHSTONE_INLINE unsigned edges_without_common(const HullRecord& hull, __m128i of_face) {
  const auto beside = [&](int side) {
    return _mm_shuffle_epi8(of_face, _mm_loadu_si128((const __m128i*)hull.edge_faces[side]));
  };
  const __m128i common = _mm_and_si128(beside(0), beside(1));
  const auto none = static_cast<unsigned>(_mm_movemask_epi8(_mm_cmpeq_epi8(common, _mm_setzero_si128())));
  return none & ((1u << hull.edge_count) - 1);
}
#endif

/// Bit e: no bit is set in the numbers of both faces beside edge e.
TOUCHSTONE_INLINE unsigned edges_without_common(const HullRecord& hull, const std::uint8_t (&of_face)[16]) {
  unsigned out = 0;
  int first = 0;
#if defined(__SSSE3__)
  out = edges_without_common(hull, _mm_loadu_si128((const __m128i*)of_face));
  first = 16;
#endif
  for (int e = first; e < hull.edge_count; ++e) {
    const unsigned numbers_of_both = of_face[hull.edge_faces[0][e]] & of_face[hull.edge_faces[1][e]];
    if (numbers_of_both == 0) out |= 1u << e;
  }
  return out;
}

/// The same of at most eight faces, whose numbers are the bytes of a word.
TOUCHSTONE_INLINE unsigned edges_without_common(const HullRecord& hull, long long of_face) {
#if defined(__SSSE3__)
  return edges_without_common(hull, _mm_cvtsi64_si128(of_face));
#else
  std::uint8_t bytes[16] = {};
  for (int f = 0; f < 8; ++f) bytes[f] = static_cast<std::uint8_t>(of_face >> (8 * f));
  return edges_without_common(hull, bytes);
#endif
}

/// In ascending order, filled up to whole packs by edge 0.
template <class Pack>
TOUCHSTONE_INLINE void list_edges(unsigned edges, EdgeList& out) {
  constexpr int kRound = 4;  // as many without a branch, whose outcome no predictor can guess
  static_assert(kRound % Traits<Pack>::lanes == 0);
  out.count = __builtin_popcount(edges);
  unsigned rest = edges;
  int k = 0;
  do {
    for (int i = 0; i < kRound; ++i, rest &= rest - 1)
      out.edge[k + i] = static_cast<std::uint8_t>(__builtin_ctz(rest | 1u << 31) % 31);
    k += kRound;
  } while (rest != 0);
}

/// The edges for which no vertex of the other lies deeper below both faces than `depth`, to rounding.
template <class Pack>
TOUCHSTONE_INLINE unsigned edges_in_question(const PosedHull& hull, const FaceDepths& other, double depth,
                                             const Magnitudes& size) {
  const double most = (depth > 0.0 ? depth : 0.0) + size.rounding(kPruneRoundoffs);
  std::uint8_t deep[PosedHull::kMostFaces] = {};  // by face, bit v: vertex v of the other
  for (int f = 0; f < hull.hull->face_count; ++f) {
    const Pack highest = all<Pack>(hull.height[f] - most);
    unsigned vertices = 0;
    for (int v = 0; v < 8; v += Traits<Pack>::lanes)
      vertices |= bits(load<Pack>(other.along[f] + v) < highest) << v;
    deep[f] = static_cast<std::uint8_t>(vertices);
  }
  return edges_without_common(*hull.hull, deep);
}

/// Listed edges in the world, in lanes.
struct PosedEdges {
  alignas(64) double x[EdgeList::kMost], y[EdgeList::kMost], z[EdgeList::kMost];

  TOUCHSTONE_INLINE Point at(int k) const { return {x[k], y[k], z[k]}; }
};

template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> lanes_of(const PosedEdges& edges, int first) {
  return {load<Pack>(edges.x + first), load<Pack>(edges.y + first), load<Pack>(edges.z + first)};
}

template <class Pack>
TOUCHSTONE_INLINE void pose_edges(const PosedHull& hull, const EdgeList& list, PosedEdges& out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  for (int first = 0; first < list.count; first += kLanes) {
    const double* from[kLanes];
    for (int l = 0; l < kLanes; ++l) from[l] = hull.hull->edges[list.edge[first + l]].direction;
    Pack local[4];
    gather(from, local);
    const Vector3Of<Pack> d = rotated<Pack>(hull.R, Vector3Of<Pack>{local[0], local[1], local[2]});
    store(d.x, out.x + first), store(d.y, out.y + first), store(d.z, out.z + first);
  }
}

/// Data beside the listed edges: the normals of both faces, and the first vertex.
struct BesideEdges {
  PosedEdges face[2], vertex;

  TOUCHSTONE_INLINE BesideEdges(const PosedHull& hull, const EdgeList& list, int lanes) {
    for (int k = 0; k < list.count || k % lanes != 0; ++k) {
      const int e = list.edge[k];
      for (int side = 0; side < 2; ++side) set(face[side], k, hull.normal(hull.hull->edge_faces[side][e]));
      set(vertex, k, hull.vertex(hull.hull->edges[e].vertices[0]));
    }
  }

 private:
  TOUCHSTONE_INLINE static void set(PosedEdges& to, int k, Point p) {
    to.x[k] = p.x, to.y[k] = p.y, to.z[k] = p.z;
  }
};

enum class EdgeSearch : unsigned char { done, too_parallel };

/// The normal across edge i of A and edge j of B, any length, and the overlap of these edges along it times
/// that length, less rounding.
struct EdgeAxis {
  Point c;
  double length2, overlap;

  TOUCHSTONE_INLINE EdgeAxis(const PosedHull& A, int i, Point edge_a, const PosedHull& B, int j, Point edge_b,
                             double sign, double extent)
      : c(sign * cross(edge_a, edge_b)), length2(dot(c, c)) {
    const Point w = B.vertex(B.hull->edges[j].vertices[0]) - A.vertex(A.hull->edges[i].vertices[0]);
    overlap = -dot(c, w) - kEdgeRoundoffs * kU * extent;
  }
  TOUCHSTONE_INLINE bool has_direction() const { return length2 > kNoCross2; }
  /// Whether the overlap is certainly more than that at `separation`.
  TOUCHSTONE_INLINE bool exceeds(double separation) const {
    return overlap > 0.0 && overlap * overlap > (separation * separation) * length2;
  }
};

template <class Pack>
TOUCHSTONE_INLINE EdgeSearch try_edges(const PosedHull& A, int i, const PosedHull& B, int j,
                                       const EdgeAxis& axis, double extent, HullAxis& best) {
  if (axis.exceeds(best.separation) || !axis.has_direction()) return EdgeSearch::done;
  if (axis.length2 < kShortCross2) return EdgeSearch::too_parallel;
  const Point n = (1.0 / __builtin_sqrt(axis.length2)) * axis.c;
  const double separation = hull_separation<Pack>(A, B, n);
  if (separation > best.separation + kTieOfExtent * kU * extent) {
    best = {separation, n};
    best.edge_a = i, best.edge_b = j;
  }
  return EdgeSearch::done;
}

/// Of one edge of A and those of B in lanes: whose arcs may cross, and whose own overlap does not exceed the
/// least known; with the signs as they stand, and turned.
struct CrossingArcs {
  unsigned ahead, turned;
};

template <class Pack>
TOUCHSTONE_INLINE CrossingArcs crossing_arcs(const Vector3Of<Pack>& e, const Vector3Of<Pack> (&u)[2],
                                             const Vector3Of<Pack>& vertex_a, const Vector3Of<Pack>& f,
                                             const BesideEdges& beside_b, int first, double extent,
                                             double separation) {
  using Mask = MaskOf<Pack>;
  const Pack tolerance = all<Pack>(kUncertainSign), zero{};
  // Signs.
  const Pack f_u1 = dot(u[0], f), f_u2 = dot(u[1], f);
  const Pack e_w1 = dot(lanes_of<Pack>(beside_b.face[0], first), e);
  const Pack e_w2 = dot(lanes_of<Pack>(beside_b.face[1], first), e);
  Mask ahead = (least(f_u1, e_w1) > -tolerance) & (greatest(f_u2, e_w2) < tolerance);
  Mask turned = (greatest(f_u1, e_w1) < tolerance) & (least(f_u2, e_w2) > -tolerance);
  // Their own overlap.
  const Vector3Of<Pack> c = cross(e, f);
  const Pack length2 = dot(c, c), along = dot(c, lanes_of<Pack>(beside_b.vertex, first) - vertex_a);
  const Pack rounding = all<Pack>(kEdgeRoundoffs * kU * extent);
  const Pack least2 = all<Pack>(separation * separation) * length2;
  const Pack overlap = -along - rounding, overlap_turned = along - rounding;
  const Mask has_direction = length2 > all<Pack>(kNoCross2);
  ahead &= has_direction & ~((overlap > zero) & (overlap * overlap > least2));
  turned &= has_direction & ~((overlap_turned > zero) & (overlap_turned * overlap_turned > least2));
  return {bits(ahead), bits(turned)};
}

/// @param in_question_a, in_question_b bits of edges
template <class Pack>
TOUCHSTONE_INLINE EdgeSearch search_edges(const PosedHull& A, unsigned in_question_a, const PosedHull& B,
                                          unsigned in_question_b, double extent, HullAxis& best) {
  constexpr int kLanes = Traits<Pack>::lanes;
  EdgeList edges_a, edges_b;
  list_edges<Pack>(in_question_a, edges_a), list_edges<Pack>(in_question_b, edges_b);
  PosedEdges posed_a, posed_b;
  pose_edges<Pack>(A, edges_a, posed_a), pose_edges<Pack>(B, edges_b, posed_b);
  const BesideEdges beside_b(B, edges_b, kLanes);
  const double face_separation = best.separation;
  for (int k = 0; k < edges_a.count; ++k) {
    const int i = edges_a.edge[k];
    const Vector3Of<Pack> e = broadcast<Pack>(posed_a.at(k));
    const Vector3Of<Pack> u[2] = {broadcast<Pack>(A.normal(A.hull->edge_faces[0][i])),
                                  broadcast<Pack>(A.normal(A.hull->edge_faces[1][i]))};
    const Vector3Of<Pack> vertex_a = broadcast<Pack>(A.vertex(A.hull->edges[i].vertices[0]));
    unsigned crossing[2] = {0, 0};
    for (int first = 0; first < edges_b.count; first += kLanes) {
      const CrossingArcs arcs = crossing_arcs<Pack>(e, u, vertex_a, lanes_of<Pack>(posed_b, first), beside_b,
                                                    first, extent, face_separation);
      crossing[0] |= arcs.ahead << first, crossing[1] |= arcs.turned << first;
    }
    // Few are left; each against the best so far.
    for (int turned = 0; turned < 2; ++turned) {
      for (unsigned rest = crossing[turned] & ((1u << edges_b.count) - 1); rest != 0; rest &= rest - 1) {
        const int l = __builtin_ctz(rest);
        const int j = edges_b.edge[l];
        const EdgeAxis axis(A, i, posed_a.at(k), B, j, posed_b.at(l), turned ? -1.0 : 1.0, extent);
        if (try_edges<Pack>(A, i, B, j, axis, extent, best) == EdgeSearch::too_parallel)
          return EdgeSearch::too_parallel;
      }
    }
  }
  return EdgeSearch::done;
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

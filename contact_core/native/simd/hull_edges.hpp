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
// Edges' directions are the differences of the world vertices, so that they are the hull's own however far
// from its solid's origin or the world's it lies. A pair of edges whose signs are uncertain (closer to 0 than
// 2^-40 extent, and than the vertices' rounding) is kept. The separation of two edges' own vertices along
// their common normal is never less than that of the hulls, so a kept pair is out of question when its own
// overlap, less its rounding, exceeds the best; else the hulls are projected, and what counts is the
// projections' separation. No answer rests on the signs but through what they leave out.
//
// A normal that is off turns about one edge, by what the other one's vertices are off over its length times
// the sine: its end is off by as much as these are, and the separation too. Edges at a sine below 2^-4 that
// could be the best leave the pair to scalar code. Those that are parallel once their vertices move by 16 u
// extent + 8 u P, by which no depth changes more, have no facet between them.

namespace touchstone::native::TOUCHSTONE_ISA {

constexpr double kPruneRoundoffs = 512.0;
constexpr double kEdgeRoundoffs = 64.0;
constexpr double kUncertainSign = 0x1p-40;
constexpr double kUncertainRoundoffs = 32.0;
constexpr double kShortCross2 = 0x1p-8;
constexpr double kParallelRoundoffs = 16.0;

/// Bit e: no bit is set in the numbers of both faces beside edge e, of eight faces and eight more.
TOUCHSTONE_INLINE unsigned edges_without_common(const HullTopology& hull,
                                                const std::uint64_t (&of_faces)[2]) {
  unsigned out = 0;
  int first = 0;
#if defined(__SSSE3__)
  const __m128i of_face =
      _mm_set_epi64x(static_cast<long long>(of_faces[1]), static_cast<long long>(of_faces[0]));
  const auto beside = [&](int side) {
    return _mm_shuffle_epi8(of_face, _mm_loadu_si128((const __m128i*)hull.edge_faces[side]));
  };
  const __m128i common = _mm_and_si128(beside(0), beside(1));
  out = static_cast<unsigned>(_mm_movemask_epi8(_mm_cmpeq_epi8(common, _mm_setzero_si128())));
  if (hull.edge_count <= 16) return out & ((1u << hull.edge_count) - 1);
  first = 16;
#endif
  const auto number = [&of_faces](int face) { return of_faces[face / 8] >> (8 * (face % 8)) & 0xff; };
  for (int e = first; e < hull.edge_count; ++e)
    if ((number(hull.edge_faces[0][e]) & number(hull.edge_faces[1][e])) == 0) out |= 1u << e;
  return out;
}

/// The edges for which no vertex of the other lies deeper below both faces than `depth`, to rounding.
template <class Pack>
TOUCHSTONE_INLINE unsigned edges_in_question(const PosedHull& hull, int face_count, const FaceDepths& other,
                                             double depth, const Magnitudes& size) {
  const double most = (depth > 0.0 ? depth : 0.0) + size.rounding(kPruneRoundoffs);
  std::uint64_t deep[2] = {};  // a byte a face, bit v: vertex v of the other
  for (int f = 0; f < face_count; ++f) {
    const Pack highest = all<Pack>(hull.height[f] - most);
    unsigned vertices = 0;
    for (int v = 0; v < 8; v += Traits<Pack>::lanes)
      vertices |= bits(load<Pack>(other.along[f] + v) < highest) << v;
    deep[f / 8] |= std::uint64_t{vertices} << (8 * (f % 8));
  }
  return edges_without_common(*hull.hull, deep);
}

enum class EdgeSearch : unsigned char { done, too_parallel };

TOUCHSTONE_INLINE Point edge_of(const PosedHull& hull, int e) {
  return hull.vertex(hull.hull->edge_vertices[1][e]) - hull.vertex(hull.hull->edge_vertices[0][e]);
}

/// What edges' lengths and directions may be off by, and the overlap that counts.
struct EdgeBounds {
  double tie, uncertain, rounding, parallel2;

  /// Lengths of a pair's edges are at most 2 sqrt(3) extent.
  TOUCHSTONE_INLINE explicit EdgeBounds(const Magnitudes& size)
      : tie(kTieOfExtent * kU * size.extent),
        uncertain(kUncertainSign * size.extent + kUncertainRoundoffs * kU * size.position),
        rounding(12.0 * kEdgeRoundoffs * kU * ((size.extent * size.extent) * size.extent)) {
    const double parallel = size.rounding(kParallelRoundoffs);
    parallel2 = parallel * parallel;
  }
};

/// Bytes of a table of edges.
TOUCHSTONE_INLINE PlaceWord looked_up(const std::uint8_t (&table)[18], PlaceWord edges) {
#if defined(__SSSE3__)
  if (__builtin_expect((edges & 0x1010101010101010) == 0, 1))
    return static_cast<PlaceWord>(_mm_cvtsi128_si64(_mm_shuffle_epi8(
        _mm_loadu_si128((const __m128i*)table), _mm_cvtsi64_si128(static_cast<long long>(edges)))));
#endif
  PlaceWord out = 0;
  for (int k = 0; k < 64; k += 8) out |= PlaceWord{table[edges >> k & 0x1f]} << k;
  return out;
}

TOUCHSTONE_INLINE int byte_of(PlaceWord word, int k) { return static_cast<int>(word >> (8 * k) & 0xff); }

/// Up to eight of a solid's edges, of the first sixteen or of the others. Places beyond the last have edge 0.
struct EdgeList {
  static constexpr int kMost = 8;

  int count;
  PlaceWord edges;

  /// Takes them out of `from`, in ascending order. @pre one at least
  TOUCHSTONE_INLINE explicit EdgeList(unsigned& from) {
    const unsigned some = (from & 0xffff) != 0 ? from & 0xffff : from;
    count = __builtin_popcount(some);
    count = count < kMost ? count : kMost;
#if defined(__AVX512F__)
    const int first = some > 0xffff ? 16 : 0;
    const __m512i numbers = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __m512i taken = _mm512_maskz_compress_epi32(static_cast<__mmask16>(some >> first), numbers);
    edges = static_cast<PlaceWord>(_mm_cvtsi128_si64(_mm512_maskz_cvtepi32_epi8(0xffff, taken)));
    if (first != 0) edges += 0x1010 & ((1u << (8 * count)) - 1);
#else
    unsigned rest = some;
    edges = 0;
    int k = 0;
    do {  // four without a branch, whose outcome no predictor can guess
      for (int i = 0; i < 4; ++i, rest &= rest - 1)
        edges |= PlaceWord{static_cast<unsigned>(__builtin_ctz(rest | 1u << 31)) % 31} << (8 * (k + i));
      k += 4;
    } while (rest != 0 && k < kMost);
#endif
    unsigned left = some;
    if (__builtin_expect(__builtin_popcount(some) > kMost, 0))
      for (int i = 0; i < kMost; ++i) left &= left - 1;
    else
      left = 0;
    from = (from & ~some) | left;
  }
  TOUCHSTONE_INLINE int at(int k) const { return byte_of(edges, k); }
};

/// Some of a solid's edges in lanes.
template <class Pack>
struct EdgeLanes {
  static constexpr int kPacks = EdgeList::kMost / Traits<Pack>::lanes;

  Vector3Of<Pack> from[kPacks], along[kPacks], normal[2][kPacks];
  Pack length2[kPacks];

  TOUCHSTONE_INLINE EdgeLanes(const PosedHull& hull, PlaceWord edges, int count) {
    constexpr int kLanes = Traits<Pack>::lanes;
    const HullTopology& topology = *hull.hull;
    const PlaceWord vertices[2] = {looked_up(topology.edge_vertices[0], edges),
                                   looked_up(topology.edge_vertices[1], edges)};
    const PlaceWord faces[2] = {looked_up(topology.edge_faces[0], edges),
                                looked_up(topology.edge_faces[1], edges)};
    for (int k = 0; k * kLanes < count; ++k) {
      const int shift = 8 * k * kLanes;
      from[k] = picked_vertices<Pack>(hull, vertices[0] >> shift);
      along[k] = picked_vertices<Pack>(hull, vertices[1] >> shift) - from[k];
      length2[k] = dot(along[k], along[k]);
      for (int side = 0; side < 2; ++side) normal[side][k] = picked_normals<Pack>(hull, faces[side] >> shift);
    }
  }
};

/// Bits of B's edges that may have a facet with edge i of A no deeper than the separation whose square is
/// given: arcs may cross, turned as B's edge passes A's faces there, and the edges' own overlap does not
/// exceed it. Where it passes along both, the turn is uncertain.
template <class Pack>
TOUCHSTONE_INLINE unsigned edges_near(const PosedHull& A, int i, const EdgeLanes<Pack>& edges_b, int count,
                                      const EdgeBounds& bounds, double separation2) {
  using Mask = MaskOf<Pack>;
  constexpr int kLanes = Traits<Pack>::lanes;
  const Point edge = edge_of(A, i);
  const Vector3Of<Pack> e = broadcast<Pack>(edge), u1 = broadcast<Pack>(A.normal(A.hull->edge_faces[0][i])),
                        u2 = broadcast<Pack>(A.normal(A.hull->edge_faces[1][i]));
  const Vector3Of<Pack> from = broadcast<Pack>(A.vertex(A.hull->edge_vertices[0][i]));
  const Pack length2 = all<Pack>(dot(edge, edge)), uncertain = all<Pack>(bounds.uncertain);
  const Mask sign = (Mask)all<Pack>(-0.0);
  unsigned out = 0;
  for (int k = 0; k * kLanes < count; ++k) {
    const Vector3Of<Pack>& f = edges_b.along[k];
    const Pack f_u1 = dot(u1, f), f_u2 = dot(u2, f);
    const Pack e_w1 = dot(edges_b.normal[0][k], e), e_w2 = dot(edges_b.normal[1][k], e);
    const Mask turn = (Mask)(f_u1 - f_u2) & sign;
    const auto turned = [turn](Pack p) __attribute__((always_inline)) { return (Pack)((Mask)p ^ turn); };
    const Mask crosses =
        (least(turned(f_u1), turned(e_w1)) > -uncertain) & (greatest(turned(f_u2), turned(e_w2)) < uncertain);
    // The edges' separation times |c|.
    const Vector3Of<Pack> c = cross(e, f);
    const Pack across2 = dot(c, c);
    const Pack separation = turned(dot(c, edges_b.from[k] - from)) + all<Pack>(bounds.rounding);
    const Mask deeper = (separation < Pack{}) & (separation * separation > all<Pack>(separation2) * across2);
    const Mask two_ways = magnitude(f_u1 - f_u2) <= uncertain + uncertain;
    const Mask parallel = across2 <= all<Pack>(bounds.parallel2) * greatest(length2, edges_b.length2[k]);
    out |= bits(((crosses & ~deeper) | two_ways) & ~parallel) << (k * kLanes);
  }
  return out & ((1u << count) - 1);
}

/// The normal across edge i of A and edge j of B, any length, if their arcs cross so, and the overlap of
/// these edges along it times that length, less rounding.
struct EdgeAxis {
  Point c;
  double length2, overlap;
  bool crosses;
  bool is_short;

  TOUCHSTONE_INLINE EdgeAxis(const PosedHull& A, int i, const PosedHull& B, int j, double sign,
                             const EdgeBounds& bounds) {
    const Point e = edge_of(A, i), f = edge_of(B, j);
    const auto side = [](const PosedHull& hull, int edge, int k, const Point& other) {
      return dot(hull.normal(hull.hull->edge_faces[k][edge]), other);
    };
    const double low = -bounds.uncertain;
    crosses = sign * side(A, i, 0, f) > low && -sign * side(A, i, 1, f) > low &&
              sign * side(B, j, 0, e) > low && -sign * side(B, j, 1, e) > low;
    c = sign * cross(e, f), length2 = dot(c, c);
    const Point w = B.vertex(B.hull->edge_vertices[0][j]) - A.vertex(A.hull->edge_vertices[0][i]);
    overlap = -dot(c, w) - bounds.rounding;
    is_short = length2 < kShortCross2 * (dot(e, e) * dot(f, f));
  }
  /// Whether the overlap is certainly more than that at `separation`.
  TOUCHSTONE_INLINE bool exceeds(double separation) const {
    return overlap > 0.0 && overlap * overlap > (separation * separation) * length2;
  }
};

template <class Pack>
TOUCHSTONE_INLINE EdgeSearch try_edges(const PosedHull& A, int i, const PosedHull& B, int j,
                                       const EdgeBounds& bounds, HullAxis& best) {
  for (int turned = 0; turned < 2; ++turned) {
    const EdgeAxis axis(A, i, B, j, turned == 0 ? 1.0 : -1.0, bounds);
    if (!axis.crosses || axis.exceeds(best.separation)) continue;
    if (axis.is_short) return EdgeSearch::too_parallel;
    const Point n = (1.0 / __builtin_sqrt(axis.length2)) * axis.c;
    const double separation = hull_separation<Pack>(A, B, n);
    if (separation > best.separation + bounds.tie) {
      best = {separation, n};
      best.edge_a = i, best.edge_b = j;
    }
  }
  return EdgeSearch::done;
}

/// Pairs of edges, of A and of B, a byte each.
struct EdgePairs {
  int count = 0;
  PlaceWord a = 0, b = 0;

  /// Takes up to eight out of `near`, which has a byte of bits of B's edges for each of A's.
  TOUCHSTONE_INLINE EdgePairs(std::uint64_t& near, const std::uint8_t (&edges_a)[8],
                              const EdgeList& edges_b) {
    for (; near != 0 && count < EdgeList::kMost; near &= near - 1, ++count) {
      const int bit = __builtin_ctzll(near);
      a |= PlaceWord{edges_a[bit / 8]} << (8 * count);
      b |= static_cast<PlaceWord>(edges_b.at(bit % 8)) << (8 * count);
    }
  }
};

/// The normals across pairs of edges, any length, and turned; bits of those along which the arcs cross; the
/// overlap of the two edges along each times that length, less rounding. Pairs in lanes.
template <class Pack>
struct EdgeAxes {
  static constexpr int kLanes = Traits<Pack>::lanes, kMost = EdgeList::kMost, kPacks = kMost / kLanes;

  Vector3Of<Pack> c[kPacks];
  alignas(64) double length2[kMost];
  alignas(64) double overlap[2][kMost];  // along c, along -c
  unsigned crosses[2] = {0, 0};
  unsigned are_short = 0;

  TOUCHSTONE_INLINE EdgeAxes(const PosedHull& A, const PosedHull& B, const EdgePairs& pairs,
                             const EdgeBounds& bounds) {
    const EdgeLanes<Pack> of_a(A, pairs.a, pairs.count), of_b(B, pairs.b, pairs.count);
    const Pack low = all<Pack>(-bounds.uncertain), high = all<Pack>(bounds.uncertain);
    for (int k = 0; k * kLanes < pairs.count; ++k) {
      const Vector3Of<Pack>&e = of_a.along[k], &f = of_b.along[k];
      const Pack f_u1 = dot(of_a.normal[0][k], f), f_u2 = dot(of_a.normal[1][k], f);
      const Pack e_w1 = dot(of_b.normal[0][k], e), e_w2 = dot(of_b.normal[1][k], e);
      crosses[0] |= bits((least(f_u1, e_w1) > low) & (greatest(f_u2, e_w2) < high)) << (k * kLanes);
      crosses[1] |= bits((greatest(f_u1, e_w1) < high) & (least(f_u2, e_w2) > low)) << (k * kLanes);
      c[k] = cross(e, f);
      const Pack across2 = dot(c[k], c[k]), along_c = dot(c[k], of_b.from[k] - of_a.from[k]);
      const Pack rounding = all<Pack>(bounds.rounding);
      store(across2, length2 + k * kLanes);
      store(-along_c - rounding, overlap[0] + k * kLanes);
      store(along_c - rounding, overlap[1] + k * kLanes);
      are_short |= bits(across2 < all<Pack>(kShortCross2) * (of_a.length2[k] * of_b.length2[k]))
                   << (k * kLanes);
    }
    for (unsigned& of : crosses) of &= (1u << pairs.count) - 1;
  }
  /// Whether there is one along which the arcs cross and the overlap is not certainly more than that at
  /// `separation`.
  TOUCHSTONE_INLINE bool any_in_question(double separation) const {
    const Pack separation2 = all<Pack>(separation * separation);
    unsigned out = 0;
    for (int first = 0; (crosses[0] | crosses[1]) >> first != 0; first += kLanes) {
      for (int turned = 0; turned < 2; ++turned) {
        const Pack over = load<Pack>(overlap[turned] + first);
        const MaskOf<Pack> exceeds =
            (over > Pack{}) & (over * over > separation2 * load<Pack>(length2 + first));
        out |= crosses[turned] & (bits(~exceeds) << first);
      }
    }
    return out != 0;
  }
  /// Whether the overlap of pair k is certainly more than that at `separation`.
  TOUCHSTONE_INLINE bool exceeds(int k, int turned, double separation) const {
    const double over = overlap[turned][k];
    return over > 0.0 && over * over > (separation * separation) * length2[k];
  }
};

/// Unit normals along c, and the hulls' separations along them and along them turned.
template <class Pack>
struct EdgeSeparations {
  static constexpr int kLanes = Traits<Pack>::lanes;

  alignas(64) double nx[EdgeList::kMost], ny[EdgeList::kMost], nz[EdgeList::kMost];
  alignas(64) double along[2][EdgeList::kMost];

  TOUCHSTONE_INLINE EdgeSeparations(const PosedHull& A, const PosedHull& B, const EdgeAxes<Pack>& axes,
                                    int count) {
    for (int k = 0; k * kLanes < count; ++k) {
      const int first = k * kLanes;
      const Pack scale = all<Pack>(1.0) / square_root(load<Pack>(axes.length2 + first));
      const Vector3Of<Pack> n = scale * axes.c[k];
      store(n.x, nx + first), store(n.y, ny + first), store(n.z, nz + first);
      Pack low_a, high_a, low_b, high_b;
      find_extent(A, n, low_a, high_a), find_extent(B, n, low_b, high_b);
      store(low_b - high_a, along[0] + first), store(low_a - high_b, along[1] + first);
    }
  }
  TOUCHSTONE_INLINE Point normal(int k) const { return {nx[k], ny[k], nz[k]}; }

 private:
  TOUCHSTONE_INLINE static void find_extent(const PosedHull& hull, const Vector3Of<Pack>& n, Pack& low,
                                            Pack& high) {
    low = high = dot(n, broadcast<Pack>(hull.vertex(0)));
    for (int i = 1; i < 8; ++i) {
      const Pack height = dot(n, broadcast<Pack>(hull.vertex(i)));
      low = least(height, low), high = greatest(height, high);
    }
  }
};

/// try_edges() of many pairs, in lanes, by the same operations.
template <class Pack>
[[gnu::noinline]] EdgeSearch try_edges_in_lanes(const PosedHull& A, const std::uint8_t (&edges_a)[8],
                                                const PosedHull& B, const EdgeList& edges_b,
                                                std::uint64_t near, const EdgeBounds& bounds,
                                                HullAxis& best) {
  while (near != 0) {
    const EdgePairs pairs(near, edges_a, edges_b);
    const EdgeAxes<Pack> axes(A, B, pairs, bounds);
    if (!axes.any_in_question(best.separation)) continue;
    // One after another: each is held against the best so far.
    const EdgeSeparations<Pack> separations(A, B, axes, pairs.count);
    for (unsigned rest = axes.crosses[0] | axes.crosses[1]; rest != 0; rest &= rest - 1) {
      const int k = __builtin_ctz(rest);
      for (int turned = 0; turned < 2; ++turned) {
        if ((axes.crosses[turned] >> k & 1) == 0 || axes.exceeds(k, turned, best.separation)) continue;
        if ((axes.are_short >> k & 1) != 0) return EdgeSearch::too_parallel;
        const double separation = separations.along[turned][k];
        if (!(separation > best.separation + bounds.tie)) continue;
        best = {separation, (turned == 0 ? 1.0 : -1.0) * separations.normal(k)};
        best.edge_a = byte_of(pairs.a, k), best.edge_b = byte_of(pairs.b, k);
      }
    }
  }
  return EdgeSearch::done;
}

/// @param in_question_a, in_question_b bits of edges
template <class Pack>
TOUCHSTONE_INLINE EdgeSearch search_edges(const PosedHull& A, unsigned in_question_a, const PosedHull& B,
                                          unsigned in_question_b, const Magnitudes& size, HullAxis& best) {
  // Most hulls have one pair near or none, whose lanes would take longer; flush faces have eight.
  constexpr int kFew = Traits<Pack>::lanes > 2 ? 2 : 64;
  const EdgeBounds bounds(size);
  const double separation2 = best.separation * best.separation;
  for (unsigned rest_b = in_question_b; rest_b != 0;) {
    const EdgeList list_b(rest_b);
    const EdgeLanes<Pack> edges_b(B, list_b.edges, list_b.count);
    for (unsigned rest_a = in_question_a; rest_a != 0;) {
      // Of eight edges of A, a byte each; few bits are left.
      std::uint64_t near = 0;
      std::uint8_t edges_a[8];
      for (int k = 0; k < 8 && rest_a != 0; ++k, rest_a &= rest_a - 1) {
        edges_a[k] = static_cast<std::uint8_t>(__builtin_ctz(rest_a));
        const unsigned found = edges_near<Pack>(A, edges_a[k], edges_b, list_b.count, bounds, separation2);
        near |= std::uint64_t{found} << (8 * k);
      }
      if (__builtin_expect(__builtin_popcountll(near) > kFew, 0)) {
        if (try_edges_in_lanes<Pack>(A, edges_a, B, list_b, near, bounds, best) == EdgeSearch::too_parallel)
          return EdgeSearch::too_parallel;
        continue;
      }
      for (; near != 0; near &= near - 1) {
        const int bit = __builtin_ctzll(near);
        if (try_edges<Pack>(A, edges_a[bit / 8], B, list_b.at(bit % 8), bounds, best) ==
            EdgeSearch::too_parallel)
          return EdgeSearch::too_parallel;
      }
    }
  }
  return EdgeSearch::done;
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

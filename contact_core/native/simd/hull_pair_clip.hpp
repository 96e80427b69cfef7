#pragma once

#include "touchstone/contact_core/native/simd/hull_clip_lanes.hpp"
#include "touchstone/contact_core/native/simd/hull_faces.hpp"

// The manifold of one pair of general hexahedra, whose faces are quadrangles, plane or bent: the eight edges
// of both contact faces in lanes, A's first. hull_clip_lanes.hpp makes those of many pairs of plane faces.
// Every number results from the same operations in the same order as in polygon_clip.hpp, so the bits are
// the same. Pairs that fit: as there.

namespace touchstone::native::TOUCHSTONE_ISA {

/// Pack number `pack` of eight lanes: `a` in the first four, `b` in the others.
template <class Pack>
TOUCHSTONE_INLINE Pack halves(double a, double b, int pack) {
  if constexpr (Traits<Pack>::lanes == 8)
    return Pack{a, a, a, a, b, b, b, b};
  else
    return all<Pack>(pack * Traits<Pack>::lanes < 4 ? a : b);
}

/// The corners that the word's bytes name, A's in its low half. @param a, b a coordinate of eight vertices
#if defined(__AVX512F__)
TOUCHSTONE_INLINE Double8 corners_at(const double* a, const double* b, PlaceWord w, int, Double8) {
  return __builtin_shufflevector(picked(a, w, Double8{}), picked(b, w, Double8{}), 0, 1, 2, 3, 12, 13, 14,
                                 15);
}
#endif
template <class Pack>
TOUCHSTONE_INLINE Pack corners_at(const double* a, const double* b, PlaceWord w, int pack, Pack) {
  constexpr int kLanes = Traits<Pack>::lanes;
  return picked(pack * kLanes < 4 ? a : b, w >> (8 * kLanes * pack), Pack{});
}

/// Of each edge the next one's: in the lanes to the right, of four.
TOUCHSTONE_INLINE void take_next(const Double2 (&p)[4], Double2 (&out)[4]) {
  for (int i = 0; i < 4; ++i) out[i] = __builtin_shufflevector(p[i], p[i ^ 1], 1, 2);
}
TOUCHSTONE_INLINE void take_next(const Double4 (&p)[2], Double4 (&out)[2]) {
  for (int i = 0; i < 2; ++i) out[i] = __builtin_shufflevector(p[i], p[i], 1, 2, 3, 0);
}
TOUCHSTONE_INLINE void take_next(const Double8 (&p)[1], Double8 (&out)[1]) {
  out[0] = __builtin_shufflevector(p[0], p[0], 1, 2, 3, 0, 5, 6, 7, 4);
}

/// The corners of each face, a byte each: A's counter-clockwise from outside, B's clockwise.
struct FaceWords {
  PlaceWord of_a[6], of_b[6];
};
inline constexpr FaceWords kFaceWords = [] {
  FaceWords out{};
  for (int f = 0; f < 6; ++f) {
    for (int k = 0; k < 4; ++k) {
      out.of_a[f] |= PlaceWord{kQuads[f][k]} << (8 * k);
      out.of_b[f] |= PlaceWord{kQuads[f][3 - k]} << (32 + 8 * k);
    }
  }
  return out;
}();

/// The contact faces, A's in lane 0: find_contact_faces().
struct FacesOfPair {
  int number_a, number_b;
  bool fits, any_bent;
  Vector3Of<Double2> anchor, normal[2];  // a plane face has the same plane twice
  Double2 inverse[2];
};

/// Bit f: face f leans most along n_S, or as much to rounding.
template <class Pack>
TOUCHSTONE_INLINE unsigned leaning_most(const QuadFaces& faces, const Point& n_S, double& most) {
  constexpr int kLanes = Traits<Pack>::lanes, kPacks = 8 / kLanes;
  Pack lean[kPacks], high{};
  for (int k = 0; k < kPacks; ++k) {
    const Vector3Of<Pack> normal = {load<Pack>(faces.normals[0] + k * kLanes),
                                    load<Pack>(faces.normals[1] + k * kLanes),
                                    load<Pack>(faces.normals[2] + k * kLanes)};
    lean[k] = dot(normal, broadcast<Pack>(n_S));
    high = greatest(lean[k], high);
  }
  most = greatest_lane(high);
  unsigned out = 0;
  for (int k = 0; k < kPacks; ++k)
    out |= bits(lean[k] + all<Pack>(hull_clip::kSameLean) >= all<Pack>(most)) << (k * kLanes);
  return out & 0x3fu;
}

template <class Pack>
TOUCHSTONE_INLINE void choose_faces(const QuadView& a, const QuadView& b, const Point& n, FacesOfPair& out) {
  const Double2 sign = {1.0, -1.0};
  // n in the solids' frames.
  Vector3Of<Double2> column[3], N[3];
  for (int i = 0; i < 3; ++i)
    column[i] = {Double2{a.R[3 * i], b.R[3 * i]}, Double2{a.R[3 * i + 1], b.R[3 * i + 1]},
                 Double2{a.R[3 * i + 2], b.R[3 * i + 2]}};
  Double2 n_S[3];
  for (int i = 0; i < 3; ++i) {
    N[i] = cross(column[(i + 1) % 3], column[(i + 2) % 3]);
    n_S[i] = dot(N[i], broadcast<Double2>(n)) * sign;
  }
  // The faces that look most along n.
  double most[2];
  const unsigned of_a = leaning_most<Pack>(*a.faces, {n_S[0][0], n_S[1][0], n_S[2][0]}, most[0]);
  const unsigned of_b = leaning_most<Pack>(*b.faces, {n_S[0][1], n_S[1][1], n_S[2][1]}, most[1]);
  const Double2 best = load<Double2>(most);
  const bool is_one = (of_a & (of_a - 1)) == 0 && (of_b & (of_b - 1)) == 0;
  out.fits = is_one && bits(best >= all<Double2>(hull_clip::kSteep)) == 3;
  out.number_a = __builtin_ctz(of_a | 1u << 5), out.number_b = __builtin_ctz(of_b | 1u << 5);
  // Their planes.
  const bool bent_a = a.faces->bent >> out.number_a & 1u, bent_b = b.faces->bent >> out.number_b & 1u;
  out.any_bent = bent_a || bent_b;
  const Mask2 bent = {-static_cast<long long>(bent_a), -static_cast<long long>(bent_b)};
  const double* const p_A = a.vertices + a.faces->anchor[out.number_a];
  const double* const p_B = b.vertices + b.faces->anchor[out.number_b];
  out.anchor = {Double2{p_A[0], p_B[0]}, Double2{p_A[8], p_B[8]}, Double2{p_A[16], p_B[16]}};
  for (int i = 0; i < (out.any_bent ? 2 : 1); ++i) {
    const double* const of_A = a.faces->planes[out.number_a].normals[i];
    const double* const of_B = b.faces->planes[out.number_b].normals[i];
    out.normal[i] = rotate(N, Vector3Of<Double2>{Double2{of_A[0], of_B[0]}, Double2{of_A[1], of_B[1]},
                                                 Double2{of_A[2], of_B[2]}});
    const Double2 lean = dot(out.normal[i], broadcast<Double2>(n));
    out.fits = out.fits && bits((lean * sign >= all<Double2>(hull_clip::kSteep)) | ~bent) == 3;
    out.inverse[i] = select(bent, all<Double2>(1.0) / lean, sign / best);
  }
}

/// Numbers of the eight edges.
template <class Pack>
using PairRow = Pack[8 / Traits<Pack>::lanes];

/// Both faces projected along n: two FacePolygon<4>.
template <class Pack>
struct EdgesOfPair {
  static constexpr int kLanes = Traits<Pack>::lanes, kPacks = 8 / kLanes;

  PairRow<Pack> p[3], next[3];  // corners, and the next ones, by coordinate
  PairRow<Pack> x, y, edge_x, edge_y, length2;
  // As lines that cut: A's edges the other way round, so that what is inside has one sign.
  alignas(64) double line_x[8], line_y[8], line_ex[8], line_ey[8], line_length2[8];

  /// @return whether no corner is sharp
  TOUCHSTONE_INLINE bool project(const double* a, const double* b, PlaceWord corners,
                                 const PlaneAcross<Double2>& across) {
    // Corners.
    const Vector3Of<Pack> axis_x = broadcast<Pack>({across.x.x[0], across.x.y[0], across.x.z[0]});
    const Vector3Of<Pack> axis_y = broadcast<Pack>({across.y.x[0], across.y.y[0], across.y.z[0]});
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < kPacks; ++k) p[i][k] = corners_at(a + 8 * i, b + 8 * i, corners, k, Pack{});
      take_next(p[i], next[i]);
    }
    for (int k = 0; k < kPacks; ++k) {
      const Vector3Of<Pack> corner = {p[0][k], p[1][k], p[2][k]};
      x[k] = dot(corner, axis_x), y[k] = dot(corner, axis_y);
    }
    // Edges.
    PairRow<Pack> next_x, next_y, after_x, after_y, after2;
    take_next(x, next_x), take_next(y, next_y);
    for (int k = 0; k < kPacks; ++k) {
      edge_x[k] = next_x[k] - x[k], edge_y[k] = next_y[k] - y[k];
      length2[k] = edge_x[k] * edge_x[k] + edge_y[k] * edge_y[k];
      const Pack sign = halves<Pack>(-1.0, 1.0, k);
      store(x[k], line_x + k * kLanes), store(y[k], line_y + k * kLanes);
      store(sign * edge_x[k], line_ex + k * kLanes), store(sign * edge_y[k], line_ey + k * kLanes);
      store(length2[k], line_length2 + k * kLanes);
    }
    // Their angles.
    take_next(edge_x, after_x), take_next(edge_y, after_y), take_next(length2, after2);
    MaskOf<Pack> blunt = ~MaskOf<Pack>{};
    for (int k = 0; k < kPacks; ++k) {
      const Pack turn = edge_x[k] * after_y[k] - edge_y[k] * after_x[k];
      const Pack least2 = all<Pack>(hull_clip::kSharp * hull_clip::kSharp) * (length2[k] * after2[k]);
      blunt &= (turn > Pack{}) & (turn * turn > least2);
    }
    return bits(blunt) == (1u << kLanes) - 1;
  }
  /// Number i of the other face's lines, for each edge.
  TOUCHSTONE_INLINE Pack other(const double (&lines)[8], int i, int pack) const {
    return halves<Pack>(lines[4 + i], lines[i], pack);
  }
};

/// r: 1 / cross(edge of A, edge of B), of each edge with the other face's i.
template <class Pack>
struct CrossingsOfPair {
  PairRow<Pack> r[4];
  std::uint64_t behind = 0;  // as HullClipBits has it
  bool any_parallel;

  TOUCHSTONE_INLINE CrossingsOfPair(const EdgesOfPair<Pack>& e, double bound) {
    constexpr int kLanes = Traits<Pack>::lanes, kPacks = 8 / kLanes;
    Pack steepest{};
    for (int i = 0; i < 4; ++i) {
      for (int k = 0; k < kPacks; ++k) {
        const Pack turn = e.edge_x[k] * e.other(e.line_ey, i, k) - e.edge_y[k] * e.other(e.line_ex, i, k);
        r[i][k] = all<Pack>(1.0) / (turn + Pack{});
        steepest = greatest(magnitude(r[i][k]), steepest);
        if (k * kLanes < 4) behind |= std::uint64_t{bits(r[i][k] < Pack{}) & 0xfu} << (4 * i + k * kLanes);
      }
    }
    any_parallel = bits(steepest > all<Pack>(bound)) != 0;
  }
};

/// cut() of both faces.
template <bool kAnyParallel, class Pack>
TOUCHSTONE_INLINE void cut_edges(const EdgesOfPair<Pack>& e, const CrossingsOfPair<Pack>& crossings,
                                 double tolerance, PairRow<Pack>& from, PairRow<Pack>& to) {
  using Mask = MaskOf<Pack>;
  const Pack zero{}, one = all<Pack>(1.0);
  for (int k = 0; k < 8 / Traits<Pack>::lanes; ++k) {
    const Mask of_a = halves<Pack>(1.0, 0.0, k) > zero;
    from[k] = zero, to[k] = one;
    for (int i = 0; i < 4; ++i) {
      const Pack lx = e.other(e.line_ex, i, k), ly = e.other(e.line_ey, i, k), r = crossings.r[i][k];
      Pack side = lx * (e.y[k] - e.other(e.line_y, i, k)) - ly * (e.x[k] - e.other(e.line_x, i, k));
      // Rounding decides the side of edges along a line, so these get slack.
      if constexpr (kAnyParallel) {
        const Pack slack = all<Pack>(tolerance) * (magnitude(lx) + magnitude(ly));
        const Pack part = slack * r;
        const Mask aligned = is_aligned<Pack>(e.length2[k] * e.other(e.line_length2, i, k), r);
        const Mask is_parallel = part * part > all<Pack>(hull_clip::kParallel * hull_clip::kParallel);
        const Pack of_parallel = select(is_parallel, slack, zero);
        side = side + select(aligned, select(of_a, slack, -slack), of_parallel);
      }
      // The part inside runs from the last entry to the first exit.
      const Pack t = side * r;
      const Mask enters = (of_a & (r < zero)) | (~of_a & (r >= zero));
      from[k] = greatest(select(enters, t, zero), from[k]);
      to[k] = least(select(enters, one, t), to[k]);
    }
  }
}

/// join_flush_edges(): bit 4 j + i where A's edge i and B's j are flush.
template <class Pack>
TOUCHSTONE_INLINE std::uint64_t flush_edges(const EdgesOfPair<Pack>& e,
                                            const CrossingsOfPair<Pack>& crossings, double tolerance) {
  constexpr int kLanes = Traits<Pack>::lanes;
  const Pack half = all<Pack>(0.5), quarter2 = all<Pack>(0.25 * kFlushEdges * kFlushEdges);
  std::uint64_t out = 0;
  for (int k = 0; k * kLanes < 4; ++k) {
    for (int j = 0; j < 4; ++j) {
      const Pack ax = e.edge_x[k], ay = e.edge_y[k], a2 = e.length2[k];
      const Pack bx = all<Pack>(e.line_ex[4 + j]), by = all<Pack>(e.line_ey[4 + j]);
      const Pack b2 = all<Pack>(e.line_length2[4 + j]);
      const Pack x = (e.x[k] + half * ax) - all<Pack>(e.line_x[4 + j]);
      const Pack y = (e.y[k] + half * ay) - all<Pack>(e.line_y[4 + j]);
      const Pack side = bx * y - by * x, shorter2 = least(a2, b2);
      const Pack near2 = quarter2 * shorter2 + all<Pack>(16.0 * (tolerance * tolerance));
      const MaskOf<Pack> flush = is_aligned<Pack>(a2 * b2, crossings.r[j][k]) & (ax * bx + ay * by > Pack{}) &
                                 (side * side <= near2 * b2);
      out |= std::uint64_t{bits(flush) & 0xfu} << (4 * j + k * kLanes);
    }
  }
  return out;
}

/// Places the corners on the edges, as place() in polygon_clip.hpp. @return which are left, and within limits
template <class Pack>
TOUCHSTONE_INLINE std::uint64_t place_corners(const EdgesOfPair<Pack>& e, const FacesOfPair& faces,
                                              const PairRow<Pack>& from, const PairRow<Pack>& to,
                                              double least_separation, double limit, double shortest2,
                                              HullClipRecord& out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  std::uint64_t words = 0;
  for (int k = 0; k < 8 / kLanes; ++k) {
    // On its own edge.
    const Vector3Of<Pack> v = {e.p[0][k], e.p[1][k], e.p[2][k]};
    const Vector3Of<Pack> next = {e.next[0][k], e.next[1][k], e.next[2][k]};
    const Vector3Of<Pack> p = v + from[k] * (next - v);
    // How far the other face is there; a bent one's solid lies behind both of its planes.
    const auto of_other = [k](const Vector3Of<Double2>& q) __attribute__((always_inline)) {
      return Vector3Of<Pack>{halves<Pack>(q.x[1], q.x[0], k), halves<Pack>(q.y[1], q.y[0], k),
                             halves<Pack>(q.z[1], q.z[0], k)};
    };
    const Vector3Of<Pack> over = of_other(faces.anchor) - p;
    const auto height = [&](int plane) __attribute__((always_inline)) {
      return dot(of_other(faces.normal[plane]), over) *
             halves<Pack>(faces.inverse[plane][1], -faces.inverse[plane][0], k);
    };
    Pack separation = height(0);
    if (faces.any_bent) separation = greatest(height(1), separation);
    // No pair of points lies deeper than the pair; what rounding puts below is as deep.
    separation = greatest(separation, all<Pack>(least_separation));
    // Whether it is left, and near enough.
    const Pack part = to[k] - from[k];
    const MaskOf<Pack> left = (part > Pack{}) & (part * part * e.length2[k] > all<Pack>(shortest2));
    words |= std::uint64_t{bits(left)} << (HullClipBits::kLeft + k * kLanes);
    words |= std::uint64_t{bits(left & (separation <= all<Pack>(limit)))}
             << (HullClipBits::kNear + k * kLanes);
    store(p.x, out.p_x + k * kLanes), store(p.y, out.p_y + k * kLanes), store(p.z, out.p_z + k * kLanes);
    store(separation, out.separation + k * kLanes);
  }
  return words;
}

template <class Pack>
TOUCHSTONE_INLINE void clip_hull_pair_inline(const QuadView& a, const QuadView& b,
                                             const double (&n_separation)[4], double extent,
                                             double max_point_separation, HullClipRecord& out) {
  // The faces, seen along n.
  const Point n = {n_separation[0], n_separation[1], n_separation[2]};
  FacesOfPair faces;
  choose_faces<Pack>(a, b, n, faces);
  const Vector3Of<Double2> n_twice = broadcast<Double2>(n);
  const PlaneAcross<Double2> across(n_twice, with_sign_of(all<Double2>(1.0), n_twice.z));
  EdgesOfPair<Pack> edges;
  const PlaceWord corners = kFaceWords.of_a[faces.number_a] | kFaceWords.of_b[faces.number_b];
  const bool blunt = edges.project(a.vertices, b.vertices, corners, across);
  out.bits = 0;
  if (!(faces.fits && blunt)) return;

  // What is left of their edges.
  const double tolerance = hull_clip::kCoincide * kU * extent;
  const CrossingsOfPair<Pack> crossings(edges, hull_clip::kNearlyParallel / (tolerance * (8.0 * extent)));
  PairRow<Pack> from, to;
  out.flush = 0;
  if (__builtin_expect(crossings.any_parallel, 0)) {
    cut_edges<true>(edges, crossings, tolerance, from, to);
    out.flush = flush_edges(edges, crossings, tolerance);
  } else {
    cut_edges<false>(edges, crossings, tolerance, from, to);
  }

  // The corners.
  out.tie = hull_clip::kAsDeep * kU * extent;
  const double least_limit = n_separation[3] + out.tie, shortest = hull_clip::kShortest * extent;
  const double limit = max_point_separation > least_limit ? max_point_separation : least_limit;
  out.bits = place_corners(edges, faces, from, to, n_separation[3], limit, shortest * shortest, out);
  out.bits |= crossings.behind << HullClipBits::kBehind | std::uint64_t{1} << HullClipBits::kFits;
  out.bits |= static_cast<std::uint64_t>(faces.number_a) << HullClipBits::kFaceA |
              static_cast<std::uint64_t>(faces.number_b) << HullClipBits::kFaceB;
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

#pragma once

#include "touchstone/contact_core/native/simd/depth_axes.hpp"

// Boxes that the margins of box_kernels.hpp leave open: they touch, but for rounding. Three certificates, in
// lanes; notation stands in box_box_overlap.cpp. m: the second pass's margin there.
//
// Edges left out. Any axis across two edges may be left out for the price that is named there, so here all
// are whose slack is not above m: of edges at 1e-9 rad and a depth of 1e-6 m, too. The price, 8 sines, leaves
// something only below an eighth, where an angle is its sine but for 1 part in 300, and 6 sines would do.
//
// Flush along an axis of the world. A row of R_A that holds one entry of magnitude 1 and zeros makes the
// coordinate of all vertices there p +- half, rounded once: the hull lies between two planes across the
// world's axis and fills two faces in them. If that holds for both boxes, comparing the two intervals is
// exact, and intervals that do not meet separate. If they meet, the hulls do if their faces, seen along the
// axis, have a point x in common: A has points over x up to its upper plane and down to its lower one, and so
// has B. Seen so the faces are rectangles but for the same errors as in three dimensions (the axis of either
// box that is the world's is off by the defect in the other coordinates, as its products with the other two
// are), and two rectangles overlap by more than these where the slacks of the four other face axes exceed m.
// Where all three axes of both boxes are the world's, the hulls are boxes and comparing is all.
//
// Crossing edges. The only axis with a slack not above m spans edge a0 a1 of A, b0 b1 of B. E_A = a1 - a0,
// E_B = b1 - b0 of the world's vertices as doubles, n = E_A x E_B, N = n / |n|, oriented either way; A_k,
// B_l: the boxes' other axes, with the signs that make a0 and b0 the supporting vertices. Let
//   (1) N . A_k >= kAcross and -N . B_l >= kAcross, kAcross = 2^-10,
//   (2) all half-extents be at least kThick (size + P), kThick = 2^-33.
// A vertex that an edge along A_k joins to a0 is a0 - 2 half_k A_k but for 64 u (size + P) = 2^-47 (size +
// P), which by (2) is 2^-15 of that edge's length at most; so it lies below a0 along N by at least 2^-10
// 2^-33 (size + P), less 2^-47 (size + P), and so do all of A's vertices but a0 and a1, which are level;
// likewise for B. Hence
//   n . (b0 - a0) > 0 separates, exactly.
// Otherwise let a0 + alpha E_A + s N = b0 + beta E_B, s <= 0, with
//   (3) alpha and beta in [kInside, 1 - kInside], kInside = 2^-6,
//   (4) |s| at most kShallow = 2^-8 of the least half-extent.
// The point b0 + beta E_B of B then is in A: -N = x D_i + y1 D_1 + y2 D_2 in the directions D of E_A and of
// a0's two other edges. These are orthonormal to g = 2^-19.9 (valid poses) + 2^-14 < 2^-13, so y_k >= kAcross
// - 3 g > 0 and |x| <= 3 g; so |s| times that stays in the tetrahedron of a0, a1 and a0's two neighbours: of
// its coordinates those along D_1 and D_2 are positive and, by (4), below 2^-8, and that along E_A, alpha,
// has moved by far less than kInside.
//
// Rounding there. Differences are exact as sums of two doubles. With M = |E_A|_inf |E_B|_inf, a component of
// n is below 2 M and off by 2 * 8 u^2 M for its products and 3 u^2 * 2 M for their difference, 22 u^2 M. So N
// is right to 2^-41 where |n| >= kSine M, kSine = 2^-60. Of w = b0 - a0, n . w is n . r with r = w - alpha
// E_A + beta E_B whatever alpha and beta are; with those of the feet r is short, so that n's error counts
// little, at any angle. r is off by 4 u^2 for each product and 3 u^2 for each of two sums of what is added
// up, so by 10 u^2 R in all, R = |w|_1 + |alpha| |E_A|_1 + |beta| |E_B|_1; n . r then by |n|_inf 10 u^2 R, 22
// u^2 M |r|_1 for n's error and 14 u^2 * 2 M |r|_1 for products and sums. kWide = 64 u^2 times M |r|_1 +
// |n|_inf R covers it. Products below 2^-960 count as exact: with M >= kLeastArea and magnitudes below 2^121
// that is less than kLeastVolume = 2^-880 in all. The feet are alpha = (w x E_B) . n / |n|^2, beta = (w x
// E_A) . n / |n|^2. Their numerators are off by 22 u^2 |w|_1 |E|_inf |n| for the first product, as n is, by
// |s| |E| 38 u^2 M for n's own error (w x E_B = alpha n + s N x E_B), and by a few u of alpha |n|^2 and the
// like, which kInside swallows: by less than kWide |E|_1 (|w|_1 + M |s| / |n|) / |n|, and 2^-40.

namespace touchstone::native::TOUCHSTONE_ISA {

constexpr double kAcross = 0x1p-10;
constexpr double kThick = 0x1p-33;
constexpr double kInside = 0x1p-6;
constexpr double kShallow = 0x1p-8;
constexpr double kWide = 64 * kU * kU;
constexpr double kLeastVolume = 0x1p-880;
constexpr double kLeastArea = 0x1p-400;
constexpr double kSine = 0x1p-60;

// ---- Edges left out

template <class Pack>
TOUCHSTONE_INLINE LaneVerdicts<Pack> certify_without_open_edges(const BoxSlacks<Pack>& s,
                                                                const CloseMargin<Pack>& close) {
  ParallelEdges<Pack> edges(s);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Pack cross = s.cross[i][j];
      edges.add(cross, ~(cross > close.margin), sine_bound(s, i, j), close.defect);
    }
  }
  return {(least_slack(s) < -close.margin) & s.ordinary, edges.overlap(close.margin, s.size) & s.ordinary};
}

// ---- Flush along an axis of the world

/// One coordinate of a box, and which of the box's axes is that of the world.
template <class Pack>
struct WorldInterval {
  Pack low, high;
  MaskOf<Pack> is_aligned;
  MaskOf<Pack> is_axis[3];

  TOUCHSTONE_INLINE WorldInterval(Pack x, Pack y, Pack z, const Pack (&half)[3], Pack p) {
    const Pack row[3] = {magnitude(x), magnitude(y), magnitude(z)};
    const Pack second =
        greatest(greatest(least(row[0], row[1]), least(row[1], row[2])), least(row[2], row[0]));
    for (int i = 0; i < 3; ++i) is_axis[i] = row[i] == all<Pack>(1.0);
    is_aligned = (is_axis[0] | is_axis[1] | is_axis[2]) & (second == Pack{});
    const Pack reach = (row[0] * half[0] + row[1] * half[1]) + row[2] * half[2];
    low = p - reach, high = p + reach;
  }

  /// The least slack along the box's faces that the axis does not cross.
  TOUCHSTONE_INLINE Pack beside(const Pack (&face)[3]) const {
    Pack out = all<Pack>(__builtin_inf());
    for (int i = 0; i < 3; ++i) out = least(out, is_axis[i] ? all<Pack>(__builtin_inf()) : face[i]);
    return out;
  }
};

template <class Pack>
TOUCHSTONE_INLINE LaneVerdicts<Pack> certify_along_the_world(const BoxLanes<Pack>& A, const BoxLanes<Pack>& B,
                                                             const BoxSlacks<Pack>& s, Pack margin) {
  LaneVerdicts<Pack> out{};
  MaskOf<Pack> all_meet = ~MaskOf<Pack>{};
  const auto compare = [&](Pack Vector3Of<Pack>::*k) {
    const WorldInterval<Pack> a(A.axis[0].*k, A.axis[1].*k, A.axis[2].*k, A.half, A.p.*k);
    const WorldInterval<Pack> b(B.axis[0].*k, B.axis[1].*k, B.axis[2].*k, B.half, B.p.*k);
    const MaskOf<Pack> are_aligned = a.is_aligned & b.is_aligned;
    const MaskOf<Pack> meet = are_aligned & (a.low <= b.high) & (b.low <= a.high);
    out.separated |= are_aligned & ~meet;
    out.overlapping |= meet & (least(a.beside(s.face_a), b.beside(s.face_b)) > margin);
    all_meet &= meet;
  };
  compare(&Vector3Of<Pack>::x), compare(&Vector3Of<Pack>::y), compare(&Vector3Of<Pack>::z);
  return {out.separated & s.ordinary, (out.overlapping | all_meet) & s.ordinary};
}

// ---- Crossing edges

/// The edge of a box that lies outermost along n among those along one axis.
template <class Pack>
struct OuterEdge {
  Vector3Of<Pack> from, to;
  Pack sign[3];

  TOUCHSTONE_INLINE OuterEdge(const BoxLanes<Pack>& box, const OneOfThree<Pack>& along,
                              const Vector3Of<Pack>& n) {
    const MaskOf<Pack> is_along[3] = {along.first, ~along.first & along.second,
                                      ~(along.first | along.second)};
    Pack low[3], high[3];
    for (int k = 0; k < 3; ++k) {
      sign[k] = is_along[k] ? Pack{} : (dot(n, box.axis[k]) >= Pack{} ? all<Pack>(1.0) : all<Pack>(-1.0));
      low[k] = is_along[k] ? all<Pack>(-1.0) : sign[k], high[k] = is_along[k] ? all<Pack>(1.0) : sign[k];
    }
    from = box_vertex<Pack>(box.axis, box.half, box.p, low);
    to = box_vertex<Pack>(box.axis, box.half, box.p, high);
  }

  /// Whether n leads outwards by kAcross from both faces at the edge.
  TOUCHSTONE_INLINE MaskOf<Pack> is_outermost(const BoxLanes<Pack>& box, const Vector3Of<Pack>& n,
                                              Pack length) const {
    MaskOf<Pack> out = ~MaskOf<Pack>{};
    for (int k = 0; k < 3; ++k)
      out &= (sign[k] == Pack{}) | (sign[k] * dot(n, box.axis[k]) >= all<Pack>(kAcross) * length);
    return out;
  }
};

/// The only axis with a slack that is not above the margin, if it is one across two edges.
template <class Pack>
struct OnlyOpenAxis {
  MaskOf<Pack> found;
  Pack code = Pack{};  // as AxisSearch::code

  TOUCHSTONE_INLINE OnlyOpenAxis(const BoxSlacks<Pack>& s, Pack margin) {
    Pack count{};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const MaskOf<Pack> is_clear = s.cross[i][j] > margin;
        count += is_clear ? Pack{} : all<Pack>(1.0);
        code = is_clear ? code : all<Pack>(6 + 3 * i + j);
      }
    }
    found = (s.face > margin) & (count == all<Pack>(1.0)) & s.ordinary;
  }
};

template <class Pack>
TOUCHSTONE_INLINE Pack least_half(const BoxLanes<Pack>& box) {
  return least(least(box.half[0], box.half[1]), box.half[2]);
}

template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> is_inside(Pack foot, Pack error) {
  const Pack inside = all<Pack>(kInside) + error;
  return (foot >= inside) & (foot <= all<Pack>(1.0) - inside);
}

template <class Pack>
TOUCHSTONE_INLINE LaneVerdicts<Pack> certify_crossing_edges(const BoxLanes<Pack>& A, const BoxLanes<Pack>& B,
                                                            const BoxSlacks<Pack>& s,
                                                            const OnlyOpenAxis<Pack>& axis) {
  // The edges, outermost along the axis from A to B.
  const OneOfThree<Pack> row = row_of(axis.code), column = column_of(axis.code);
  const Vector3Of<Pack> L = accurate_cross(row.of(A.axis), column.of(B.axis));
  const Pack forward = dot(L, B.p - A.p) >= Pack{} ? all<Pack>(1.0) : all<Pack>(-1.0);
  const OuterEdge<Pack> a(A, row, forward * L), b(B, column, (-forward) * L);
  const WideVector<Pack> E_A = wide_difference(a.to, a.from), E_B = wide_difference(b.to, b.from),
                         w = wide_difference(b.from, a.from);
  const Vector3Of<Pack> e_a = E_A.high(), e_b = E_B.high();
  const Pack M = largest(e_a) * largest(e_b), reach = sum(w.high());
  // Where they come nearest.
  const WideVector<Pack> normal = cross(E_A, E_B);
  const Vector3Of<Pack> n = normal.high();
  const Pack length2 = dot(n, n), length = square_root(length2);
  const Pack alpha = dot(cross(w, E_B).high(), n) / length2, beta = dot(cross(w, E_A).high(), n) / length2;
  // The determinant, and the bound of its error.
  const WideVector<Pack> r = w + E_A * (-alpha) + E_B * beta;
  const Pack volume = forward * dot(normal, r).high;
  const Pack terms = reach + magnitude(alpha) * sum(e_a) + magnitude(beta) * sum(e_b);
  const Pack error = all<Pack>(kWide) * (M * sum(r.high()) + largest(n) * terms) + all<Pack>(kLeastVolume);
  // Whether it decides: (1), (2).
  const Pack thin = least(least_half(A), least_half(B));
  const MaskOf<Pack> counts = axis.found & (M >= all<Pack>(kLeastArea)) & (length >= all<Pack>(kSine) * M) &
                              (thin >= all<Pack>(kThick) * (s.size + s.position)) &
                              a.is_outermost(A, forward * n, length) &
                              b.is_outermost(B, (-forward) * n, length);
  // And that they meet: (3), (4).
  const Pack depth = -volume / length;
  const Pack turned = all<Pack>(kWide) * (reach + M * magnitude(depth) / length) / length;
  const MaskOf<Pack> holds = is_inside<Pack>(alpha, turned * sum(e_b)) &
                             is_inside<Pack>(beta, turned * sum(e_a)) & (depth <= all<Pack>(kShallow) * thin);
  return {counts & (volume > error), counts & holds & (volume < -error)};
}

// ---- All of them

template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> decided(const LaneVerdicts<Pack>& verdicts) {
  return verdicts.separated | verdicts.overlapping;
}

template <class Pack>
TOUCHSTONE_INLINE LaneVerdicts<Pack> either(const LaneVerdicts<Pack>& p, const LaneVerdicts<Pack>& q) {
  return {p.separated | q.separated, p.overlapping | q.overlapping};
}

template <class Pack>
TOUCHSTONE_INLINE LaneVerdicts<Pack> certify_touching_lanes(const BoxLanes<Pack>& A,
                                                            const BoxLanes<Pack>& B) {
  BoxSlacks<Pack> s;
  find_slacks(A, B, s);
  const CloseMargin<Pack> close(A, B, s);
  LaneVerdicts<Pack> out =
      either(certify_without_open_edges(s, close), certify_along_the_world(A, B, s, close.margin));
  const OnlyOpenAxis<Pack> axis(s, close.margin);
  if (bits(~decided(out) & axis.found) == 0) return out;
  return either(out, certify_crossing_edges(A, B, s, axis));
}

template <class Pack>
TOUCHSTONE_INLINE void certify_touching_boxes_inline(const PoseRecord* poses, const BoxRecord* shapes,
                                                     const PairIndices* pairs, std::size_t count,
                                                     Certified* out) {
  for_each_block<Pack>(
      poses, shapes, pairs, count, out,
      [](const auto& poses_a, const auto& shapes_a, const auto& poses_b, const auto& shapes_b) {
        BoxLanes<Pack> A, B;
        gather_boxes<Pack>(poses_a, shapes_a, A);
        gather_boxes<Pack>(poses_b, shapes_b, B);
        return certify_touching_lanes(A, B);
      });
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

#pragma once

#include "touchstone/contact_core/native/simd/depth_axes.hpp"

// Boxes that the margins of box_kernels.hpp leave open: they touch, but for rounding. Four certificates, in
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
// axis, have a point x in common where the intervals do: at a level between its planes, the section of a
// hull is a mixture of its two faces, and x is in all of them. Seen so the faces are rectangles but for the
// same errors as in three dimensions (the axis of either box that is the world's is off by the defect in
// the other coordinates, as its products with the other two are), and two rectangles overlap by more than
// these where the slacks of the four other face axes exceed m. Where all three axes of both boxes are the
// world's, the hulls are boxes and comparing is all.
//
// Crossing edges. The open axes, those with a slack not above m, name an edge a0 a1 of A and b0 b1 of B; a
// bad guess certifies nothing. E_A = a1 - a0, E_B = b1 - b0 of the world's vertices as doubles, n = E_A x
// E_B, N = n / |n|, oriented either way; A_k, B_l: the boxes' other axes, with the signs that make a0 and b0
// the supporting vertices. Let
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
// is right to 2^-40 where |n| >= kSine M, kSine = 2^-60. Of w = b0 - a0, n . w is n . r with r = w - alpha
// E_A + beta E_B whatever alpha and beta are; with those of the feet r is short, so that n's error counts
// little, at any angle. r is off by 4 u^2 for each product and 3 u^2 for each of two sums of what is added
// up, so by 10 u^2 R in all, R = |w|_1 + |alpha| |E_A|_1 + |beta| |E_B|_1; n . r then by |n|_inf 10 u^2 R, 22
// u^2 M |r|_1 for n's error and 14 u^2 * 2 M |r|_1 for products and sums. kWide = 64 u^2 times M |r|_1 +
// |n|_inf R covers it. Products below 2^-960 lose up to 2^-1013 each. With M >= kLeastArea and magnitudes
// below 2^121 a coordinate of r so loses 2^-1012 at most, which n, below 2^243, makes 2^-767 in n . r; all
// else is less: below kLeastVolume = 2^-760 in all. The feet are alpha = (w x E_B) . n / |n|^2, beta = (w x
// E_A) . n / |n|^2. As w x E_B = alpha n + s N x E_B, what is computed is off by 22 u^2 |w|_1 |E|_inf / |n|
// for the first product, 38 u^2 M |s| |E| / |n|^2 for n's own error, and kFootRoundoffs = 8 u of alpha, which
// kInside swallows, and of |s| |E| / |n|: by kWide |E|_1 (|w|_1 + M |s| / |n|) / |n| + 8 u |E|_1 |s| / |n| at
// most.
//
// Parallel edges: as near as rounding tells, so that E_A x E_B is no normal of either box. Two open faces
// meet at the ridge of W = B - A from r0 = b0 - a1 to b1 - a0, B's edge turned to lead as A's does; D is the
// difference, g1 and g2 lead from r0 to two more points b - a of vertices, one along each of the faces.
//  - With -r0 = lambda D + y1 g1 + y2 g2 the origin is in the tetrahedron r0, r0 + D, r0 + g1, r0 + g2 of
//  points
//    of W, and the hulls meet, where y1, y2 and lambda are not negative and add up to 1 at most. y1 = (D x
//    g2) . r0 / V, y2 = -(D x g1) . r0 / V, V = D . (g1 x g2). Asked is (5) y1, y2 > 0 by more than their
//    errors, (6) y1 and y2 <= kShallow, (7) y1 |g1|_1 + y2 |g2|_1 <= kShallow |D|_inf, so that lambda is -r0
//    . D / |D|^2 but for kShallow, and (8) that this is in [kInside, 1 - kInside].
//  - The hulls are apart along N, whatever it is, where both ends of B's edge lie above both of A's, by exact
//    differences, and (1) and (2) hold. N is the part across D of one face's normal, tilted by kTilt towards
//    the other's: kAcross and more away from the faces that bound such directions.
// Rounding: D is off by 3 u^2 (|E_A| + |E_B|), so by 8 u^2 |D|_inf a coordinate, as the edges lead the same
// way; with G = |D|_inf |g|_1 a coordinate of D x g is off by 8 u^2 G for that, 8 u^2 G for its products and
// 3 u^2 G for their difference; its product with r0 then by 19 u^2 G |r0|_1 and 14 u^2 G |r0|_1, below kWide.
// V is certain where |V| >= kAcross |D|_inf |g1|_1 |g2|_1. N is the sum of two doubles as computed, exactly;
// N . w is off by 14 u^2 |N|_inf |w|_1. Underflow as above.

namespace touchstone::native::TOUCHSTONE_ISA {

constexpr double kAcross = 0x1p-10;
constexpr double kThick = 0x1p-33;
constexpr double kInside = 0x1p-6;
constexpr double kShallow = 0x1p-8;
constexpr double kWide = 64 * kU * kU;
constexpr double kLeastVolume = 0x1p-760;
constexpr double kLeastArea = 0x1p-400;
constexpr double kSine = 0x1p-60;
constexpr double kFootRoundoffs = 8;
/// At larger angles edges touch at one point, and no other axis is open there.
constexpr double kNearEdges = 0x1p-20;
constexpr double kTilt = 0x1p-6;

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

// ---- Edges

/// The edge of a box that lies outermost along n among those along one axis.
template <class Pack>
struct OuterEdge {
  Vector3Of<Pack> from, to;
  Pack sign[3];
  MaskOf<Pack> is_along[3];

  TOUCHSTONE_INLINE OuterEdge(const BoxLanes<Pack>& box, const OneOfThree<Pack>& along,
                              const Vector3Of<Pack>& n)
      : is_along{along.first, ~along.first & along.second, ~(along.first | along.second)} {
    for (int k = 0; k < 3; ++k) sign[k] = dot(n, box.axis[k]) >= Pack{} ? all<Pack>(1.0) : all<Pack>(-1.0);
    from = end(box, all<Pack>(-1.0)), to = end(box, all<Pack>(1.0));
  }

  TOUCHSTONE_INLINE Vector3Of<Pack> end(const BoxLanes<Pack>& box, Pack side) const {
    Pack at[3];
    for (int k = 0; k < 3; ++k) at[k] = is_along[k] ? side : sign[k];
    return box_vertex<Pack>(box.axis, box.half, box.p, at);
  }

  /// From that end away from the edge, within the face along axis `face`.
  TOUCHSTONE_INLINE Vector3Of<Pack> beside(const BoxLanes<Pack>& box, Pack side,
                                           const MaskOf<Pack> (&face)[3]) const {
    Pack at[3];
    for (int k = 0; k < 3; ++k) at[k] = is_along[k] ? side : (face[k] ? sign[k] : -sign[k]);
    return box_vertex<Pack>(box.axis, box.half, box.p, at);
  }

  /// Whether n leads outwards by kAcross from both faces at the edge.
  TOUCHSTONE_INLINE MaskOf<Pack> is_outermost(const BoxLanes<Pack>& box, const Vector3Of<Pack>& n,
                                              Pack length) const {
    MaskOf<Pack> out = ~MaskOf<Pack>{};
    for (int k = 0; k < 3; ++k)
      out &= is_along[k] | (sign[k] * dot(n, box.axis[k]) >= all<Pack>(kAcross) * length);
    return out;
  }
};

/// A face axis whose slack is not above the margin, from A to B.
template <class Pack>
struct OpenFace {
  MaskOf<Pack> found = MaskOf<Pack>{}, is_b = MaskOf<Pack>{};
  MaskOf<Pack> axis[3] = {};  // of A's or B's
  Vector3Of<Pack> n = {Pack{}, Pack{}, Pack{}};

  TOUCHSTONE_INLINE void set(MaskOf<Pack> where, bool of_b, int k, const Vector3Of<Pack>& n_of) {
    found |= where;
    if (of_b) is_b |= where;
    axis[k] |= where;
    n = select<Pack>(where, n_of, n);
  }
};

/// Which edges touch, judged by the axes with a slack that is not above the margin: those that the only such
/// axis spans, or the two nearest to parallel; and the first two of the faces there that look different ways.
template <class Pack>
struct TouchingEdges {
  MaskOf<Pack> found;
  Pack code = Pack{};  // as AxisSearch::code
  OpenFace<Pack> face[2];
  MaskOf<Pack> is_level = MaskOf<Pack>{};  // another looks as the first does
  Vector3Of<Pack> n;                       // about from A to B

  TOUCHSTONE_INLINE TouchingEdges(const BoxLanes<Pack>& A, const BoxLanes<Pack>& B, const BoxSlacks<Pack>& s,
                                  Pack margin) {
    // Open faces: an edge along the axis of one has no more than an end there.
    const Vector3Of<Pack> T = B.p - A.p;
    MaskOf<Pack> is_open_a[3], is_open_b[3];
    for (int k = 0; k < 3; ++k) {
      is_open_a[k] = ~(s.face_a[k] > margin), is_open_b[k] = ~(s.face_b[k] > margin);
      add_face(is_open_a[k], false, k, A.axis[k], T);
      add_face(is_open_b[k], true, k, B.axis[k], T);
    }
    // Open axes across edges, and the edges nearest to parallel.
    Pack count{}, open{}, least_sine = all<Pack>(1.0);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const MaskOf<Pack> is_clear = s.cross[i][j] > margin;
        count += is_clear ? Pack{} : all<Pack>(1.0);
        open = is_clear ? open : all<Pack>(6 + 3 * i + j);
        const Pack sine = (is_open_a[i] | is_open_b[j]) ? all<Pack>(1.0) : sine_bound(s, i, j);
        code = sine < least_sine ? all<Pack>(6 + 3 * i + j) : code;
        least_sine = least(sine, least_sine);
      }
    }
    // Whose edges touch, and a direction outwards there. Faces that all look the same way lie flush, and have
    // no edges to themselves.
    const MaskOf<Pack> is_only = (s.face > margin) & (count == all<Pack>(1.0));
    const MaskOf<Pack> is_flush = is_level & ~face[1].found;
    found = (is_only | (~is_flush & (least_sine < all<Pack>(kNearEdges)))) & s.ordinary;
    code = is_only ? open : code;
    const Vector3Of<Pack> L = accurate_cross(row_of(code).of(A.axis), column_of(code).of(B.axis));
    n = select<Pack>(face[0].found, face[0].n + face[1].n, forward(L, T) * L);
  }

  TOUCHSTONE_INLINE static Pack forward(const Vector3Of<Pack>& axis, const Vector3Of<Pack>& T) {
    return dot(axis, T) >= Pack{} ? all<Pack>(1.0) : all<Pack>(-1.0);
  }

  TOUCHSTONE_INLINE void add_face(MaskOf<Pack> is_open, bool of_b, int k, const Vector3Of<Pack>& axis,
                                  const Vector3Of<Pack>& T) {
    const Vector3Of<Pack> outwards = forward(axis, T) * axis;
    const MaskOf<Pack> looks_as_first = face[0].found & (dot(face[0].n, outwards) > all<Pack>(1.0 - kAcross));
    is_level |= is_open & looks_as_first;
    const MaskOf<Pack> is_second = is_open & face[0].found & ~looks_as_first & ~face[1].found;
    face[0].set(is_open & ~face[0].found, of_b, k, outwards);
    face[1].set(is_second, of_b, k, outwards);
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

/// Both edges as sums of two doubles, and whether (2) holds and their magnitudes are ordinary.
template <class Pack>
struct EdgePair {
  OuterEdge<Pack> a, b;
  WideVector<Pack> E_A, E_B;
  Pack thin;
  MaskOf<Pack> counts;

  TOUCHSTONE_INLINE EdgePair(const BoxLanes<Pack>& A, const BoxLanes<Pack>& B, const BoxSlacks<Pack>& s,
                             const TouchingEdges<Pack>& edges)
      : a(A, row_of(edges.code), edges.n),
        b(B, column_of(edges.code), all<Pack>(-1.0) * edges.n),
        E_A(wide_difference(a.to, a.from)),
        E_B(wide_difference(b.to, b.from)),
        thin(least(least_half(A), least_half(B))) {
    counts = edges.found & (thin >= all<Pack>(kThick) * (s.size + s.position)) &
             (thin * thin >= all<Pack>(kLeastArea));
  }
};

// ---- Crossing edges

template <class Pack>
TOUCHSTONE_INLINE LaneVerdicts<Pack> certify_crossing_edges(const BoxLanes<Pack>& A, const BoxLanes<Pack>& B,
                                                            const EdgePair<Pack>& edges,
                                                            const Vector3Of<Pack>& towards) {
  const WideVector<Pack>&E_A = edges.E_A, &E_B = edges.E_B;
  const WideVector<Pack> w = wide_difference(edges.b.from, edges.a.from);
  const Vector3Of<Pack> e_a = E_A.high(), e_b = E_B.high();
  const Pack M = largest(e_a) * largest(e_b), reach = sum(w.high());
  // Where they come nearest.
  const WideVector<Pack> normal = cross(E_A, E_B);
  const Vector3Of<Pack> n = normal.high();
  const Pack forward = TouchingEdges<Pack>::forward(n, towards);
  const Pack length2 = dot(n, n), length = square_root(length2);
  const Pack alpha = dot(cross(w, E_B).high(), n) / length2, beta = dot(cross(w, E_A).high(), n) / length2;
  // The determinant, and the bound of its error.
  const WideVector<Pack> r = w + E_A * (-alpha) + E_B * beta;
  const Pack volume = forward * dot(normal, r).high;
  const Pack terms = reach + magnitude(alpha) * sum(e_a) + magnitude(beta) * sum(e_b);
  const Pack error = all<Pack>(kWide) * (M * sum(r.high()) + largest(n) * terms) + all<Pack>(kLeastVolume);
  // Whether it decides: (1).
  const MaskOf<Pack> counts = edges.counts & (length >= all<Pack>(kSine) * M) &
                              edges.a.is_outermost(A, forward * n, length) &
                              edges.b.is_outermost(B, (-forward) * n, length);
  // And that they meet: (3), (4).
  const Pack depth = -volume / length;
  const Pack moved = magnitude(depth);
  const Pack turned =
      (all<Pack>(kWide) * (reach + M * moved / length) + all<Pack>(kFootRoundoffs * kU) * moved) / length;
  const MaskOf<Pack> holds = is_inside<Pack>(alpha, turned * sum(e_b)) &
                             is_inside<Pack>(beta, turned * sum(e_a)) &
                             (depth <= all<Pack>(kShallow) * edges.thin);
  return {counts & (volume > error), counts & holds & (volume < -error)};
}

// ---- Parallel edges

/// The ends of both edges, B's turned to lead as A's does, and the ridge of W between them.
template <class Pack>
struct Ridge {
  Pack first_of_b;  // the side of b0
  Vector3Of<Pack> a0, a1, b0, b1;
  WideVector<Pack> r0, D;

  TOUCHSTONE_INLINE explicit Ridge(const EdgePair<Pack>& edges) {
    const MaskOf<Pack> same = dot(edges.E_A.high(), edges.E_B.high()) >= Pack{};
    first_of_b = same ? all<Pack>(-1.0) : all<Pack>(1.0);
    a0 = edges.a.from, a1 = edges.a.to;
    b0 = select<Pack>(same, edges.b.from, edges.b.to), b1 = select<Pack>(same, edges.b.to, edges.b.from);
    r0 = wide_difference(b0, a1);
    D = edges.E_A + wide_difference(b1, b0);
  }
};

/// Along a facet of W at the ridge, away from it.
template <class Pack>
TOUCHSTONE_INLINE WideVector<Pack> away_from_ridge(const BoxLanes<Pack>& A, const BoxLanes<Pack>& B,
                                                   const EdgePair<Pack>& edges, const Ridge<Pack>& ridge,
                                                   const OpenFace<Pack>& face) {
  const Vector3Of<Pack> of_a = edges.a.beside(A, all<Pack>(1.0), face.axis),
                        of_b = edges.b.beside(B, ridge.first_of_b, face.axis);
  return wide_difference(select<Pack>(face.is_b, of_b, ridge.a1), select<Pack>(face.is_b, ridge.b0, of_a));
}

/// Whether both ends of B's edge lie above both of A's, along the part of `n` across the ridge.
template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> is_apart_along(const BoxLanes<Pack>& A, const BoxLanes<Pack>& B,
                                              const EdgePair<Pack>& edges, const Ridge<Pack>& ridge,
                                              const Vector3Of<Pack>& n) {
  const Vector3Of<Pack> h = cross(n, ridge.D.high());
  const WideVector<Pack> N = cross(ridge.D, WideVector<Pack>{{h.x, Pack{}}, {h.y, Pack{}}, {h.z, Pack{}}});
  const Vector3Of<Pack> high = N.high();
  const Pack length = square_root(dot(high, high));
  MaskOf<Pack> out = edges.counts & (length >= all<Pack>(kLeastArea)) &
                     edges.a.is_outermost(A, high, length) &
                     edges.b.is_outermost(B, all<Pack>(-1.0) * high, length);
  const Vector3Of<Pack> a[2] = {ridge.a0, ridge.a1}, b[2] = {ridge.b0, ridge.b1};
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const WideVector<Pack> w = wide_difference(b[j], a[i]);
      out &= dot(N, w).high > all<Pack>(kWide) * largest(high) * sum(w.high()) + all<Pack>(kLeastVolume);
    }
  }
  return out;
}

template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> holds_origin(const EdgePair<Pack>& edges, const Ridge<Pack>& ridge,
                                            const WideVector<Pack>& g1, const WideVector<Pack>& g2) {
  const Vector3Of<Pack> d = ridge.D.high(), e1 = g1.high(), e2 = g2.high(), r = ridge.r0.high();
  // Where the origin lies, in terms of D, g1 and g2.
  const Pack V = dot(d, cross(e1, e2));
  const Pack y1 = dot(cross(ridge.D, g2), ridge.r0).high / V,
             y2 = -dot(cross(ridge.D, g1), ridge.r0).high / V;
  const Pack along = -dot(r, d) / dot(d, d);
  // The bounds of errors, and (5) to (8).
  const Pack size_1 = sum(e1), size_2 = sum(e2), size_d = largest(d), reach = sum(r);
  const Pack unit = (all<Pack>(kWide) * size_d * reach) / magnitude(V);
  const Pack least_y = all<Pack>(kLeastVolume) / magnitude(V);
  return edges.counts & (magnitude(V) >= all<Pack>(kAcross) * size_d * size_1 * size_2) &
         (y1 > unit * size_2 + least_y) & (y2 > unit * size_1 + least_y) & (y1 <= all<Pack>(kShallow)) &
         (y2 <= all<Pack>(kShallow)) & (y1 * size_1 + y2 * size_2 <= all<Pack>(kShallow) * size_d) &
         is_inside<Pack>(along, Pack{});
}

template <class Pack>
TOUCHSTONE_INLINE LaneVerdicts<Pack> certify_parallel_edges(const BoxLanes<Pack>& A, const BoxLanes<Pack>& B,
                                                            const EdgePair<Pack>& edges,
                                                            const OpenFace<Pack> (&face)[2]) {
  const Ridge<Pack> ridge(edges);
  const MaskOf<Pack> counts = face[1].found;
  LaneVerdicts<Pack> out;
  out.overlapping = counts & holds_origin(edges, ridge, away_from_ridge(A, B, edges, ridge, face[0]),
                                          away_from_ridge(A, B, edges, ridge, face[1]));
  const Pack tilt = all<Pack>(kTilt);
  out.separated = counts & (is_apart_along(A, B, edges, ridge, face[0].n + tilt * face[1].n) |
                            is_apart_along(A, B, edges, ridge, face[1].n + tilt * face[0].n));
  return out;
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
  if (bits(~decided(out) & s.ordinary) == 0) return out;
  const TouchingEdges<Pack> touching(A, B, s, close.margin);
  if (bits(~decided(out) & touching.found) == 0) return out;
  const EdgePair<Pack> edges(A, B, s, touching);
  out = either(out, certify_crossing_edges(A, B, edges, touching.n));
  if (bits(~decided(out) & touching.found & touching.face[1].found) == 0) return out;
  return either(out, certify_parallel_edges(A, B, edges, touching.face));
}

template <class Pack>
TOUCHSTONE_INLINE void certify_touching_boxes_inline(const PoseRecord* poses, const BoxRecord* shapes,
                                                     const PairIndices* pairs, std::size_t count,
                                                     Certified* out) {
  for_each_two_solids<Pack, BoxLanes>(
      poses, shapes, pairs, count, out, [](const auto& A, const auto& B) __attribute__((always_inline)) {
        return certify_touching_lanes(A, B);
      });
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

#pragma once

#include "touchstone/contact_core/native/simd/pair_blocks.hpp"

// Both passes of certify_boxes: notation and bounds stand in box_box_overlap.cpp. Valid poses have delta
// <= 1e-6 < 2^-19.9, and 20 * 2^-19.9 + 24 u < 2^-15. Of a pose that is not finite a comparison may hold all
// the same, on an axis that the number does not enter: the pair is left to the caller, found by sums that all
// twelve numbers enter.

namespace touchstone::native::TOUCHSTONE_ISA {

constexpr double kCoarse = 0x1p-15;
constexpr double kDefectFactor = 20.0;
constexpr double kSizeRoundoffs = 24.0;
constexpr double kPositionRoundoffs = 4.0;
/// By how much an axis may be longer than 1.
constexpr double kLongestAxis = 0x1p-15;
/// At larger angles edges count as crossing ones.
constexpr double kNearlyParallel = 0x1p-30;
/// Larger sizes and positions are left to scalar code, which scales them (is_ordinary() in placed_pair.hpp;
/// records of solids too small have an infinite size).
constexpr double kOrdinaryHigh = 0x1p120;

// ---- One pair: lanes are A's axes.

TOUCHSTONE_INLINE Double4 next(Double4 p) { return __builtin_shufflevector(p, p, 1, 2, 0, 3); }
TOUCHSTONE_INLINE Double4 after_next(Double4 p) { return __builtin_shufflevector(p, p, 2, 0, 1, 3); }

/// R's rows, the last lane zero: products with it are as good as the box having no fourth axis.
struct Rows {
  Double4 x, y, z;
};

/// out[i][j] = in[j][i], three by three.
TOUCHSTONE_INLINE void transpose_three(const Double4 (&in)[3], Double4 (&out)[3]) {
  const Double4 low = __builtin_shufflevector(in[0], in[1], 0, 4, 1, 5);
  const Double4 high = __builtin_shufflevector(in[0], in[1], 2, 6, 3, 7);
  out[0] = __builtin_shufflevector(low, in[2], 0, 1, 4, 7);
  out[1] = __builtin_shufflevector(low, in[2], 2, 3, 5, 7);
  out[2] = __builtin_shufflevector(high, in[2], 0, 1, 6, 7);
}

/// With the last lane zero.
TOUCHSTONE_INLINE Double4 three_of(Double4 p) { return __builtin_shufflevector(p, Double4{}, 0, 1, 2, 7); }

/// Coordinate by coordinate: whole vectors of a pose that was just written would wait for its stores.
TOUCHSTONE_INLINE Rows rows_of(const PoseRecord& X) {
  const double* const R = X.R;
  return {Double4{R[0], R[3], R[6], 0.0}, Double4{R[1], R[4], R[7], 0.0}, Double4{R[2], R[5], R[8], 0.0}};
}

TOUCHSTONE_INLINE Double4 times(const Rows& R, double x, double y, double z) {
  return (R.x * all<Double4>(x) + R.y * all<Double4>(y)) + R.z * all<Double4>(z);
}

TOUCHSTONE_INLINE double largest_of(const double (&p)[3]) {
  const double x = __builtin_fabs(p[0]), y = __builtin_fabs(p[1]), z = __builtin_fabs(p[2]);
  const double xy = x > y ? x : y;
  return xy > z ? xy : z;
}

/// How the boxes of one pair are turned against each other.
struct PairTurn {
  Rows A;
  Double4 C[3];  ///< column j of R_A^T R_B

  TOUCHSTONE_INLINE PairTurn(const PoseRecord& X_WA, const PoseRecord& X_WB) : A(rows_of(X_WA)) {
    for (int j = 0; j < 3; ++j) C[j] = times(A, X_WB.R[3 * j], X_WB.R[3 * j + 1], X_WB.R[3 * j + 2]);
  }
};

/// The first pass of one pair, as far as the face normals.
struct CoarsePair {
  double size, position;
  Double4 margin, half_a, half_b;
  Double4 C[3], abs_C[3];  ///< column j of R_A^T R_B
  Double4 T_A;
  Double4 face_a, face_b;  ///< slacks of A's and B's axes
  Double4 face;            ///< the lesser of both
  bool counts;             ///< magnitudes are ordinary, and numbers

  TOUCHSTONE_INLINE CoarsePair(const PoseRecord& X_WA, const BoxRecord& a, const PoseRecord& X_WB,
                               const BoxRecord& b)
      : CoarsePair(PairTurn(X_WA, X_WB), X_WA, a, X_WB, b) {}
  TOUCHSTONE_INLINE CoarsePair(const PairTurn& turn, const PoseRecord& X_WA, const BoxRecord& a,
                               const PoseRecord& X_WB, const BoxRecord& b) {
    // The margin, from sizes and coordinates.
    const double tx = X_WB.p[0] - X_WA.p[0], ty = X_WB.p[1] - X_WA.p[1], tz = X_WB.p[2] - X_WA.p[2];
    size = (a.reach + b.reach) + ((__builtin_fabs(tx) + __builtin_fabs(ty)) + __builtin_fabs(tz));
    position = largest_of(X_WA.p) + largest_of(X_WB.p);
    margin = all<Double4>(kCoarse * size + kPositionRoundoffs * kU * position);

    // B in A's axes.
    const Rows &A = turn.A, B = rows_of(X_WB);
    half_a = Double4{a.half_extents[0], a.half_extents[1], a.half_extents[2], 0.0};
    half_b = Double4{b.half_extents[0], b.half_extents[1], b.half_extents[2], 0.0};
    for (int j = 0; j < 3; ++j) {
      C[j] = turn.C[j];
      abs_C[j] = magnitude(C[j]);
    }
    T_A = times(A, tx, ty, tz);

    // Figures so large that products could overflow do not count.
    const Double4 reach_b =
        (all<Double4>(b.half_extents[0]) * abs_C[0] + all<Double4>(b.half_extents[1]) * abs_C[1]) +
        all<Double4>(b.half_extents[2]) * abs_C[2];
    counts = (size + position < kOrdinaryHigh) & (in_three(reach_b < all<Double4>(kOrdinaryHigh)) == kThree);

    // The largest gap along the faces' normals of both.
    Double4 row[3];  // of C, for B's faces
    transpose_three(abs_C, row);
    const Double4 reach_a =
        (all<Double4>(a.half_extents[0]) * row[0] + all<Double4>(a.half_extents[1]) * row[1]) +
        all<Double4>(a.half_extents[2]) * row[2];
    const Double4 T_B = times(B, tx, ty, tz);
    face_a = (half_a + reach_b) - magnitude(T_A), face_b = (half_b + reach_a) - magnitude(T_B);
    face = least(face_a, face_b);
  }

  /// The slacks across A's edges and edge j of B, and the squares of these axes' lengths.
  struct Across {
    Double4 slack, length2;
  };
  TOUCHSTONE_INLINE Across across(int j, const BoxRecord& b) const {
    const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    const Double4 C1 = next(C[j]), C2 = after_next(C[j]);
    const Double4 radius_a = next(half_a) * magnitude(C2) + after_next(half_a) * magnitude(C1);
    const Double4 radius_b =
        all<Double4>(b.half_extents[j1]) * abs_C[j2] + all<Double4>(b.half_extents[j2]) * abs_C[j1];
    return {(radius_a + radius_b) - magnitude(after_next(T_A) * C1 - next(T_A) * C2), C1 * C1 + C2 * C2};
  }

  static constexpr unsigned kThree = 7;
  TOUCHSTONE_INLINE static unsigned in_three(Mask4 mask) { return bits(mask) & kThree; }

  /// Whether a face certainly separates.
  TOUCHSTONE_INLINE bool separates() const { return counts & (in_three(face < -margin) != 0); }
};

TOUCHSTONE_INLINE Certified certify_box_pair_inline(const PoseRecord& X_WA, const BoxRecord& a,
                                                    const PoseRecord& X_WB, const BoxRecord& b) {
  const CoarsePair s(X_WA, a, X_WB, b);
  Double4 slack = s.face;
  for (int j = 0; j < 3; ++j) slack = least(slack, s.across(j, b).slack);
  // No branch on the answer, which is unpredictable: the next call's loads need not wait for it.
  return verdict(s.counts & (s.in_three(slack < -s.margin) != 0),
                 s.counts & (s.in_three(slack > s.margin) == s.kThree));
}

// ---- Many pairs: lanes are pairs.

template <class Pack>
struct BoxLanes {
  Vector3Of<Pack> axis[3];
  Vector3Of<Pack> p;
  Pack half[3];
  Pack reach;
};

template <class Pack>
TOUCHSTONE_INLINE void gather_solid(const double* const (&poses)[Traits<Pack>::lanes],
                                    const double* const (&shapes)[Traits<Pack>::lanes], BoxLanes<Pack>& out) {
  Pack pose[12], shape[4];
  gather(poses, pose);
  gather(shapes, shape);
  for (int i = 0; i < 3; ++i) out.axis[i] = {pose[3 * i], pose[3 * i + 1], pose[3 * i + 2]};
  out.p = {pose[9], pose[10], pose[11]};
  for (int i = 0; i < 3; ++i) out.half[i] = shape[i];
  out.reach = shape[3];
}

/// The input of all passes.
template <class Pack>
struct BoxSlacks {
  Pack size, position;
  Pack abs_C[3][3];
  Pack face_a[3], face_b[3];
  Pack face;         // the least of the six
  Pack cross[3][3];  // one an axis
  MaskOf<Pack> ordinary;
};

template <class Pack>
TOUCHSTONE_INLINE void find_slacks(const BoxLanes<Pack>& A, const BoxLanes<Pack>& B, BoxSlacks<Pack>& out) {
  const Vector3Of<Pack> T = B.p - A.p;
  out.size = (A.reach + B.reach) + sum(T);
  out.position = largest(A.p) + largest(B.p);
  Pack C[3][3], T_A[3], T_B[3];
  for (int i = 0; i < 3; ++i) {
    T_A[i] = dot(A.axis[i], T);
    T_B[i] = dot(B.axis[i], T);
    for (int j = 0; j < 3; ++j) {
      C[i][j] = dot(A.axis[i], B.axis[j]);
      out.abs_C[i][j] = magnitude(C[i][j]);
    }
  }
  // The six face normals.
  const auto& abs_C = out.abs_C;
  out.face = all<Pack>(__builtin_inf());
  Pack reaches{};
  for (int i = 0; i < 3; ++i) {
    const Pack reach_b = (B.half[0] * abs_C[i][0] + B.half[1] * abs_C[i][1]) + B.half[2] * abs_C[i][2];
    reaches += reach_b;
    out.face_a[i] = (A.half[i] + reach_b) - magnitude(T_A[i]);
    out.face_b[i] =
        (B.half[i] + ((A.half[0] * abs_C[0][i] + A.half[1] * abs_C[1][i]) + A.half[2] * abs_C[2][i])) -
        magnitude(T_B[i]);
    out.face = least(out.face, least(out.face_a[i], out.face_b[i]));
  }
  // The nine cross products of edges.
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const Pack radius_a = A.half[i1] * abs_C[i2][j] + A.half[i2] * abs_C[i1][j];
      const Pack radius_b = B.half[j1] * abs_C[i][j2] + B.half[j2] * abs_C[i][j1];
      out.cross[i][j] = (radius_a + radius_b) - magnitude(T_A[i2] * C[i1][j] - T_A[i1] * C[i2][j]);
    }
  }
  // Within kOrdinaryHigh no product above over- or underflows harmfully.
  out.ordinary = (out.size + out.position) + reaches < all<Pack>(kOrdinaryHigh);
}

/// Over all axes.
template <class Pack>
TOUCHSTONE_INLINE Pack least_slack(const BoxSlacks<Pack>& s) {
  Pack slack = s.face;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) slack = least(slack, s.cross[i][j]);
  return slack;
}

/// orthonormality_defect() of the pose.
template <class Pack>
TOUCHSTONE_INLINE Pack defect_of(const Vector3Of<Pack> (&axis)[3]) {
  Pack defect{};
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      defect = greatest(magnitude(dot(axis[i], axis[j]) - all<Pack>(i == j ? 1.0 : 0.0)), defect);
  return defect;
}

/// Of the second pass, with measured delta.
template <class Pack>
struct CloseMargin {
  Pack defect, margin;

  TOUCHSTONE_INLINE CloseMargin(const BoxLanes<Pack>& A, const BoxLanes<Pack>& B, const BoxSlacks<Pack>& s) {
    defect = greatest(defect_of(A.axis), defect_of(B.axis)) + all<Pack>(6 * kU);
    margin = (all<Pack>(kDefectFactor) * defect + all<Pack>(kSizeRoundoffs * kU)) * s.size +
             all<Pack>(kPositionRoundoffs * kU) * s.position;
  }
};

/// At least the sine between edge i of A and j of B.
template <class Pack>
TOUCHSTONE_INLINE Pack sine_bound(const BoxSlacks<Pack>& s, int i, int j) {
  return (s.abs_C[i][(j + 1) % 3] + s.abs_C[i][(j + 2) % 3]) + all<Pack>(8 * kU);
}

/// The least slack of all axes but those across nearly parallel edges, and what leaving these out costs.
template <class Pack>
struct ParallelEdges {
  Pack slack, turn = Pack{};

  TOUCHSTONE_INLINE explicit ParallelEdges(const BoxSlacks<Pack>& s) : slack(s.face) {}

  TOUCHSTONE_INLINE void add(Pack cross, MaskOf<Pack> is_left_out, Pack sine, Pack defect) {
    turn += select<Pack>(is_left_out, sine + defect, Pack{});
    slack = select<Pack>(is_left_out, slack, least(slack, cross));
  }
  TOUCHSTONE_INLINE MaskOf<Pack> overlap(Pack margin, Pack size) const {
    return slack > margin + (all<Pack>(8.0) * turn) * size;
  }
};

/// The second pass of certify_boxes: measured delta, and parallel edges left out. @param lowest of all slacks
template <class Pack>
TOUCHSTONE_INLINE LaneVerdicts<Pack> certify_box_lanes_closely(const BoxLanes<Pack>& A,
                                                               const BoxLanes<Pack>& B,
                                                               const BoxSlacks<Pack>& s, Pack lowest) {
  const CloseMargin<Pack> close(A, B, s);
  ParallelEdges<Pack> edges(s);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Pack sine = sine_bound(s, i, j);
      const MaskOf<Pack> parallel = (s.abs_C[i][j] > all<Pack>(0.5)) & (sine < all<Pack>(kNearlyParallel));
      edges.add(s.cross[i][j], parallel, sine, close.defect);
    }
  }
  const MaskOf<Pack> separated = lowest < -close.margin;
  return {separated & s.ordinary, edges.overlap(close.margin, s.size) & s.ordinary};
}

/// Both passes, the second where the first leaves a lane open.
template <class Pack>
TOUCHSTONE_INLINE LaneVerdicts<Pack> certify_box_lanes(const BoxLanes<Pack>& A, const BoxLanes<Pack>& B) {
  BoxSlacks<Pack> s;
  find_slacks(A, B, s);
  const Pack margin = all<Pack>(kCoarse) * s.size + all<Pack>(kPositionRoundoffs * kU) * s.position;
  const Pack slack = least_slack(s);
  const LaneVerdicts<Pack> coarse = {(slack < -margin) & s.ordinary, (slack > margin) & s.ordinary};
  if (bits(~(coarse.separated | coarse.overlapping)) == 0) return coarse;
  const LaneVerdicts<Pack> close = certify_box_lanes_closely(A, B, s, slack);
  return {coarse.separated | close.separated, coarse.overlapping | close.overlapping};
}

/// With the bits of world_vertices(): the vertex on the sides that `sign` names.
template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> box_vertex(const Vector3Of<Pack> (&axis)[3], const Pack (&half)[3],
                                             const Vector3Of<Pack>& p, const Pack (&sign)[3]) {
  return (((sign[0] * half[0]) * axis[0] + (sign[1] * half[1]) * axis[1]) + (sign[2] * half[2]) * axis[2]) +
         p;
}

/// One pair, in all lanes.
template <class Pack>
TOUCHSTONE_INLINE Certified certify_one_of_many(const PoseRecord& X_WA, const BoxRecord& a,
                                                const PoseRecord& X_WB, const BoxRecord& b) {
  constexpr int kLanes = Traits<Pack>::lanes;
  const double *poses_a[kLanes], *poses_b[kLanes], *shapes_a[kLanes], *shapes_b[kLanes];
  for (int l = 0; l < kLanes; ++l) {
    poses_a[l] = X_WA.R, poses_b[l] = X_WB.R;
    shapes_a[l] = a.half_extents, shapes_b[l] = b.half_extents;
  }
  BoxLanes<Pack> A, B;
  gather_solid(poses_a, shapes_a, A);
  gather_solid(poses_b, shapes_b, B);
  const LaneVerdicts<Pack> verdicts = certify_box_lanes(A, B);
  return verdict((bits(verdicts.separated) & 1u) != 0, (bits(verdicts.overlapping) & 1u) != 0);
}

/// Whether a face's normal or the cross product of two edges shows a gap wider than `reach`: the first pass's
/// margin, and |L| <= 1 + 3 delta < 1 + kLongestAxis. Pairs so found are further apart than `reach` by 2^-15
/// size, which is far beyond the rounding of any distance.
template <class Pack>
TOUCHSTONE_INLINE LaneVerdicts<Pack> find_box_lanes_beyond(const BoxLanes<Pack>& A, const BoxLanes<Pack>& B,
                                                           double reach) {
  BoxSlacks<Pack> s;
  find_slacks(A, B, s);
  const Pack margin = all<Pack>(kCoarse) * s.size + all<Pack>(kPositionRoundoffs * kU) * s.position;
  const Pack gap = margin + all<Pack>(reach * (1.0 + kLongestAxis));
  return {(least_slack(s) < -gap) & s.ordinary, MaskOf<Pack>{}};
}

template <class Pack>
TOUCHSTONE_INLINE void find_boxes_beyond_inline(const PoseRecord* poses, const BoxRecord* shapes,
                                                const PairIndices* pairs, std::size_t count, double reach,
                                                Certified* out) {
  for_each_two_solids<Pack, BoxLanes>(
      poses, shapes, pairs, count, out,
      [reach](const auto& A, const auto& B) { return find_box_lanes_beyond(A, B, reach); });
}

template <class Pack>
TOUCHSTONE_INLINE void certify_boxes_inline(const PoseRecord* poses, const BoxRecord* shapes,
                                            const PairIndices* pairs, std::size_t count, Certified* out) {
  for_each_two_solids<Pack, BoxLanes>(poses, shapes, pairs, count, out,
                                      [](const auto& A, const auto& B) { return certify_box_lanes(A, B); });
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

#pragma once

#include "touchstone/contact_core/native/simd/resting_axis.hpp"

// depth_kernels.hpp for a single pair of boxes: lanes are the axes of one box, so that none is idle. Every
// value results from the same operations in the same order as in a batch, so the bits are the same.

namespace touchstone::native::TOUCHSTONE_ISA {

/// The result of search_pair_axes(): by code 3 k + lane, and over all. Where that stops apart, `code` is 0,
/// and where a face separates, the edges' entries are unset.
struct PairSearch {
  static constexpr int kRows = 5;
  Double4 length2[kRows], overlap[kRows];
  Double4 turn = {};  // by B's edge
  double least_slack = 0.0;
  int code = 0;

  TOUCHSTONE_INLINE void keep(int k, Double4 L2, Double4 overlap_of) {
    length2[k] = L2;
    overlap[k] = overlap_of;
  }

  /// Of the least overlap, or the greatest gap, as AxisSearch::choose() finds it: later axes only where they
  /// are better. Axes that are surely worse than some face, as most across edges are, are passed over: one of
  /// them that were the best so far would be replaced with that face, and be better than none after it.
  /// @param face_square the signed square of the faces' least overlap
  TOUCHSTONE_INLINE void choose(double face_square) {
    const Double4 limit = all<Double4>(near_limit(face_square));
    unsigned near = 0;
    for (int k = 0; k < kRows; ++k)
      near |= (bits(overlap[k] * magnitude(overlap[k]) <= limit * length2[k]) & 7u) << 4 * k;
    // Of faces that touch, which are flush mostly, none overlaps less than the first.
    constexpr unsigned kFaces = 0x77;
    if ((face_square == 0.0) & ((near & ~kFaces) == 0)) {
      near = bits(overlap[0] * overlap[0] <= Double4{}) & 7u;
      if (near == 0) near = bits(overlap[1] * overlap[1] <= Double4{}) << 4;
      code = code_at(__builtin_ctz(near));
      return;
    }
    double best_square = kInfinite, best_length2 = 1.0;
    for (; near != 0; near &= near - 1) {
      const int place = __builtin_ctz(near), k = place / 4, lane = place % 4;
      const double square = overlap[k][lane] * __builtin_fabs(overlap[k][lane]);
      if (!(square * best_length2 < best_square * length2[k][lane])) continue;
      best_square = square, best_length2 = length2[k][lane], code = code_at(place);
    }
  }

 private:
  TOUCHSTONE_INLINE static int code_at(int place) { return 3 * (place / 4) + place % 4; }
};

/// Refines short axes of edges, as AxisSearch::add_short(): of each of A's edges no more than one of B's is
/// that near to parallel, so one lane is enough for each. @param which the edge of B, or -1 @return slacks
TOUCHSTONE_INLINE Double4 refine_pair_axes(const BoxPair& boxes, const double* R_WB, const int (&which)[3],
                                           Double4 tie, Double4 margin, PairSearch& search) {
  // A lane for each edge of A, with its partner of B.
  Vector3Of<Double4> b = {};
  for (int i = 0; i < 3; ++i) {
    const int j = which[i] < 0 ? 0 : which[i];
    b.x[i] = R_WB[3 * j], b.y[i] = R_WB[3 * j + 1], b.z[i] = R_WB[3 * j + 2];
  }
  const auto widths = [&boxes](const Vector3Of<Double4>& L) {
    return half_width<Double4>(L, boxes.each[0], boxes.half[0]) +
           half_width<Double4>(L, boxes.each[1], boxes.half[1]);
  };
  const SearchedAxis<Double4> fine = refined_axis<Double4>(boxes.direction[0], b, boxes.T, widths);
  // Edges that are parallel have no axis; the turn that makes others parallel counts against the rest.
  const Double4 infinity = all<Double4>(kInfinite), length = square_root(fine.L2);
  const Mask4 none = fine.L2 <= all<Double4>(kNoAxis2);
  const Double4 turn = turn_by(fine.L);
  const Mask4 counts = (fine.slack < -margin * length) & (fine.L2 > all<Double4>(kThinSquare));
  const Double4 overlap =
      none ? infinity : (counts ? fine.slack : greatest(fine.slack, Double4{}) + tie * length);
  Double4 slack = none ? infinity : fine.slack / length;
  for (int i = 0; i < 3; ++i) {
    if (which[i] < 0) {
      slack[i] = kInfinite;
      continue;
    }
    const Mask4 at = kLaneNumbers == Mask4{} + static_cast<long long>(which[i]);
    const int row = 2 + i;
    search.overlap[row] = at ? all<Double4>(overlap[i]) : search.overlap[row];
    search.length2[row] = at ? all<Double4>(fine.L2[i]) : search.length2[row];
    if (none[i]) search.turn[which[i]] += turn[i];
  }
  return slack;
}

/// @param unit_size kU * size @param stop_apart whether the search may end with the faces where one separates
TOUCHSTONE_INLINE void search_pair_axes(const BoxPair& boxes, const double* R_WB, double unit_size,
                                        double margin_of, bool stop_apart, PairSearch& search) {
  const Double4 tie = all<Double4>(kTieRoundoffs * unit_size), margin = all<Double4>(margin_of);
  const Double4 slack_error = all<Double4>(kSlackRoundoffs * unit_size);
  const Double4 infinity = all<Double4>(kInfinite);
  // a_b[j]: |normal i of A . direction j of B|, lanes i; b_a[i]: |normal j of B . direction i of A|, lanes j.
  Double4 a_b[3], b_a[3], by_b[3];
  for (int k = 0; k < 3; ++k) a_b[k] = magnitude(dot(boxes.normal[0], boxes.each[1][k]));
  for (int k = 0; k < 3; ++k) b_a[k] = magnitude(dot(boxes.normal[1], boxes.each[0][k]));
  transpose_three(a_b, by_b);  // by_b[i]: lanes j
  Double4 least_slack = infinity, least_overlap = infinity;
  for (int s = 0; s < 2; ++s) {
    const Double4(&half)[3] = boxes.half[1 - s];
    const Double4(&products)[3] = s == 0 ? a_b : b_a;
    const Double4 reach = (half[0] * products[0] + half[1] * products[1]) + half[2] * products[2];
    const Double4 slack =
        (boxes.extents[s] * boxes.volume[s] + reach) - magnitude(dot(boxes.normal[s], boxes.T));
    const Double4 overlap = slack < -margin ? slack : greatest(slack, Double4{});
    least_slack = least(least_slack, slack), least_overlap = least(least_overlap, overlap);
    search.keep(s, dot(boxes.normal[s], boxes.normal[s]), overlap);
  }
  if (stop_apart && (bits(least_slack < -margin) & 7u) != 0) {
    search.least_slack = least_of_three(least_slack);
    return;
  }
  // Faces' normals are of length 1 to 2^-18, which the rest of kSurelyMore swallows.
  const double face = least_of_three(least_overlap);
  const Double4 best_square = all<Double4>(face * __builtin_fabs(face)), one = all<Double4>(1.0);
  const Double4(&half_a)[3] = boxes.half[0];
  const Double4 next_b = next(boxes.extents[1]), after_b = after_next(boxes.extents[1]);
  int which[3] = {-1, -1, -1};
  unsigned any_short = 0;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    const Vector3Of<Double4> L = cross(boxes.each[0][i], boxes.direction[1]);
    const Double4 radius_a = half_a[i1] * by_b[i2] + half_a[i2] * by_b[i1];
    const Double4 radius_b = next_b * after_next(b_a[i]) + after_b * next(b_a[i]);
    const Double4 slack = (radius_a + radius_b) - magnitude(dot(L, boxes.T)), L2 = dot(L, L);
    const Mask4 is_short = L2 < all<Double4>(kShortAxis2), none = L2 <= all<Double4>(kSurelyNoAxis2);
    const Mask4 loses = is_short & surely_loses<Double4>(slack, L2, slack_error, best_square, one);
    const unsigned shorts = bits(is_short & ~none & ~loses) & 7u;
    if (shorts != 0) which[i] = __builtin_ctz(shorts);
    any_short |= shorts;
    if ((bits(none) & 7u) != 0) search.turn = search.turn + (none ? turn_by(L) : Double4{});
    least_slack = least(least_slack, is_short ? infinity : slack);
    search.keep(2 + i, L2,
                none | loses ? infinity : (slack < -margin ? slack : greatest(slack, Double4{}) + tie));
  }
  if (any_short != 0)
    least_slack = least(least_slack, refine_pair_axes(boxes, R_WB, which, tie, margin, search));
  search.least_slack = least_of_three(least_slack);
  if (!(stop_apart && search.least_slack < -margin_of)) search.choose(face * __builtin_fabs(face));
}

/// Of depth_along() one axis.
struct PairDepth {
  double separation;
  Double4 n, p_A;  // coordinates in lanes
  bool has_witness;
};

/// The vertex that `sign` names, with the bits of world_vertices().
TOUCHSTONE_INLINE Double4 signed_vertex(const PoseRecord& X, Double4 sign, Double4 half) {
  const Double4 part = sign * half;
  return ((all<Double4>(part[0]) * in_lanes(X, 0) + all<Double4>(part[1]) * in_lanes(X, 1)) +
          all<Double4>(part[2]) * in_lanes(X, 2)) +
         in_lanes(X.p);
}

/// depth_along() a face's normal.
TOUCHSTONE_INLINE PairDepth depth_along_face(const PoseRecord* const (&X)[2], const BoxPair& boxes, int code,
                                             double level, double tolerance) {
  const int with_face = code < 3 ? 0 : 1, other = 1 - with_face;  // whose face it is
  const Double4 axis = in_lanes(boxes.normal[with_face], code % 3);
  const double T[3] = {boxes.T.x[0], boxes.T.y[0], boxes.T.z[0]};
  const double forward = dot_lanes(axis, in_lanes(T)) >= 0.0 ? 1.0 : -1.0;
  PairDepth out;
  out.n = all<Double4>(forward / square_root(Double2{dot_lanes(axis, axis), 1.0})[0]) * axis;
  const Vector3Of<Double4> n = spread(out.n);
  Double4 sign[2], projection[2], vertex[2];
  const Double4 one = all<Double4>(1.0);
  for (int s = 0; s < 2; ++s) {
    const Double4 along = dot(boxes.direction[s], n);
    projection[s] = magnitude(along);
    sign[s] = s == 0 ? (along >= Double4{} ? one : -one) : (along >= Double4{} ? -one : one);
    vertex[s] = signed_vertex(*X[s], sign[s], boxes.extents[s]);
  }
  const double raw = dot_lanes(vertex[1] - vertex[0], out.n);
  out.separation = raw < 0.0 ? raw : 0.0;
  // As face_witness().
  const Double4 centre = in_lanes(X[with_face]->p) + Double4{}, inward = -sign[other];
  const Double4 twice = all<Double4>(2.0) * boxes.extents[other];
  const Double4 toward = inward * dot(spread(centre - vertex[other]), boxes.direction[other]);
  const Double4 along = least(greatest(toward, Double4{}), twice);
  const Double4 by = inward * (projection[other] * twice <= all<Double4>(level) ? along : Double4{});
  Double4 p = vertex[other];
  for (int k = 0; k < 3; ++k) p = p + all<Double4>(by[k]) * in_lanes(*X[other], k);
  const Double4 offset = all<Double4>(out.separation) * out.n;
  const Double4 moved = with_face == 1 ? p + offset : p - offset;
  out.p_A = with_face == 1 ? p : moved;
  const Double4 off = magnitude(dot(boxes.normal[with_face], spread(moved - centre)));
  const Double4 most = (boxes.extents[with_face] + all<Double4>(tolerance)) * boxes.volume[with_face];
  out.has_witness = (bits(off <= most) & 7u) == 7u;
  return out;
}

struct EdgeNumbers {
  int a, b;
};
TOUCHSTONE_INLINE EdgeNumbers edge_of(int code) { return {(code - 6) / 3, code % 3}; }

/// Across both edges, in lanes.
TOUCHSTONE_INLINE Double4 edges_axis(const PoseRecord* const (&X)[2], EdgeNumbers edge) {
  return cross_lanes(in_lanes(*X[0], edge.a), in_lanes(*X[1], edge.b));
}
TOUCHSTONE_INLINE bool is_short(Double4 axis) { return dot_lanes(axis, axis) < kShortAxis2; }

/// depth_along() an axis across two edges, no short one.
TOUCHSTONE_INLINE PairDepth depth_along_edges(const PoseRecord* const (&X)[2], const BoxPair& boxes,
                                              const BoxRecord* const (&box)[2], EdgeNumbers edges,
                                              double tolerance) {
  const Double4 axis = edges_axis(X, edges);
  const int edge[2] = {edges.a, edges.b};
  const double T[3] = {boxes.T.x[0], boxes.T.y[0], boxes.T.z[0]};
  const double forward = dot_lanes(axis, in_lanes(T)) >= 0.0 ? 1.0 : -1.0;
  PairDepth out;
  out.n = all<Double4>(forward / square_root(Double2{dot_lanes(axis, axis), 1.0})[0]) * axis;
  const Vector3Of<Double4> n = spread(out.n);
  // The supporting vertices, and the edges from there inwards.
  Double4 vertex[2], inward[2];
  double twice[2];
  const Double4 one = all<Double4>(1.0);
  for (int s = 0; s < 2; ++s) {
    const Mask4 behind = dot(boxes.direction[s], n) >= Double4{};
    const Double4 sign = s == 0 ? (behind ? one : -one) : (behind ? -one : one);
    vertex[s] = signed_vertex(*X[s], sign, boxes.extents[s]);
    const bool is_low = ((bits(behind) >> edge[s] & 1u) != 0) == (s == 1);
    inward[s] = all<Double4>(is_low ? 1.0 : -1.0) * in_lanes(*X[s], edge[s]);
    twice[s] = 2.0 * box[s]->half_extents[edge[s]];
  }
  const Double4 between = vertex[1] - vertex[0];
  const double raw = dot_lanes(between, out.n);
  out.separation = raw < 0.0 ? raw : 0.0;
  // As edge_witness().
  const Double4 b_n = cross_lanes(inward[1], out.n), a_n = cross_lanes(inward[0], out.n);
  const Double2 along =
      Double2{dot_lanes(between, b_n), dot_lanes(between, a_n)} / all<Double2>(dot_lanes(inward[0], b_n));
  const Double2 on = clamped<Double2>(along, Double2{twice[0], twice[1]});
  out.p_A = vertex[0] + all<Double4>(on[0]) * inward[0];
  out.has_witness = bits(magnitude(along - on) <= all<Double2>(tolerance)) == 3u;
  return out;
}

/// depth_along() any axis, with idle lanes: those across edges that are nearly parallel.
TOUCHSTONE_INLINE void depth_along_axis(const PoseRecord* const (&X)[2], const BoxRecord* const (&box)[2],
                                        const PairSearch& found, DepthRecord* out) {
  BoxSolid<Double2> A, B;
  A.read({X[0]->R, X[0]->R}, {box[0]->half_extents, box[0]->half_extents});
  B.read({X[1]->R, X[1]->R}, {box[1]->half_extents, box[1]->half_extents});
  const DepthScale<Double2> scale(A, B);
  AxisSearch<Double2> search;
  search.margin = scale.margin();
  search.least_slack = all<Double2>(found.least_slack);
  for (int j = 0; j < 3; ++j) search.turn[j] = all<Double2>(found.turn[j]);
  search.code = all<Double2>(found.code);
  const Normals<Double2> normal_a(A), normal_b(B);
  write<Double2>(depth_along<BoxSolid<Double2>, Double2>(A, normal_a, B, normal_b, scale, search), 1, out);
}

/// The axis that search_pair_axes() surely chooses, from the first pass of CoarsePair, and the class; code -1
/// where that pass leaves one of the two open.
///
/// Its slacks s' are within 40 delta size + 48 u size < 2^-14 size of those s that the search has: both are
/// within 14 delta size of those of the nearest rotations (box_box_overlap.cpp), and cross axes are replaced
/// at another 6 delta size. Squares of lengths |L'| are within 12 delta < 2^-16. No edges here are as near to
/// parallel as the search's short axes, |L'|^2 > 2^-7 - 2^-14, so that s' / |L'| is off by 2^-10 size from
/// the slack and by another 2^-10 size from the length; two axes together by 2^-8 size. Where all others lie
/// 2^-8 size above the least, the search chooses that; and slacks beyond 2^-13 size + 8 u P are beyond its
/// margins.
struct SureAxis {
  static constexpr double kApart = 0x1p-8, kSlackError = 0x1p-13, kNotParallel = 1.0 - 0x1p-8;
  int code = -1;
  bool is_apart = false;  ///< by one of the 15 axes

  TOUCHSTONE_INLINE SureAxis(const CoarsePair& coarse, const BoxRecord& b) {
    // Of nearly parallel edges, and of pairs that nearly touch with a face, the search tells more.
    const double error = kSlackError * coarse.size + 2.0 * kPositionRoundoffs * kU * coarse.position;
    const Double4 steepest = greatest(greatest(coarse.abs_C[0], coarse.abs_C[1]), coarse.abs_C[2]);
    const Mask4 tells =
        (steepest <= all<Double4>(kNotParallel)) & (magnitude(coarse.face) > all<Double4>(error));
    if (CoarsePair::in_three(tells) != CoarsePair::kThree) return;
    // Squares of all overlaps, or gaps below 0: by A's faces, B's, and B's edges.
    Double4 square[5] = {coarse.face_a * magnitude(coarse.face_a), coarse.face_b * magnitude(coarse.face_b)};
    Double4 least_slack = coarse.face, least_square = least(square[0], square[1]);
    for (int j = 0; j < 3; ++j) {
      const auto [slack, length2] = coarse.across(j, b);
      square[2 + j] = slack * magnitude(slack) / length2;
      least_slack = least(least_slack, slack), least_square = least(least_square, square[2 + j]);
    }
    is_apart = coarse.counts & (CoarsePair::in_three(least_slack < -coarse.margin) != 0);
    // The least one, if no other is near it.
    const double lowest = least_of_three(least_square);
    const double root = square_root(Double2{__builtin_fabs(lowest), 1.0})[0];
    const double reach = (lowest < 0.0 ? -root : root) + kApart * coarse.size;
    const Double4 limit = all<Double4>(reach * __builtin_fabs(reach));
    unsigned near = 0;
    for (int k = 0; k < 5; ++k) near |= CoarsePair::in_three(square[k] <= limit) << 3 * k;
    if (!(coarse.counts & (near != 0) & ((near & (near - 1)) == 0) &
          (CoarsePair::in_three(magnitude(least_slack) > all<Double4>(error)) == CoarsePair::kThree)))
      return;
    const int place = __builtin_ctz(near);
    code = place < 6 ? place : 6 + 3 * (place % 3) + (place - 6) / 3;
  }
};

TOUCHSTONE_INLINE void write_depth(const PairDepth& depth, DepthRecord* out) {
  // In two stores, each of which whole vectors may be loaded from at once.
  store(Double4{depth.separation, depth.n[0], depth.n[1], depth.n[2]}, (double*)out);
  store(__builtin_shufflevector(depth.p_A, depth.p_A, 0, 1), out->p_A);
  out->p_A[2] = depth.p_A[2];
  out->known = depth_known(true, depth.has_witness);
}

/// Boxes that rest on each other, face on face (resting_axis.hpp). False where that does not tell.
[[gnu::noinline]] inline bool compute_resting_depth(const PoseRecord& X_WA, const BoxRecord& a,
                                                    const PoseRecord& X_WB, const BoxRecord& b,
                                                    DepthRecord* out) {
  const PoseRecord* const X[2] = {&X_WA, &X_WB};
  const BoxRecord* const box[2] = {&a, &b};
  const BoxPair boxes(X, box);
  const PairFaceAxes faces(boxes);
  const double size = (a.reach + b.reach) + sum(boxes.T)[0];
  const double position = largest_of(X_WA.p) + largest_of(X_WB.p);
  const double unit_size = kU * size, unit_position = kU * position;
  const int code =
      find_resting_axis({boxes, faces, least_of_three(least(faces.slack[0], faces.slack[1])), size,
                         kParallelepipedRoundoffs * unit_size + kPositionRoundoffs * unit_position});
  if (code < 0 || !(size + position < kOrdinaryHigh)) return false;
  out->certified = Certified::overlapping;
  out->axis = static_cast<std::uint8_t>(code);
  const double tolerance = kWitnessRoundoffs * (unit_size + unit_position);
  write_depth(code < 6 ? depth_along_face(X, boxes, code, kLevelRoundoffs * unit_size, tolerance)
                       : depth_along_edges(X, boxes, box, edge_of(code), tolerance),
              out);
  return true;
}

TOUCHSTONE_INLINE void compute_box_pair_depth_inline(const PoseRecord& X_WA, const BoxRecord& a,
                                                     const PoseRecord& X_WB, const BoxRecord& b,
                                                     PairNeed need, DepthRecord* out) {
  int code = -1;
  if (need != PairNeed::distance) {
    // Most boxes in contact rest on each other.
    const PairTurn turn(X_WA, X_WB);
    if (are_flat(turn) && compute_resting_depth(X_WA, a, X_WB, b, out)) return;
    // Most pairs that are apart are so along a face's normal, which a third of the work tells. Where
    // distances are asked for, that work would come on top for flush pairs, which the search decides.
    if (need == PairNeed::contacts) {
      out->known = DepthKnown::nothing;
      out->certified = Certified::separated;
      const CoarsePair coarse(turn, X_WA, a, X_WB, b);
      if (coarse.separates()) return;
      const SureAxis sure(coarse, b);
      if (sure.is_apart) return;
      code = sure.code;
    }
  }

  out->known = DepthKnown::nothing;
  const PoseRecord* const X[2] = {&X_WA, &X_WB};
  const BoxRecord* const box[2] = {&a, &b};
  const BoxPair boxes(X, box);
  const double size = (a.reach + b.reach) + sum(boxes.T)[0];
  const double position = largest_of(X_WA.p) + largest_of(X_WB.p);
  const double unit_size = kU * size, unit_position = kU * position;
  const double tolerance = kWitnessRoundoffs * (unit_size + unit_position);
  if (code >= 0) {
    out->axis = static_cast<std::uint8_t>(code);
    out->certified = Certified::overlapping;
  } else {
    // The search tells.
    const double margin = kParallelepipedRoundoffs * unit_size + kPositionRoundoffs * unit_position;
    PairSearch search;
    search_pair_axes(boxes, X_WB.R, unit_size, margin, need == PairNeed::contacts, search);
    const bool ordinary = size + position < kOrdinaryHigh;
    const double turn = (search.turn[0] + search.turn[1]) + search.turn[2];
    const bool separated = search.least_slack < -margin && ordinary;
    out->certified = verdict(separated, search.least_slack > margin + turn * size && ordinary);
    code = search.code;
    out->axis = static_cast<std::uint8_t>(code);
    if (!ordinary || separated) return;
    if (code >= 6 && is_short(edges_axis(X, edge_of(code)))) return depth_along_axis(X, box, search, out);
  }
  // Along a face's normal, or across two edges.
  write_depth(code < 6 ? depth_along_face(X, boxes, code, kLevelRoundoffs * unit_size, tolerance)
                       : depth_along_edges(X, boxes, box, edge_of(code), tolerance),
              out);
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

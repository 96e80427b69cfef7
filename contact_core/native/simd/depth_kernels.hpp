#pragma once

#include "contact_core/native/simd/box_kernels.hpp"
#include "contact_core/native/simd/exact_products.hpp"
#include "contact_core/native/simd/line_crossing.hpp"
#include "contact_core/native/simd/parallelepiped_kernels.hpp"

// Depth, normal and witness points of boxes and parallelepipeds that overlap, pairs in lanes: the least
// overlap over 15 axes in closed form, then the separation of the two vertices that support the chosen axis.
//
// Notation. u = 2^-53. A_i, B_j: unit edge directions in the world (a box's are R's columns), their half
// lengths, c_A and c_B the centres; T = c_B - c_A, t = |T|_1, h the sum of all half lengths; P = |p_A|_inf +
// |p_B|_inf; D both deviations; size = h + t. Nothing is assumed about the directions' orthogonality. The
// axes L are nA_i = A_i+1 x A_i+2, nB_j and A_i x B_j, |L| <= 1 + 2^-19; the slack is s(L) = r_A + r_B - |T .
// L| and the overlap along L is s / |L|.
//
// The hulls of the rounded world vertices are within e = 32 u size + 4 u P + 2 D (Hausdorff, both together)
// of the solids that A_i, B_j and T span exactly (box_box_overlap.cpp, parallelepiped_overlap.cpp). A product
// L is off by 2 u a coordinate, a triple product of directions by 7 u, T . L by 8 u t, so a slack by E = 16 u
// size at most. Hence with m = 64 u size + 4 u P + 2 D >= e + E: s < -m on any axis certifies separation, s >
// m on all overlap. Edges at a sine below 2^-4 get their axis from exact products, right to 2 u |L|, and the
// slack from its own projections: s / |L| then is off by E at most, and is what is compared with m. Below 8 u
// (4 u, where rounded products are enough to tell) an axis carries no direction; leaving it out turns B by at
// most twice the sine and changes every other slack by at most 4 times that times size (box_box_overlap.cpp),
// so the others must exceed m by 8 sines times size for each. A sine is at most |L|_1 + 8 u.
//
// Choice. Overlaps are compared by the squares of s / |L|, without a division; a slack below 0, of pairs that
// touch to rounding, counts as 0. An axis has an overlap right to (E + e) / 2^-4 at most, and rarely off by
// more than 2 u size; of axes closer than that any is right to as much. Cross axes are taken when better than
// face axes by 4 u size, so that ties are decided for faces. A face's axis with |L| < 2^-4, of forms, is
// never taken: when its overlap less E could be the least, the pair is left to the scalar road. The facet of
// an axis left out is no wider than 8 u times the shorter edge, so its neighbours are as near to that.
//
// Depth. n = +-L / |L|; the vertices that support it are found by the signs of n . A_i and n . B_j, formed as
// world_vertices() does, and the separation is n . (v_B - v_A): that of the hulls along n to e.
//
// Witness. On a face's axis: the other's supporting vertex, moved along its edges that lie level with the
// face towards the face's centre; on a cross axis: where the two supporting edges come nearest. It counts
// when it lies on both to 16 u (size + P) along each edge's direction.

namespace touchstone::native::TOUCHSTONE_ISA {

constexpr double kSlackRoundoffs = 16.0;
constexpr double kTieRoundoffs = 4.0;
constexpr double kDeviationRoundoffs = 8.0;
constexpr double kLevelRoundoffs = 4.0;
constexpr double kWitnessRoundoffs = 16.0;
constexpr double kShortAxis2 = 0x1p-8;
constexpr double kTurn = 8.0;
constexpr double kSineRoundoffs = 8.0;
constexpr double kNoAxis2 = 64 * kU * kU;
/// Short of which an axis from rounded products is off by less than what is missing to that.
constexpr double kSurelyNoAxis2 = 16 * kU * kU;

// ---- The solids in lanes

template <class Pack>
struct DepthSolid {
  Vector3Of<Pack> direction[3];
  Pack half[3];
  Pack reach;              // their sum
  Vector3Of<Pack> p;       // of the pose
  Vector3Of<Pack> centre;  // less p, in W
  Pack centre_sum;
  Pack deviation;
};

template <class Pack>
struct BoxSolid : DepthSolid<Pack> {
  TOUCHSTONE_INLINE void read(const double* const (&poses)[Traits<Pack>::lanes],
                              const double* const (&shapes)[Traits<Pack>::lanes]) {
    Pack pose[12], shape[4];
    gather(poses, pose);
    gather(shapes, shape);
    for (int i = 0; i < 3; ++i) this->direction[i] = {pose[3 * i], pose[3 * i + 1], pose[3 * i + 2]};
    this->p = {pose[9], pose[10], pose[11]};
    for (int i = 0; i < 3; ++i) this->half[i] = shape[i];
    this->reach = shape[3];
    this->centre = {Pack{}, Pack{}, Pack{}};
    this->centre_sum = this->deviation = Pack{};
  }

  /// With the bits of world_vertices().
  TOUCHSTONE_INLINE Vector3Of<Pack> vertex(const Pack (&sign)[3]) const {
    return (((sign[0] * this->half[0]) * this->direction[0] +
             (sign[1] * this->half[1]) * this->direction[1]) +
            (sign[2] * this->half[2]) * this->direction[2]) +
           this->p;
  }
};

template <class Pack>
struct FormSolid : DepthSolid<Pack> {
  Vector3Of<Pack> column[3];
  const double* record[Traits<Pack>::lanes];

  TOUCHSTONE_INLINE void read(const double* const (&poses)[Traits<Pack>::lanes],
                              const double* const (&shapes)[Traits<Pack>::lanes]) {
    Pack pose[12], shape[16];
    gather(poses, pose);
    gather(shapes, shape);
    for (int i = 0; i < 3; ++i) column[i] = {pose[3 * i], pose[3 * i + 1], pose[3 * i + 2]};
    this->p = {pose[9], pose[10], pose[11]};
    for (int i = 0; i < 3; ++i) {
      this->direction[i] = rotate(column, Vector3Of<Pack>{shape[3 * i], shape[3 * i + 1], shape[3 * i + 2]});
      this->half[i] = shape[9 + i];
    }
    this->reach = (this->half[0] + this->half[1]) + this->half[2];
    const Vector3Of<Pack> middle = {shape[12], shape[13], shape[14]};
    this->centre = rotate(column, middle);
    this->centre_sum = sum(middle);
    this->deviation = shape[15];
    for (int l = 0; l < Traits<Pack>::lanes; ++l) record[l] = shapes[l];
  }

  /// With the bits of world_vertices().
  TOUCHSTONE_INLINE Vector3Of<Pack> vertex(const Pack (&sign)[3]) const {
    constexpr int kVertices = 16;  // where FormRecord::x begins
    const unsigned x = bits(sign[0] > Pack{}), y = bits(sign[1] > Pack{}), z = bits(sign[2] > Pack{});
    double local[3][Traits<Pack>::lanes];
    for (int l = 0; l < Traits<Pack>::lanes; ++l) {
      const unsigned i = (x >> l & 1u) << 2 | (y >> l & 1u) << 1 | (z >> l & 1u);
      for (int k = 0; k < 3; ++k) local[k][l] = record[l][kVertices + 8 * k + static_cast<int>(i)];
    }
    return rotate(column, Vector3Of<Pack>{load<Pack>(local[0]), load<Pack>(local[1]), load<Pack>(local[2])}) +
           this->p;
  }
};

// ---- The axis

/// One of three, by lane.
template <class Pack>
struct OneOfThree {
  MaskOf<Pack> first, second;

  TOUCHSTONE_INLINE Vector3Of<Pack> of(const Vector3Of<Pack> (&v)[3]) const {
    return select<Pack>(first, v[0], select<Pack>(second, v[1], v[2]));
  }
  TOUCHSTONE_INLINE Pack of(const Pack (&p)[3]) const { return first ? p[0] : (second ? p[1] : p[2]); }
};

/// By how much, of the size, other slacks change when the edges that span L are made parallel.
template <class Pack>
TOUCHSTONE_INLINE Pack turn_by(const Vector3Of<Pack>& L) {
  return all<Pack>(kTurn) * (sum(L) + all<Pack>(kSineRoundoffs * kU));
}

template <class Pack>
struct SearchedAxis {
  Vector3Of<Pack> L;
  Pack slack;
  Pack L2;
  Pack overlap;  ///< times |L|, with its handicap
};

template <class Pack>
struct AxisSearch {
  Pack slack_error, tie, margin;
  Pack least_slack = all<Pack>(__builtin_inf());
  Pack turn[3] = {};  // by B's edge
  // Of the least overlap so far: (overlap |L|)^2 and |L|^2.
  Pack best_square = all<Pack>(__builtin_inf());
  Pack best_length2 = all<Pack>(1.0);
  Pack code = Pack{};

  TOUCHSTONE_INLINE void add_face(const Vector3Of<Pack>& L, Pack slack, double number) {
    SearchedAxis<Pack> axis = {L, slack, dot(L, L), greatest(slack, Pack{})};
    const MaskOf<Pack> is_short = axis.L2 < all<Pack>(kShortAxis2);
    least_slack = least(least_slack, slack);
    if (__builtin_expect(bits(is_short) != 0, 0)) {
      const Pack uncertain = greatest(slack - slack_error, Pack{});
      axis.overlap = is_short ? uncertain : axis.overlap;
      axis.overlap = axis.L2 <= all<Pack>(kNoAxis2) ? all<Pack>(__builtin_inf()) : axis.overlap;
    }
    choose(axis, number);
  }

  /// @param refine the same axis from exact products
  template <class Refine>
  TOUCHSTONE_INLINE void add_edges(const Vector3Of<Pack>& L, Pack slack, int i, int j, const Refine& refine) {
    SearchedAxis<Pack> axis = {L, slack, dot(L, L), greatest(slack, Pack{}) + tie};
    const MaskOf<Pack> is_short = axis.L2 < all<Pack>(kShortAxis2);
    if (__builtin_expect(bits(is_short) != 0, 0)) {
      const MaskOf<Pack> none = axis.L2 <= all<Pack>(kSurelyNoAxis2);
      SearchedAxis<Pack> fine = axis;
      if (bits(is_short & ~none) != 0) fine = refine();
      add_short(fine, is_short, none, turn[j], axis);
    } else {
      least_slack = least(least_slack, axis.slack);
    }
    choose(axis, 6 + 3 * i + j);
  }

  TOUCHSTONE_INLINE void add_short(const SearchedAxis<Pack>& refined, MaskOf<Pack> is_short,
                                   MaskOf<Pack> surely_none, Pack& turn_j, SearchedAxis<Pack>& axis) {
    const Pack length = square_root(refined.L2);
    const MaskOf<Pack> none = surely_none | (is_short & (refined.L2 <= all<Pack>(kNoAxis2)));
    const Pack slack = is_short ? refined.slack / length : axis.slack;
    least_slack = none ? least_slack : least(least_slack, slack);
    turn_j = turn_j + (none ? turn_by(select<Pack>(surely_none, axis.L, refined.L)) : Pack{});
    const Pack overlap = greatest(refined.slack, Pack{}) + tie * length;
    axis.overlap = is_short ? (none ? all<Pack>(__builtin_inf()) : overlap) : axis.overlap;
    axis.L2 = is_short ? (surely_none ? axis.L2 : refined.L2) : axis.L2;
  }

  TOUCHSTONE_INLINE void choose(const SearchedAxis<Pack>& axis, double number) {
    const Pack square = axis.overlap * axis.overlap;
    const MaskOf<Pack> better = square * best_length2 < best_square * axis.L2;
    best_square = better ? square : best_square;
    best_length2 = better ? axis.L2 : best_length2;
    code = better ? all<Pack>(number) : code;
  }
};

/// Half the solid's width along L.
template <class Pack>
TOUCHSTONE_INLINE Pack half_width(const Vector3Of<Pack>& L, const Vector3Of<Pack> (&direction)[3],
                                  const Pack (&half)[3]) {
  return (half[0] * magnitude(dot(L, direction[0])) + half[1] * magnitude(dot(L, direction[1]))) +
         half[2] * magnitude(dot(L, direction[2]));
}

/// The axis across two edges from exact products, and its slack from its own projections. @param widths L ->
/// the sum of both half widths
template <class Pack, class Widths>
TOUCHSTONE_INLINE SearchedAxis<Pack> refined_axis(const Vector3Of<Pack>& a, const Vector3Of<Pack>& b,
                                                  const Vector3Of<Pack>& T, const Widths& widths) {
  const Vector3Of<Pack> L = accurate_cross(a, b);
  return {L, widths(L) - magnitude(dot(L, T)), dot(L, L), Pack{}};
}

template <class Pack>
struct Normals {
  Vector3Of<Pack> of[3];
  Pack volume;  // |direction_i . normal_i|

  TOUCHSTONE_INLINE explicit Normals(const DepthSolid<Pack>& s) {
    for (int i = 0; i < 3; ++i) of[i] = cross(s.direction[(i + 1) % 3], s.direction[(i + 2) % 3]);
    volume = magnitude(dot(of[0], s.direction[0]));
  }
};

/// Codes 0-2: A's faces, 3-5: B's, 6 + 3 i + j: edge i of A, j of B.
template <class Pack>
TOUCHSTONE_INLINE void search_axes(const DepthSolid<Pack>& A, const Normals<Pack>& normal_a,
                                   const DepthSolid<Pack>& B, const Normals<Pack>& normal_b,
                                   const Vector3Of<Pack>& T, AxisSearch<Pack>& search) {
  Pack a_b[3][3], b_a[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      a_b[i][j] = magnitude(dot(normal_a.of[i], B.direction[j]));
      b_a[i][j] = magnitude(dot(normal_b.of[i], A.direction[j]));
    }
  }
  for (int i = 0; i < 3; ++i) {
    const Pack reach = (B.half[0] * a_b[i][0] + B.half[1] * a_b[i][1]) + B.half[2] * a_b[i][2];
    search.add_face(normal_a.of[i], (A.half[i] * normal_a.volume + reach) - magnitude(dot(normal_a.of[i], T)),
                    i);
  }
  for (int j = 0; j < 3; ++j) {
    const Pack reach = (A.half[0] * b_a[j][0] + A.half[1] * b_a[j][1]) + A.half[2] * b_a[j][2];
    search.add_face(normal_b.of[j], (B.half[j] * normal_b.volume + reach) - magnitude(dot(normal_b.of[j], T)),
                    3 + j);
  }
  const auto widths = [&](const Vector3Of<Pack>& L) {
    return half_width<Pack>(L, A.direction, A.half) + half_width<Pack>(L, B.direction, B.half);
  };
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const Vector3Of<Pack> L = cross(A.direction[i], B.direction[j]);
      // L . A_k is up to sign B_j . normal of A opposite both; likewise for B.
      const Pack radius_a = A.half[i1] * a_b[i2][j] + A.half[i2] * a_b[i1][j];
      const Pack radius_b = B.half[j1] * b_a[j2][i] + B.half[j2] * b_a[j1][i];
      search.add_edges(L, (radius_a + radius_b) - magnitude(dot(L, T)), i, j,
                       [&] { return refined_axis<Pack>(A.direction[i], B.direction[j], T, widths); });
    }
  }
}

/// Which edge of A, and of B, an edge code names.
template <class Pack>
TOUCHSTONE_INLINE OneOfThree<Pack> row_of(Pack code) {
  return {code < all<Pack>(9), code < all<Pack>(12)};
}

template <class Pack>
TOUCHSTONE_INLINE OneOfThree<Pack> column_of(Pack code) {
  return {(code == all<Pack>(6)) | (code == all<Pack>(9)) | (code == all<Pack>(12)),
          (code == all<Pack>(7)) | (code == all<Pack>(10)) | (code == all<Pack>(13))};
}

/// The axis that a code names, as the search formed it.
template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> axis_of(Pack code, const DepthSolid<Pack>& A, const Normals<Pack>& normal_a,
                                          const DepthSolid<Pack>& B, const Normals<Pack>& normal_b) {
  const OneOfThree<Pack> face_a = {code == Pack{}, code == all<Pack>(1)};
  const OneOfThree<Pack> face_b = {code == all<Pack>(3), code == all<Pack>(4)};
  const Vector3Of<Pack> face =
      select<Pack>(code < all<Pack>(3), face_a.of(normal_a.of), face_b.of(normal_b.of));
  const MaskOf<Pack> is_face = code < all<Pack>(6);
  if (bits(~is_face) == 0) return face;
  const Vector3Of<Pack> a = row_of(code).of(A.direction), b = column_of(code).of(B.direction);
  const Vector3Of<Pack> edges = cross(a, b);
  const MaskOf<Pack> is_short = dot(edges, edges) < all<Pack>(kShortAxis2);
  if (__builtin_expect(bits(is_short) == 0, 1)) return select<Pack>(is_face, face, edges);
  return select<Pack>(is_face, face, select<Pack>(is_short, accurate_cross(a, b), edges));
}

// ---- Depth and witness points

template <class Pack>
TOUCHSTONE_INLINE Pack clamped(Pack p, Pack high) {
  return least(greatest(p, Pack{}), high);
}

/// +1 where n . direction is at least zero, -1 elsewhere; `projection`: |n . direction|.
template <class Pack>
TOUCHSTONE_INLINE void support_signs(const DepthSolid<Pack>& s, const Vector3Of<Pack>& n, Pack (&sign)[3],
                                     Pack (&projection)[3]) {
  for (int i = 0; i < 3; ++i) {
    const Pack along = dot(s.direction[i], n);
    projection[i] = magnitude(along);
    sign[i] = along >= Pack{} ? all<Pack>(1.0) : all<Pack>(-1.0);
  }
}

template <class Pack>
struct DepthLanes {
  MaskOf<Pack> separated, overlapping, has_axis, has_witness;
  Pack separation;
  Vector3Of<Pack> n, p_A;
  Pack code;
};

/// What both of an overlapping pair's supporting vertices tell.
template <class Pack>
struct Supports {
  Pack sign_a[3], sign_b[3];
  Pack projection_a[3], projection_b[3];
  Vector3Of<Pack> a, b;  // world vertices
};

/// p_A and whether it holds, for axes that are face normals (of A, or of B where is_b).
template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> face_witness(const DepthSolid<Pack>& A, const Normals<Pack>& normal_a,
                                            const DepthSolid<Pack>& B, const Normals<Pack>& normal_b,
                                            const Supports<Pack>& v, MaskOf<Pack> is_b, Pack level,
                                            Pack tolerance, const Vector3Of<Pack>& offset,
                                            Vector3Of<Pack>& p_A) {
  const Vector3Of<Pack> a = A.p + A.centre, b = B.p + B.centre;
  const Vector3Of<Pack> start = select<Pack>(is_b, v.a, v.b);
  const Vector3Of<Pack> centre = select<Pack>(is_b, b, a);
  const Vector3Of<Pack> way = centre - start;
  Vector3Of<Pack> p = start;
  for (int k = 0; k < 3; ++k) {
    const Vector3Of<Pack> direction = select<Pack>(is_b, A.direction[k], B.direction[k]);
    const Pack twice = all<Pack>(2.0) * (is_b ? A.half[k] : B.half[k]);
    const Pack inward = is_b ? -v.sign_a[k] : -v.sign_b[k];
    const Pack projection = is_b ? v.projection_a[k] : v.projection_b[k];
    const Pack along = clamped<Pack>(inward * dot(way, direction), twice);
    const Pack by = projection * twice <= level ? along : Pack{};
    p = p + (inward * by) * direction;
  }
  p_A = select<Pack>(is_b, p, p - offset);
  const Vector3Of<Pack> q = select<Pack>(is_b, p + offset, p - offset) - centre;
  const Pack volume = is_b ? normal_b.volume : normal_a.volume;
  MaskOf<Pack> holds = ~MaskOf<Pack>{};
  for (int k = 0; k < 3; ++k) {
    const Vector3Of<Pack> normal = select<Pack>(is_b, normal_b.of[k], normal_a.of[k]);
    const Pack half = is_b ? B.half[k] : A.half[k];
    holds &= magnitude(dot(normal, q)) <= (half + tolerance) * volume;
  }
  return holds;
}

template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> edge_witness(const DepthSolid<Pack>& A, const DepthSolid<Pack>& B,
                                            const Supports<Pack>& v, Pack code, const Vector3Of<Pack>& n,
                                            Pack tolerance, Vector3Of<Pack>& p_A) {
  const OneOfThree<Pack> row = row_of(code), column = column_of(code);
  const Vector3Of<Pack> a = (-row.of(v.sign_a)) * row.of(A.direction);
  const Vector3Of<Pack> b = (-column.of(v.sign_b)) * column.of(B.direction);
  const Pack twice_a = all<Pack>(2.0) * row.of(A.half), twice_b = all<Pack>(2.0) * column.of(B.half);
  const auto [x, y] = cross_lines<Pack>(v.b - v.a, a, b, n);
  const Pack on_a = clamped<Pack>(x, twice_a);
  p_A = v.a + on_a * a;
  return (magnitude(x - on_a) <= tolerance) & (magnitude(y - clamped<Pack>(y, twice_b)) <= tolerance);
}

/// What bounds the roundings of a pair.
template <class Pack>
struct DepthScale {
  Vector3Of<Pack> T;
  Pack size, position, unit_size, unit_position, deviation;

  TOUCHSTONE_INLINE DepthScale(const DepthSolid<Pack>& A, const DepthSolid<Pack>& B) {
    T = (B.p - A.p) + (B.centre - A.centre);
    size = ((A.reach + B.reach) + (A.centre_sum + B.centre_sum)) + sum(T);
    position = largest(A.p) + largest(B.p);
    unit_size = all<Pack>(kU) * size, unit_position = all<Pack>(kU) * position;
    deviation = A.deviation + B.deviation;
  }

  TOUCHSTONE_INLINE Pack slack_error() const { return all<Pack>(kSlackRoundoffs) * unit_size; }
  TOUCHSTONE_INLINE Pack tie() const { return all<Pack>(kTieRoundoffs) * unit_size; }
  TOUCHSTONE_INLINE Pack margin() const {
    return (all<Pack>(kFormRoundoffs) * unit_size + all<Pack>(kPositionRoundoffs) * unit_position) +
           all<Pack>(2.0) * deviation;
  }
};

/// Verdict, depth and witness points from the axis found. The axis holds for pairs that overlap, whether this
/// or something else proves that they do.
template <class Solid, class Pack>
TOUCHSTONE_INLINE DepthLanes<Pack> measure_along(const Solid& A, const Normals<Pack>& normal_a,
                                                 const Solid& B, const Normals<Pack>& normal_b,
                                                 const DepthScale<Pack>& scale,
                                                 const AxisSearch<Pack>& search) {
  DepthLanes<Pack> out;
  const MaskOf<Pack> ordinary = scale.size + scale.position < all<Pack>(kOrdinaryHigh);
  const Pack turn = (search.turn[0] + search.turn[1]) + search.turn[2];
  out.separated = (search.least_slack < -search.margin) & ordinary;
  out.overlapping = (search.least_slack > search.margin + turn * scale.size) & ordinary;
  out.code = search.code;

  const Vector3Of<Pack> axis = axis_of<Pack>(out.code, A, normal_a, B, normal_b);
  const Pack length2 = dot(axis, axis);
  const MaskOf<Pack> is_b = out.code >= all<Pack>(3), is_edge = out.code >= all<Pack>(6);
  out.has_axis = ordinary & ~out.separated & (is_edge | (length2 >= all<Pack>(kShortAxis2))) &
                 (scale.deviation <= all<Pack>(kDeviationRoundoffs) * scale.unit_size);
  const Pack forward = dot(axis, scale.T) >= Pack{} ? all<Pack>(1.0) : all<Pack>(-1.0);
  out.n = (forward / square_root(length2)) * axis;
  Supports<Pack> v;
  support_signs<Pack>(A, out.n, v.sign_a, v.projection_a);
  support_signs<Pack>(B, out.n, v.sign_b, v.projection_b);
  for (int k = 0; k < 3; ++k) v.sign_b[k] = -v.sign_b[k];
  v.a = A.vertex(v.sign_a), v.b = B.vertex(v.sign_b);
  out.separation = least(dot(v.b - v.a, out.n), Pack{});
  const Pack tolerance =
      all<Pack>(kWitnessRoundoffs) * (scale.unit_size + scale.unit_position) + scale.deviation;
  const Pack level = all<Pack>(kLevelRoundoffs) * scale.unit_size;
  out.p_A = {Pack{}, Pack{}, Pack{}};
  out.has_witness = MaskOf<Pack>{};
  if (bits(~is_edge) != 0)
    out.has_witness = face_witness<Pack>(A, normal_a, B, normal_b, v, is_b, level, tolerance,
                                         out.separation * out.n, out.p_A);
  if (bits(is_edge) != 0) {
    Vector3Of<Pack> on_edge;
    const MaskOf<Pack> holds = edge_witness<Pack>(A, B, v, out.code, out.n, tolerance, on_edge);
    out.p_A = select<Pack>(is_edge, on_edge, out.p_A);
    out.has_witness = (is_edge & holds) | (~is_edge & out.has_witness);
  }
  return out;
}

template <class Solid, class Pack>
TOUCHSTONE_INLINE DepthLanes<Pack> depth_lanes(const Solid& A, const Solid& B) {
  const DepthScale<Pack> scale(A, B);
  AxisSearch<Pack> search;
  search.slack_error = scale.slack_error(), search.tie = scale.tie(), search.margin = scale.margin();
  const Normals<Pack> normal_a(A), normal_b(B);
  search_axes<Pack>(A, normal_a, B, normal_b, scale.T, search);
  return measure_along<Solid, Pack>(A, normal_a, B, normal_b, scale, search);
}

template <class Pack>
TOUCHSTONE_INLINE void write(const DepthLanes<Pack>& lanes, std::size_t count, DepthRecord* out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  double value[7][kLanes], code[kLanes];
  store(lanes.separation, value[0]);
  store(lanes.n.x, value[1]), store(lanes.n.y, value[2]), store(lanes.n.z, value[3]);
  store(lanes.p_A.x, value[4]), store(lanes.p_A.y, value[5]), store(lanes.p_A.z, value[6]);
  store(lanes.code, code);
  const unsigned separated = bits(lanes.separated), overlapping = bits(lanes.overlapping);
  const unsigned has_axis = bits(lanes.has_axis), has_witness = bits(lanes.has_witness);
  for (std::size_t l = 0; l < count; ++l) {
    DepthRecord& record = out[l];
    record.separation = value[0][l];
    for (int k = 0; k < 3; ++k) record.n[k] = value[1 + k][l], record.p_A[k] = value[4 + k][l];
    record.certified = verdict(separated >> l & 1u, overlapping >> l & 1u);
    record.has_axis = has_axis >> l & 1u;
    record.has_witness = has_axis & has_witness & 1u << l;
  }
}

template <class Pack, template <class> class Solid, class Record>
TOUCHSTONE_INLINE void measure_depths_inline(const PoseRecord* poses, const Record* shapes,
                                             const PairIndices* pairs, std::size_t count, DepthRecord* out) {
  for_each_lanes<Pack>(poses, shapes, pairs, count,
                       [&](std::size_t first, std::size_t here, const auto& poses_a, const auto& shapes_a,
                           const auto& poses_b, const auto& shapes_b) {
                         Solid<Pack> A, B;
                         A.read(poses_a, shapes_a), B.read(poses_b, shapes_b);
                         write<Pack>(depth_lanes<Solid<Pack>, Pack>(A, B), here, out + first);
                       });
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

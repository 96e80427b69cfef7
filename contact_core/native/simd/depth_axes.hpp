#pragma once

#include "touchstone/contact_core/native/simd/box_kernels.hpp"
#include "touchstone/contact_core/native/simd/exact_products.hpp"
#include "touchstone/contact_core/native/simd/parallelepiped_kernels.hpp"

// The solids and the search for the axis of least overlap; notation and bounds stand in depth_kernels.hpp.

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
/// An axis from rounded products is right to 2^-10 of its length, and more, from this square on.
constexpr double kLeastRounded2 = 0x1p-80;
constexpr double kSurelyMore = 1.0 + 0x1p-6;
/// Edges at a sine below 2^-10 span no facet that distance_kernels.hpp takes from rounded products.
constexpr double kThinSquare = 0x1p-20;

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
    return box_vertex<Pack>(this->direction, this->half, this->p, sign);
  }
};

template <class Pack>
struct ParallelepipedSolid : DepthSolid<Pack> {
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
    constexpr int kVertices = 16;  // where ParallelepipedEdges::x begins
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
  Pack overlap;  ///< times |L|, with its handicap; beyond the margin below 0
};

/// Square with the sign of `overlap`.
template <class Pack>
TOUCHSTONE_INLINE Pack signed_square(Pack overlap) {
  return overlap * magnitude(overlap);
}

/// Whether an axis across edges at a sine below 2^-4 needs no exact products, as with these it would be no
/// better than the best so far. Rounded products leave its slack s right to E, and |L| to 4 u; from exact
/// ones s / |L| is right to E, so at least (s - 2 E) / (|L| (1 + 2^-10)) where |L| >= 2^-40. What it is
/// compared with is as great as the least slack or, of short faces, below all margins: the verdicts do not
/// change.
template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> surely_loses(Pack slack, Pack L2, Pack slack_error, Pack best_square,
                                            Pack best_length2) {
  const Pack least_of = slack - all<Pack>(2.0) * slack_error;
  const Pack best = best_square * (L2 * all<Pack>(kSurelyMore));
  return (L2 >= all<Pack>(kLeastRounded2)) & (least_of > Pack{}) &
         ((least_of * least_of) * best_length2 > best);
}

template <class Pack>
struct AxisSearch {
  Pack slack_error, tie, margin;
  Pack least_slack = all<Pack>(__builtin_inf());
  Pack turn[3] = {};  // by B's edge
  // Of the least overlap so far: (overlap |L|)^2 with its sign, and |L|^2.
  Pack best_square = all<Pack>(__builtin_inf());
  Pack best_length2 = all<Pack>(1.0);
  Pack code = Pack{};

  TOUCHSTONE_INLINE void add_face(const Vector3Of<Pack>& L, Pack slack, double number) {
    const MaskOf<Pack> is_apart = slack < -margin;
    SearchedAxis<Pack> axis = {L, slack, dot(L, L), is_apart ? slack : greatest(slack, Pack{})};
    const MaskOf<Pack> is_short = axis.L2 < all<Pack>(kShortAxis2);
    least_slack = least(least_slack, slack);
    if (__builtin_expect(bits(is_short) != 0, 0)) {
      const Pack uncertain = greatest(slack - slack_error, Pack{});
      const MaskOf<Pack> counts = is_apart & (axis.L2 > all<Pack>(kThinSquare));
      axis.overlap = is_short ? (counts ? slack : uncertain) : axis.overlap;
      axis.overlap = axis.L2 <= all<Pack>(kNoAxis2) ? all<Pack>(__builtin_inf()) : axis.overlap;
    }
    choose(axis, number);
  }

  /// @param refine the same axis from exact products
  template <class Refine>
  TOUCHSTONE_INLINE void add_edges(const Vector3Of<Pack>& L, Pack slack, int i, int j, const Refine& refine) {
    SearchedAxis<Pack> axis = {L, slack, dot(L, L), slack < -margin ? slack : greatest(slack, Pack{}) + tie};
    const MaskOf<Pack> is_short = axis.L2 < all<Pack>(kShortAxis2);
    if (__builtin_expect(bits(is_short) != 0, 0)) {
      const MaskOf<Pack> none = axis.L2 <= all<Pack>(kSurelyNoAxis2);
      const MaskOf<Pack> loses =
          is_short & surely_loses<Pack>(axis.slack, axis.L2, slack_error, best_square, best_length2);
      SearchedAxis<Pack> fine = axis;
      if (bits(is_short & ~none & ~loses) != 0) fine = refine();
      add_short(fine, is_short, none, loses, turn[j], axis);
    } else {
      least_slack = least(least_slack, axis.slack);
    }
    choose(axis, 6 + 3 * i + j);
  }

  TOUCHSTONE_INLINE void add_short(const SearchedAxis<Pack>& refined, MaskOf<Pack> is_short,
                                   MaskOf<Pack> surely_none, MaskOf<Pack> loses, Pack& turn_j,
                                   SearchedAxis<Pack>& axis) {
    const Pack length = square_root(refined.L2);
    const MaskOf<Pack> none = surely_none | (is_short & (refined.L2 <= all<Pack>(kNoAxis2)));
    const Pack slack = is_short ? refined.slack / length : axis.slack;
    least_slack = none | loses ? least_slack : least(least_slack, slack);
    turn_j = turn_j + (none ? turn_by(select<Pack>(surely_none, axis.L, refined.L)) : Pack{});
    const MaskOf<Pack> counts = (refined.slack < -margin * length) & (refined.L2 > all<Pack>(kThinSquare));
    const Pack overlap = counts ? refined.slack : greatest(refined.slack, Pack{}) + tie * length;
    axis.overlap = is_short ? (none | loses ? all<Pack>(__builtin_inf()) : overlap) : axis.overlap;
    axis.L2 = is_short ? (surely_none ? axis.L2 : refined.L2) : axis.L2;
  }

  TOUCHSTONE_INLINE void choose(const SearchedAxis<Pack>& axis, double number) {
    const Pack square = signed_square(axis.overlap);
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

/// |normal . direction| of each solid's normals and the other's directions.
template <class Pack>
struct CrossProjections {
  Pack a_b[3][3], b_a[3][3];

  TOUCHSTONE_INLINE CrossProjections(const DepthSolid<Pack>& A, const Normals<Pack>& normal_a,
                                     const DepthSolid<Pack>& B, const Normals<Pack>& normal_b) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        a_b[i][j] = magnitude(dot(normal_a.of[i], B.direction[j]));
        b_a[i][j] = magnitude(dot(normal_b.of[i], A.direction[j]));
      }
    }
  }
};

/// Codes 0-2: A's faces, 3-5: B's.
template <class Pack>
TOUCHSTONE_INLINE void search_faces(const DepthSolid<Pack>& A, const Normals<Pack>& normal_a,
                                    const DepthSolid<Pack>& B, const Normals<Pack>& normal_b,
                                    const Vector3Of<Pack>& T, const CrossProjections<Pack>& along,
                                    AxisSearch<Pack>& search) {
  for (int i = 0; i < 3; ++i) {
    const Pack(&of_b)[3] = along.a_b[i];
    const Pack reach = (B.half[0] * of_b[0] + B.half[1] * of_b[1]) + B.half[2] * of_b[2];
    search.add_face(normal_a.of[i], (A.half[i] * normal_a.volume + reach) - magnitude(dot(normal_a.of[i], T)),
                    i);
  }
  for (int j = 0; j < 3; ++j) {
    const Pack(&of_a)[3] = along.b_a[j];
    const Pack reach = (A.half[0] * of_a[0] + A.half[1] * of_a[1]) + A.half[2] * of_a[2];
    search.add_face(normal_b.of[j], (B.half[j] * normal_b.volume + reach) - magnitude(dot(normal_b.of[j], T)),
                    3 + j);
  }
}

/// Codes 6 + 3 i + j: edge i of A, j of B.
template <class Pack>
TOUCHSTONE_INLINE void search_edges(const DepthSolid<Pack>& A, const DepthSolid<Pack>& B,
                                    const Vector3Of<Pack>& T, const CrossProjections<Pack>& along,
                                    AxisSearch<Pack>& search) {
  const auto widths = [&](const Vector3Of<Pack>& L) {
    return half_width<Pack>(L, A.direction, A.half) + half_width<Pack>(L, B.direction, B.half);
  };
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const Vector3Of<Pack> L = cross(A.direction[i], B.direction[j]);
      // L . A_k is up to sign B_j . normal of A opposite both; likewise for B.
      const Pack radius_a = A.half[i1] * along.a_b[i2][j] + A.half[i2] * along.a_b[i1][j];
      const Pack radius_b = B.half[j1] * along.b_a[j2][i] + B.half[j2] * along.b_a[j1][i];
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

}  // namespace touchstone::native::TOUCHSTONE_ISA

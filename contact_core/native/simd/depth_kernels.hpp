#pragma once

#include "contact_core/native/simd/box_kernels.hpp"
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
// m on all overlap. Edges at a sine below 2^-38 cannot reach that; leaving their axes out turns B by at most
// 2 * 2^-38 each and changes every other slack by at most 4 times that times size (box_box_overlap.cpp), so
// the others must exceed m by 2^-35 size for each.
//
// Choice. Overlaps are compared by the squares of s / |L|, without a division. An axis with |L| >= 2^-4 has
// an overlap right to (E + e) / |L| at most, and rarely off by more than 2 u size; of axes closer than that
// any is right to as much. Cross axes are taken when better than face axes by 4 u size, so that ties are
// decided for faces. An axis with a shorter L is never taken: when its overlap less E could be the least, the
// pair is left to the scalar road, which forms the axis from exact products. Shorter than 8 u an axis carries
// no direction and is left out: its facet is no wider than 8 u times the shorter edge, so its neighbours are
// as near to that.
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
constexpr double kTinyAxis2 = 0x1p-76;
constexpr double kTinyTurn = 0x1p-35;
constexpr double kNoAxis2 = 64 * kU * kU;

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

template <class Pack>
struct AxisSearch {
  Pack slack_error, tie, margin;
  Pack least_slack = all<Pack>(__builtin_inf());
  Pack turn = Pack{};
  MaskOf<Pack> separated = MaskOf<Pack>{};
  // Of the least overlap so far: (overlap |L|)^2 and |L|^2.
  Pack best_square = all<Pack>(__builtin_inf());
  Pack best_length2 = all<Pack>(1.0);
  Pack code = Pack{};

  TOUCHSTONE_INLINE void add(const Vector3Of<Pack>& L, Pack slack, Pack handicap, double number) {
    const Pack L2 = dot(L, L);
    Pack overlap = slack + handicap;
    const MaskOf<Pack> is_short = L2 < all<Pack>(kShortAxis2);
    if (__builtin_expect(bits(is_short) != 0, 0))
      add_short(L2, is_short, slack, overlap);
    else
      least_slack = least(least_slack, slack);
    const Pack square = overlap * overlap;
    const MaskOf<Pack> better = square * best_length2 < best_square * L2;
    best_square = better ? square : best_square;
    best_length2 = better ? L2 : best_length2;
    code = better ? all<Pack>(number) : code;
  }

  TOUCHSTONE_INLINE void add_short(Pack L2, MaskOf<Pack> is_short, Pack slack, Pack& overlap) {
    const Pack infinity = all<Pack>(__builtin_inf());
    const MaskOf<Pack> tiny = L2 < all<Pack>(kTinyAxis2);
    separated |= slack < -margin;
    turn = turn + (tiny ? all<Pack>(kTinyTurn) : Pack{});
    least_slack = least(least_slack, tiny ? infinity : slack);
    overlap = is_short ? greatest(slack - slack_error, Pack{}) : overlap;
    overlap = L2 <= all<Pack>(kNoAxis2) ? infinity : overlap;
  }
};

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
    search.add(normal_a.of[i], (A.half[i] * normal_a.volume + reach) - magnitude(dot(normal_a.of[i], T)),
               Pack{}, i);
  }
  for (int j = 0; j < 3; ++j) {
    const Pack reach = (A.half[0] * b_a[j][0] + A.half[1] * b_a[j][1]) + A.half[2] * b_a[j][2];
    search.add(normal_b.of[j], (B.half[j] * normal_b.volume + reach) - magnitude(dot(normal_b.of[j], T)),
               Pack{}, 3 + j);
  }
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const Vector3Of<Pack> L = cross(A.direction[i], B.direction[j]);
      // L . A_k is up to sign B_j . normal of A opposite both; likewise for B.
      const Pack radius_a = A.half[i1] * a_b[i2][j] + A.half[i2] * a_b[i1][j];
      const Pack radius_b = B.half[j1] * b_a[j2][i] + B.half[j2] * b_a[j1][i];
      search.add(L, (radius_a + radius_b) - magnitude(dot(L, T)), search.tie, 6 + 3 * i + j);
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
  const Vector3Of<Pack> edges = cross(row_of(code).of(A.direction), column_of(code).of(B.direction));
  const Vector3Of<Pack> face =
      select<Pack>(code < all<Pack>(3), face_a.of(normal_a.of), face_b.of(normal_b.of));
  return select<Pack>(code < all<Pack>(6), face, edges);
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

template <class Solid, class Pack>
TOUCHSTONE_INLINE DepthLanes<Pack> depth_lanes(const Solid& A, const Solid& B) {
  const Vector3Of<Pack> T = (B.p - A.p) + (B.centre - A.centre);
  const Pack size = ((A.reach + B.reach) + (A.centre_sum + B.centre_sum)) + sum(T);
  const Pack position = largest(A.p) + largest(B.p);
  const Pack unit_size = all<Pack>(kU) * size, unit_position = all<Pack>(kU) * position;
  const Pack deviation = A.deviation + B.deviation;
  AxisSearch<Pack> search;
  search.slack_error = all<Pack>(kSlackRoundoffs) * unit_size;
  search.tie = all<Pack>(kTieRoundoffs) * unit_size;
  search.margin = (all<Pack>(kFormRoundoffs) * unit_size + all<Pack>(kPositionRoundoffs) * unit_position) +
                  all<Pack>(2.0) * deviation;
  const Normals<Pack> normal_a(A), normal_b(B);
  search_axes<Pack>(A, normal_a, B, normal_b, T, search);

  DepthLanes<Pack> out;
  const MaskOf<Pack> ordinary = size + position < all<Pack>(kOrdinaryHigh);
  out.separated = (search.separated | (search.least_slack < -search.margin)) & ordinary;
  out.overlapping = (search.least_slack > search.margin + search.turn * size) & ordinary;
  out.code = search.code;

  const Vector3Of<Pack> axis = axis_of<Pack>(out.code, A, normal_a, B, normal_b);
  const Pack length2 = dot(axis, axis);
  out.has_axis = out.overlapping & (length2 >= all<Pack>(kShortAxis2)) &
                 (deviation <= all<Pack>(kDeviationRoundoffs) * unit_size);
  const Pack forward = dot(axis, T) >= Pack{} ? all<Pack>(1.0) : all<Pack>(-1.0);
  out.n = (forward / square_root(length2)) * axis;
  Supports<Pack> v;
  support_signs<Pack>(A, out.n, v.sign_a, v.projection_a);
  support_signs<Pack>(B, out.n, v.sign_b, v.projection_b);
  for (int k = 0; k < 3; ++k) v.sign_b[k] = -v.sign_b[k];
  v.a = A.vertex(v.sign_a), v.b = B.vertex(v.sign_b);
  out.separation = dot(v.b - v.a, out.n);
  const Pack tolerance = all<Pack>(kWitnessRoundoffs) * (unit_size + unit_position) + deviation;
  const Pack level = all<Pack>(kLevelRoundoffs) * unit_size;
  const MaskOf<Pack> is_b = out.code >= all<Pack>(3), is_edge = out.code >= all<Pack>(6);
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

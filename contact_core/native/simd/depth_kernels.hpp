#pragma once

#include "touchstone/contact_core/native/simd/depth_axes.hpp"
#include "touchstone/contact_core/native/simd/line_crossing.hpp"

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
// slack from its own projections: s / |L| then is off by E at most, and is what is compared with m. (Those
// that surely are not the least do without: surely_loses() in depth_axes.hpp.) Below 8 u
// (4 u, where rounded products are enough to tell) an axis carries no direction; leaving it out turns B by at
// most twice the sine and changes every other slack by at most 4 times that times size (box_box_overlap.cpp),
// so the others must exceed m by 8 sines times size for each. A sine is at most |L|_1 + 8 u.
//
// Choice. Overlaps are compared by the squares of s / |L|, without a division; a slack below 0, of pairs that
// touch to rounding, counts as 0. An axis has an overlap right to (E + e) / 2^-4 at most, and rarely off by
// more than 2 u size; of axes closer than that any is right to as much. Cross axes are taken when better than
// face axes by 4 u size, so that ties are decided for faces. A face's axis with |L| < 2^-4, of
// parallelepipeds, is never taken: when its overlap less E could be the least, the pair is left to scalar
// code. The facet of an axis left out is no wider than 8 u times the shorter edge, so its neighbours are as
// near to that. Slacks below -m count as they are, so that a pair apart gets the axis along which it is
// furthest apart, for its distance; no bound rests on that choice (distance_kernels.hpp verifies what it
// finds).
//
// Depth. n = +-L / |L|; the vertices that support it are found by the signs of n . A_i and n . B_j, formed as
// world_vertices() does, and the separation is n . (v_B - v_A): that of the hulls along n to e.
//
// Witness. On a face's axis: the other's supporting vertex, moved along its edges that lie level with the
// face towards the face's centre; on a cross axis: where the two supporting edges come nearest. It counts
// when it lies on both to 16 u (size + P) along each edge's direction.

namespace touchstone::native::TOUCHSTONE_ISA {

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

/// The supporting vertices of both solids of an overlapping pair.
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
  // From the support vertex towards the face's middle along the edges that are level with it.
  const Vector3Of<Pack> a = A.p + A.centre, b = B.p + B.centre;
  const Vector3Of<Pack> start = select<Pack>(is_b, v.a, v.b);
  const Vector3Of<Pack> centre = select<Pack>(is_b, b, a);
  const Vector3Of<Pack> to_centre = centre - start;
  Vector3Of<Pack> p = start;
  for (int k = 0; k < 3; ++k) {
    const Vector3Of<Pack> direction = select<Pack>(is_b, A.direction[k], B.direction[k]);
    const Pack twice = all<Pack>(2.0) * (is_b ? A.half[k] : B.half[k]);
    const Pack inward = is_b ? -v.sign_a[k] : -v.sign_b[k];
    const Pack projection = is_b ? v.projection_a[k] : v.projection_b[k];
    const Pack along = clamped<Pack>(inward * dot(to_centre, direction), twice);
    const Pack by = projection * twice <= level ? along : Pack{};
    p = p + (inward * by) * direction;
  }
  // It holds where its foot is within the face.
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

/// Magnitudes that bound a pair's roundings.
template <class Pack>
struct DepthScale {
  Vector3Of<Pack> T;
  Pack size, position, unit_size, unit_position, deviation;
  /// Magnitudes are, and all numbers of both poses are numbers: a comparison may lose those of directions.
  MaskOf<Pack> ordinary;

  TOUCHSTONE_INLINE DepthScale(const DepthSolid<Pack>& A, const DepthSolid<Pack>& B) {
    T = (B.p - A.p) + (B.centre - A.centre);
    size = ((A.reach + B.reach) + (A.centre_sum + B.centre_sum)) + sum(T);
    position = largest(A.p) + largest(B.p);
    unit_size = all<Pack>(kU) * size, unit_position = all<Pack>(kU) * position;
    deviation = A.deviation + B.deviation;
    ordinary =
        (size + position) + magnitude(sum_of_directions(A) + sum_of_directions(B)) < all<Pack>(kOrdinaryHigh);
  }

  TOUCHSTONE_INLINE static Pack sum_of_directions(const DepthSolid<Pack>& s) {
    const Vector3Of<Pack> all_three = (s.direction[0] + s.direction[1]) + s.direction[2];
    return (all_three.x + all_three.y) + all_three.z;
  }

  TOUCHSTONE_INLINE Pack slack_error() const { return all<Pack>(kSlackRoundoffs) * unit_size; }
  TOUCHSTONE_INLINE Pack tie() const { return all<Pack>(kTieRoundoffs) * unit_size; }
  TOUCHSTONE_INLINE Pack margin() const {
    return (all<Pack>(kParallelepipedRoundoffs) * unit_size + all<Pack>(kPositionRoundoffs) * unit_position) +
           all<Pack>(2.0) * deviation;
  }
};

template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> certify_apart(const DepthScale<Pack>& scale, const AxisSearch<Pack>& search) {
  return (search.least_slack < -search.margin) & scale.ordinary;
}

/// Verdict, depth and witness points from the axis found. The axis holds for pairs that overlap, whether this
/// or something else proves that they do.
template <class Solid, class Pack>
TOUCHSTONE_INLINE DepthLanes<Pack> depth_along(const Solid& A, const Normals<Pack>& normal_a, const Solid& B,
                                               const Normals<Pack>& normal_b, const DepthScale<Pack>& scale,
                                               const AxisSearch<Pack>& search) {
  DepthLanes<Pack> out;
  const Pack turn = (search.turn[0] + search.turn[1]) + search.turn[2];
  out.separated = certify_apart(scale, search);
  out.overlapping = (search.least_slack > search.margin + turn * scale.size) & scale.ordinary;
  out.code = search.code;

  const Vector3Of<Pack> axis = axis_of<Pack>(out.code, A, normal_a, B, normal_b);
  const Pack length2 = dot(axis, axis);
  const MaskOf<Pack> is_b = out.code >= all<Pack>(3), is_edge = out.code >= all<Pack>(6);
  out.has_axis = scale.ordinary & ~out.separated & (is_edge | (length2 >= all<Pack>(kShortAxis2))) &
                 (scale.deviation <= all<Pack>(kDeviationRoundoffs) * scale.unit_size);
  const Pack forward = dot(axis, scale.T) >= Pack{} ? all<Pack>(1.0) : all<Pack>(-1.0);
  out.n = (forward / square_root(length2)) * axis;
  // The depth: how far the supports along n lie beyond each other.
  Supports<Pack> v;
  support_signs<Pack>(A, out.n, v.sign_a, v.projection_a);
  support_signs<Pack>(B, out.n, v.sign_b, v.projection_b);
  for (int k = 0; k < 3; ++k) v.sign_b[k] = -v.sign_b[k];
  v.a = A.vertex(v.sign_a), v.b = B.vertex(v.sign_b);
  out.separation = least(dot(v.b - v.a, out.n), Pack{});
  // The witness lies on the face or edge that the axis belongs to.
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

/// @param stop_apart whether the search may end at faces that separate all lanes' pairs: `code` then is none
/// of a greatest gap
template <class Solid, class Pack>
TOUCHSTONE_INLINE DepthLanes<Pack> depth_lanes(const Solid& A, const Solid& B, bool stop_apart) {
  const DepthScale<Pack> scale(A, B);
  AxisSearch<Pack> search;
  search.slack_error = scale.slack_error(), search.tie = scale.tie(), search.margin = scale.margin();
  const Normals<Pack> normal_a(A), normal_b(B);
  const CrossProjections<Pack> along(A, normal_a, B, normal_b);
  search_faces<Pack>(A, normal_a, B, normal_b, scale.T, along, search);
  MaskOf<Pack> separated = certify_apart(scale, search);
  if (!stop_apart || bits(~separated) != 0) {
    search_edges<Pack>(A, B, scale.T, along, search);
    separated = certify_apart(scale, search);
  }
  if (bits(~separated) == 0) {
    DepthLanes<Pack> out{};
    out.separated = separated, out.code = search.code;
    return out;
  }
  return depth_along<Solid, Pack>(A, normal_a, B, normal_b, scale, search);
}

TOUCHSTONE_INLINE DepthKnown depth_known(bool has_axis, bool has_witness) {
  return !has_axis ? DepthKnown::nothing : has_witness ? DepthKnown::witness : DepthKnown::axis;
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
    record.known = depth_known(has_axis >> l & 1u, has_witness >> l & 1u);
    record.axis = static_cast<std::uint8_t>(code[l]);
  }
}

template <class Pack, template <class> class Solid, class Record>
TOUCHSTONE_INLINE void compute_depths_inline(const PoseRecord* poses, const Record* shapes,
                                             const PairIndices* pairs, std::size_t count, DepthRecord* out,
                                             bool stop_apart = false) {
  for_each_lanes<Pack>(poses, shapes, pairs, count,
                       [&](std::size_t first, std::size_t here, const auto& poses_a, const auto& shapes_a,
                           const auto& poses_b, const auto& shapes_b) {
                         Solid<Pack> A, B;
                         A.read(poses_a, shapes_a), B.read(poses_b, shapes_b);
                         write<Pack>(depth_lanes<Solid<Pack>, Pack>(A, B, stop_apart), here, out + first);
                       });
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

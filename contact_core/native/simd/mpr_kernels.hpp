#pragma once

#include "touchstone/contact_core/native/simd/parallelepiped_kernels.hpp"

// Pairs in lanes: Minkowski portal refinement (see mpr.hpp) for any two hexahedra. Every lane takes the
// same steps; a lane's steps after its certificate have no effect.
//
// Notation. u = 2^-53, P = |p_A|_inf + |p_B|_inf. All coordinates are about p_A: A's vertices are rotated
// only, a = R_A v; B's are b = R_B v + T with T = p_B - p_A. E is the largest of their magnitudes. The solids
// are the hulls of the rounded world vertices, where R v has the same bits: so a coordinate of a is off by
// the rounding of R v + p_A, at most u (P + E). For b the same is at most u (2 P + E), as |R v| <= E + |T|,
// and rounding T and the sum adds u (P + E). A difference w = b - a rounds by 2 u E. Hence w is off by u (4 P
// + 5 E) a coordinate.
//
// Separated: (greatest L . b) - (least L . a) is off by u |L|_1 (4 P + 3 E) for the vertices, twice 3 u |L|_1
// E for the dot products, and u |L|_1 2 E for the difference. 12 u |L|_1 (P + E) covers that and the second
// order.
//
// Overlapping: the origin is strictly inside the tetrahedron of v0, ... v3. v0, the difference of the means,
// is off by u (4 P + 3 E) for the vertices, twice 3 u E for the sums, and 2 u E: u (4 P + 11 E). A
// determinant has 6 products of three factors of at most 2 E: a factor's error counts 4 E^2 times, in all 4
// E^2 u (12 P + 21 E), and evaluation is off by 8 u of a product, 64 u E^3. 6 (48 P + 148 E) u E^2 <= 960 u
// E^2 (P + E), the second order included.

namespace touchstone::native::TOUCHSTONE_ISA {

constexpr double kProjectionRoundoffs = 12.0;
constexpr double kDeterminantRoundoffs = 960.0;
constexpr double kUnderflow = 0x1p-1000;

template <class Pack>
struct VertexLanes {
  Pack x[8], y[8], z[8];
};

template <class Pack>
struct MprLanes {
  VertexLanes<Pack> a, b;
  Pack extent;    // E
  Pack position;  // P
  Pack reach;     // not finite where a number of a pose is not: E and P may lose that
};

template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> is_ordinary(const MprLanes<Pack>& pair) {
  return (pair.extent + pair.position < all<Pack>(kOrdinaryHigh)) & (pair.reach < all<Pack>(__builtin_inf()));
}

template <class Pack>
struct PoseLanes {
  Vector3Of<Pack> column[3];
  Vector3Of<Pack> p;
};

template <class Pack>
TOUCHSTONE_INLINE PoseLanes<Pack> gather_poses(const double* const (&poses)[Traits<Pack>::lanes]) {
  Pack pose[12];
  gather(poses, pose);
  PoseLanes<Pack> out;
  for (int i = 0; i < 3; ++i) out.column[i] = {pose[3 * i], pose[3 * i + 1], pose[3 * i + 2]};
  out.p = {pose[9], pose[10], pose[11]};
  return out;
}

/// R v + t; the largest magnitude joins `extent`.
template <class Pack>
TOUCHSTONE_INLINE void place_vertices(const double* const (&shapes)[Traits<Pack>::lanes],
                                      const PoseLanes<Pack>& pose, const Vector3Of<Pack>* t, Pack& extent,
                                      VertexLanes<Pack>& out) {
  Pack local[24];  // x of all vertices, y, z
  gather(shapes, local);
  for (int i = 0; i < 8; ++i) {
    Vector3Of<Pack> v = rotate(pose.column, Vector3Of<Pack>{local[i], local[8 + i], local[16 + i]});
    if (t) v = v + *t;
    out.x[i] = v.x, out.y[i] = v.y, out.z[i] = v.z;
    extent = greatest(extent, largest(v));
  }
}

template <class Pack>
TOUCHSTONE_INLINE Pack sum_of(const Pack (&v)[8]) {
  return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> difference_of_means(const MprLanes<Pack>& pair) {
  const Pack eighth = all<Pack>(0.125);
  return {eighth * (sum_of(pair.b.x) - sum_of(pair.a.x)), eighth * (sum_of(pair.b.y) - sum_of(pair.a.y)),
          eighth * (sum_of(pair.b.z) - sum_of(pair.a.z))};
}

/// The vertex of the greatest axis . v, which also is `value`.
template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> highest(const VertexLanes<Pack>& v, const Vector3Of<Pack>& axis,
                                          Pack& value) {
  Vector3Of<Pack> best = {v.x[0], v.y[0], v.z[0]};
  value = dot(axis, best);
  for (int i = 1; i < 8; ++i) {
    const Pack along = (axis.x * v.x[i] + axis.y * v.y[i]) + axis.z * v.z[i];
    const MaskOf<Pack> further = along > value;
    best = select(further, Vector3Of<Pack>{v.x[i], v.y[i], v.z[i]}, best);
    value = select(further, along, value);
  }
  return best;
}

template <class Pack>
struct ExtremeLanes {
  Vector3Of<Pack> w;
  MaskOf<Pack> short_of_origin;  // W ends before the origin along the axis: a certificate
};

template <class Pack>
TOUCHSTONE_INLINE ExtremeLanes<Pack> extreme_along(const MprLanes<Pack>& pair, const Vector3Of<Pack>& axis) {
  Pack on_a, on_b;
  const Vector3Of<Pack> back = {-axis.x, -axis.y, -axis.z};
  const Vector3Of<Pack> b = highest(pair.b, axis, on_b);
  const Vector3Of<Pack> a = highest(pair.a, back, on_a);
  const Pack error = (all<Pack>(kProjectionRoundoffs * kU) * (pair.extent + pair.position)) * sum(axis);
  return {b - a, on_b + on_a < -(error + all<Pack>(kUnderflow))};
}

template <class Pack>
struct Portal {
  Vector3Of<Pack> v0, v1, v2, v3;
};

template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> certainly_holds_origin(const Portal<Pack>& p, const MprLanes<Pack>& pair) {
  const Vector3Of<Pack> v23 = cross(p.v2, p.v3), v01 = cross(p.v0, p.v1);
  const Pack d0 = dot(p.v1, v23), d1 = -dot(p.v0, v23), d2 = dot(p.v3, v01), d3 = -dot(p.v2, v01);
  const Pack error =
      ((all<Pack>(kDeterminantRoundoffs * kU) * pair.extent) * pair.extent) * (pair.extent + pair.position);
  return (least(least(d0, d1), least(d2, d3)) > error) |
         (greatest(greatest(d0, d1), greatest(d2, d3)) < -error);
}

/// The vertex v takes its place in the portal. @param refining the lanes in which the portal is found: v1,
/// v2, v3.
template <class Pack>
TOUCHSTONE_INLINE void take_in(const Vector3Of<Pack>& v, MaskOf<Pack>& refining, Portal<Pack>& p) {
  using Mask = MaskOf<Pack>;
  const Pack zero{};
  const Vector3Of<Pack> v_v0 = cross(v, p.v0);
  const Pack side_1 = dot(p.v1, v_v0), side_2 = dot(p.v2, v_v0), side_3 = dot(p.v3, v_v0);
  // Searching: v takes the place of v2 or v1 while the ray passes outside, else it is v3.
  const Mask out_1 = ~refining & (side_1 < zero);
  const Mask out_2 = ~refining & ~out_1 & (side_2 > zero);
  const Mask closes = ~refining & ~out_1 & ~out_2;
  // Refining: v splits the portal; the part the ray passes through stays.
  const Mask left = refining & (side_1 >= zero), right = refining & ~left;
  const Mask new_1 = out_2 | (left & (side_2 >= zero)) | (right & ~(side_3 >= zero));
  const Mask new_2 = out_1 | (right & (side_3 >= zero));
  const Mask new_3 = closes | (left & ~(side_2 >= zero));
  p.v1 = select(new_1, v, p.v1);
  p.v2 = select(new_2, v, p.v2);
  p.v3 = select(new_3, v, p.v3);
  refining |= closes;
}

/// @param separating set in the lanes found separated, if kKeepAxes: W ends before the origin along it.
template <class Pack, bool kKeepAxes>
TOUCHSTONE_INLINE LaneVerdicts<Pack> certify_mpr_lanes(const MprLanes<Pack>& pair, int max_steps,
                                                       Vector3Of<Pack>& separating) {
  using Mask = MaskOf<Pack>;
  const Pack zero{};
  LaneVerdicts<Pack> verdicts{};
  Mask open = is_ordinary(pair);
  const auto end_lanes = [&](Mask separated, const Vector3Of<Pack>& along) {
    verdicts.separated |= separated & open;
    if constexpr (kKeepAxes) separating = select(separated & open, along, separating);
    open &= ~separated;
  };

  // The first three vertices: against v0, and across it twice.
  Portal<Pack> p;
  p.v0 = difference_of_means(pair);
  Vector3Of<Pack> axis = {-p.v0.x, -p.v0.y, -p.v0.z};
  ExtremeLanes<Pack> found = extreme_along(pair, axis);
  end_lanes(found.short_of_origin, axis);
  if (!bits(open)) return verdicts;
  p.v1 = found.w;
  axis = cross(p.v1, p.v0);
  found = extreme_along(pair, axis);
  end_lanes(found.short_of_origin, axis);
  if (!bits(open)) return verdicts;
  p.v2 = found.w;
  axis = cross(p.v1 - p.v0, p.v2 - p.v0);
  const Mask turned = dot(axis, p.v0) > zero;
  const Vector3Of<Pack> v1 = p.v1;
  p.v1 = select(turned, p.v2, p.v1);
  p.v2 = select(turned, v1, p.v2);
  axis = select(turned, Vector3Of<Pack>{-axis.x, -axis.y, -axis.z}, axis);
  p.v3 = p.v0;

  // Then refine: the portal moves outwards until a lane is certain.
  Mask refining{};
  for (int step = 0; step < max_steps; ++step) {
    found = extreme_along(pair, axis);
    end_lanes(found.short_of_origin, axis);
    if (!bits(open)) break;
    take_in(found.w, refining, p);
    const Vector3Of<Pack> from = select(refining, p.v1, p.v0);
    axis = cross(select(refining, p.v2, p.v1) - from, select(refining, p.v3, p.v2) - from);
    const Mask inside = refining & open & (dot(axis, p.v1) >= zero);
    if (bits(inside)) {
      verdicts.overlapping |= inside & certainly_holds_origin(p, pair);
      open &= ~inside;
      if (!bits(open)) break;
    }
  }
  return verdicts;
}

/// One axis a lane, from A to B.
template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> separated_along(const MprLanes<Pack>& pair, const Vector3Of<Pack>& axis) {
  const auto along = [&axis](const VertexLanes<Pack>& v, int i) {
    return (axis.x * v.x[i] + axis.y * v.y[i]) + axis.z * v.z[i];
  };
  Pack high = along(pair.a, 0), low = along(pair.b, 0);
  for (int i = 1; i < 8; ++i) {
    high = greatest(high, along(pair.a, i));
    low = least(low, along(pair.b, i));
  }
  const Pack error = (all<Pack>(kProjectionRoundoffs * kU) * (pair.extent + pair.position)) * sum(axis);
  return (low - high > error + all<Pack>(kUnderflow)) & is_ordinary(pair);
}

template <class Pack>
TOUCHSTONE_INLINE void gather_pair(const double* const (&poses_a)[Traits<Pack>::lanes],
                                   const double* const (&shapes_a)[Traits<Pack>::lanes],
                                   const double* const (&poses_b)[Traits<Pack>::lanes],
                                   const double* const (&shapes_b)[Traits<Pack>::lanes],
                                   MprLanes<Pack>& pair) {
  const PoseLanes<Pack> X_WA = gather_poses<Pack>(poses_a), X_WB = gather_poses<Pack>(poses_b);
  const Vector3Of<Pack> T = X_WB.p - X_WA.p;
  pair.position = largest(X_WA.p) + largest(X_WB.p);
  pair.extent = Pack{};
  place_vertices<Pack>(shapes_a, X_WA, nullptr, pair.extent, pair.a);
  place_vertices<Pack>(shapes_b, X_WB, &T, pair.extent, pair.b);
  pair.reach = sum(Vector3Of<Pack>{pair.a.x[0], pair.a.y[0], pair.a.z[0]}) +
               sum(Vector3Of<Pack>{pair.b.x[0], pair.b.y[0], pair.b.z[0]});
}

/// Lane l's axis to axes[l], turned to point from A to B.
template <class Pack>
TOUCHSTONE_INLINE void store_axes(const Vector3Of<Pack>& separating, std::size_t count, PairAxis* axes) {
  constexpr int kLanes = Traits<Pack>::lanes;
  double x[kLanes], y[kLanes], z[kLanes];
  store(-separating.x, x), store(-separating.y, y), store(-separating.z, z);
  for (std::size_t l = 0; l < kLanes && l < count; ++l) axes[l] = {x[l], y[l], z[l], 0.0};
}

template <class Pack, bool kKeepAxes>
TOUCHSTONE_INLINE void certify_by_mpr_inline(const PoseRecord* poses, const VertexRecord* shapes,
                                             const PairIndices* pairs, std::size_t count, int max_steps,
                                             Certified* out, PairAxis* axes) {
  std::size_t done = 0;  // blocks come in order
  for_each_block<Pack>(
      poses, shapes, pairs, count, out,
      [&](const auto& poses_a, const auto& shapes_a, const auto& poses_b, const auto& shapes_b) {
        MprLanes<Pack> pair;
        gather_pair<Pack>(poses_a, shapes_a, poses_b, shapes_b, pair);
        Vector3Of<Pack> separating{};
        const LaneVerdicts<Pack> verdicts = certify_mpr_lanes<Pack, kKeepAxes>(pair, max_steps, separating);
        if constexpr (kKeepAxes) store_axes(separating, count - done, axes + done);
        done += Traits<Pack>::lanes;
        return verdicts;
      });
}

template <class Pack>
TOUCHSTONE_INLINE void certify_by_axis_inline(const PoseRecord* poses, const VertexRecord* shapes,
                                              const PairIndices* pairs, std::size_t count,
                                              const PairAxis* axes, Certified* out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  std::size_t done = 0;  // blocks come in order; the last repeats its last pair
  for_each_block<Pack>(
      poses, shapes, pairs, count, out,
      [&](const auto& poses_a, const auto& shapes_a, const auto& poses_b, const auto& shapes_b) {
        MprLanes<Pack> pair;
        gather_pair<Pack>(poses_a, shapes_a, poses_b, shapes_b, pair);
        const double* from[kLanes];
        for (std::size_t l = 0; l < kLanes; ++l) from[l] = &axes[done + l < count ? done + l : count - 1].x;
        Pack axis[4];
        gather(from, axis);
        done += kLanes;
        return LaneVerdicts<Pack>{separated_along(pair, Vector3Of<Pack>{axis[0], axis[1], axis[2]}), {}};
      });
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

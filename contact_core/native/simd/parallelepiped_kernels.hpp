#pragma once

#include "touchstone/contact_core/native/simd/box_kernels.hpp"

// certify_parallelepipeds in lanes: notation, bounds and order of operations as in
// parallelepiped_overlap.cpp. `size` holds every number of both poses: one that is not finite leaves the pair
// open.

namespace touchstone::native::TOUCHSTONE_ISA {

constexpr double kParallelepipedRoundoffs = 64.0;

template <class Pack>
struct ParallelepipedLanes {
  Vector3Of<Pack> edge[3];
  Vector3Of<Pack> normal[3];
  Pack length[3];
  Pack size;
  Vector3Of<Pack> centre_W;  // without p
  Vector3Of<Pack> p;
  Pack centre_sum;
  Pack deviation;
};

template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> rotate(const Vector3Of<Pack> (&column)[3], const Vector3Of<Pack>& v) {
  return {(column[0].x * v.x + column[1].x * v.y) + column[2].x * v.z,
          (column[0].y * v.x + column[1].y * v.y) + column[2].y * v.z,
          (column[0].z * v.x + column[1].z * v.y) + column[2].z * v.z};
}

template <class Pack>
TOUCHSTONE_INLINE void gather_solid(const double* const (&poses)[Traits<Pack>::lanes],
                                    const double* const (&shapes)[Traits<Pack>::lanes],
                                    ParallelepipedLanes<Pack>& out) {
  Pack pose[12], shape[16];
  gather(poses, pose);
  gather(shapes, shape);
  Vector3Of<Pack> column[3];
  for (int i = 0; i < 3; ++i) column[i] = {pose[3 * i], pose[3 * i + 1], pose[3 * i + 2]};
  out.p = {pose[9], pose[10], pose[11]};
  for (int i = 0; i < 3; ++i) {
    out.edge[i] = rotate(column, Vector3Of<Pack>{shape[3 * i], shape[3 * i + 1], shape[3 * i + 2]});
    out.length[i] = sum(out.edge[i]);
  }
  const Vector3Of<Pack> centre = {shape[9], shape[10], shape[11]};
  out.centre_W = rotate(column, centre);
  out.centre_sum = sum(centre);
  out.deviation = shape[12];
  for (int i = 0; i < 3; ++i) out.normal[i] = cross(out.edge[(i + 1) % 3], out.edge[(i + 2) % 3]);
  out.size = (out.length[0] + out.length[1]) + out.length[2];
}

template <class Pack>
struct AxisVerdicts {
  Pack error;
  LaneVerdicts<Pack> lanes;

  TOUCHSTONE_INLINE void add(Pack slack, Pack scale) {
    const Pack margin = scale * error;
    lanes.separated |= slack < -margin;
    lanes.overlapping &= slack > margin;
  }
};

template <class Pack>
TOUCHSTONE_INLINE void add_faces(const ParallelepipedLanes<Pack>& P, const Pack (&triples)[3][3],
                                 const Vector3Of<Pack>& T, AxisVerdicts<Pack>& verdicts) {
  const Pack radius = magnitude(dot(P.normal[0], P.edge[0]));
  for (int i = 0; i < 3; ++i) {
    const Pack reach = (triples[i][0] + triples[i][1]) + triples[i][2];
    verdicts.add((radius + reach) - magnitude(dot(P.normal[i], T)),
                 P.length[(i + 1) % 3] * P.length[(i + 2) % 3]);
  }
}

template <class Pack>
TOUCHSTONE_INLINE LaneVerdicts<Pack> certify_parallelepiped_lanes(const ParallelepipedLanes<Pack>& A,
                                                                  const ParallelepipedLanes<Pack>& B) {
  // The margin: roundings of sizes and places, and how far the vertices are from a parallelepiped's.
  const Vector3Of<Pack> T = (B.p - A.p) + (B.centre_W - A.centre_W);
  const Pack size = ((A.size + B.size) + (A.centre_sum + B.centre_sum)) + sum(T);
  const Pack position = largest(A.p) + largest(B.p);
  const MaskOf<Pack> ordinary = size + position < all<Pack>(kOrdinaryHigh);
  AxisVerdicts<Pack> verdicts;
  verdicts.error =
      (all<Pack>(kParallelepipedRoundoffs * kU) * size + all<Pack>(kPositionRoundoffs * kU) * position) +
      all<Pack>(2.0) * (A.deviation + B.deviation);
  verdicts.lanes.separated = MaskOf<Pack>{};
  verdicts.lanes.overlapping = ~MaskOf<Pack>{};
  // Face axes of both.
  Pack a_b[3][3], b_a[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      a_b[i][j] = magnitude(dot(A.normal[i], B.edge[j]));
      b_a[i][j] = magnitude(dot(B.normal[i], A.edge[j]));
    }
  }
  add_faces(A, a_b, T, verdicts);
  add_faces(B, b_a, T, verdicts);
  // Axes across an edge of each.
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    const Vector3Of<Pack> moment = cross(T, A.edge[i]);  // T . (a_i x b_j) = b_j . (T x a_i)
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const Pack radii = (a_b[i1][j] + a_b[i2][j]) + (b_a[j1][i] + b_a[j2][i]);
      verdicts.add(radii - magnitude(dot(moment, B.edge[j])), A.length[i] * B.length[j]);
    }
  }
  return {verdicts.lanes.separated & ordinary, verdicts.lanes.overlapping & ordinary};
}

template <class Pack>
TOUCHSTONE_INLINE void certify_parallelepipeds_inline(const PoseRecord* poses, const Parallelepiped* shapes,
                                                      const PairIndices* pairs, std::size_t count,
                                                      Certified* out) {
  for_each_two_solids<Pack, ParallelepipedLanes>(
      poses, shapes, pairs, count, out,
      [](const auto& A, const auto& B) { return certify_parallelepiped_lanes(A, B); });
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

#pragma once

#include "touchstone/contact_core/native/simd/depth_kernels.hpp"

// A single pair of boxes, the axes of one box in lanes, for box_pair_depth.hpp and resting_axis.hpp.

namespace touchstone::native::TOUCHSTONE_ISA {

/// A vector's three coordinates in lanes.
TOUCHSTONE_INLINE Double4 in_lanes(const double* p) { return Double4{p[0], p[1], p[2], 0.0}; }
/// Axis k of a pose.
TOUCHSTONE_INLINE Double4 in_lanes(const PoseRecord& X, int k) {
  return three_of(load<Double4>((const double*)&X + 3 * k));
}
TOUCHSTONE_INLINE Double4 in_lanes(const Vector3Of<Double4>& p, int lane) {
  return Double4{p.x[lane], p.y[lane], p.z[lane], 0.0};
}
TOUCHSTONE_INLINE double dot_lanes(Double4 p, Double4 q) {
  const Double4 product = p * q;
  return (product[0] + product[1]) + product[2];
}
TOUCHSTONE_INLINE Double4 cross_lanes(Double4 p, Double4 q) {
  return next(p) * after_next(q) - after_next(p) * next(q);
}
TOUCHSTONE_INLINE Vector3Of<Double4> spread(Double4 p) {
  return {all<Double4>(p[0]), all<Double4>(p[1]), all<Double4>(p[2])};
}

TOUCHSTONE_INLINE double least_of_three(Double4 p) {
  const double least_01 = p[0] < p[1] ? p[0] : p[1];
  return least_01 < p[2] ? least_01 : p[2];
}

/// A box's three directions in lanes, the last lane zero.
TOUCHSTONE_INLINE Vector3Of<Double4> lanes_of(const PoseRecord& X) {
  const Rows rows = rows_of(X);
  return {rows.x, rows.y, rows.z};
}

TOUCHSTONE_INLINE Vector3Of<Double4> in_all_lanes(const double* p) {
  return {all<Double4>(p[0]), all<Double4>(p[1]), all<Double4>(p[2])};
}

TOUCHSTONE_INLINE Vector3Of<Double4> normals_of(const Vector3Of<Double4>& d) {
  return cross(Vector3Of<Double4>{next(d.x), next(d.y), next(d.z)},
               Vector3Of<Double4>{after_next(d.x), after_next(d.y), after_next(d.z)});
}

/// Both boxes. By axis in lanes: directions and normals; in all lanes: one coordinate, or one half-extent.
struct BoxPair {
  Vector3Of<Double4> direction[2], normal[2];
  Vector3Of<Double4> each[2][3];  // a direction in all lanes
  Double4 extents[2], half[2][3];
  Double4 volume[2];  // in all lanes
  Vector3Of<Double4> T;

  TOUCHSTONE_INLINE BoxPair(const PoseRecord* const (&X)[2], const BoxRecord* const (&box)[2]) {
    for (int s = 0; s < 2; ++s) {
      direction[s] = lanes_of(*X[s]);
      normal[s] = normals_of(direction[s]);
      volume[s] = all<Double4>(magnitude(dot(normal[s], direction[s]))[0]);
      const double* const h = box[s]->half_extents;
      extents[s] = Double4{h[0], h[1], h[2], 0.0};
      for (int i = 0; i < 3; ++i) each[s][i] = in_all_lanes(X[s]->R + 3 * i), half[s][i] = all<Double4>(h[i]);
    }
    T = in_all_lanes(X[1]->p) - in_all_lanes(X[0]->p);
  }
};

/// Lanes of the three axes of a face or an edge; the last stands for none.
constexpr Mask4 kLaneNumbers = {0, 1, 2, 3};
constexpr double kInfinite = __builtin_inf();

/// The signed square of overlaps, times the square of their axis' length, beyond which an axis surely is
/// worse than the face whose signed square of overlap this is. Faces' normals are of length 1 to 2^-18; no
/// product of such quotients underflows.
TOUCHSTONE_INLINE double near_limit(double face_square) {
  constexpr double kSurely = 0x1p-15, kTiny = 0x1p-900;
  return face_square + (__builtin_fabs(face_square) * kSurely + kTiny);
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

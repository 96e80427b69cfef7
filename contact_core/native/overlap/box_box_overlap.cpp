#include "touchstone/contact_core/native/overlap/box_box_overlap.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/contact_core/native/common/hull_pair.hpp"

// Notation. u = 2^-53. h = |half_a|_1 + |half_b|_1; T = p_B - p_A, t = |T|_1; P = |p_A|_inf + |p_B|_inf;
// delta: the larger orthonormality defect of the two matrices. C = R_A^T R_B. On an axis L the slack is s(L)
// = r_A + r_B - |T . L|, with face axes L = A_i, B_j and cross axes L = A_i x B_j not normalised (|L| <= 1 +
// 3 delta).
//
// The solids are the hulls of rounded vertices: each coordinate is off by at most 3 u |R| |half| for the
// rotated part and u (|p| + |half|_1) for the last sum, so each hull is within 8 u |half|_1 + 2 u |p|_inf
// (Hausdorff, sqrt(3) included) of the parallelepiped p + R [-half, half].
//
// Separated. The formulas take R_A and R_B as orthonormal. On face axes that puts r off by delta h; on cross
// axes, where A_k . (A_i x B_j) is replaced by +-C_lj and T is expanded in A's columns, by at most 3 delta h
// + 6 delta t. Arithmetic: an entry of C is off by 4 u, of R_A^T T by 5 u t, so every s is off by at most 16
// u (h + t). Hence
//   s < -m  certifies separation for  m >= 6 delta (h + t) + 24 u (h + t) + 2 u P.
//
// Overlapping. Let the boxes be those of the nearest rotations (polar factors): |R - R'| <= 1.5 * 3 delta
// entrywise, each within 4.5 delta |half|_1 of its parallelepiped, and no s changes by more than 14 delta (h
// + t). If every s' > e |L'| for e = the two Hausdorff distances together, the exact boxes overlap by more
// than e on all 15 axes, hence by depth > e, hence the hulls overlap. As |L'| <= 1:
//   all s > m  certifies overlap for  m >= 20 delta (h + t) + 24 u (h + t) + 3 u P.
//
// Nearly parallel edges. As |A_i x B_j| -> 0 no s there can exceed m. If sin(A_i, B_j) = theta, turning B by
// theta about its centre makes the two exactly parallel: that axis drops out of the 15, B moves by at most
// theta |half_b|_1, every other s changes by at most 2 theta (h + t). So the axis may be left out when all
// others have s > m + 4 theta (h + t). If several axes are left out, all three axis pairs are that near, and
// one turn by at most twice the sum of the thetas serves them all.

namespace touchstone::native {
namespace {

/// The first pass spends nothing on measuring delta: valid poses have delta <= 1e-6 < 2^-19.9, and 20 *
/// 2^-19.9 + 24 u < 2^-15.
constexpr double kCoarse = 0x1p-15;
constexpr double kDefectFactor = 20.0;
constexpr double kSizeRoundoffs = 24.0;
constexpr double kPositionRoundoffs = 4.0;
/// Edges closer than this may count as parallel; beyond it 4 theta (h + t) would leave near-touching pairs
/// unknown anyway.
constexpr double kNearlyParallel = 0x1p-30;

struct Setup {
  double C[3][3];  // R_A^T R_B
  double absC[3][3];
  double T_A[3];      // R_A^T T
  double T_B[3];      // R_B^T T
  double a[3], b[3];  // half-extents
  double size;        // h + t
  double position;    // P
};

double column_dot(const Matrix3& R, int i, const Vector3& v) {
  return (R(0, i) * v.x() + R(1, i) * v.y()) + R(2, i) * v.z();
}

double face_slack_a(const Setup& s, int i) {
  return (s.a[i] + ((s.b[0] * s.absC[i][0] + s.b[1] * s.absC[i][1]) + s.b[2] * s.absC[i][2])) -
         std::abs(s.T_A[i]);
}

double face_slack_b(const Setup& s, int j) {
  return (s.b[j] + ((s.a[0] * s.absC[0][j] + s.a[1] * s.absC[1][j]) + s.a[2] * s.absC[2][j])) -
         std::abs(s.T_B[j]);
}

template <int i, int j>
double cross_slack(const Setup& s) {
  constexpr int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
  const double radius_a = s.a[i1] * s.absC[i2][j] + s.a[i2] * s.absC[i1][j];
  const double radius_b = s.b[j1] * s.absC[i][j2] + s.b[j2] * s.absC[i][j1];
  return (radius_a + radius_b) - std::abs(s.T_A[i2] * s.C[i1][j] - s.T_A[i1] * s.C[i2][j]);
}

std::array<double, 9> cross_slacks(const Setup& s) {
  return {cross_slack<0, 0>(s), cross_slack<0, 1>(s), cross_slack<0, 2>(s),
          cross_slack<1, 0>(s), cross_slack<1, 1>(s), cross_slack<1, 2>(s),
          cross_slack<2, 0>(s), cross_slack<2, 1>(s), cross_slack<2, 2>(s)};
}

double least(const std::array<double, 9>& v) {
  const double p = std::min(std::min(v[0], v[1]), std::min(v[2], v[3]));
  const double q = std::min(std::min(v[4], v[5]), std::min(v[6], v[7]));
  return std::min(std::min(p, q), v[8]);
}

/// At least sin(A_i, B_j): the two other entries of the row, and 4 u for the error of each.
double sine_bound(const Setup& s, int i, int j) {
  return (s.absC[i][(j + 1) % 3] + s.absC[i][(j + 2) % 3]) + 8 * kRoundoff;
}

/// The second pass: measured delta, and parallel edges left out.
Certified certify_closely(const Setup& s, double face_slack, const std::array<double, 9>& crosses,
                          const Pose& X_WA, const Pose& X_WB) {
  const double defect =
      std::max(orthonormality_defect(X_WA.R), orthonormality_defect(X_WB.R)) + 6 * kRoundoff;
  double margin = (kDefectFactor * defect + kSizeRoundoffs * kRoundoff) * s.size +
                  kPositionRoundoffs * kRoundoff * s.position;
  if (face_slack < -margin || least(crosses) < -margin) return Certified::separated;
  double slack = face_slack;
  double turn = 0.0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double theta = s.absC[i][j] > 0.5 ? sine_bound(s, i, j) : 1.0;
      if (theta < kNearlyParallel)
        turn += theta + defect;
      else
        slack = std::min(slack, crosses[3 * i + j]);
    }
  }
  margin += 8 * turn * s.size;
  return slack > margin ? Certified::overlapping : Certified::unknown;
}

}  // namespace

Certified certify_boxes(const Vector3& half_a, const Pose& X_WA, const Vector3& half_b, const Pose& X_WB) {
  // Both boxes in the frames of each other.
  Setup s;
  const Vector3 T = X_WB.p - X_WA.p;
  s.size = (norm_1(half_a) + norm_1(half_b)) + norm_1(T);
  s.position = norm_inf(X_WA.p) + norm_inf(X_WB.p);
  const double margin = kCoarse * s.size + kPositionRoundoffs * kRoundoff * s.position;
  for (int i = 0; i < 3; ++i) {
    s.a[i] = half_a(i), s.b[i] = half_b(i);
    s.T_A[i] = column_dot(X_WA.R, i, T);
    s.T_B[i] = column_dot(X_WB.R, i, T);
    for (int j = 0; j < 3; ++j) {
      s.C[i][j] = column_dot(X_WA.R, i, X_WB.R.col(j));
      s.absC[i][j] = std::abs(s.C[i][j]);
    }
  }
  // Face axes separate most pairs that are apart, so they come first.
  const double slack_a = std::min(std::min(face_slack_a(s, 0), face_slack_a(s, 1)), face_slack_a(s, 2));
  if (slack_a < -margin) return Certified::separated;
  const double slack_b = std::min(std::min(face_slack_b(s, 0), face_slack_b(s, 1)), face_slack_b(s, 2));
  if (slack_b < -margin) return Certified::separated;
  // Axes across two edges, then a closer look where the coarse margin certifies nothing.
  const std::array<double, 9> crosses = cross_slacks(s);
  const double face_slack = std::min(slack_a, slack_b);
  const double cross_slack_least = least(crosses);
  if (cross_slack_least < -margin) return Certified::separated;
  if (face_slack > margin && cross_slack_least > margin) return Certified::overlapping;
  return certify_closely(s, face_slack, crosses, X_WA, X_WB);
}

}  // namespace touchstone::native

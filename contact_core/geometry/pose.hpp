#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "touchstone/contact_core/geometry/vector.hpp"

namespace touchstone {

/// The pose X_WA of a frame A in a frame W: p_W = R_WA * p_A + p_WA. Lengths in metres.
struct Pose {
  using MovesByBits = Pose;  ///< see kMovesByBits

  Matrix3 R = Matrix3::Identity();  ///< columns: A's axes expressed in W
  Vector3 p = Vector3::Zero();      ///< A's origin in W [m]
};

/// How far R's columns may be from orthonormal, largest |(R^T R - I)_ij|, before a matrix counts as "no
/// rotation". Matrices are used as given, never re-orthonormalised; 1e-6 admits matrices written with single
/// precision.
inline constexpr double kRotationTolerance = 1e-6;

/// Largest |(R^T R - I)_ij|.
double orthonormality_defect(const Matrix3& R);

/// True if no entry is infinite or NaN.
inline bool is_finite(const Pose& X) {
  const double* const R = X.R.data();
  // A sum of finite numbers may overflow; each entry is checked then. Summed in pairs, for speed.
  const double sum = ((((R[0] + R[1]) + (R[2] + R[3])) + ((R[4] + R[5]) + (R[6] + R[7]))) +
                      ((R[8] + X.p.x()) + (X.p.y() + X.p.z())));
  if (sum - sum == 0.0) return true;
  return is_finite(X.R.col(0)) && is_finite(X.R.col(1)) && is_finite(X.R.col(2)) && is_finite(X.p);
}

/// True if all entries are equal; 0 equals -0.
inline bool is_same(const Pose& X, const Pose& Y) { return X.p == Y.p && X.R == Y.R; }

/// The entries bit by bit: R's by columns, then p's.
inline std::array<std::uint64_t, 12> words_of(const Pose& X) {
  std::array<std::uint64_t, 12> words;
  std::memcpy(words.data(), X.R.data(), 9 * sizeof(double));
  std::memcpy(words.data() + 9, X.p.data(), 3 * sizeof(double));
  return words;
}

/// True if all entries have the same bits: 0 and -0 differ.
inline bool has_same_bits(const Pose& X, const Pose& Y) { return words_of(X) == words_of(Y); }

/// True if every entry is finite, the defect is at most kRotationTolerance, and det R > 0.
bool is_valid_pose(const Pose& X);

/// @throws InputError naming `name` and the figure that is off.
void validate_pose(const Pose& X, std::string_view name);

/// R from a quaternion (w, x, y, z), normalised: q / sqrt(w2+x2+y2+z2), then R00 = w*w+x*x-y*y-z*z and so on,
/// left to right. Components are scaled by a power of two first, so 1e-200 and 1e200 are accepted.
/// @throws InputError when a component is not finite or all are zero.
Matrix3 rotation_from_quaternion(double w, double x, double y, double z,
                                 std::string_view name = "quaternion");

/// @throws InputError when `X` is no rigid transform (see is_valid_pose) or its last row is not 0 0 0 1.
Pose pose_from_matrix(const Matrix4& X, std::string_view name = "matrix");
/// The 4x4 matrix [R p; 0 0 0 1], every bit as in the pose.
Matrix4 matrix_from_pose(const Pose& X);

/// The paper's 6x1 position vector (x, y, z [m], roll, pitch, yaw [rad]) as a pose: R = Rz(yaw) Ry(pitch)
/// Rx(roll), i.e. rotations about the fixed axes x, then y, then z (equally: yaw, then pitch, then roll about
/// the moving axes).
/// @throws InputError when a component is not finite.
Pose pose_from_position_vector(const Vector6& position, std::string_view name = "position vector");

/// The inverse: pitch in [-pi/2, pi/2], roll and yaw in [-pi, pi]. At pitch = +-pi/2 only roll -+ yaw is
/// defined (gimbal lock): where cos(pitch) < 1e-12 roll is returned as 0 and yaw carries the whole turn, so
/// the matrix is still reproduced.
Vector6 position_vector_from_pose(const Pose& X);

/// X_WB = X_WA * X_AB.
Pose compose(const Pose& X_WA, const Pose& X_AB);
/// The rigid inverse (R^T, -R^T p).
Pose inverse(const Pose& X_WA);
/// ((R.col0 * x + R.col1 * y) + R.col2 * z) + p: the order that defines a solid's world vertices.
inline Vector3 transform(const Pose& X_WA, const Vector3& p_A) {
  const Matrix3& R = X_WA.R;
  return {((R(0, 0) * p_A.x() + R(0, 1) * p_A.y()) + R(0, 2) * p_A.z()) + X_WA.p.x(),
          ((R(1, 0) * p_A.x() + R(1, 1) * p_A.y()) + R(1, 2) * p_A.z()) + X_WA.p.y(),
          ((R(2, 0) * p_A.x() + R(2, 1) * p_A.y()) + R(2, 2) * p_A.z()) + X_WA.p.z()};
}

/// A direction (no translation), same order.
inline Vector3 rotate(const Matrix3& R, const Vector3& v_A) {
  return {(R(0, 0) * v_A.x() + R(0, 1) * v_A.y()) + R(0, 2) * v_A.z(),
          (R(1, 0) * v_A.x() + R(1, 1) * v_A.y()) + R(1, 2) * v_A.z(),
          (R(2, 0) * v_A.x() + R(2, 1) * v_A.y()) + R(2, 2) * v_A.z()};
}

}  // namespace touchstone

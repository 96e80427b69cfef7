#include "touchstone/contact_core/geometry/pose.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/geometry/trigonometry.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

double determinant(const Matrix3& R) { return dot(R.col(0), cross(R.col(1), R.col(2))); }

// cos(pitch) below this is gimbal lock: roll and yaw turn about the same axis to within rounding.
constexpr double kGimbalLock = 1e-12;

}  // namespace

double orthonormality_defect(const Matrix3& R) {
  double defect = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      defect = std::max(defect, std::abs(dot(R.col(i), R.col(j)) - (i == j ? 1.0 : 0.0)));
  return defect;
}

bool is_valid_pose(const Pose& X) {
  return is_finite(X) && orthonormality_defect(X.R) <= kRotationTolerance && determinant(X.R) > 0.0;
}

void validate_pose(const Pose& X, std::string_view name) {
  if (!is_finite(X)) reject(name, "a pose entry is not finite");
  const double defect = orthonormality_defect(X.R);
  if (!(defect <= kRotationTolerance))
    reject(name, "not a rotation: columns are off orthonormal by " + figure(defect) + ", allowed " +
                     figure(kRotationTolerance));
  if (!(determinant(X.R) > 0.0))
    reject(name, "not a rotation: a reflection, determinant " + figure(determinant(X.R)));
}

Matrix3 rotation_from_quaternion(double w, double x, double y, double z, std::string_view name) {
  if (!std::isfinite(w) || !std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z))
    reject(name, "a quaternion component is not finite");
  const double largest = std::max({std::abs(w), std::abs(x), std::abs(y), std::abs(z)});
  if (largest == 0.0) reject(name, "the quaternion is zero");
  // Powers of two change no bits; needed only where squares would overflow or underflow.
  if (largest > 0x1p500 || largest < 0x1p-500) {
    const int exponent = -std::ilogb(largest);
    w = std::scalbn(w, exponent), x = std::scalbn(x, exponent);
    y = std::scalbn(y, exponent), z = std::scalbn(z, exponent);
  }
  return rotation_matrix(normalized({w, {x, y, z}}));
}

Pose pose_from_matrix(const Matrix4& X, std::string_view name) {
  for (int column = 0; column < 4; ++column) {
    if (X(3, column) != (column == 3 ? 1.0 : 0.0)) reject(name, "the last row is not 0 0 0 1");
  }
  Pose pose;
  pose.R = X.topLeftCorner<3, 3>();
  pose.p = X.topRightCorner<3, 1>();
  validate_pose(pose, name);
  return pose;
}

Matrix4 matrix_from_pose(const Pose& X) {
  Matrix4 matrix = Matrix4::Identity();
  matrix.topLeftCorner<3, 3>() = X.R;
  matrix.topRightCorner<3, 1>() = X.p;
  return matrix;
}

Pose pose_from_position_vector(const Vector6& position, std::string_view name) {
  for (int i = 0; i < 6; ++i)
    if (!std::isfinite(position(i))) reject(name, "component " + std::to_string(i) + " is not finite");
  const auto [sr, cr] = sine_cosine(position(3));
  const auto [sp, cp] = sine_cosine(position(4));
  const auto [sy, cy] = sine_cosine(position(5));
  Pose X;
  X.R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,     //
      -sp, cp * sr, cp * cr;
  X.p = position.head<3>();
  return X;
}

Vector6 position_vector_from_pose(const Pose& X) {
  const Matrix3& R = X.R;
  const double cos_pitch = std::sqrt(R(0, 0) * R(0, 0) + R(1, 0) * R(1, 0));
  const double pitch = arc_tangent(-R(2, 0), cos_pitch);
  double roll = 0.0;
  double yaw = 0.0;
  if (cos_pitch < kGimbalLock) {
    yaw = arc_tangent(-R(0, 1), R(1, 1));
  } else {
    // Roll from what is left once yaw is undone, not from R's last row: near gimbal lock both are off by
    // eps / cos(pitch), and only so do their errors cancel in the matrix.
    yaw = arc_tangent(R(1, 0), R(0, 0));
    const auto [sy, cy] = sine_cosine(yaw);
    roll = arc_tangent(sy * R(0, 2) - cy * R(1, 2), cy * R(1, 1) - sy * R(0, 1));
  }
  Vector6 position;
  position << X.p, roll, pitch, yaw;
  return position;
}

Pose compose(const Pose& X_WA, const Pose& X_AB) {
  Pose X_WB;
  X_WB.R = product(X_WA.R, X_AB.R);
  X_WB.p = transform(X_WA, X_AB.p);
  return X_WB;
}

Pose inverse(const Pose& X_WA) {
  Pose X_AW;
  X_AW.R = X_WA.R.transpose();
  X_AW.p = -rotate(X_AW.R, X_WA.p);
  return X_AW;
}

}  // namespace touchstone

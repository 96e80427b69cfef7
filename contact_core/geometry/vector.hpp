#pragma once

#include <Eigen/Core>
#include <cmath>

/// @file
/// Vectors, and the few products whose rounding order is part of the project's contract: results have the
/// same bits on every compiler and instruction set, so no Eigen reduction (.dot, .norm, .sum) appears on a
/// numeric path.

namespace touchstone {

/// A column of three doubles; without Eigen's alignment, so that it may stand in any struct.
using Vector3 = Eigen::Vector3d;
/// Three columns, as Vector3; in memory column by column.
using Matrix3 = Eigen::Matrix3d;
/// The paper's position vector: x, y, z [m], roll, pitch, yaw [rad]. @see pose_from_position_vector()
using Vector6 = Eigen::Matrix<double, 6, 1>;
/// A homogeneous transform [R p; 0 0 0 1]. @see pose_from_matrix()
using Matrix4 = Eigen::Matrix4d;

/// (u.x v.x + u.y v.y) + u.z v.z, rounded after each operation.
inline double dot(const Vector3& u, const Vector3& v) {
  return (u.x() * v.x() + u.y() * v.y()) + u.z() * v.z();
}

/// u x v, each product and difference rounded.
inline Vector3 cross(const Vector3& u, const Vector3& v) {
  return {u.y() * v.z() - u.z() * v.y(), u.z() * v.x() - u.x() * v.z(), u.x() * v.y() - u.y() * v.x()};
}

/// Plain sqrt(v.v): squares may overflow beyond 1e154 and underflow below 1e-154.
inline double norm(const Vector3& v) { return std::sqrt(dot(v, v)); }

/// True where no component is infinite or NaN.
bool is_finite(const Vector3& v);

}  // namespace touchstone

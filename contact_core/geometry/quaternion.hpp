#pragma once

#include "touchstone/contact_core/geometry/pose.hpp"

namespace touchstone {

/// w + x i + y j + z k; as an attitude of unit length: p_W = q p_B q*. The project uses no other: the
/// rounding of Eigen's depends on the instruction set.
struct Quaternion {
  double w = 1.0;
  Vector3 v = Vector3::Zero();  ///< x, y, z
};

/// Hamilton's product: the turn b, then a.
inline Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - dot(a.v, b.v), (a.w * b.v + b.w * a.v) + cross(a.v, b.v)};
}

/// The opposite turn of a unit quaternion.
inline Quaternion conjugate(const Quaternion& q) { return {q.w, -q.v}; }

/// q / |q|, |q| = sqrt(((w w + x x) + y y) + z z). @pre |q|^2 as a double is neither 0 nor infinite.
Quaternion normalized(const Quaternion& q);
/// The rotation of a unit quaternion: R00 = ((w w + x x) - y y) - z z and so on.
Matrix3 rotation_matrix(const Quaternion& q);
/// The unit quaternion with w >= 0 of a rotation (Shepperd's choice of the largest component).
Quaternion quaternion_of(const Matrix3& R);
/// exp: a turn by |angles| [rad] about angles.
Quaternion quaternion_of_turn(const Vector3& angles);

/// A turn by `angle` [rad] about a unit axis.
struct AxisAngle {
  Vector3 axis = Vector3::UnitZ();
  double angle = 0.0;
};
/// The turn by 0 <= angle <= pi that a unit quaternion stands for.
AxisAngle axis_angle_of(const Quaternion& q);

/// Spherical linear interpolation along the shorter arc (Shoemake 1985), s in [0, 1]. Takes unit quaternions;
/// the result is of unit length to rounding.
Quaternion slerp(const Quaternion& from, const Quaternion& to, double s);

}  // namespace touchstone

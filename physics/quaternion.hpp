#pragma once

#include "touchstone/contact_core/geometry/pose.hpp"

namespace touchstone::physics {

/// w + x i + y j + z k; as an attitude of unit length: p_W = q p_B q*. Of its own, as Eigen's product changes
/// its rounding with the instruction set.
struct Quaternion {
  double w = 1.0;
  Vector3 v = Vector3::Zero();
};

/// Hamilton's product: the turn b, then a.
inline Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - dot(a.v, b.v), (a.w * b.v + b.w * a.v) + cross(a.v, b.v)};
}

/// q / |q|. @pre |q|^2 as a double is neither 0 nor infinite.
Quaternion normalized(const Quaternion& q);
/// Of a unit quaternion.
Matrix3 rotation_matrix(const Quaternion& q);
/// The unit quaternion with w >= 0 of a rotation (Shepperd's choice of the largest component).
Quaternion quaternion_of(const Matrix3& R);
/// exp: a turn by |angles| [rad] about angles. Uses sin and cos.
Quaternion quaternion_of_turn(const Vector3& angles);

}  // namespace touchstone::physics

#include "touchstone/physics/quaternion.hpp"

#include <cmath>

namespace touchstone::physics {

Quaternion normalized(const Quaternion& q) {
  const double length = std::sqrt(q.w * q.w + dot(q.v, q.v));
  return {q.w / length, q.v / length};
}

Matrix3 rotation_matrix(const Quaternion& q) {
  const double w = q.w, x = q.v.x(), y = q.v.y(), z = q.v.z();
  Matrix3 R;
  R << ((w * w + x * x) - y * y) - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),  //
      2.0 * (x * y + w * z), ((w * w - x * x) + y * y) - z * z, 2.0 * (y * z - w * x),   //
      2.0 * (x * z - w * y), 2.0 * (y * z + w * x), ((w * w - x * x) - y * y) + z * z;
  return R;
}

Quaternion quaternion_of(const Matrix3& R) {
  const double trace = (R(0, 0) + R(1, 1)) + R(2, 2);
  int largest = 3;  // the trace
  double most = trace;
  for (int i = 0; i < 3; ++i)
    if (R(i, i) > most) most = R(i, i), largest = i;
  const Vector3 twist(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  Quaternion q;
  if (largest == 3) {
    q = {1.0 + trace, twist};
  } else {
    q.w = twist[largest];
    for (int j = 0; j < 3; ++j) q.v[j] = R(largest, j) + R(j, largest);
    q.v[largest] = 1.0 + (2.0 * most - trace);
    if (q.w < 0.0) q = {-q.w, -q.v};
  }
  return normalized(q);
}

Quaternion quaternion_of_turn(const Vector3& angles) {
  const double angle = norm(angles);
  const double half = 0.5 * angle;
  // sin(x)/x to rounding where the angle's own square is lost beside 1.
  const double ratio = half < 0x1p-27 ? 0.5 : std::sin(half) / angle;
  return {std::cos(half), ratio * angles};
}

}  // namespace touchstone::physics

#include "touchstone/contact_core/geometry/quaternion.hpp"

#include <cmath>

#include "touchstone/contact_core/geometry/trigonometry.hpp"

namespace touchstone {

namespace {

double length_of(const Quaternion& q) {
  const double x = q.v.x(), y = q.v.y(), z = q.v.z();
  return std::sqrt(((q.w * q.w + x * x) + y * y) + z * z);
}

}  // namespace

Quaternion normalized(const Quaternion& q) {
  const double length = length_of(q);
  return {q.w / length, {q.v.x() / length, q.v.y() / length, q.v.z() / length}};
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
  const double xx = R(0, 0), yy = R(1, 1), zz = R(2, 2), trace = (xx + yy) + zz;
  const double xy = R(0, 1) + R(1, 0), xz = R(0, 2) + R(2, 0), yz = R(1, 2) + R(2, 1);
  const Vector3 twist(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  // Four times q by its largest component.
  Quaternion q;
  if (trace >= xx && trace >= yy && trace >= zz)
    q = {1.0 + trace, twist};
  else if (xx >= yy && xx >= zz)
    q = {twist.x(), {1.0 + (2.0 * xx - trace), xy, xz}};
  else if (yy >= zz)
    q = {twist.y(), {xy, 1.0 + (2.0 * yy - trace), yz}};
  else
    q = {twist.z(), {xz, yz, 1.0 + (2.0 * zz - trace)}};
  const double scale = (q.w < 0.0 ? -1.0 : 1.0) / length_of(q);
  return {scale * q.w, scale * q.v};
}

Quaternion quaternion_of_turn(const Vector3& angles) {
  const double angle = norm(angles);
  const double half = 0.5 * angle;
  const SineCosine of_half = sine_cosine(half);
  // sin(x)/x to rounding where the angle's own square is lost beside 1.
  const double ratio = half < 0x1p-27 ? 0.5 : of_half.sine / angle;
  return {of_half.cosine, ratio * angles};
}

AxisAngle axis_angle_of(const Quaternion& q) {
  const double across = norm(q.v);
  if (across == 0.0) return {};
  return {q.v / (q.w < 0.0 ? -across : across), 2.0 * arc_tangent(across, std::abs(q.w))};
}

Quaternion slerp(const Quaternion& from, const Quaternion& to, double s) {
  const double product = from.w * to.w + dot(from.v, to.v);
  const double along = std::abs(product), sign = product < 0.0 ? -1.0 : 1.0;
  // `to` is along * from + aside: cosine and sine of half the turn.
  const Quaternion aside{sign * to.w - along * from.w, sign * to.v - along * from.v};
  const double across = length_of(aside);
  const SineCosine part = sine_cosine(s * arc_tangent(across, along));
  const double share = across > 0x1p-27 ? part.sine / across : s;  // below, an angle is its sine to rounding
  return {part.cosine * from.w + share * aside.w, part.cosine * from.v + share * aside.v};
}

}  // namespace touchstone

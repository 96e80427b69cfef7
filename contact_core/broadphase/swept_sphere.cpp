#include "touchstone/contact_core/broadphase/swept_sphere.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"

namespace touchstone {
namespace {

bool stands(const SweptSphere& a) { return a.from_W == a.to_W; }

constexpr double kEps = 2.0 * kUnitRoundoff;
constexpr double kLeast = std::numeric_limits<double>::min();

// From near the closest point of segment a to near that of b (Ericson, Real-Time Collision Detection, 5.1.9),
// its largest component scaled to 1. Any direction will do for may_touch(): this one separates best.
Vector3 between_closest_points(const SweptSphere& a, const SweptSphere& b) {
  Vector3 w = a.from_W - b.from_W;
  if (stands(a) && stands(b)) return -w / norm_inf(w);
  Vector3 u = a.to_W - a.from_W;
  Vector3 v = b.to_W - b.from_W;
  const double scale = std::max({norm_inf(u), norm_inf(v), norm_inf(w)});
  u /= scale, v /= scale, w /= scale;  // products of four would leave the range of doubles
  const double uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), uw = dot(u, w), vw = dot(v, w);
  const double denominator = uu * vv - uv * uv;
  double s = denominator > 0.0 ? std::clamp((uv * vw - uw * vv) / denominator, 0.0, 1.0) : 0.0;
  double t = vv > 0.0 ? (uv * s + vw) / vv : -1.0;  // a point: its only end
  if (!(t >= 0.0 && t <= 1.0)) {
    t = t > 1.0 ? 1.0 : 0.0;
    s = uu > 0.0 ? std::clamp((uv * t - uw) / uu, 0.0, 1.0) : 0.0;
  }
  const Vector3 n = (t * v - s * u) - w;
  return n / norm_inf(n);
}

}  // namespace

// At s the solid lies in the sphere of world_sphere(S, X(s)) whose centre is within `bulge` of the segment
// between the ends' rounded centres. Its slack grows with |p(s)|: the frame's origin is within sqrt(3) |c_S|
// (1 + 1e-6) of the centre at s as at the ends, so |p(s)| <= |p| at an end + bulge + 2 sqrt(3) |c_S| (1 +
// 1e-6) < |p| + bulge + 2 reach, in largest magnitudes, with reach as there: 8 eps (reach + |p(s)|) < 24 eps
// (reach + |p| + bulge). Two roundings of the sum are in the last factor.
SweptSphere swept_sphere(const Sphere& sphere_S, const Pose& X_WS_from, const Pose& X_WS_to, double bulge) {
  const Sphere from = world_sphere(sphere_S, X_WS_from);
  const Sphere to = world_sphere(sphere_S, X_WS_to);
  const double reach = 2.0 * norm_inf(sphere_S.centre) + sphere_S.radius;
  const double farthest = std::max(norm_inf(X_WS_from.p), norm_inf(X_WS_to.p));
  const double slack = 24 * kEps * (reach + farthest + bulge);
  return {from.centre, to.centre, (std::max(from.radius, to.radius) + (bulge + slack)) * (1.0 + 4 * kEps)};
}

Box bounding_box(const SweptSphere& swept, double margin) {
  return union_of(bounding_box({swept.from_W, swept.radius}, margin),
                  bounding_box({swept.to_W, swept.radius}, margin));
}

// Any points x, y of the two segments have n . (y - x) >= least, the least over the four pairs of ends, so
// they are at least `least` / |n| apart, whatever n is. A computed n . (y - x) takes at most 5
// roundings, so it is off by less than 4 eps of the sum of its terms' magnitudes; |n| is in [1, sqrt(3)], so
// that only the terms can underflow, by less than DBL_MIN together.
bool may_touch(const SweptSphere& a, const SweptSphere& b, double margin) {
  const Vector3 n = between_closest_points(a, b);
  const double reach = ((a.radius + b.radius) + margin) * norm(n) * (1.0 + 16 * kEps) + 2 * kLeast;
  const std::array<const Vector3*, 2> of_a{&a.from_W, &a.to_W}, of_b{&b.from_W, &b.to_W};
  for (const Vector3* x : std::span(of_a).first(stands(a) ? 1 : 2)) {
    for (const Vector3* y : std::span(of_b).first(stands(b) ? 1 : 2)) {
      const double dx = n.x() * (y->x() - x->x());
      const double dy = n.y() * (y->y() - x->y());
      const double dz = n.z() * (y->z() - x->z());
      const double rounding = 8 * kEps * ((std::abs(dx) + std::abs(dy)) + std::abs(dz));
      if (!(((dx + dy) + dz) - rounding > reach)) return true;  // NaN as well
    }
  }
  return false;
}

// The point's distances to the two ends add up to `length` at most: an ellipsoid about the segment, half as
// thick as sqrt(length^2 - chord^2), which is more than it juts out beyond the ends, (length - chord) / 2.
// The chord is rounded down by more than it can be off.
double bulge_of_path_length(double length, const Vector3& from_W, const Vector3& to_W) {
  const double chord = norm(to_W - from_W) * (1.0 - 8 * kEps);
  if (!std::isfinite(length) || !std::isfinite(chord)) return kInfinity;
  if (!(length > chord)) return 4 * kEps * length;
  return 0.5 * std::sqrt(length - chord) * std::sqrt(length + chord) * (1.0 + 8 * kEps) + kLeast;
}

// The pivot's part is on its segment. With half the turn h and u = 2s - 1, the offset from the point
// of the segment at the same s is d, d^2 = arm^2 ((cos uh - cos h)^2 + (sin uh - u sin h)^2). It falls
// with |u|: its derivative has the sign of S(h)(S(h) - cos uh) - S(uh)(S(h) - cos h), S(x) = sin(x) / x,
// which is <= 0 for |u| <= 1, h < pi, where S and cos fall. So d <= arm (1 - cos h), at s = 1/2.
double bulge_of_turn(double arm, double cos_half_turn) {
  return arm * (1.0 - std::clamp(cos_half_turn, -1.0, 1.0)) * (1.0 + 4 * kEps);
}

// R is within 3t of the nearest rotation, t = kRotationTolerance (Frobenius; its singular values are as far
// from 1 as their squares are), and interpolate() turns between rotations that near to the ends' matrices,
// which it returns as they are: 8t of the arm covers both ends' differences. The trace of R_from^T R_to =
// 1 + 2 cos(turn) = 4 cos^2(turn / 2) - 1 is off by less than 2 * 3t * sqrt(3) (1 + 3t) < 12t, so the squared
// cosine by less than 3t; their rounding, some eps, is small beside it. A chord end off by 8t arm moves the
// chord by as much.
double bulge_of_interpolation(double arm, const Pose& X_WO_from, const Pose& X_WO_to) {
  constexpr double t = kRotationTolerance;
  double trace = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) trace += X_WO_from.R(i, j) * X_WO_to.R(i, j);
  const double cos_half_turn = std::sqrt(std::max(0.0, 0.25 * (1.0 + trace) - 4 * t));
  const double farthest = std::max(norm_inf(X_WO_from.p), norm_inf(X_WO_to.p));
  return bulge_of_turn(arm, cos_half_turn) + 16 * t * arm + 16 * kEps * farthest;
}

}  // namespace touchstone

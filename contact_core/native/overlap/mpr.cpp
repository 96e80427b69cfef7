#include "touchstone/contact_core/native/overlap/mpr.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "touchstone/contact_core/native/common/lanes.hpp"

namespace touchstone::native {
namespace {

/// Random pairs take 0 to 4 iterations; pairs that need more are near touching, where GJK is faster.
constexpr int kMaxSteps = 12;
/// Covers underflow where an axis is tiny; negligible for ordinary pairs otherwise.
constexpr double kUnderflow = 0x1p-1000;

std::uint8_t index(int i) { return static_cast<std::uint8_t>(i); }

double sum_of(const std::array<double, 8>& v) {
  return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

Vector3 difference_of_means(const HullPair& pair) {
  return {0.125 * (sum_of(pair.b.x) - sum_of(pair.a.x)), 0.125 * (sum_of(pair.b.y) - sum_of(pair.a.y)),
          0.125 * (sum_of(pair.b.z) - sum_of(pair.a.z))};
}

/// A vertex b - a of W.
struct Extreme {
  Vector3 w;
  int a, b;
  double value;  // axis . w, the greatest
};

Extreme extreme_along(const HullPair& pair, const Vector3& axis) {
  const Lanes on_a = dots(pair.a, axis), on_b = dots(pair.b, axis);
  const double low = low_of(on_a), high = high_of(on_b);
  const int i = first_equal(on_a, low), j = first_equal(on_b, high);
  return {
      {pair.b.x[j] - pair.a.x[i], pair.b.y[j] - pair.a.y[i], pair.b.z[j] - pair.a.z[i]}, i, j, high - low};
}

/// A vector perpendicular to v.
Vector3 perpendicular(const Vector3& v) {
  const double x = std::abs(v.x()), y = std::abs(v.y()), z = std::abs(v.z());
  if (x <= y && x <= z) return {0.0, -v.z(), v.y()};
  return y <= z ? Vector3(v.z(), 0.0, -v.x()) : Vector3(-v.y(), v.x(), 0.0);
}

/// The origin is strictly inside the tetrahedron of the exact points. As for GJK's tetrahedron of vertices,
/// whose coordinates are off by at most 4 u M (M the extent) and whose determinants' evaluation adds 8 u W^3
/// a product (W the largest coordinate); but v0's are off by 11 u M: each mean is off by u M for the shift
/// and 3 u M for the sums of three levels, their difference by 2 u M, and one for second order. So each of 6
/// products is off by at most (4 + 4 + 11) u M W^2.
bool certainly_holds_origin(const Vector3& v0, const Vector3& v1, const Vector3& v2, const Vector3& v3,
                            double extent) {
  const Vector3 v23 = cross(v2, v3), v01 = cross(v0, v1);
  const double d0 = dot(v1, v23), d1 = -dot(v0, v23), d2 = dot(v3, v01), d3 = -dot(v2, v01);
  const double reach = std::max(std::max(norm_inf(v0), norm_inf(v1)), std::max(norm_inf(v2), norm_inf(v3)));
  const double error = 6 * kRoundoff * reach * reach * (9 * reach + 20 * extent);
  return std::min(std::min(d0, d1), std::min(d2, d3)) > error ||
         std::max(std::max(d0, d1), std::max(d2, d3)) < -error;
}

}  // namespace

Certified certify_by_mpr(const HullPair& pair, Portal& portal) {
  portal.found = false;
  const auto beyond = [&pair, &portal](const Extreme& extreme, const Vector3& axis) {
    if (!(extreme.value < -(projection_error(axis, pair.extent) + kUnderflow))) return false;
    portal.axis = -axis;
    return true;
  };
  // A portal about the ray from a point inside of B - A through the origin.
  const Vector3 v0 = difference_of_means(pair);
  Vector3 axis = -v0;
  Extreme v1 = extreme_along(pair, axis);
  if (beyond(v1, axis)) return Certified::separated;
  axis = cross(v1.w, v0);
  if (!(dot(axis, axis) > 0.0)) axis = perpendicular(v0);  // the ray passes through v1
  Extreme v2 = extreme_along(pair, axis);
  if (beyond(v2, axis)) return Certified::separated;
  axis = cross(v1.w - v0, v2.w - v0);
  if (dot(axis, v0) > 0.0) {
    std::swap(v1, v2);
    axis = -axis;
  }
  // The portal is turned until the ray passes through it.
  int step = 0;
  Extreme v3;
  for (;; ++step) {
    if (step == kMaxSteps) return Certified::unknown;
    v3 = extreme_along(pair, axis);
    if (beyond(v3, axis)) return Certified::separated;
    const Vector3 v30 = cross(v3.w, v0);  // (v1 x v3) . v0 = v1 . (v3 x v0)
    if (dot(v1.w, v30) < 0.0) {
      v2 = v3;
    } else if (dot(v2.w, v30) > 0.0) {
      v1 = v3;
    } else {
      break;
    }
    axis = cross(v1.w - v0, v2.w - v0);
  }
  // It is moved outwards until the origin is inside, or beyond its plane, or nothing lies further out.
  for (;; ++step) {
    axis = cross(v2.w - v1.w, v3.w - v1.w);
    const double height = dot(axis, v1.w);
    if (height >= 0.0 && certainly_holds_origin(v0, v1.w, v2.w, v3.w, pair.extent))
      return Certified::overlapping;
    const Extreme v4 = extreme_along(pair, axis);
    if (beyond(v4, axis)) return Certified::separated;
    const bool at_boundary = v4.value - height <= 2 * projection_error(axis, pair.extent);
    if (at_boundary || step >= kMaxSteps) {
      portal = {{index(v1.a), index(v2.a), index(v3.a)}, {index(v1.b), index(v2.b), index(v3.b)}, true};
      return Certified::unknown;
    }
    const Vector3 v40 = cross(v4.w, v0);
    if (dot(v1.w, v40) >= 0.0) {
      (dot(v2.w, v40) >= 0.0 ? v1 : v3) = v4;
    } else {
      (dot(v3.w, v40) >= 0.0 ? v2 : v1) = v4;
    }
  }
}

}  // namespace touchstone::native

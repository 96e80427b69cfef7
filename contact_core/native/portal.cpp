#include "contact_core/native/portal.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "contact_core/native/lanes.hpp"

namespace touchstone::native {
namespace {

/// Random pairs take 0 to 4; whoever needs more is near touching, where closest points lead on faster.
constexpr int kMaxSteps = 12;

double sum_of(const std::array<double, 8>& v) {
  return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

Vector3 difference_of_means(const HullPair& pair) {
  return {0.125 * (sum_of(pair.b.x) - sum_of(pair.a.x)), 0.125 * (sum_of(pair.b.y) - sum_of(pair.a.y)),
          0.125 * (sum_of(pair.b.z) - sum_of(pair.a.z))};
}

struct Extreme {
  Vector3 w;
  double value;  // axis . w, the greatest
};

Extreme extreme_along(const HullPair& pair, const Vector3& axis) {
  const Lanes on_a = dots(pair.a, axis), on_b = dots(pair.b, axis);
  const double low = low_of(on_a), high = high_of(on_b);
  const int i = first_equal(on_a, low), j = first_equal(on_b, high);
  return {{pair.b.x[j] - pair.a.x[i], pair.b.y[j] - pair.a.y[i], pair.b.z[j] - pair.a.z[i]}, high - low};
}

double largest(const Vector3& p) { return std::max({std::abs(p.x()), std::abs(p.y()), std::abs(p.z())}); }

/// The origin is strictly inside the tetrahedron of the exact points. As for GJK's tetrahedron of vertices,
/// whose coordinates are off by at most 4 u M (M the extent) and whose determinants' evaluation adds 8 u W^3
/// a product (W the largest coordinate); but v0's are off by 11 u M: each mean is off by u M for the shift
/// and 3 u M for the sums of three levels, their difference by 2 u M, and one for second order. So each of 6
/// products is off by at most (4 + 4 + 11) u M W^2.
bool certainly_holds_origin(const Vector3& v0, const Vector3& v1, const Vector3& v2, const Vector3& v3,
                            double extent) {
  const Vector3 v23 = cross(v2, v3), v01 = cross(v0, v1);
  const double d0 = dot(v1, v23), d1 = -dot(v0, v23), d2 = dot(v3, v01), d3 = -dot(v2, v01);
  const double reach = std::max(std::max(largest(v0), largest(v1)), std::max(largest(v2), largest(v3)));
  const double error = 6 * kRoundoff * reach * reach * (9 * reach + 20 * extent);
  return std::min(std::min(d0, d1), std::min(d2, d3)) > error ||
         std::max(std::max(d0, d1), std::max(d2, d3)) < -error;
}

}  // namespace

Certified certify_by_portal(const HullPair& pair) {
  const auto beyond = [&pair](const Extreme& extreme, const Vector3& axis) {
    return extreme.value < -projection_error(axis, pair.extent);
  };
  const Vector3 v0 = difference_of_means(pair);
  Vector3 axis = -v0;
  Extreme found = extreme_along(pair, axis);
  if (beyond(found, axis)) return Certified::separated;
  Vector3 v1 = found.w;
  axis = cross(v1, v0);
  if (!(dot(axis, axis) > 0.0)) return Certified::unknown;
  found = extreme_along(pair, axis);
  if (beyond(found, axis)) return Certified::separated;
  Vector3 v2 = found.w;
  axis = cross(v1 - v0, v2 - v0);
  if (dot(axis, v0) > 0.0) {
    std::swap(v1, v2);
    axis = -axis;
  }

  int step = 0;
  Vector3 v3;
  for (;; ++step) {
    if (step == kMaxSteps) return Certified::unknown;
    found = extreme_along(pair, axis);
    if (beyond(found, axis)) return Certified::separated;
    v3 = found.w;
    const Vector3 v30 = cross(v3, v0);  // (v1 x v3) . v0 = v1 . (v3 x v0)
    if (dot(v1, v30) < 0.0) {
      v2 = v3;
    } else if (dot(v2, v30) > 0.0) {
      v1 = v3;
    } else {
      break;
    }
    axis = cross(v1 - v0, v2 - v0);
  }

  for (;; ++step) {
    axis = cross(v2 - v1, v3 - v1);
    if (dot(axis, v1) >= 0.0)
      return certainly_holds_origin(v0, v1, v2, v3, pair.extent) ? Certified::overlapping
                                                                 : Certified::unknown;
    if (step >= kMaxSteps) return Certified::unknown;
    found = extreme_along(pair, axis);
    if (beyond(found, axis)) return Certified::separated;
    const Vector3& v4 = found.w;
    if (v4 == v1 || v4 == v2 || v4 == v3) return Certified::unknown;
    const Vector3 v40 = cross(v4, v0);
    if (dot(v1, v40) >= 0.0) {
      (dot(v2, v40) >= 0.0 ? v1 : v3) = v4;
    } else {
      (dot(v3, v40) >= 0.0 ? v2 : v1) = v4;
    }
  }
}

}  // namespace touchstone::native

#pragma once

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/vector.hpp"

namespace touchstone {

/// (|v.x| + |v.y|) + |v.z|, rounded after each operation.
inline double norm_1(const Vector3& v) { return (std::abs(v.x()) + std::abs(v.y())) + std::abs(v.z()); }

/// The largest |component|.
inline double norm_inf(const Vector3& v) {
  return std::max({std::abs(v.x()), std::abs(v.y()), std::abs(v.z())});
}

/// v times 2^exponent, exactly but for underflow.
inline Vector3 times_power_of_two(const Vector3& v, int exponent) {
  return {std::scalbn(v.x(), exponent), std::scalbn(v.y(), exponent), std::scalbn(v.z(), exponent)};
}

/// |v| without overflow or underflow in between. Eigen's stableNorm() rounds as the instruction set has it.
inline double safe_norm(const Vector3& v) {
  const double largest = norm_inf(v);
  if (!(largest > 0.0) || std::isinf(largest)) return largest;
  const int exponent = std::ilogb(largest);
  return std::scalbn(norm(times_power_of_two(v, -exponent)), exponent);
}

/// v / |v| of a finite vector of any magnitude; zero of zero.
inline Vector3 safe_unit(const Vector3& v) {
  const double largest = norm_inf(v);
  if (largest == 0.0) return Vector3::Zero();
  const Vector3 scaled = times_power_of_two(v, -std::ilogb(largest));
  return scaled / norm(scaled);
}

}  // namespace touchstone

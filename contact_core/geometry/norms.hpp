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

}  // namespace touchstone

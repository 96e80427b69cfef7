#pragma once

#include "touchstone/contact_core/geometry/vector.hpp"

namespace touchstone::physics {

/// sum += x, with what rounding takes kept in `low` and given back by the next sum (Kahan).
inline void add_compensated(Vector3& sum, Vector3& low, const Vector3& x) {
  const Vector3 y = x + low;
  const Vector3 next = sum + y;
  low = y - (next - sum);
  sum = next;
}

}  // namespace touchstone::physics

#pragma once

#include <cmath>

#include "contact_core/geometry/vector.hpp"

namespace touchstone::native {

/// n, and two unit vectors that span the plane across it: x, y, n is right-handed.
struct TangentFrame {
  Vector3 n, x, y;
};

inline TangentFrame tangent_frame(const Vector3& n) {
  int least = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(n(i)) < std::abs(n(least))) least = i;
  const Vector3 across = cross(Vector3::Unit(least), n);
  const Vector3 x = across / norm(across);
  return {n, x, cross(n, x)};
}

}  // namespace touchstone::native

#pragma once

#include <cmath>

#include "touchstone/contact_core/geometry/vector.hpp"

namespace touchstone::native {

/// n, and two unit vectors that span the plane across it: x, y, n is right-handed.
struct TangentFrame {
  Vector3 n, x, y;
};

/// Orthonormal to a few u for a unit n. Without branches and roots (Duff et al., Building an Orthonormal
/// Basis, Revisited, JCGT 6(1), 2017).
inline TangentFrame tangent_frame(const Vector3& n) {
  const double sign = std::copysign(1.0, n.z());
  const double a = -1.0 / (sign + n.z());
  const double b = n.x() * n.y() * a;
  return {
      n, {1.0 + sign * (n.x() * n.x() * a), sign * b, -sign * n.x()}, {b, sign + n.y() * n.y() * a, -n.y()}};
}

}  // namespace touchstone::native

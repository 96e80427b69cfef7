#pragma once

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"

namespace touchstone {

/// Whether two solids may be within `within` [m] of each other, by their bounding spheres; rounding included.
inline bool may_be_within(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB,
                          double within = 0.0) {
  constexpr double kRounding =
      1e-9;  // of the radii: far more than that of the centres in any of these worlds
  const Sphere &of_a = a.bounding_sphere(), &of_b = b.bounding_sphere();
  const double between = norm(transform(X_WA, of_a.centre) - transform(X_WB, of_b.centre));
  return between <= (of_a.radius + of_b.radius) * (1 + kRounding) + within;
}

}  // namespace touchstone

#include "contact_core/numerics/exact_predicates.hpp"

#include <Eigen/Geometry>

// First slice: long double; the exact arithmetic replaces this file before anything relies on it.

namespace touchstone::numerics {

int orient3d_sign(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  using V = Eigen::Matrix<long double, 3, 1>;
  const V u = b.cast<long double>() - a.cast<long double>();
  const V v = c.cast<long double>() - a.cast<long double>();
  const V w = d.cast<long double>() - a.cast<long double>();
  const long double det = u.cross(v).dot(w);
  return det > 0 ? 1 : det < 0 ? -1 : 0;
}

}  // namespace touchstone::numerics

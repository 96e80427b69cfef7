#include "touchstone/contact_core/geometry/orientation.hpp"

#include <array>

#include "touchstone/contact_core/geometry/difference_determinant.hpp"

namespace touchstone::numerics {

int orient3d_sign(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) noexcept {
  const FilteredDeterminant det = filtered_determinant(b - a, c - a, d - a);
  if (det.is_certain()) return det.sign();
  const std::array points = {a, b, c, d};
  return DifferenceDeterminant(points).sign({0, 1}, {0, 2}, {0, 3});
}

}  // namespace touchstone::numerics

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

bool has_volume(const std::array<Vector3, 8>& v) noexcept {
  for (int i = 0; i < 8; ++i)
    for (int j = i + 1; j < 8; ++j)
      for (int k = j + 1; k < 8; ++k)
        for (int l = k + 1; l < 8; ++l)
          if (orient3d_sign(v[i], v[j], v[k], v[l]) != 0) return true;
  return false;
}

}  // namespace touchstone::numerics

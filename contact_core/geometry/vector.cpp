#include "contact_core/geometry/vector.hpp"

#include <cmath>

namespace touchstone {

double norm(const Vector3& v) { return std::sqrt(dot(v, v)); }

bool is_finite(const Vector3& v) {
  return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z());
}

}  // namespace touchstone

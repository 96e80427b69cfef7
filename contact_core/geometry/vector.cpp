#include "touchstone/contact_core/geometry/vector.hpp"

#include <cmath>

namespace touchstone {

bool is_finite(const Vector3& v) {
  return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z());
}

}  // namespace touchstone

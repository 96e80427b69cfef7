#pragma once

#include <algorithm>
#include <limits>

#include "touchstone/contact_core/geometry/vector.hpp"

namespace touchstone {

/// The coordinates that the trees' boxes are in: floats, (x - origin) * scale. Each of these roundings is
/// monotone, so boxes that overlap in double overlap in any frame: a bad one costs time, never a pair.
struct FloatFrame {
  Vector3 origin = Vector3::Zero();
  Vector3 scale = Vector3::Ones();

  float to_float(double x, int axis) const noexcept {
    constexpr double kLargest = std::numeric_limits<float>::max();
    return static_cast<float>(std::clamp((x - origin(axis)) * scale(axis), -kLargest, kLargest));
  }
};

}  // namespace touchstone

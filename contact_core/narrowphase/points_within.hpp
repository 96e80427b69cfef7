#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

/// Brings the points that are no further apart than `limit` [m] (point_limit()) to the front, in their order.
/// Returns their number. For backends whose engine has no such limit.
inline std::int32_t keep_within(std::span<ContactPoint> points, double limit) {
  const auto beyond = [limit](const ContactPoint& point) { return point.separation > limit; };
  return static_cast<std::int32_t>(std::remove_if(points.begin(), points.end(), beyond) - points.begin());
}

}  // namespace touchstone

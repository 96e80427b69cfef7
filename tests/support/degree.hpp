#pragma once

#include <numbers>

namespace touchstone {

inline constexpr double kDegree = std::numbers::pi / 180.0;  ///< [rad]

}  // namespace touchstone

#pragma once

#include <limits>

namespace touchstone {

/// Larger than every length and time: "no limit", or a distance beyond what was asked for.
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Not a number: marks a quantity that was not measured or does not exist.
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// u: the largest relative error of one rounding to nearest.
inline constexpr double kUnitRoundoff = 0x1p-53;

}  // namespace touchstone

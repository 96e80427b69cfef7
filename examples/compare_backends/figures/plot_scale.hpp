#pragma once

#include <algorithm>
#include <cmath>

namespace touchstone::comparison {

/// Errors over S beyond these are held at the axis' ends, so that one backend's do not take the axis from the
/// others: a wrong class where solids touch exactly is wrong by 5e-324, and an answer may be 1e300.
inline constexpr double kLeastShownError = 1e-20, kMostShownError = 10.0;

/// A range between two powers of ten, in exponents.
struct Decades {
  int low, high;
};
/// The narrowest one, of a decade at least, that holds both. @pre 0 < least <= most.
inline Decades decades_around(double least, double most) {
  const int low = static_cast<int>(std::floor(std::log10(least)));
  return {low, std::max(static_cast<int>(std::ceil(std::log10(most))), low + 1)};
}

/// A logarithmic axis between two powers of ten, in pixels; what lies outside is held at its end.
struct LogScale {
  double low, high;  ///< exponents of ten
  double from, to;   ///< pixels

  /// -1 or 1 where the value is held at the low or high end, 0 on the axis.
  int beyond(double value) const {
    const double exponent = std::log10(value);
    return exponent < low ? -1 : exponent > high ? 1 : 0;
  }

  double operator()(double value) const {
    return from + (to - from) * std::clamp((std::log10(value) - low) / (high - low), 0.0, 1.0);
  }
};

inline LogScale log_scale(const Decades& range, double from, double to) {
  return {static_cast<double>(range.low), static_cast<double>(range.high), from, to};
}

/// A signed logarithmic axis: linear within `threshold` of 0, then the decades up to `largest` on both sides.
struct SignedLogScale {
  double threshold, largest;
  double from, to;  ///< pixels of -largest and +largest

  bool reaches(double value) const { return std::abs(value) <= largest; }

  double operator()(double value) const {
    const double decades = std::log10(largest / threshold) + 1;
    const double size = std::abs(value);
    const double share =
        size <= threshold ? size / threshold : std::min(1 + std::log10(size / threshold), decades);
    return (from + to) / 2 + std::copysign(share / decades, value) * (to - from) / 2;
  }
};

}  // namespace touchstone::comparison

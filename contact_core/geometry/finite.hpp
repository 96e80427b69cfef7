#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace touchstone {

/// True where no value is infinite or NaN; of a vector: is_finite(), vector.hpp.
inline bool all_finite(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

}  // namespace touchstone

#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace touchstone::comparison {

/// Of a sample; NaN and index 0 when it is empty. An infinite value is the worst.
struct Quantiles {
  double median = std::numeric_limits<double>::quiet_NaN();
  double p99 = std::numeric_limits<double>::quiet_NaN();
  double worst = std::numeric_limits<double>::quiet_NaN();
  std::size_t worst_case = 0;  ///< the case of `worst`
  std::size_t count = 0;
};

struct CaseValue {
  double value;
  std::size_t index;
};

/// Nearest-rank quantiles. Reorders the sample. Of equal worst values the one with the lowest index counts.
Quantiles quantiles(std::span<CaseValue> sample);

struct Timing {
  double median_ns = 0;  ///< of the blocks' averages, per pair
  double p99_ns = 0;
  double minimum_ns = 0;
  std::size_t blocks = 0;
  std::size_t block = 0;  ///< pairs a block; 0: a frame
};

/// Reorders the sample of block averages [ns]. An empty sample gives zeros.
Timing summarise_blocks(std::span<double> averages);

}  // namespace touchstone::comparison

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone::measures {

/// Of a sample; NaN and index 0 when it is empty. An infinite value is the worst.
struct Quantiles {
  double median = kNaN;
  double p99 = kNaN;
  double worst = kNaN;
  std::size_t worst_case = 0;  ///< the case of `worst`
  std::size_t count = 0;
};

/// NaN where one is: std::max drops a NaN that comes second.
inline double larger(double x, double y) { return std::isnan(x) || std::isnan(y) ? kNaN : std::max(x, y); }

struct CaseValue {
  double value;
  std::size_t index;
};

/// Where a distribution is looked at.
inline constexpr std::array<double, 17> kCurveShares = {0,   0.01, 0.02, 0.05, 0.1,  0.2,  0.3,   0.4, 0.5,
                                                        0.6, 0.7,  0.8,  0.9,  0.95, 0.99, 0.999, 1};
/// A distribution: the nearest-rank value at each of kCurveShares, the least at 0; zeros of an empty sample.
using Curve = std::array<double, kCurveShares.size()>;
Curve curve(std::span<const CaseValue> sorted);

/// Nearest-rank quantiles. Reorders the sample. Of equal worst values the one with the lowest index counts.
Quantiles quantiles(std::span<CaseValue> sample);

/// Of frames or steps [us]: nearest ranks; NaN of none.
struct StepTimes {
  double median_us = kNaN;
  double p999_us = kNaN;
  double worst_us = kNaN;
};
StepTimes step_times(std::vector<double> us);

/// As many medians of repetitions as a Timing keeps.
inline constexpr std::size_t kKeptRepetitions = 32;

struct Timing {
  double median_ns = 0;  ///< of the blocks' averages, per pair
  double p99_ns = 0;
  double minimum_ns = 0;
  std::size_t blocks = 0;
  std::size_t block = 0;  ///< pairs a block; 0: a frame
  double lower_quartile_ns = 0;
  double upper_quartile_ns = 0;
  std::size_t repetitions = 0;                              ///< in repetition_ns
  std::array<double, kKeptRepetitions> repetition_ns = {};  ///< each repetition's median, the first ones
  /// Of single calls (a pair, or a frame), each timed on its own, reading the clock included; NaN where there
  /// were fewer than kLeastForP999.
  double p999_ns = kNaN;
  std::size_t calls = 0;  ///< behind p999_ns
};

/// NaN: not timed.
inline double median(const std::optional<Timing>& timing) { return timing ? timing->median_ns : kNaN; }

/// Below this many calls the nearest 99.9 % is the slowest call: no percentile is given then.
inline constexpr std::size_t kLeastForP999 = 1000;
/// Adds the percentile of single calls [ns], reordering them.
void add_calls(Timing& timing, std::span<double> calls);

/// The median; of an even number the mean of the middle two. @pre not empty, sorted.
double middle(std::span<const double> sorted);

/// Below this many blocks the nearest 99 % is the slowest block: no percentile is given then.
inline constexpr std::size_t kLeastForP99 = 100;
/// p99_ns; NaN of fewer than kLeastForP99 blocks.
double shown_p99(const Timing& timing);

/// Reorders the sample of block averages [ns], which holds as many of each of the repetitions, one repetition
/// after the other. An empty sample gives zeros. The median of an even
/// number is the mean of the middle two, other shares are nearest ranks.
Timing summarise_blocks(std::span<double> averages, std::size_t repetitions = 1);

}  // namespace touchstone::measures

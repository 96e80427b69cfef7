#include "examples/measures/quantiles.hpp"

#include <algorithm>
#include <cmath>

namespace touchstone::comparison {
namespace {

// Nearest rank: the smallest value with at least `share` of the sample at or below it.
std::size_t rank(double share, std::size_t count) {
  const auto r = static_cast<std::size_t>(std::ceil(share * static_cast<double>(count)));
  return std::clamp<std::size_t>(r, 1, count) - 1;
}

}  // namespace

Quantiles quantiles(std::span<CaseValue> sample) {
  Quantiles result;
  result.count = sample.size();
  if (sample.empty()) return result;
  std::sort(sample.begin(), sample.end(), [](const CaseValue& x, const CaseValue& y) {
    return x.value < y.value || (x.value == y.value && x.index > y.index);
  });
  result.median = sample[rank(0.5, sample.size())].value;
  result.p99 = sample[rank(0.99, sample.size())].value;
  result.worst = sample.back().value;
  result.worst_case = sample.back().index;
  return result;
}

Timing summarise_blocks(std::span<double> averages) {
  Timing timing;
  timing.blocks = averages.size();
  if (averages.empty()) return timing;
  std::sort(averages.begin(), averages.end());
  timing.median_ns = averages[rank(0.5, averages.size())];
  timing.p99_ns = averages[rank(0.99, averages.size())];
  timing.minimum_ns = averages.front();
  return timing;
}

}  // namespace touchstone::comparison

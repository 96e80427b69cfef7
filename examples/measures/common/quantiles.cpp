#include "touchstone/examples/measures/common/quantiles.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone::measures {
namespace {

// Nearest rank: the smallest value with at least `share` of the sample at or below it.
std::size_t rank(double share, std::size_t count) {
  const auto r = static_cast<std::size_t>(std::ceil(share * static_cast<double>(count)));
  return std::clamp<std::size_t>(r, 1, count) - 1;
}

}  // namespace

double middle(std::span<const double> sorted) {
  const std::size_t half = sorted.size() / 2;
  return sorted.size() % 2 == 1 ? sorted[half] : 0.5 * (sorted[half - 1] + sorted[half]);
}

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

Curve curve(std::span<const CaseValue> sorted) {
  Curve values{};
  if (sorted.empty()) return values;
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = sorted[rank(kCurveShares[i], sorted.size())].value;
  return values;
}

Timing summarise_blocks(std::span<double> averages, std::size_t repetitions) {
  Timing timing;
  timing.blocks = averages.size();
  if (averages.empty()) return timing;
  const std::size_t each = averages.size() / repetitions;
  timing.repetitions = std::min(repetitions, kKeptRepetitions);
  for (std::size_t r = 0; r < timing.repetitions; ++r) {
    const auto part = averages.subspan(r * each, each);
    std::sort(part.begin(), part.end());
    timing.repetition_ns[r] = middle(part);
  }
  std::sort(averages.begin(), averages.end());
  timing.median_ns = middle(averages);
  timing.p99_ns = averages[rank(0.99, averages.size())];
  timing.minimum_ns = averages.front();
  timing.lower_quartile_ns = averages[rank(0.25, averages.size())];
  timing.upper_quartile_ns = averages[rank(0.75, averages.size())];
  return timing;
}

void add_calls(Timing& timing, std::span<double> calls) {
  timing.calls = calls.size();
  if (calls.size() < kLeastForP999) return;
  const auto at = calls.begin() + static_cast<std::ptrdiff_t>(rank(0.999, calls.size()));
  std::nth_element(calls.begin(), at, calls.end());
  timing.p999_ns = *at;
}

double shown_p99(const Timing& timing) { return timing.blocks < kLeastForP99 ? kNaN : timing.p99_ns; }

StepTimes step_times(std::vector<double> us) {
  if (us.empty()) return {};
  std::sort(us.begin(), us.end());
  return {us[rank(0.5, us.size())], us[rank(0.999, us.size())], us.back()};
}

}  // namespace touchstone::measures

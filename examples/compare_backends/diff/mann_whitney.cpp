#include "touchstone/examples/compare_backends/diff/mann_whitney.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace touchstone::comparison {
namespace {

// Twice the mean rank of every value among all, in the order of x, then y.
std::vector<std::size_t> doubled_ranks(std::span<const double> x, std::span<const double> y) {
  std::vector<double> all(x.begin(), x.end());
  all.insert(all.end(), y.begin(), y.end());
  std::vector<std::size_t> ranks;
  for (const double value : all) {
    const auto below = static_cast<std::size_t>(
        std::count_if(all.begin(), all.end(), [&](double other) { return other < value; }));
    const auto equal = static_cast<std::size_t>(std::count(all.begin(), all.end(), value));
    ranks.push_back(2 * below + equal + 1);
  }
  return ranks;
}

// ways[s]: the number of choices of `count` ranks whose sum is s.
std::vector<double> ways_to_choose(std::span<const std::size_t> ranks, std::size_t count) {
  const std::size_t most = std::accumulate(ranks.begin(), ranks.end(), std::size_t{0});
  std::vector<std::vector<double>> ways(count + 1, std::vector<double>(most + 1, 0.0));
  ways[0][0] = 1;
  for (const std::size_t rank : ranks) {
    for (std::size_t chosen = count; chosen > 0; --chosen) {
      for (std::size_t sum = rank; sum <= most; ++sum) ways[chosen][sum] += ways[chosen - 1][sum - rank];
    }
  }
  return ways[count];
}

}  // namespace

double mann_whitney_p(std::span<const double> x, std::span<const double> y) {
  if (x.empty() || y.empty()) return 1.0;
  const std::vector<std::size_t> ranks = doubled_ranks(x, y);
  const auto of_x = static_cast<double>(
      std::accumulate(ranks.begin(), ranks.begin() + static_cast<std::ptrdiff_t>(x.size()), std::size_t{0}));
  const double expected = static_cast<double>(x.size()) * static_cast<double>(x.size() + y.size() + 1);
  const std::vector<double> ways = ways_to_choose(ranks, x.size());
  double all = 0, as_far = 0;
  for (std::size_t sum = 0; sum < ways.size(); ++sum) {
    all += ways[sum];
    if (std::abs(static_cast<double>(sum) - expected) >= std::abs(of_x - expected)) as_far += ways[sum];
  }
  return as_far / all;
}

std::vector<bool> resolved(std::span<const double> p_values, double rate) {
  std::vector<double> sorted(p_values.begin(), p_values.end());
  std::sort(sorted.begin(), sorted.end());
  double limit = -1;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (sorted[i] <= rate * static_cast<double>(i + 1) / static_cast<double>(sorted.size()))
      limit = sorted[i];
  }
  std::vector<bool> holds;
  for (const double p : p_values) holds.push_back(p <= limit);
  return holds;
}

}  // namespace touchstone::comparison

#include "touchstone/examples/compare_backends/judge/upper_bound.hpp"

#include <cmath>

#include "touchstone/examples/compare_backends/names.hpp"

namespace touchstone::comparison {
namespace {

double log_choose(double n, double k) {
  return std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1);
}

// P(X <= found), X binomial, for a share above found / cases: the terms shrink from `found` downward.
double at_most(double found, double cases, double share) {
  double term =
      std::exp(log_choose(cases, found) + found * std::log(share) + (cases - found) * std::log1p(-share));
  double sum = term;
  for (double k = found; k > 0 && term > sum * 0x1p-60; --k) {
    term *= k * (1 - share) / ((cases - k + 1) * share);
    sum += term;
  }
  return sum;
}

}  // namespace

double upper_bound_95(std::size_t found, std::size_t cases) {
  if (found >= cases) return 1.0;
  const double k = static_cast<double>(found), n = static_cast<double>(cases);
  if (found == 0) return -std::expm1(std::log(0.05) / n);
  double low = k / n, high = 1.0;
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    (at_most(k, n, middle) > 0.05 ? low : high) = middle;
  }
  return high;
}

}  // namespace touchstone::comparison

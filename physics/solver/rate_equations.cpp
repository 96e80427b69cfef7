#include "touchstone/physics/solver/rate_equations.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/physics/solver/elimination.hpp"
#include "touchstone/physics/solver/reserved.hpp"

namespace touchstone::physics {
namespace {

// Beside rows whose largest entry of W is 1. With it w's rounding is 2e-6 of y, and 6e-11 over the least
// eigenvalue of what stops is missed; each refinement leaves as much of what it begins with. With one
// Newton's method takes a step more in some solves, and up to 12 % more time.
constexpr double kSoft = 0x1p-34;
constexpr int kRefinements = 2;

}  // namespace

void RateEquations::reserve(std::size_t equations, std::size_t rates) {
  reserve_written(equations_, equations);
  for (auto* vector : {&left_, &of_}) reserve_written(*vector, equations * rates, kDenseRows * kDenseRows);
  for (auto* vector : {&y_, &missed_}) reserve_written(*vector, equations);
  for (auto* vector : {&start_, &w_}) reserve_written(*vector, rates);
  reserve_written(A_, rates * rates, kDenseRows * kDenseRows);
  reserve_written(pivots_, rates);
}

void RateEquations::begin(std::size_t rates) {
  rates_ = rates;
  equations_.clear();
  left_.clear();
  of_.clear();
  start_.assign(rates, 0.0);
}

void RateEquations::add(Reach reach, double own, double right) {
  equations_.push_back({reach, own, right, 1.0 / (own + kSoft)});
  left_.resize(left_.size() + rates_);
  of_.resize(of_.size() + rates_);
}

/// A w = w_0 + sum of left right / own, A = 1 + sum of left of^T / own.
void RateEquations::assemble() {
  const std::size_t n = rates_;
  A_.assign(n * n, 0.0);
  for (std::size_t k = 0; k < n; ++k) A_[k * (n + 1)] = 1.0;
  double products = 0.0;
  for (std::size_t e = 0; e < equations_.size(); ++e) {
    const auto [first, end] = equations_[e].reach;
    const double* const left = &left_[e * n];
    const double* const of = &of_[e * n];
    for (std::size_t r = first; r < end; ++r)
      subtract_multiple(&A_[r * n + first], of + first, -left[r] * equations_[e].by_own, end - first);
    const auto width = static_cast<double>(end - first);
    products += width * (width + 3.0 + 4.0 * kRefinements);
  }
  const auto rates = static_cast<double>(n);
  work_ = products + rates * rates * (rates / 3.0 + 1.0 + kRefinements);
}

/// A = P L U: L below the diagonal, without its ones.
bool RateEquations::factor() {
  const std::size_t n = rates_;
  pivots_.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (std::abs(A_[i * n + k]) > std::abs(A_[pivot * n + k])) pivot = i;
    if (!(std::abs(A_[pivot * n + k]) > 0.0)) return false;
    pivots_[k] = pivot;
    if (pivot != k) std::swap_ranges(&A_[k * n], &A_[k * n] + n, &A_[pivot * n]);
    const double inverse = 1.0 / A_[k * n + k];
    for (std::size_t i = k + 1; i < n; ++i) A_[i * n + k] *= inverse;
    eliminate(A_.data(), n, k, n, n);
  }
  return true;
}

/// y by what it misses; first of 0.
void RateEquations::correct(bool is_first) {
  const std::size_t n = rates_;
  // The right-hand side by rate.
  if (is_first)
    w_ = start_;
  else
    std::fill(w_.begin(), w_.end(), 0.0);
  for (std::size_t e = 0; e < equations_.size(); ++e) {
    const auto [first, end] = equations_[e].reach;
    subtract_multiple(&w_[first], &left_[e * n + first], -equations_[e].by_own * missed_[e], end - first);
  }
  // The rates.
  for (std::size_t k = 0; k < n; ++k) std::swap(w_[k], w_[pivots_[k]]);
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = k + 1; i < n; ++i) w_[i] -= A_[i * n + k] * w_[k];
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t i = k + 1; i < n; ++i) w_[k] -= A_[k * n + i] * w_[i];
    w_[k] /= A_[k * n + k];
  }
  // The equations' unknowns follow from them.
  for (std::size_t e = 0; e < equations_.size(); ++e) {
    const auto [first, end] = equations_[e].reach;
    y_[e] +=
        equations_[e].by_own * (missed_[e] - sum_of_products(&of_[e * n + first], &w_[first], end - first));
  }
}

/// By the rates that y gives.
void RateEquations::find_missed() {
  const std::size_t n = rates_;
  w_ = start_;
  for (std::size_t e = 0; e < equations_.size(); ++e) {
    const auto [first, end] = equations_[e].reach;
    subtract_multiple(&w_[first], &left_[e * n + first], -y_[e], end - first);
  }
  for (std::size_t e = 0; e < equations_.size(); ++e) {
    const auto [first, end] = equations_[e].reach;
    missed_[e] = (equations_[e].right - equations_[e].own * y_[e]) -
                 sum_of_products(&of_[e * n + first], &w_[first], end - first);
  }
}

bool RateEquations::solve() {
  assemble();
  if (!factor()) return false;
  y_.assign(equations_.size(), 0.0);
  missed_.resize(equations_.size());
  for (std::size_t e = 0; e < equations_.size(); ++e) missed_[e] = equations_[e].right;
  correct(true);
  for (int i = 0; i < kRefinements; ++i) {
    find_missed();
    correct(false);
  }
  return std::all_of(y_.begin(), y_.end(), [](double y) { return std::isfinite(y); });
}

}  // namespace touchstone::physics

#include "touchstone/physics/solver/scaled_contacts.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/physics/solver/contact_laws.hpp"
#include "touchstone/physics/solver/reserved.hpp"

namespace touchstone::physics {
namespace {

// A residual below this share of the terms in the sums of W y + b is rounding: more than the square root
// of the number of rows times the unit roundoff, so that no problem is given up that could be solved better.
constexpr double kRounding = 0x1p-49;

/// Of a symmetric 2 x 2 matrix with the diagonal a, d.
double largest_eigenvalue(double a, double d, double off) {
  return 0.5 * (a + d) + std::sqrt(0.25 * (a - d) * (a - d) + off * off);
}

}  // namespace

void ScaledProblem::reserve(std::size_t rows) {
  for (auto* vector : {&scale_, &b_}) reserve_written(*vector, rows);
  reserve_written(W_, rows * rows, kDenseRows * kDenseRows);
  reserve_written(bounds_, rows);
  reserve_written(columns_, rows);
  for (auto* vector : {&J_, &Y_})
    reserve_written(*vector, rows * rows / ContactProblem::kRowsARate,
                    kDenseRows * kDenseRows / ContactProblem::kRowsARate);
  reserve_written(rates_, rows / 3);
  reserve_written(w_, rows / ContactProblem::kRowsARate);
}

void ScaledProblem::load(const ContactProblem& problem, std::span<const double> x, std::span<double> y) {
  problem_ = problem;
  const std::size_t n = problem.rows();
  for (auto* vector : {&scale_, &b_}) vector->resize(n);
  bounds_.assign(problem.bounds.begin(), problem.bounds.end());
  // A block's scale makes the largest diagonal entry of its W 1; it is 0 where nothing moves.
  const auto scale_block = [&](std::size_t row, std::size_t size) {
    const double w = block_scale(problem, row, size);
    const double scale = std::isfinite(w) ? 1.0 / std::sqrt(w) : kNaN;
    for (std::size_t i = row; i < row + size; ++i) scale_[i] = w <= 0.0 ? 0.0 : scale;
  };
  for (std::size_t c = 0; c < problem.contacts; ++c) scale_block(3 * c, 3);
  for (std::size_t i = 3 * problem.contacts; i < n; ++i) {
    scale_block(i, 1);
    auto& bounds = bounds_[i - 3 * problem.contacts];
    if (scale_[i] > 0.0) bounds = {bounds.lower / scale_[i], bounds.upper / scale_[i]};
  }
  // b, the start and W or its parts are scaled.
  for (std::size_t i = 0; i < n; ++i) {
    b_[i] = scale_[i] * problem.b[i];
    y[i] = scale_[i] > 0.0 ? x[i] / scale_[i] : 0.0;
  }
  if (is_by_rates())
    load_rates();
  else
    load_couplings();
  const std::span<const double> W = is_by_rates() ? std::span<const double>() : W_;
  view_ = {problem.contacts, problem.friction, bounds_, W, b_};
}

/// W, and each row's range of nonzero columns.
void ScaledProblem::load_couplings() {
  const std::size_t n = problem_.rows();
  W_.resize(n * n);
  columns_.resize(n);
  std::size_t entries = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) W_[i * n + k] = scale_[i] * problem_.W[i * n + k] * scale_[k];
    std::size_t first = 0, end = n;
    while (first < i && W_[i * n + first] == 0.0) ++first;
    while (end > i + 1 && W_[i * n + end - 1] == 0.0) --end;
    columns_[i] = {first, end};
    entries += end - first;
  }
  work_ = static_cast<double>(entries);
}

/// J and Y, and the rates of each contact: what lies between is 0 or not.
void ScaledProblem::load_rates() {
  const std::size_t n = problem_.rates;
  J_.resize(problem_.J.size());
  Y_.resize(problem_.Y.size());
  for (std::size_t i = 0; i * n < J_.size(); ++i)
    for (std::size_t k = i * n; k < (i + 1) * n; ++k)
      J_[k] = scale_[i] * problem_.J[k], Y_[k] = scale_[i] * problem_.Y[k];
  rates_.resize(problem_.contacts);
  w_.resize(n);
  std::size_t entries = 0;
  for (std::size_t c = 0; c < rates_.size(); ++c) {
    const double* const rows = &J_[3 * c * n];
    const auto is_moved = [&](std::size_t k) {
      return rows[k] != 0.0 || rows[n + k] != 0.0 || rows[2 * n + k] != 0.0;
    };
    std::size_t first = 0, end = n;
    while (first < end && !is_moved(first)) ++first;
    while (end > first && !is_moved(end - 1)) --end;
    rates_[c] = {first, end};
    entries += 6 * (end - first);
  }
  work_ = ContactProblem::kPriceOfRates * static_cast<double>(entries);
}

/// w += Y^T of an impulse.
void ScaledProblem::add_to_rates(std::size_t row, double impulse) {
  const auto [first, end] = rates_[row / 3];
  subtract_multiple(&w_[first], Y(row) + first, -impulse, end - first);
}

/// w = Y^T y.
void ScaledProblem::find_rates(std::span<const double> y) {
  std::fill(w_.begin(), w_.end(), 0.0);
  for (std::size_t i = 0; i < y.size(); ++i)
    if (y[i] != 0.0) add_to_rates(i, y[i]);
}

double ScaledProblem::velocity_by_rates(std::size_t row) const {
  const auto [first, end] = rates_[row / 3];
  return b_[row] + sum_of_products(J(row) + first, &w_[first], end - first);
}

double ScaledProblem::velocity(std::size_t row, std::span<const double> y) const {
  const auto [first, end] = columns_[row];
  return b_[row] + sum_of_products(&W_[row * y.size() + first], &y[first], end - first);
}

double ScaledProblem::residual(std::span<const double> y, std::span<double> u) {
  const std::size_t n = y.size();
  if (is_by_rates()) {
    find_rates(y);
    for (std::size_t i = 0; i < n; ++i) u[i] = velocity_by_rates(i);
  } else {
    for (std::size_t i = 0; i < n; ++i) u[i] = velocity(i, y);
  }
  double worst = 0.0;
  for (std::size_t c = 0; c < problem_.contacts; ++c)
    if (scale_[3 * c] != 0.0)
      worst =
          worse_of(worst, contact_residual(1.0, problem_.friction[c], &y[3 * c], &u[3 * c]) / scale_[3 * c]);
  for (std::size_t i = 3 * problem_.contacts; i < n; ++i)
    if (scale_[i] != 0.0)
      worst = worse_of(worst,
                       std::abs(y[i] - clamped(y[i] - u[i], bounds_[i - 3 * problem_.contacts])) / scale_[i]);
  return worst;
}

void ScaledProblem::sweep(std::span<double> y) {
  if (is_by_rates()) return sweep_by_rates(y);
  const std::size_t n = y.size();
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    const std::size_t i = 3 * c;
    if (scale_[i] == 0.0) continue;
    const double normal = W_[i * n + i];
    if (normal > 0.0) y[i] = std::max(0.0, y[i] - velocity(i, y) / normal);
    const double u1 = velocity(i + 1, y), u2 = velocity(i + 2, y);
    const double a = W_[(i + 1) * n + i + 1], d = W_[(i + 2) * n + i + 2], off = W_[(i + 1) * n + i + 2];
    const double largest = largest_eigenvalue(a, d, off);
    if (largest > 0.0) {
      y[i + 1] -= u1 / largest;
      y[i + 2] -= u2 / largest;
    }
    project_on_disc(problem_.friction[c] * y[i], y[i + 1], y[i + 2]);
  }
  for (std::size_t i = 3 * problem_.contacts; i < n; ++i)
    if (scale_[i] > 0.0) y[i] = clamped(y[i] - velocity(i, y), bounds_[i - 3 * problem_.contacts]);
}

/// sweep(), the rates kept up to date.
void ScaledProblem::sweep_by_rates(std::span<double> y) {
  find_rates(y);
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    const std::size_t i = 3 * c;
    if (scale_[i] == 0.0) continue;
    const auto [first, end] = rates_[c];
    const auto entry = [&, first = first, end = end](std::size_t r, std::size_t s) {
      return sum_of_products(J(r) + first, Y(s) + first, end - first);
    };
    const double before[3] = {y[i], y[i + 1], y[i + 2]}, normal = entry(i, i);
    if (normal > 0.0) {
      y[i] = std::max(0.0, y[i] - velocity_by_rates(i) / normal);
      add_to_rates(i, y[i] - before[0]);
    }
    const double largest = largest_eigenvalue(entry(i + 1, i + 1), entry(i + 2, i + 2), entry(i + 1, i + 2));
    if (largest > 0.0) {
      const double u1 = velocity_by_rates(i + 1), u2 = velocity_by_rates(i + 2);
      y[i + 1] -= u1 / largest;
      y[i + 2] -= u2 / largest;
    }
    project_on_disc(problem_.friction[c] * y[i], y[i + 1], y[i + 2]);
    add_to_rates(i + 1, y[i + 1] - before[1]);
    add_to_rates(i + 2, y[i + 2] - before[2]);
  }
}

double ScaledProblem::rounding(std::span<const double> y) const {
  double worst = 0.0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    if (scale_[i] == 0.0) continue;
    double sum = std::abs(b_[i]);
    for (std::size_t k = columns_[i].first; k < columns_[i].end; ++k)
      sum += std::abs(W_[i * y.size() + k] * y[k]);
    worst = worse_of(worst, sum / scale_[i]);
  }
  return kRounding * worst;
}

}  // namespace touchstone::physics

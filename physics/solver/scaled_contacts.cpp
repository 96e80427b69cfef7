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

}  // namespace

void ScaledProblem::reserve(std::size_t rows) {
  for (auto* vector : {&scale_, &b_}) reserve_written(*vector, rows);
  reserve_written(W_, rows * rows, kDenseRows * kDenseRows);
  reserve_written(bounds_, rows);
  reserve_written(columns_, rows);
}

void ScaledProblem::load(const ContactProblem& problem, std::span<const double> x, std::span<double> y) {
  problem_ = problem;
  const std::size_t n = problem.rows();
  for (auto* vector : {&scale_, &b_}) vector->resize(n);
  W_.resize(n * n);
  columns_.resize(n);
  bounds_.assign(problem.bounds.begin(), problem.bounds.end());
  // A block's scale makes the largest diagonal entry of its W 1; it is 0 where nothing moves.
  const auto scale_block = [&](std::size_t row, std::size_t size) {
    const double w = block_scale(problem.W, n, row, size);
    const double scale = std::isfinite(w) ? 1.0 / std::sqrt(w) : kNaN;
    for (std::size_t i = row; i < row + size; ++i) scale_[i] = w <= 0.0 ? 0.0 : scale;
  };
  for (std::size_t c = 0; c < problem.contacts; ++c) scale_block(3 * c, 3);
  for (std::size_t i = 3 * problem.contacts; i < n; ++i) {
    scale_block(i, 1);
    auto& bounds = bounds_[i - 3 * problem.contacts];
    if (scale_[i] > 0.0) bounds = {bounds.lower / scale_[i], bounds.upper / scale_[i]};
  }
  // W, b and the start are scaled, and each row's range of nonzero columns is found.
  std::size_t entries = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) W_[i * n + k] = scale_[i] * problem.W[i * n + k] * scale_[k];
    std::size_t first = 0, end = n;
    while (first < i && W_[i * n + first] == 0.0) ++first;
    while (end > i + 1 && W_[i * n + end - 1] == 0.0) --end;
    columns_[i] = {first, end};
    entries += end - first;
    b_[i] = scale_[i] * problem.b[i];
    y[i] = scale_[i] > 0.0 ? x[i] / scale_[i] : 0.0;
  }
  work_ = static_cast<double>(entries);
  view_ = {problem.contacts, problem.friction, bounds_, W_, b_};
}

double ScaledProblem::velocity(std::size_t row, std::span<const double> y) const {
  const auto [first, end] = columns_[row];
  return b_[row] + sum_of_products(&W_[row * y.size() + first], &y[first], end - first);
}

double ScaledProblem::residual(std::span<const double> y, std::span<double> u) const {
  const std::size_t n = y.size();
  for (std::size_t i = 0; i < n; ++i) u[i] = velocity(i, y);
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

void ScaledProblem::sweep(std::span<double> y) const {
  const std::size_t n = y.size();
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    const std::size_t i = 3 * c;
    if (scale_[i] == 0.0) continue;
    const double normal = W_[i * n + i];
    if (normal > 0.0) y[i] = std::max(0.0, y[i] - velocity(i, y) / normal);
    const double u1 = velocity(i + 1, y), u2 = velocity(i + 2, y);
    const double a = W_[(i + 1) * n + i + 1], d = W_[(i + 2) * n + i + 2], off = W_[(i + 1) * n + i + 2];
    const double largest = 0.5 * (a + d) + std::sqrt(0.25 * (a - d) * (a - d) + off * off);
    if (largest > 0.0) {
      y[i + 1] -= u1 / largest;
      y[i + 2] -= u2 / largest;
    }
    project_on_disc(problem_.friction[c] * y[i], y[i + 1], y[i + 2]);
  }
  for (std::size_t i = 3 * problem_.contacts; i < n; ++i)
    if (scale_[i] > 0.0) y[i] = clamped(y[i] - velocity(i, y), bounds_[i - 3 * problem_.contacts]);
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

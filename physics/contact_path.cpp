#include "physics/contact_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/contact_laws.hpp"

namespace touchstone::physics {
namespace {

constexpr double kFirstLogSoftness = 1.5;
constexpr double kFirstStep = 0.5, kLongestStep = 3.0;
constexpr int kMostCorrections = 5, kMostFirstCorrections = 40;

/// max(x, 0) rounded off over `width`, and its derivatives by x and width.
struct SmoothPositive {
  double value, by_x, by_width;
  SmoothPositive(double x, double width) {
    const double root = std::sqrt(x * x + 4.0 * width * width);
    // For x < 0 in the form that does not cancel.
    value = x >= 0.0 ? 0.5 * (x + root) : 2.0 * width * width / (root - x);
    by_x = value / root;
    by_width = 2.0 * width / root;
  }
};

}  // namespace

void ContactPath::reserve(std::size_t rows) {
  for (auto* vector : {&y_, &trial_, &tangent_, &next_tangent_, &u_, &F_, &change_})
    vector->reserve(rows + 1);
  A_.reserve((rows + 1) * (rows + 3));
}

void ContactPath::set_parameter(double log_softness) {
  s_ = std::exp(log_softness);
  rho_ = 1.0 / (1.0 + s_);
  width_ = smoothing_ * s_;
}

/// F and its Jacobian at the point, into F_ and A_. Returns the largest |F| over the width.
double ContactPath::evaluate(std::span<const double> point) {
  set_parameter(point[n_]);
  const std::size_t width = n_ + 3;
  for (std::size_t i = 0; i < n_; ++i)
    u_[i] = row_velocity(problem_.W, problem_.b, point.first(n_), i) + s_ * point[i];
  std::fill(A_.begin(), A_.end(), 0.0);
  for (std::size_t c = 0; c < problem_.contacts; ++c) contact_rows(c, point.data());
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) joint_row(j, point.data());
  double worst = 0.0;
  for (std::size_t i = 0; i < n_; ++i) {
    A_[i * width + n_ + 1] = -F_[i];
    worst = std::max(worst, std::abs(F_[i]));
  }
  return worst / width_;
}

void ContactPath::contact_rows(std::size_t contact, const double* y) {
  const std::size_t i = 3 * contact, width = n_ + 3;
  const double* const W = &problem_.W[i * n_];
  if (block_scale(problem_.W, n_, i, 3) == 0.0) {
    for (std::size_t r = i; r < i + 3; ++r) A_[r * width + r] = 1.0, F_[r] = y[r];
    return;
  }
  // min(y, rho u) = y - max(y - rho u, 0)
  const SmoothPositive open(y[i] - rho_ * u_[i], width_);
  double* const row = &A_[i * width];
  F_[i] = y[i] - open.value;
  for (std::size_t k = 0; k < n_; ++k) row[k] = (open.by_x * rho_) * W[k];
  row[i] += 1.0 - open.by_x * (1.0 - rho_ * s_);
  row[n_] = open.by_x * ((rho_ * s_) * (y[i] - rho_ * u_[i])) - open.by_width * width_;
  tangential_rows(i, problem_.friction[contact], y);
}

/// y_t = z r / max(|z|, r), z = y_t - rho u_t, r = friction max(y_n, 0), all maxima rounded off.
void ContactPath::tangential_rows(std::size_t i, double friction, const double* y) {
  const std::size_t width = n_ + 3;
  const SmoothPositive normal(y[i], width_);
  const double r = friction * normal.value;
  const double z[2] = {y[i + 1] - rho_ * u_[i + 1], y[i + 2] - rho_ * u_[i + 2]};
  const double length = std::sqrt((z[0] * z[0] + z[1] * z[1]) + width_ * width_);
  const SmoothPositive excess(length - r, width_);
  const double most = r + excess.value, ratio = r / most;
  const double by_length = -ratio / most * excess.by_x;  // of the ratio
  const double by_radius = (1.0 - ratio * (1.0 - excess.by_x)) / most;
  const double by_width = by_length * (width_ / length) - ratio / most * excess.by_width +
                          by_radius * (friction * normal.by_width);
  for (std::size_t a = 0; a < 2; ++a) {
    double* const row = &A_[(i + 1 + a) * width];
    F_[i + 1 + a] = y[i + 1 + a] - ratio * z[a];
    row[i + 1 + a] = 1.0;
    row[i] -= z[a] * (by_radius * (friction * normal.by_x));
    row[n_] = -z[a] * (by_width * width_);
    for (std::size_t c = 0; c < 2; ++c) {
      const double by_z = (a == c ? ratio : 0.0) + z[a] * (by_length * (z[c] / length));
      const double* const W = &problem_.W[(i + 1 + c) * n_];
      subtract_multiple(row, W, -(by_z * rho_), n_);
      row[i + 1 + c] -= by_z * (1.0 - rho_ * s_);
      row[n_] += by_z * ((rho_ * s_) * (y[i + 1 + c] - rho_ * u_[i + 1 + c]));
    }
  }
}

void ContactPath::joint_row(std::size_t joint, const double* y) {
  const std::size_t i = 3 * problem_.contacts + joint, width = n_ + 3;
  const auto& bounds = problem_.bounds[joint];
  double* const row = &A_[i * width];
  const double scale = problem_.W[i * n_ + i];
  const double z = y[i] - rho_ * u_[i];
  double value = z, by_z = 1.0, by_width = 0.0;
  if (std::isfinite(bounds.upper)) {
    const SmoothPositive over(z - bounds.upper, width_);
    value -= over.value, by_z -= over.by_x, by_width -= over.by_width;
  }
  if (std::isfinite(bounds.lower)) {
    const SmoothPositive under(bounds.lower - z, width_);
    value += under.value, by_z -= under.by_x, by_width += under.by_width;
  }
  if (scale == 0.0) value = by_z = by_width = 0.0;
  F_[i] = y[i] - value;
  const double* const W = &problem_.W[i * n_];
  for (std::size_t k = 0; k < n_; ++k) row[k] = (by_z * rho_) * W[k];
  row[i] += 1.0 - by_z * (1.0 - rho_ * s_);
  row[n_] = by_z * ((rho_ * s_) * (y[i] - rho_ * u_[i])) - by_width * width_;
}

/// Newton's step across the tangent into change_ and the tangent here into next_tangent_: A_ with the tangent
/// as its last row, by elimination with row pivots.
bool ContactPath::solve_bordered() {
  ++linear_solves_;
  const std::size_t n = n_ + 1, width = n_ + 3;
  for (std::size_t k = 0; k < n; ++k) A_[n_ * width + k] = tangent_[k] / (k < n_ ? size_ * size_ : 1.0);
  A_[n_ * width + n] = 0.0;
  A_[n_ * width + n + 1] = 1.0;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (std::abs(A_[i * width + k]) > std::abs(A_[pivot * width + k])) pivot = i;
    if (!(std::abs(A_[pivot * width + k]) > 0.0)) return false;
    if (pivot != k) std::swap_ranges(&A_[k * width + k], &A_[k * width + width], &A_[pivot * width + k]);
    const double* const row_k = &A_[k * width];
    const double inverse = 1.0 / row_k[k];
    for (std::size_t i = k + 1; i < n; ++i) A_[i * width + k] *= inverse;
    eliminate(A_.data(), width, k, n, width);
  }
  double length = 0.0;
  for (std::size_t i = n; i-- > 0;) {
    double step = A_[i * width + n], along = A_[i * width + n + 1];
    for (std::size_t j = i + 1; j < n; ++j) {
      step -= A_[i * width + j] * change_[j];
      along -= A_[i * width + j] * next_tangent_[j];
    }
    change_[i] = step / A_[i * width + i];
    next_tangent_[i] = along / A_[i * width + i];
    if (!std::isfinite(change_[i]) || !std::isfinite(next_tangent_[i])) return false;
    const double scaled = i < n_ ? next_tangent_[i] / size_ : next_tangent_[i];
    length += scaled * scaled;
  }
  length = std::sqrt(length);
  for (std::size_t i = 0; i < n; ++i) next_tangent_[i] /= length;
  return true;
}

/// Brings trial_ to the path, at right angles to the tangent.
bool ContactPath::correct(double tolerance, int most_steps) {
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0;; ++i) {
    const double off = evaluate(trial_);
    if (!(off <= 1e6) || (i > 1 && off > last)) return false;
    if (!solve_bordered()) return false;
    if (off <= tolerance) return true;
    if (i == most_steps) return false;
    last = off;
    for (std::size_t k = 0; k <= n_; ++k) trial_[k] += change_[k];
  }
}

void ContactPath::keep() {
  y_ = trial_;
  tangent_ = next_tangent_;
  softness_ = std::exp(y_[n_]);
}

bool ContactPath::start(const Problem& problem, const Way& way) {
  problem_ = problem;
  n_ = problem.b.size();
  linear_solves_ = 0;
  for (auto* vector : {&y_, &trial_, &tangent_, &next_tangent_, &u_, &F_, &change_})
    vector->assign(n_ + 1, 0.0);
  A_.assign((n_ + 1) * (n_ + 3), 0.0);
  double largest = 0.0;
  for (const double b : problem.b) largest = std::max(largest, std::abs(b));
  if (!(largest > 0.0)) return false;
  way_ = way;
  smoothing_ = way.smoothing * largest;
  size_ = least_size_ = largest;
  tangent_[n_] = -1.0;
  trial_[n_] = kFirstLogSoftness;
  if (!correct(way_.most_off, kMostFirstCorrections)) return false;
  keep();
  step_ = kFirstStep;
  return true;
}

bool ContactPath::advance() {
  for (; step_ > way_.shortest_step; step_ *= 0.35) {
    size_ = least_size_;
    for (std::size_t i = 0; i < n_; ++i) size_ = std::max(size_, std::abs(y_[i]));
    double length = 0.0;
    for (std::size_t i = 0; i <= n_; ++i) {
      const double scaled = i < n_ ? tangent_[i] / size_ : tangent_[i];
      length += scaled * scaled;
    }
    length = std::sqrt(length);
    for (std::size_t i = 0; i <= n_; ++i) {
      tangent_[i] /= length;
      trial_[i] = y_[i] + step_ * tangent_[i];
    }
    const int before = linear_solves_;
    if (!correct(way_.most_off, kMostCorrections)) continue;
    double turn = 0.0;
    for (std::size_t i = 0; i <= n_; ++i)
      turn += tangent_[i] * next_tangent_[i] / (i < n_ ? size_ * size_ : 1.0);
    if (turn < 0.5) continue;
    keep();
    const int solves = linear_solves_ - before;
    if (solves <= 3) step_ = std::min(2.0 * step_, kLongestStep);
    if (solves >= 6) step_ *= 0.7;
    return true;
  }
  return false;
}

}  // namespace touchstone::physics

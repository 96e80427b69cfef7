#include "touchstone/physics/solver/contact_arc.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/physics/solver/contact_laws.hpp"

namespace touchstone::physics {
namespace {

// The first softness over the largest sum of a row of |W|: there u turns with y nearly as s y does, and
// sweeps halve the error many times over each.
constexpr double kFirstSoftness = 16.0;
constexpr int kFirstSweeps = 16;

// Where log s changes less than this along the arc, all is taken for linear in its length.
constexpr double kSlope = 1e-3;
// Points closer together tell nothing of curvature, nor do points that lie on either side of a turn.
constexpr double kShortestOffset = 1e-4, kLeastRate = 1e-2;

/// Close to exp(x) for |x| up to 3, in arithmetic that is the same everywhere.
double growth(double x) {
  const double h = 0.125 * std::clamp(x, -4.0, 4.0), ratio = (1.0 + h) / (1.0 - h);
  return (ratio * ratio) * (ratio * ratio);
}

}  // namespace

std::size_t ContactArc::unknowns(Status status) {
  switch (status) {
    case Status::closed:
    case Status::within:
      return 1;
    case Status::slip:
      return 2;
    case Status::stick:
      return 3;
    default:
      return 0;
  }
}

void ContactArc::reserve(std::size_t rows) {
  for (auto* vector : {&y_, &u_, &slope_, &du_, &e_, &kept_y_, &kept_e_, &units_}) vector->reserve(rows + 1);
  status_.reserve(rows);
  first_.reserve(rows);
  G_.reserve(rows * rows);
  A_.reserve((rows + 1) * (rows + 3));
}

void ContactArc::load(const ScaledContacts& problem, std::span<const double> anchor) {
  problem_ = problem;
  anchor_ = anchor;
  n_ = problem.rows();
  for (auto* vector : {&y_, &u_, &slope_, &du_, &units_}) vector->assign(n_ + 1, 0.0);
  y_.resize(n_);
  e_.assign(2 * problem.blocks(), 0.0);
  status_.assign(problem.blocks(), Status::still);
  first_.assign(problem.blocks(), 0);
  G_.resize(n_ * n_);
  A_.resize((n_ + 1) * (n_ + 3));
}

/// By fixed-point steps of the projected softened laws, which contract where s is large.
bool ContactArc::begin() {
  // The largest entry of b scales the speeds.
  speed_ = 0.0;
  for (const double b : problem_.b) speed_ = std::max(speed_, std::abs(b));
  if (!(speed_ > 0.0)) return false;
  // The first softness is a multiple of the largest row sum of W.
  double most = 0.0;
  for (std::size_t i = 0; i < n_; ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k < n_; ++k) sum += std::abs(problem_.W[i * n_ + k]);
    most = std::max(most, sum);
  }
  s_ = kFirstSoftness * most;
  if (!(s_ > 0.0)) return false;
  // Sweeps of projected steps solve the softened problem.
  for (int sweep = 0; sweep < kFirstSweeps; ++sweep) {
    update_velocities();
    for (std::size_t c = 0; c < problem_.contacts; ++c) {
      const std::size_t i = 3 * c;
      if (block_scale(problem_.W, n_, i, 3) == 0.0) continue;
      for (std::size_t k = i; k < i + 3; ++k) y_[k] -= u_[k] / s_;
      y_[i] = std::max(0.0, y_[i]);
      project_on_disc(problem_.friction[c] * y_[i], y_[i + 1], y_[i + 2]);
    }
    for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
      const std::size_t i = 3 * problem_.contacts + j;
      if (problem_.W[i * n_ + i] > 0.0) y_[i] = clamped(y_[i] - u_[i] / s_, problem_.bounds[j]);
    }
  }
  // Each block's status follows from the point reached.
  update_velocities();
  for (std::size_t k = 0; k < problem_.blocks(); ++k) set_status(k);
  number_unknowns();
  return true;
}

/// By the values of a point that meets the laws.
void ContactArc::set_status(std::size_t block) {
  const std::size_t i = problem_.row(block);
  Status& status = status_[block];
  // A joint row is at a bound or between them.
  if (block >= problem_.contacts) {
    const auto& bounds = problem_.bounds[block - problem_.contacts];
    status = problem_.W[i * n_ + i] == 0.0 || bounds.lower == bounds.upper ? Status::still
             : y_[i] <= bounds.lower                                       ? Status::lower
             : y_[i] >= bounds.upper                                       ? Status::upper
                                                                           : Status::within;
    return;
  }
  // A contact that no impulse moves stays still.
  if (block_scale(problem_.W, n_, i, 3) == 0.0) {
    status = Status::still;
    return;
  }
  // A contact is open, without friction, sticking or slipping along `e_`.
  const double radius = problem_.friction[block] * y_[i];
  const double z1 = y_[i + 1] - u_[i + 1] / s_, z2 = y_[i + 2] - u_[i + 2] / s_, length = length_of(z1, z2);
  if (!(y_[i] > 0.0)) {
    status = Status::open;
  } else if (problem_.friction[block] == 0.0) {
    status = Status::closed;
  } else if (length <= radius) {
    status = Status::stick;
  } else {
    status = Status::slip;
    e_[2 * block] = z1 / length, e_[2 * block + 1] = z2 / length;
    y_[i + 1] = radius * e_[2 * block], y_[i + 2] = radius * e_[2 * block + 1];
  }
}

void ContactArc::number_unknowns() {
  m_ = 0;
  for (std::size_t k = 0; k < problem_.blocks(); ++k) {
    first_[k] = m_;
    m_ += unknowns(status_[k]);
  }
}

void ContactArc::update_velocities() {
  size_ = speed_;
  for (std::size_t i = 0; i < n_; ++i) {
    size_ = std::max(size_, std::abs(y_[i]));
    slope_[i] = s_ * (y_[i] - (anchor_.empty() ? 0.0 : anchor_[i]));
    u_[i] = problem_.b[i] + slope_[i];
  }
  for (std::size_t k = 0; k < n_; ++k)
    if (y_[k] != 0.0) subtract_multiple(u_.data(), &problem_.W[k * n_], -y_[k], n_);
}

/// u by each unknown.
void ContactArc::fill_velocities() {
  const auto combine = [&](std::size_t unknown, std::size_t row, const double* d, std::size_t size) {
    double* const g = &G_[unknown * n_];
    for (std::size_t k = 0; k < n_; ++k) g[k] = d[0] * problem_.W[row * n_ + k];
    for (std::size_t i = 1; i < size; ++i) subtract_multiple(g, &problem_.W[(row + i) * n_], -d[i], n_);
    for (std::size_t i = 0; i < size; ++i) g[row + i] += s_ * d[i];
  };
  const double one = 1.0;
  for (std::size_t k = 0; k < problem_.blocks(); ++k) {
    const std::size_t row = problem_.row(k), j = first_[k];
    for (std::size_t i = 0; i < unknowns(status_[k]); ++i) units_[j + i] = size_;
    if (status_[k] == Status::slip) {
      const double *const e = &e_[2 * k], f = problem_.friction[k], r = f * y_[row];
      const double normal[3] = {1.0, f * e[0], f * e[1]}, turn[2] = {-r * e[1], r * e[0]};
      combine(j, row, normal, 3);
      combine(j + 1, row + 1, turn, 2);
      units_[j + 1] = 1.0;
      continue;
    }
    for (std::size_t i = 0; i < unknowns(status_[k]); ++i) combine(j + i, row + i, &one, 1);
  }
  units_[m_] = 1.0;
}

/// u = 0 of a row.
void ContactArc::fill_row(std::size_t equation, std::size_t row) {
  double* const a = &A_[equation * (m_ + 3)];
  for (std::size_t j = 0; j < m_; ++j) a[j] = G_[j * n_ + row];
  a[m_] = slope_[row];
  a[m_ + 1] = -u_[row];
  a[m_ + 2] = 0.0;
}

/// No slip across the direction of friction.
void ContactArc::fill_turn(std::size_t block) {
  const std::size_t j = first_[block] + 1, t1 = problem_.row(block) + 1, t2 = t1 + 1;
  const double e0 = e_[2 * block], e1 = e_[2 * block + 1];
  double* const a = &A_[j * (m_ + 3)];
  for (std::size_t k = 0; k < m_; ++k) a[k] = e0 * G_[k * n_ + t2] - e1 * G_[k * n_ + t1];
  a[j] -= e0 * u_[t1] + e1 * u_[t2];
  a[m_] = e0 * slope_[t2] - e1 * slope_[t1];
  a[m_ + 1] = e1 * u_[t1] - e0 * u_[t2];
  a[m_ + 2] = 0.0;
}

double ContactArc::linearise() {
  update_velocities();
  fill_velocities();
  for (std::size_t k = 0; k < problem_.blocks(); ++k) {
    const std::size_t row = problem_.row(k), j = first_[k];
    const bool slips = status_[k] == Status::slip;
    for (std::size_t i = 0; i < (slips ? 1 : unknowns(status_[k])); ++i) fill_row(j + i, row + i);
    if (slips) fill_turn(k);
  }
  double worst = 0.0;
  for (std::size_t i = 0; i < m_; ++i) worst = std::max(worst, std::abs(A_[i * (m_ + 3) + m_ + 1]));
  return worst / speed_;
}

void ContactArc::border_by(std::span<const double> tangent) {
  double* const a = &A_[m_ * (m_ + 3)];
  for (std::size_t j = 0; j <= m_; ++j) a[j] = tangent[j] / (units_[j] * units_[j]);
  a[m_ + 1] = 0.0;
  a[m_ + 2] = 1.0;
}

/// By elimination with row pivots.
bool ContactArc::solve(std::span<double> step, std::span<double> along) {
  const std::size_t n = m_ + 1, width = m_ + 3;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (std::abs(A_[i * width + k]) > std::abs(A_[pivot * width + k])) pivot = i;
    if (!(std::abs(A_[pivot * width + k]) > 0.0)) return false;
    if (pivot != k) std::swap_ranges(&A_[k * width + k], &A_[k * width] + width, &A_[pivot * width + k]);
    const double inverse = 1.0 / A_[k * width + k];
    for (std::size_t i = k + 1; i < n; ++i) A_[i * width + k] *= inverse;
    eliminate(A_.data(), width, k, n, width);
  }
  for (std::size_t i = n; i-- > 0;) {
    const double* const row = &A_[i * width];
    step[i] = (row[n] - sum_of_products(row + i + 1, &step[i + 1], n - i - 1)) / row[i];
    along[i] = (row[n + 1] - sum_of_products(row + i + 1, &along[i + 1], n - i - 1)) / row[i];
    if (!std::isfinite(step[i]) || !std::isfinite(along[i])) return false;
  }
  return true;
}

void ContactArc::move_unknowns(double factor, std::span<const double> step) {
  for (std::size_t k = 0; k < problem_.blocks(); ++k) {
    const std::size_t row = problem_.row(k);
    const double* const d = step.data() + first_[k];
    if (status_[k] == Status::slip) {
      y_[row] += factor * d[0];
      // By the half angle, without sine and cosine.
      const double t = 0.5 * (factor * d[1]);
      const double cos = (1.0 - t * t) / (1.0 + t * t), sin = 2.0 * t / (1.0 + t * t);
      double* const e = &e_[2 * k];
      const double e0 = cos * e[0] - sin * e[1], e1 = sin * e[0] + cos * e[1], length = length_of(e0, e1);
      e[0] = e0 / length, e[1] = e1 / length;
      const double r = problem_.friction[k] * y_[row];
      y_[row + 1] = r * e[0], y_[row + 2] = r * e[1];
      continue;
    }
    for (std::size_t i = 0; i < unknowns(status_[k]); ++i) y_[row + i] += factor * d[i];
  }
}

void ContactArc::move(std::span<const double> step) {
  move_unknowns(1.0, step);
  s_ *= growth(step[m_]);
}

void ContactArc::predict(std::span<const double> tangent, std::span<const double> curvature, double length) {
  const double slope = tangent[m_];
  const double ratio = growth(length * slope + (0.5 * length * length) * curvature[m_]);
  // (p(s ratio) - p(s)) / (dp/dlog s slope), p = s / (1 + s)
  const double factor =
      std::abs(slope) > kSlope ? (ratio - 1.0) * (1.0 + s_) / (slope * (1.0 + s_ * ratio)) : length;
  for (std::size_t j = 0; j < m_; ++j)
    units_[j] = factor * tangent[j] + (0.5 * factor * factor) * curvature[j];
  move_unknowns(1.0, units_);
  s_ *= ratio;
}

void ContactArc::find_curvature(std::span<const double> before, std::span<const double> tangent,
                                double length, std::span<double> curvature) const {
  const double slope = tangent[m_], slope_before = before[m_];
  double offset = -length, rate = 1.0;  // predict()'s factor at the point before, and its rate there
  if (std::abs(slope) > kSlope) {
    const double share = (1.0 + s_) / (1.0 + kept_s_);
    offset = (kept_s_ - s_) * share / (s_ * slope);
    rate = (kept_s_ / s_) * (share * share) * (slope_before / slope);
  }
  const bool is_useful = offset < -kShortestOffset && rate > kLeastRate;
  for (std::size_t j = 0; j < m_; ++j)
    curvature[j] = is_useful ? (tangent[j] - before[j] / rate) / -offset : 0.0;
  curvature[m_] = is_useful ? (slope - slope_before) / length : 0.0;
}

double ContactArc::length_to_zero(double value, double rate, std::span<const double> tangent) const {
  const double factor = std::max(value, 0.0) / -rate, slope = tangent[m_];
  if (!(rate < 0.0) || !(std::abs(slope) > kSlope)) return rate < 0.0 ? factor : kInfinity;
  // predict()'s factor for the ratio, then growth() for the length.
  const double share = slope * factor / (1.0 + s_), ratio = (1.0 + share) / (1.0 - s_ * share);
  if (!(1.0 + share > 0.0) || !(1.0 - s_ * share > 0.0)) return kInfinity;
  const double root = std::sqrt(std::sqrt(ratio)), length = 8.0 * (root - 1.0) / ((root + 1.0) * slope);
  return std::max(length, 0.0);
}

void ContactArc::keep() { kept_y_ = y_, kept_e_ = e_, kept_s_ = s_; }
void ContactArc::go_back() { y_ = kept_y_, e_ = kept_e_, s_ = kept_s_; }

}  // namespace touchstone::physics

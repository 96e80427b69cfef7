#include "touchstone/physics/solver/contact_newton.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/physics/solver/contact_laws.hpp"
#include "touchstone/physics/solver/reserved.hpp"

namespace touchstone::physics {
namespace {

// Rows that stop say u = 0, which redundant contacts say several times over: the proximal term makes them
// independent and, vanishing with the step, moves no solution. 2^-40 of the diagonal is far above rounding
// and far below 1.
constexpr double kProximal = 0x1p-40;

}  // namespace

void ContactNewton::reserve(std::size_t rows) {
  reserve_written(law_, rows);
  for (auto* vector : {&active_, &end_, &block_end_}) reserve_written(*vector, rows);
  reserve_written(before_, rows + 1);
  for (auto* vector : {&met_u_, &right_, &held_w_}) reserve_written(*vector, rows);
  reserve_written(A_, rows * rows, kDenseRows * kDenseRows);
  equations_.reserve(rows, rows / ContactProblem::kRowsARate);
}

void ContactNewton::decide_contact(std::size_t contact, std::span<double> step) {
  const std::size_t i = 3 * contact;
  if (problem_->scale(i) == 0.0 || y_[i] - rho_ * u_[i] <= 0.0) {
    for (std::size_t k = i; k < i + 3; ++k) law_[k] = Law::held, step[k] = -y_[k];
    return;
  }
  const double z1 = y_[i + 1] - rho_ * u_[i + 1], z2 = y_[i + 2] - rho_ * u_[i + 2];
  const double length = std::sqrt(z1 * z1 + z2 * z2);
  const double radius = problem_->view().friction[contact] * std::max(y_[i], 0.0);
  law_[i] = Law::stopped;
  law_[i + 1] = law_[i + 2] = length <= radius || length == 0.0 ? Law::stopped : Law::slipping;
}

/// Decides which rows are held, and by how much they move there.
void ContactNewton::decide(std::span<double> step) {
  const ScaledContacts& view = problem_->view();
  law_.resize(n_);
  for (std::size_t c = 0; c < view.contacts; ++c) decide_contact(c, step);
  // A joint row is held at a bound, or its velocity is stopped.
  for (std::size_t i = 3 * view.contacts; i < n_; ++i) {
    const auto& bounds = view.bounds[i - 3 * view.contacts];
    const double z = y_[i] - rho_ * u_[i];
    law_[i] = Law::held;
    if (problem_->scale(i) == 0.0) {
      step[i] = -y_[i];
    } else if (z <= bounds.lower) {
      step[i] = bounds.lower - y_[i];
    } else if (z >= bounds.upper) {
      step[i] = bounds.upper - y_[i];
    } else {
      law_[i] = Law::stopped;
    }
  }
  // Rows that are not held are the unknowns; the held rows' steps change the velocities.
  met_u_.assign(u_.begin(), u_.end());
  if (problem_->is_by_rates()) return meet_by_rates(step);
  active_.clear();
  before_.resize(n_ + 1);
  for (std::size_t i = 0; i < n_; ++i) {
    before_[i] = active_.size();
    if (law_[i] != Law::held) {
      active_.push_back(i);
    } else if (step[i] != 0.0) {
      const auto [first, end] = problem_->columns(i);
      subtract_multiple(&met_u_[first], &view.W[i * n_ + first], -step[i], end - first);
    }
  }
  before_[n_] = m_ = active_.size();
}

/// Adds a row of W to an equation.
void ContactNewton::gather(std::size_t equation, std::size_t row, double factor) {
  const auto [first, end] = problem_->columns(row);
  const double* const W = &problem_->view().W[row * n_];
  double* const a = &A_[equation * m_];
  for (std::size_t k = before_[first]; k < before_[end]; ++k) a[k] += factor * W[active_[k]];
}

/// u = 0.
void ContactNewton::fill_stop(std::size_t row) {
  const std::size_t i = before_[row];
  gather(i, row, 1.0);
  A_[i * m_ + i] += kProximal;
  right_[i] = -met_u_[row];
}

/// y_t = f y_n z / |z|: its derivative turns with z across z, and grows with y_n along it.
void ContactNewton::fill_slip(std::size_t contact) {
  const std::size_t row = 3 * contact, i = before_[row];
  const double friction = problem_->view().friction[contact];
  const double radius = friction * std::max(y_[row], 0.0);
  const double z1 = y_[row + 1] - rho_ * u_[row + 1], z2 = y_[row + 2] - rho_ * u_[row + 2];
  const double length = std::sqrt(z1 * z1 + z2 * z2), e[2] = {z1 / length, z2 / length};
  const double ratio = std::min(radius / length, 1.0);
  for (std::size_t r = 0; r < 2; ++r) {
    double* const a = &A_[(i + 1 + r) * m_];
    double right = radius * e[r] - y_[row + 1 + r];
    for (std::size_t s = 0; s < 2; ++s) {
      const double one = r == s ? 1.0 : 0.0, across = ratio * (one - e[r] * e[s]);
      gather(i + 1 + r, row + 1 + s, rho_ * across);
      a[i + 1 + s] += one - across;
      right -= (rho_ * across) * (met_u_[row + 1 + s] - u_[row + 1 + s]);
    }
    if (y_[row] > 0.0) a[i] -= friction * e[r];
    right_[i + 1 + r] = right;
  }
}

/// Across is e turned by a right angle.
ContactNewton::Slip ContactNewton::slip_of(std::size_t contact) const {
  const std::size_t row = 3 * contact;
  const double friction = problem_->view().friction[contact], radius = friction * std::max(y_[row], 0.0);
  const double z1 = y_[row + 1] - rho_ * u_[row + 1], z2 = y_[row + 2] - rho_ * u_[row + 2];
  const double length = std::sqrt(z1 * z1 + z2 * z2), e[2] = {z1 / length, z2 / length};
  return {{e[0], e[1]},
          std::min(radius / length, 1.0),
          y_[row] > 0.0 ? friction : 0.0,
          radius - (e[0] * y_[row + 1] + e[1] * y_[row + 2])};
}

void ContactNewton::fill() {
  A_.assign(m_ * m_, 0.0);
  right_.resize(m_);
  const std::size_t contact_rows = 3 * problem_->view().contacts;
  for (const std::size_t row : active_) {
    if (law_[row] == Law::stopped) fill_stop(row);
    if (law_[row] == Law::slipping && row % 3 == 1 && row < contact_rows) fill_slip(row / 3);
  }
}

/// W is symmetric: the columns in which a row may be nonzero are rows that may be nonzero in its column.
void ContactNewton::find_profile() {
  end_.resize(m_);
  block_end_.resize(m_);
  const std::size_t contact_rows = 3 * problem_->view().contacts;
  for (std::size_t i = 0; i < m_; ++i) {
    const std::size_t row = active_[i], block = row < contact_rows ? row - row % 3 : row;
    const std::size_t last = row < contact_rows ? block + 3 : row + 1;
    std::size_t end = last;
    for (std::size_t k = block; k < last; ++k) end = std::max(end, problem_->columns(k).end);
    end_[i] = before_[end];
    // Rows of a contact take each other's columns, so whole contacts are reached.
    if (end < contact_rows) end += (3 - end % 3) % 3;
    block_end_[i] = before_[end];
  }
}

/// right_ = A_^-1 right_ with row pivots; A_ is spoilt.
bool ContactNewton::eliminate_rows() {
  const std::size_t m = m_;
  std::size_t reach = 0;         // rows up to here may hold something in the columns so far
  std::size_t products = m * m;  // of filling, at most; each entry is cleared besides
  for (std::size_t k = 0; k < m; ++k) {
    reach = std::max(reach, block_end_[k]);
    // The column's largest entry is the pivot.
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < reach; ++i)
      if (std::abs(A_[i * m + k]) > std::abs(A_[pivot * m + k])) pivot = i;
    if (!(std::abs(A_[pivot * m + k]) > 0.0)) return false;
    if (pivot != k) {
      const std::size_t most = std::max(end_[k], end_[pivot]);
      std::swap_ranges(&A_[k * m + k], &A_[k * m] + most, &A_[pivot * m + k]);
      std::swap(end_[k], end_[pivot]);
      std::swap(right_[k], right_[pivot]);
    }
    // The rows below are eliminated within the profile.
    const double inverse = 1.0 / A_[k * m + k];
    for (std::size_t i = k + 1; i < reach; ++i) {
      double& entry = A_[i * m + k];
      if (entry == 0.0) continue;
      entry *= inverse;
      end_[i] = std::max(end_[i], end_[k]);
      right_[i] -= entry * right_[k];
    }
    eliminate(A_.data(), m, k, reach, end_[k]);
    products += (reach - k) * (end_[k] - k);
  }
  work_ = static_cast<double>(products);
  // Back substitution gives the solution.
  for (std::size_t i = m; i-- > 0;) {
    const double sum = sum_of_products(&A_[i * m] + i + 1, right_.data() + i + 1, end_[i] - i - 1);
    right_[i] = (right_[i] - sum) / A_[i * m + i];
    if (!std::isfinite(right_[i])) return false;
  }
  return true;
}

/// met_u_, of the held rows' steps.
void ContactNewton::meet_by_rates(std::span<const double> step) {
  const std::size_t rates = problem_->unscaled().rates;
  held_w_.assign(rates, 0.0);
  bool is_any = false;
  for (std::size_t i = 0; i < n_; ++i) {
    if (law_[i] != Law::held || step[i] == 0.0) continue;
    const auto [first, end] = problem_->rates(i / 3);
    subtract_multiple(&held_w_[first], problem_->Y(i) + first, -step[i], end - first);
    is_any = true;
  }
  for (std::size_t i = 0; i < n_ && is_any; ++i) {
    const auto [first, end] = problem_->rates(i / 3);
    met_u_[i] += sum_of_products(problem_->J(i) + first, &held_w_[first], end - first);
  }
}

/// u = 0.
void ContactNewton::add_stop(std::size_t row, RateEquations::Reach reach) {
  equations_.add(reach, kProximal, -met_u_[row]);
  std::copy(problem_->Y(row) + reach.first, problem_->Y(row) + reach.end, equations_.left() + reach.first);
  std::copy(problem_->J(row) + reach.first, problem_->J(row) + reach.end, equations_.of() + reach.first);
}

/// As fill_slip(): the normal's, which takes the tangents along where they slip with it, and that of what is
/// across the slip.
void ContactNewton::add_slip(std::size_t contact) {
  const std::size_t row = 3 * contact;
  const auto [first, end] = problem_->rates(contact);
  const Slip slip = slip_of(contact);
  const double *const J1 = problem_->J(row + 1), *const J2 = problem_->J(row + 2);
  const double *const Y1 = problem_->Y(row + 1), *const Y2 = problem_->Y(row + 2);
  add_stop(row, {first, end});
  double* left = equations_.left();
  for (std::size_t k = first; k < end; ++k) {
    const double along = slip.e[0] * Y1[k] + slip.e[1] * Y2[k];
    left[k] += slip.friction * along;
    equations_.start()[k] += slip.along * along;
  }
  const double by_u = rho_ * slip.ratio;
  const double u1 = met_u_[row + 1] - u_[row + 1], u2 = met_u_[row + 2] - u_[row + 2];
  equations_.add({first, end}, 1.0 - slip.ratio,
                 slip.across(-y_[row + 1], -y_[row + 2]) - by_u * slip.across(u1, u2));
  left = equations_.left();
  double* const of = equations_.of();
  for (std::size_t k = first; k < end; ++k)
    left[k] = slip.across(Y1[k], Y2[k]), of[k] = by_u * slip.across(J1[k], J2[k]);
}

bool ContactNewton::solve_by_rates(std::span<double> step) {
  const std::size_t contacts = problem_->view().contacts;
  equations_.begin(problem_->unscaled().rates);
  for (std::size_t c = 0; c < contacts; ++c) {
    const auto [first, end] = problem_->rates(c);
    if (law_[3 * c] == Law::held) continue;
    if (law_[3 * c + 1] == Law::slipping) {
      add_slip(c);
      continue;
    }
    for (std::size_t i = 3 * c; i < 3 * c + 3; ++i) add_stop(i, {first, end});
  }
  const bool is_solved = equations_.solve();
  work_ = ContactProblem::kPriceOfRates * equations_.work();
  if (!is_solved) return false;
  // Each contact's steps, in the same order.
  std::size_t at = 0;
  for (std::size_t c = 0; c < contacts; ++c) {
    if (law_[3 * c] == Law::held) continue;
    step[3 * c] = equations_.solution(at++);
    if (law_[3 * c + 1] != Law::slipping) {
      for (std::size_t i = 3 * c + 1; i < 3 * c + 3; ++i) step[i] = equations_.solution(at++);
      continue;
    }
    const Slip slip = slip_of(c);
    const double along = slip.along + slip.friction * step[3 * c], across = equations_.solution(at++);
    step[3 * c + 1] = slip.e[0] * along - slip.e[1] * across;
    step[3 * c + 2] = slip.e[1] * along + slip.e[0] * across;
  }
  return true;
}

bool ContactNewton::step(const ScaledProblem& problem, std::span<const double> y, std::span<const double> u,
                         double rho, std::span<double> step) {
  problem_ = &problem;
  y_ = y, u_ = u, rho_ = rho;
  n_ = y.size();
  decide(step);
  if (problem.is_by_rates()) return solve_by_rates(step);
  fill();
  find_profile();
  if (!eliminate_rows()) return false;
  for (std::size_t i = 0; i < m_; ++i) step[active_[i]] = right_[i];
  return true;
}

}  // namespace touchstone::physics

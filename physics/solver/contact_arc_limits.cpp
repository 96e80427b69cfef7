// Where arcs end, and which arc comes next.

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/physics/solver/contact_arc.hpp"
#include "touchstone/physics/solver/contact_laws.hpp"

namespace touchstone::physics {

void ContactArc::add_velocity(std::size_t row, double factor) {
  double* const a = &A_[m_ * (m_ + 3)];
  for (std::size_t k = 0; k < m_; ++k) a[k] += factor * G_[k * n_ + row];
  a[m_] += factor * slope_[row];
}

void ContactArc::border_by(Limit limit) {
  const auto [block, second] = limit;
  const std::size_t row = problem_.row(block), j = first_[block];
  // The border row is the gradient of the limit.
  double* const a = &A_[m_ * (m_ + 3)];
  std::fill(a, a + m_ + 1, 0.0);
  double unit = size_;
  // The status decides whether a velocity, an impulse or the friction cone is the limit.
  switch (status_[block]) {
    case Status::open:
    case Status::lower:
    case Status::upper:
      unit = speed_;
      add_velocity(row, status_[block] == Status::upper ? -1.0 : 1.0);
      break;
    case Status::slip:
      if (second) {
        const double e0 = e_[2 * block], e1 = e_[2 * block + 1];
        unit = speed_;
        add_velocity(row + 1, -e0);
        add_velocity(row + 2, -e1);
        a[j + 1] -= e0 * u_[row + 2] - e1 * u_[row + 1];
        break;
      }
      [[fallthrough]];
    case Status::closed:
    case Status::within:
      a[j] = second ? -1.0 : 1.0;
      break;
    case Status::stick: {
      const double length = length_of(y_[row + 1], y_[row + 2]);
      a[j] = problem_.friction[block];
      if (length > 0.0) a[j + 1] = -y_[row + 1] / length, a[j + 2] = -y_[row + 2] / length;
      break;
    }
    case Status::still:
      break;
  }
  // The row is scaled and gets its two right-hand sides.
  for (std::size_t k = 0; k <= m_; ++k) a[k] /= unit;
  a[m_ + 1] = -value(limit);
  a[m_ + 2] = 1.0;
}

double ContactArc::value(Limit limit) const {
  const auto [block, second] = limit;
  const std::size_t row = problem_.row(block);
  const Status status = status_[block];
  const bool has_second = status == Status::slip || status == Status::within;
  if (status == Status::still || (second && !has_second)) return kInfinity;
  switch (status) {
    case Status::open:
    case Status::lower:
      return u_[row] / speed_;
    case Status::upper:
      return -u_[row] / speed_;
    case Status::slip:
      if (second) return -(e_[2 * block] * u_[row + 1] + e_[2 * block + 1] * u_[row + 2]) / speed_;
      return y_[row] / size_;
    case Status::stick:
      return (problem_.friction[block] * y_[row] - length_of(y_[row + 1], y_[row + 2])) / size_;
    case Status::within: {
      const auto& bounds = problem_.bounds[block - problem_.contacts];
      return (second ? bounds.upper - y_[row] : y_[row] - bounds.lower) / size_;
    }
    default:
      return y_[row] / size_;
  }
}

void ContactArc::set_rates(std::span<const double> tangent) {
  for (std::size_t i = 0; i < n_; ++i) du_[i] = tangent[m_] * slope_[i];
  for (std::size_t j = 0; j < m_; ++j) subtract_multiple(du_.data(), &G_[j * n_], -tangent[j], n_);
}

double ContactArc::rate(Limit limit, std::span<const double> tangent) const {
  const auto [block, second] = limit;
  const std::size_t row = problem_.row(block), j = first_[block];
  const Status status = status_[block];
  const bool has_second = status == Status::slip || status == Status::within;
  if (status == Status::still || (second && !has_second)) return 0.0;
  // A velocity, an impulse or the distance to the friction cone changes, by status.
  switch (status) {
    case Status::open:
    case Status::lower:
      return du_[row] / speed_;
    case Status::upper:
      return -du_[row] / speed_;
    case Status::slip:
      if (second) return -(e_[2 * block] * du_[row + 1] + e_[2 * block + 1] * du_[row + 2]) / speed_;
      return tangent[j] / size_;
    case Status::stick: {
      const double length = length_of(y_[row + 1], y_[row + 2]);
      const double outwards = length > 0.0
                                  ? (y_[row + 1] * tangent[j + 1] + y_[row + 2] * tangent[j + 2]) / length
                                  : length_of(tangent[j + 1], tangent[j + 2]);
      return (problem_.friction[block] * tangent[j] - outwards) / size_;
    }
    default:
      return (second ? -tangent[j] : tangent[j]) / size_;
  }
}

ContactArc::Limit ContactArc::cross(Limit limit) {
  const std::size_t block = limit.block, row = problem_.row(block);
  Status& status = status_[block];
  Limit next{block, false};
  double* const e = &e_[2 * block];
  // The status changes as its limit is crossed; `next` is the same point in the new status.
  switch (status) {
    case Status::open: {
      if (problem_.friction[block] == 0.0) {
        status = Status::closed;
        break;
      }
      const double length = length_of(u_[row + 1], u_[row + 2]);
      status = length > 0.0 ? Status::slip : Status::stick;
      if (length > 0.0) e[0] = -u_[row + 1] / length, e[1] = -u_[row + 2] / length;
      break;
    }
    case Status::slip:
      if (limit.second) {
        status = Status::stick;
        break;
      }
      [[fallthrough]];
    case Status::closed:
      status = Status::open;
      std::fill(&y_[row], &y_[row] + 3, 0.0);
      break;
    case Status::stick: {
      const double length = length_of(y_[row + 1], y_[row + 2]);
      status = length > 0.0 ? Status::slip : Status::open;
      next.second = length > 0.0;
      if (length > 0.0) e[0] = y_[row + 1] / length, e[1] = y_[row + 2] / length;
      break;
    }
    case Status::lower:
      status = Status::within;
      break;
    case Status::upper:
      status = Status::within;
      next.second = true;
      break;
    case Status::within:
      status = limit.second ? Status::upper : Status::lower;
      break;
    case Status::still:
      break;
  }
  number_unknowns();
  return next;
}

}  // namespace touchstone::physics

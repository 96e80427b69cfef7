#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "touchstone/physics/solver/contact_problem.hpp"
#include "touchstone/physics/solver/elimination.hpp"

// The laws of one block, shared by the residual and the solver.

namespace touchstone::physics {

/// The larger of two residuals; NaN where one is: std::max would hide that.
inline double worse_of(double a, double b) { return a >= b || a != a ? a : b; }

inline double length_of(double x, double y) { return std::sqrt(x * x + y * y); }

/// Shrinks (x, y) to the disc of radius r.
inline void project_on_disc(double r, double& x, double& y) {
  const double length = length_of(x, y);
  if (length <= r) return;
  const double factor = r > 0.0 ? r / length : 0.0;
  x *= factor;
  y *= factor;
}

inline double clamped(double x, const ContactProblem::Bounds& bounds) {
  return std::min(std::max(x, bounds.lower), bounds.upper);
}

/// (W x + b) of one row.
inline double row_velocity(std::span<const double> W, std::span<const double> b, std::span<const double> x,
                           std::size_t row) {
  return b[row] + sum_of_products(&W[row * x.size()], x.data(), x.size());
}

/// The natural map's residual of a contact of scale w: normal, then two tangents. NaN where x or u is.
inline double contact_residual(double w, double friction, const double* x, const double* u) {
  const double wx = w * x[0], normal = wx < u[0] || wx != wx ? wx : u[0];
  double t1 = x[1] - u[1] / w, t2 = x[2] - u[2] / w;
  project_on_disc(friction * std::max(x[0], 0.0), t1, t2);
  const double r1 = w * (x[1] - t1), r2 = w * (x[2] - t2);
  return worse_of(std::abs(normal), std::sqrt(r1 * r1 + r2 * r2));
}

/// Largest diagonal entry of a block of W.
inline double block_scale(std::span<const double> W, std::size_t n, std::size_t row, std::size_t size) {
  double w = 0.0;
  for (std::size_t i = row; i < row + size; ++i) w = worse_of(w, W[i * n + i]);
  return w;
}

inline double block_scale(const ContactProblem& problem, std::size_t row, std::size_t size) {
  const std::size_t rates = problem.rates;
  if (rates == 0) return block_scale(problem.W, problem.rows(), row, size);
  double w = 0.0;
  for (std::size_t i = row; i < row + size; ++i)
    w = worse_of(w, sum_of_products(&problem.J[i * rates], &problem.Y[i * rates], rates));
  return w;
}

}  // namespace touchstone::physics

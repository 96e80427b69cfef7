#include "touchstone/physics/solver/contact_problem.hpp"

#include <algorithm>

#include "touchstone/physics/solver/contact_laws.hpp"

namespace touchstone::physics {
namespace {

/// u = J Y^T x + b, by the rates one after the other.
void velocities_by_rates(const ContactProblem& problem, std::span<const double> x, std::span<double> u) {
  const std::size_t n = problem.rows(), rates = problem.rates;
  std::copy(problem.b.begin(), problem.b.end(), u.begin());
  for (std::size_t k = 0; k < rates; ++k) {
    double w = 0.0;
    for (std::size_t i = 0; i < n; ++i) w += problem.Y[i * rates + k] * x[i];
    for (std::size_t i = 0; i < n; ++i) u[i] += problem.J[i * rates + k] * w;
  }
}

}  // namespace

double natural_residual(const ContactProblem& problem, std::span<const double> x, std::span<double> u) {
  const std::size_t n = problem.rows();
  if (problem.rates > 0)
    velocities_by_rates(problem, x, u);
  else
    for (std::size_t i = 0; i < n; ++i) u[i] = row_velocity(problem.W, problem.b, x, i);
  double worst = 0.0;
  for (std::size_t c = 0; c < problem.contacts; ++c) {
    const double w = block_scale(problem, 3 * c, 3);
    if (w == 0.0) continue;  // between bodies that no impulse moves: nothing to solve for
    worst = worse_of(worst, contact_residual(w, problem.friction[c], &x[3 * c], &u[3 * c]));
  }
  for (std::size_t j = 0; j < problem.bounds.size(); ++j) {
    const std::size_t i = 3 * problem.contacts + j;
    const double w = problem.W[i * n + i];
    if (!(w <= 0.0))
      worst = worse_of(worst, w * std::abs(x[i] - clamped(x[i] - u[i] / w, problem.bounds[j])));
  }
  return worst;
}

}  // namespace touchstone::physics

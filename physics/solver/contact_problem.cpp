#include "touchstone/physics/solver/contact_problem.hpp"

#include "touchstone/physics/solver/contact_laws.hpp"

namespace touchstone::physics {

double natural_residual(const ContactProblem& problem, std::span<const double> x, std::span<double> u) {
  const std::size_t n = problem.rows();
  for (std::size_t i = 0; i < n; ++i) u[i] = row_velocity(problem.W, problem.b, x, i);
  double worst = 0.0;
  for (std::size_t c = 0; c < problem.contacts; ++c) {
    const double w = block_scale(problem.W, n, 3 * c, 3);
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

// Islands by ConvexContacts: those of any size, and those that contradict themselves.

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/dynamics_world.hpp"

namespace touchstone::physics {
namespace {

// Of what the contact gap allows: what is left moves nothing by more than this share of it in a step.
constexpr double kShareOfGap = 0.1;
// Of the fastest that anything approaches or slides: what is left of large islands that move is not more.
constexpr double kShareOfSpeed = 1e-5;
// What contradicted itself is taken to do so still for so many solves, then tried by all means again.
constexpr std::uint8_t kSoftSolves = 64;

}  // namespace

/// Of an island's residual [m/s].
double DynamicsWorld::tolerance_of(const Island& island, bool is_exact) const {
  const double exact = settings_.solver.tolerance;
  if (settings_.accuracy == Accuracy::exact || is_exact) return exact;
  double speed = 0.0;
  for (std::size_t k = 0; k < island.contacts + island.joints; ++k) {
    const std::size_t first = first_row(block_order_[island.first_block + k]);
    for (std::size_t i = first; i < first + (k < island.contacts ? 3 : 1); ++i)
      speed = std::max(speed, std::abs(b_[i]));
  }
  return std::max({exact, kShareOfGap * settings_.contact_gap / h_, kShareOfSpeed * speed});
}

/// Then exact means are not tried first.
bool DynamicsWorld::is_contradicted(const Island& island) const {
  const std::span<const std::uint32_t> units =
      std::span(unit_order_).subspan(island.first_unit, island.units);
  return settings_.accuracy == Accuracy::bounded &&
         std::any_of(units.begin(), units.end(),
                     [&](std::uint32_t unit) { return contradicted_[unit] != 0; });
}

/// Masses of the island's units, and its loaded rows with units as it counts them.
void DynamicsWorld::load_convex(const Island& island) {
  convex_sizes_.clear();
  masses_.clear();
  local_unit_.resize(bodies_.size() + mechanisms_.size());
  for (const std::uint32_t unit : std::span(unit_order_).subspan(island.first_unit, island.units)) {
    const std::size_t n = width_of(unit), first = masses_.size();
    local_unit_[unit] = static_cast<std::uint32_t>(convex_sizes_.size());
    convex_sizes_.push_back(static_cast<std::uint32_t>(n));
    masses_.resize(first + n * n, 0.0);
    double* const M = &masses_[first];
    if (is_body(unit)) {
      const Body& body = bodies_[unit];
      const Matrix3 I = symmetric_inverse(body.row_inverse_W);
      for (std::size_t r = 0; r < 3; ++r) {
        M[r * n + r] = body.body.inertia().mass;
        for (std::size_t k = 0; k < 3; ++k)
          M[(r + 3) * n + k + 3] = I(static_cast<int>(r), static_cast<int>(k));
      }
      continue;
    }
    const std::vector<double>& L = arm_of(unit).M;  // factored: the diagonal's inverses
    const auto entry = [&](std::size_t i, std::size_t k) {
      return i == k ? 1.0 / L[i * n + i] : L[i * n + k];
    };
    for (std::size_t r = 0; r < n; ++r)
      for (std::size_t c = 0; c <= r; ++c) {
        double sum = 0.0;
        for (std::size_t k = 0; k <= c; ++k) sum += entry(r, k) * entry(c, k);
        M[r * n + c] = M[c * n + r] = sum;
      }
  }
  convex_rows_.assign(rows_.begin(), rows_.end());
  for (Row& row : convex_rows_)
    for (int i = 0; i < row.count; ++i) row.units[i] = local_unit_[row.units[i]];
}

/// The loaded island; where the step's work ends, the best of what there is.
SolveReport DynamicsWorld::solve_convex(const Island& island, StepReport& report) {
  const double tolerance = tolerance_of(island, false);
  load_convex(island);
  const SparseContacts problem{
      convex_sizes_, masses_, island.contacts, local_friction_, local_bounds_, convex_rows_, J_, Y_,
      local_b_};
  const ConvexReport convex = convex_.solve(problem, local_x_, tolerance, budget_, is_contradicted(island));
  for (std::size_t k = 0; k < local_rows_.size(); ++k) x_[local_rows_[k]] = local_x_[k];
  SolveReport solved;
  solved.newton_steps = convex.newton_steps;
  solved.residual = update_velocities(island).worst;
  solved.converged = solved.residual <= tolerance;
  report.contradictory += convex.is_contradictory ? 1 : 0;
  for (const std::uint32_t unit : std::span(unit_order_).subspan(island.first_unit, island.units)) {
    std::uint8_t& left = contradicted_[unit];
    left = !convex.is_contradictory ? 0 : left > 0 ? left - 1 : kSoftSolves;
  }
  if (!solved.converged && budget_.is_spent()) report.is_work_spent = true;
  return solved;
}

}  // namespace touchstone::physics

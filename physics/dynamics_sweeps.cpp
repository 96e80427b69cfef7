// The last resort, where a step's work ends before Newton's method does: a few sweeps through the contacts.

#include <algorithm>
#include <cmath>

#include "touchstone/physics/contact_laws.hpp"
#include "touchstone/physics/dynamics_world.hpp"

namespace touchstone::physics {
namespace {

// Of the last resort.
constexpr int kSweeps = 20;
constexpr double kSweepWork = 50.0;  // a row
// What held in a step of another length may be far too much in this: worse than nothing by this factor, it is
// dropped.
constexpr double kWorseThanNothing = 10.0;
constexpr int kSlipSteps = 2;

/// The inverse of a symmetric matrix, row by row. @return false where it has none.
bool invert(const double* D, double* inverse) {
  const double c00 = D[4] * D[8] - D[5] * D[5], c01 = D[2] * D[5] - D[1] * D[8],
               c02 = D[1] * D[5] - D[2] * D[4];
  const double determinant = (D[0] * c00 + D[1] * c01) + D[2] * c02;
  if (!(determinant > 0.0)) return false;
  inverse[0] = c00 / determinant;
  inverse[1] = inverse[3] = c01 / determinant;
  inverse[2] = inverse[6] = c02 / determinant;
  inverse[4] = (D[0] * D[8] - D[2] * D[2]) / determinant;
  inverse[5] = inverse[7] = (D[1] * D[2] - D[0] * D[5]) / determinant;
  inverse[8] = (D[0] * D[4] - D[1] * D[1]) / determinant;
  return true;
}

/// One contact's laws, the others held: exact where it opens or sticks, projected steps where it slips.
/// @param q its velocity without its own impulse. @param x in: what it was.
void solve_contact(const double* D, const double* inverse, double friction, const double* q, double* x) {
  if (q[0] >= 0.0) {
    x[0] = x[1] = x[2] = 0.0;
    return;
  }
  double stick[3];
  for (int i = 0; i < 3; ++i)
    stick[i] = -((inverse[3 * i] * q[0] + inverse[3 * i + 1] * q[1]) + inverse[3 * i + 2] * q[2]);
  if (inverse[0] > 0.0 && length_of(stick[1], stick[2]) <= friction * stick[0]) {
    std::copy(stick, stick + 3, x);
    return;
  }
  const double half = 0.5 * (D[4] - D[8]),
               largest = 0.5 * (D[4] + D[8]) + std::sqrt(half * half + D[5] * D[5]);
  for (int i = 0; i < kSlipSteps; ++i) {
    x[0] = D[0] > 0.0 ? std::max(0.0, -((q[0] + D[1] * x[1]) + D[2] * x[2]) / D[0]) : 0.0;
    if (!(largest > 0.0)) continue;
    const double u1 = ((q[1] + D[1] * x[0]) + D[4] * x[1]) + D[5] * x[2];
    const double u2 = ((q[2] + D[2] * x[0]) + D[5] * x[1]) + D[8] * x[2];
    x[1] -= u1 / largest;
    x[2] -= u2 / largest;
    project_on_disc(friction * x[0], x[1], x[2]);
  }
}

}  // namespace

/// J V of a loaded row: the velocity that the impulses so far give it.
double DynamicsWorld::swept_velocity(std::size_t row) const {
  const Row& r = rows_[row];
  double u = local_b_[row];
  for (int i = 0; i < r.count; ++i) {
    const double* const V = &V_[first_V_[r.units[i]]];
    for (std::size_t k = 0; k < width_of(r.units[i]); ++k) u += J_[r.first[i] + k] * V[k];
  }
  return u;
}

void DynamicsWorld::add_swept_impulse(std::size_t row, double change) {
  const Row& r = rows_[row];
  if (change == 0.0) return;
  for (int i = 0; i < r.count; ++i) {
    double* const V = &V_[first_V_[r.units[i]]];
    for (std::size_t k = 0; k < width_of(r.units[i]); ++k) V[k] += Y_[r.first[i] + k] * change;
  }
}

/// Velocities of the units by the impulses to start from, and each contact's own block of W with its inverse.
void DynamicsWorld::prepare_sweeps(const Island& island) {
  V_.clear();
  first_V_.resize(bodies_.size() + mechanisms_.size());
  for (const std::uint32_t unit : std::span(unit_order_).subspan(island.first_unit, island.units)) {
    first_V_[unit] = V_.size();
    V_.resize(V_.size() + width_of(unit), 0.0);
  }
  for (std::size_t r = 0; r < rows_.size(); ++r) add_swept_impulse(r, local_x_[r]);
  own_W_.resize(18 * island.contacts + island.joints);
  for (std::size_t c = 0; c < island.contacts; ++c) {
    double* const D = &own_W_[18 * c];
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = i; k < 3; ++k)
        D[3 * i + k] = D[3 * k + i] = coupling(rows_[3 * c + i], rows_[3 * c + k]);
    if (!invert(D, D + 9)) std::fill(D + 9, D + 18, 0.0);
  }
  for (std::size_t j = 0; j < island.joints; ++j) {
    const Row& row = rows_[3 * island.contacts + j];
    own_W_[18 * island.contacts + j] = coupling(row, row);
  }
}

void DynamicsWorld::sweep_contact(std::size_t contact) {
  const double* const D = &own_W_[18 * contact];
  double* const x = &local_x_[3 * contact];
  double q[3], next[3];
  for (std::size_t i = 0; i < 3; ++i) {
    next[i] = x[i];
    q[i] = swept_velocity(3 * contact + i) - ((D[3 * i] * x[0] + D[3 * i + 1] * x[1]) + D[3 * i + 2] * x[2]);
  }
  solve_contact(D, D + 9, local_friction_[contact], q, next);
  for (std::size_t i = 0; i < 3; ++i) {
    add_swept_impulse(3 * contact + i, next[i] - x[i]);
    x[i] = next[i];
  }
}

/// Block Gauss-Seidel over the loaded island in impulses, to and fro, as many times as there is time for.
/// @param warm the residual of what there is to start from.
SolveReport DynamicsWorld::sweep_loaded(const Island& island, double warm) {
  double without = 0.0;
  for (std::size_t c = 0; c < island.contacts; ++c) without = std::max(without, -local_b_[3 * c]);
  if (warm > kWorseThanNothing * without) std::fill(local_x_.begin(), local_x_.end(), 0.0);
  prepare_sweeps(island);
  SolveReport report;
  for (report.sweeps = 0; report.sweeps < kSweeps; ++report.sweeps) {
    const bool forth = report.sweeps % 2 == 0;
    for (std::size_t c = 0; c < island.contacts; ++c) sweep_contact(forth ? c : island.contacts - 1 - c);
    for (std::size_t j = 0; j < island.joints; ++j) {
      const std::size_t row = 3 * island.contacts + j;
      const double w = own_W_[18 * island.contacts + j];
      if (!(w > 0.0)) continue;
      const double next = clamped(local_x_[row] - swept_velocity(row) / w, local_bounds_[j]);
      add_swept_impulse(row, next - local_x_[row]);
      local_x_[row] = next;
    }
  }
  for (std::size_t k = 0; k < local_rows_.size(); ++k) x_[local_rows_[k]] = local_x_[k];
  budget_.spend(kSweepWork * kSweeps * static_cast<double>(local_rows_.size()));
  report.residual = update_velocities(island).worst;
  report.converged = report.residual <= settings_.solver.tolerance;
  return report;
}

}  // namespace touchstone::physics

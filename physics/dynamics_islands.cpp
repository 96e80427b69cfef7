// Rows that have to do with each other, solved apart from those that have not.

#include <algorithm>
#include <cmath>

#include "physics/contact_laws.hpp"
#include "physics/dynamics_world.hpp"

namespace touchstone::physics {

std::size_t DynamicsWorld::unit_of(const Mover& mover) const {
  return mover.kind == Mover::Kind::link ? bodies_.size() + mover.index : mover.index;
}

std::size_t DynamicsWorld::leader_of(std::size_t unit) {
  while (leader_[unit] != unit) unit = leader_[unit] = leader_[leader_[unit]];
  return unit;
}

/// Rows that do not meet, directly or through others, are problems of their own. Islands come in the order of
/// their first row, rows in theirs. Contacts that move nothing are in none.
void DynamicsWorld::find_islands() {
  const std::size_t units = bodies_.size() + mechanisms_.size();
  leader_.resize(units);
  for (std::size_t i = 0; i < units; ++i) leader_[i] = i;
  for (const Row& row : rows_)
    if (row.count == 2)
      leader_[leader_of(unit_of(row.sides[1].mover))] = leader_of(unit_of(row.sides[0].mover));
  island_of_unit_.assign(units, kNoIsland);
  islands_.clear();
  const std::size_t blocks = active_.size() + joint_rows_.size();
  island_of_block_.resize(blocks);
  for (std::size_t i = 0; i < blocks; ++i) {
    const Row& row = rows_[first_row(i)];
    island_of_block_[i] = kNoIsland;
    if (row.count == 0) continue;
    std::size_t& island = island_of_unit_[leader_of(unit_of(row.sides[0].mover))];
    if (island == kNoIsland) {
      island = islands_.size();
      islands_.push_back({0, 0, 0});
    }
    island_of_block_[i] = island;
    ++(i < active_.size() ? islands_[island].contacts : islands_[island].joints);
  }
  std::size_t first = 0;
  for (Island& island : islands_) {
    island.first_block = first;
    first += island.contacts + island.joints;
    island.contacts = island.joints = 0;
  }
  block_order_.resize(first);
  for (std::size_t i = 0; i < blocks; ++i) {
    if (island_of_block_[i] == kNoIsland) continue;
    Island& island = islands_[island_of_block_[i]];
    block_order_[island.first_block + island.contacts + island.joints] = i;
    ++(i < active_.size() ? island.contacts : island.joints);
  }
}

/// Its rows, one after the other.
void DynamicsWorld::load_rows(const Island& island) {
  local_rows_.clear();
  local_friction_.clear();
  local_bounds_.clear();
  for (std::size_t k = 0; k < island.contacts + island.joints; ++k) {
    const std::size_t block = block_order_[island.first_block + k];
    const bool is_contact = block < active_.size();
    for (std::size_t i = 0; i < (is_contact ? 3U : 1U); ++i) local_rows_.push_back(first_row(block) + i);
    if (is_contact) {
      local_friction_.push_back(friction_[block]);
    } else {
      local_bounds_.push_back(bounds_[block - active_.size()]);
    }
  }
  const std::size_t n = local_rows_.size();
  for (auto* vector : {&local_b_, &local_x_, &local_u_}) vector->resize(n);
  for (std::size_t r = 0; r < n; ++r) {
    local_b_[r] = b_[local_rows_[r]];
    local_x_[r] = x_[local_rows_[r]];
  }
}

/// J M^-1 J^T of the loaded rows: those meet that act on the same body or mechanism, and the rows of one
/// contact all act on the same.
void DynamicsWorld::load_couplings() {
  const std::size_t n = local_rows_.size(), contact_rows = 3 * local_friction_.size();
  W_.assign(n * n, 0.0);
  const auto size_at = [&](std::size_t row) { return row < contact_rows ? 3U : 1U; };
  for (std::size_t r = 0; r < n; r += size_at(r))
    for (std::size_t s = 0; s <= r; s += size_at(s)) {
      if (!meet(rows_[local_rows_[r]], rows_[local_rows_[s]])) continue;
      for (std::size_t i = r; i < r + size_at(r); ++i)
        for (std::size_t k = s; k < s + size_at(s) && k <= i; ++k)
          W_[i * n + k] = W_[k * n + i] = coupling(rows_[local_rows_[i]], rows_[local_rows_[k]]);
    }
}

/// local_u_ = W x + b by way of the units' velocities, without W: what rows cost, not their square. Returns
/// the natural residual.
double DynamicsWorld::velocities_from_impulses() {
  const auto spread_of = [&](const Side& side) { return &spread_[first_of_unit_[unit_of(side.mover)]]; };
  const std::size_t n = local_rows_.size(), contacts = local_friction_.size();
  for (const std::size_t r : local_rows_)
    for (int i = 0; i < rows_[r].count; ++i)
      std::fill_n(spread_of(rows_[r].sides[i]), rows_[r].sides[i].size, 0.0);
  for (std::size_t k = 0; k < n; ++k)
    for (int i = 0; i < rows_[local_rows_[k]].count; ++i) {
      const Side& side = rows_[local_rows_[k]].sides[i];
      double* const spread = spread_of(side);
      for (std::size_t c = 0; c < side.size; ++c) spread[c] += Y_[side.first + c] * local_x_[k];
    }
  double worst = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    double sum = local_b_[k];
    for (int i = 0; i < rows_[local_rows_[k]].count; ++i) {
      const Side& side = rows_[local_rows_[k]].sides[i];
      const double* const spread = spread_of(side);
      for (std::size_t c = 0; c < side.size; ++c) sum += J_[side.first + c] * spread[c];
    }
    local_u_[k] = sum;
  }
  const auto scale = [&](std::size_t k) { return coupling(rows_[local_rows_[k]], rows_[local_rows_[k]]); };
  for (std::size_t c = 0; c < contacts; ++c) {
    const std::size_t k = 3 * c;
    const double w = std::max({scale(k), scale(k + 1), scale(k + 2)});
    if (w > 0.0) worst = std::max(worst, contact_residual(w, local_friction_[c], &local_x_[k], &local_u_[k]));
  }
  for (std::size_t k = 3 * contacts; k < n; ++k) {
    const double w = scale(k);
    if (w > 0.0)
      worst = std::max(worst, w * std::abs(local_x_[k] - clamped(local_x_[k] - local_u_[k] / w,
                                                                 local_bounds_[k - 3 * contacts])));
  }
  return worst;
}

bool DynamicsWorld::meet(const Row& r, const Row& s) const {
  for (int i = 0; i < r.count; ++i)
    for (int k = 0; k < s.count; ++k)
      if (r.sides[i].mover.kind == s.sides[k].mover.kind && r.sides[i].mover.index == s.sides[k].mover.index)
        return true;
  return false;
}

double DynamicsWorld::coupling(const Row& r, const Row& s) const {
  double sum = 0.0;
  for (int i = 0; i < r.count; ++i)
    for (int k = 0; k < s.count; ++k) {
      const Side &a = r.sides[i], &b = s.sides[k];
      if (a.mover.kind != b.mover.kind || a.mover.index != b.mover.index) continue;
      for (std::size_t c = 0; c < a.size; ++c) sum += J_[a.first + c] * Y_[b.first + c];
    }
  return sum;
}

void DynamicsWorld::solve(StepReport& report) {
  u_ = b_;
  find_islands();
  first_of_unit_.clear();
  std::size_t size = 0;
  for (std::size_t i = 0; i < bodies_.size() + mechanisms_.size(); ++i) {
    first_of_unit_.push_back(size);
    size += i < bodies_.size() ? 6 : mechanisms_[i - bodies_.size()].q.size();
  }
  spread_.resize(size);
  for (std::size_t r = 0; r < rows_.size(); ++r)
    if (rows_[r].count == 0) x_[r] = 0.0;
  for (const Island& island : islands_) {
    load_rows(island);
    SolveReport solved;
    // Most of what rests goes on resting: what held it in the last step does in this.
    solved.residual = velocities_from_impulses();
    if (!(solved.residual <= settings_.solver.tolerance)) {
      load_couplings();
      solved = solver_.solve({island.contacts, local_friction_, local_bounds_, W_, local_b_}, local_x_);
      solved.residual = velocities_from_impulses();
    }
    for (std::size_t k = 0; k < local_rows_.size(); ++k) {
      x_[local_rows_[k]] = local_x_[k];
      u_[local_rows_[k]] = local_u_[k];
    }
    ++report.solves;
    report.unconverged += solved.converged ? 0 : 1;
    report.sweeps += static_cast<std::uint32_t>(solved.sweeps);
    report.newton_steps += static_cast<std::uint32_t>(solved.newton_steps);
    report.worst_residual = std::max(report.worst_residual, solved.residual);
  }
}

}  // namespace touchstone::physics

#include "touchstone/physics/world/islands/island_problem.hpp"

#include <algorithm>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/solver/reserved.hpp"

namespace touchstone::physics::stepping {
namespace {

constexpr std::size_t kBodyRates = 6;

bool meet(const SparseContacts::Row& r, const SparseContacts::Row& s) {
  for (int i = 0; i < r.count; ++i)
    for (int k = 0; k < s.count; ++k)
      if (r.units[i] == s.units[k]) return true;
  return false;
}

/// An entry of J M^-1 J^T.
double coupling(const SparseContacts::Row& r, const SparseContacts::Row& s, const ContactRows& rows) {
  double sum = 0.0;
  for (int i = 0; i < r.count; ++i)
    for (int k = 0; k < s.count; ++k) {
      if (r.units[i] != s.units[k]) continue;
      const std::size_t size = rows.units[r.units[i]].width();
      for (std::size_t c = 0; c < size; ++c) sum += rows.J[r.first[i] + c] * rows.Y[s.first[k] + c];
    }
  return sum;
}

/// M of a body, 6 x 6: of its centre, then of its turning.
void write_body_mass(const RowUnit& unit, double* M) {
  const Matrix3 I = symmetric_inverse(unit.inverse_inertia_W);
  for (std::size_t r = 0; r < 3; ++r) {
    M[r * 6 + r] = unit.mass;
    for (std::size_t k = 0; k < 3; ++k) M[(r + 3) * 6 + k + 3] = I(static_cast<int>(r), static_cast<int>(k));
  }
}

/// M = L L^T of a mechanism.
void write_mechanism_mass(const RowUnit& unit, double* M) {
  const std::span<const double> L = unit.M;  // the diagonal's inverses
  const std::size_t n = unit.width();
  const auto entry = [&](std::size_t i, std::size_t k) { return i == k ? 1.0 / L[i * n + i] : L[i * n + k]; };
  for (std::size_t r = 0; r < n; ++r)
    for (std::size_t c = 0; c <= r; ++c) {
      double sum = 0.0;
      for (std::size_t k = 0; k <= c; ++k) sum += entry(r, k) * entry(c, k);
      M[r * n + c] = M[c * n + r] = sum;
    }
}

}  // namespace

void IslandProblem::reserve(const ContactRows& rows, std::size_t units, std::size_t widest) {
  const std::size_t most_rows = rows.b.capacity();
  for (auto* vector : {&rows_, &sparse_rows_}) reserve_written(*vector, most_rows);
  reserve_written(group_rows_, most_rows);
  for (auto* vector : {&b, &x}) reserve_written(*vector, most_rows);
  reserve_written(levers_, rows.friction.capacity());
  reserve_written(friction_, rows.friction.capacity());
  reserve_written(commanded_, most_rows);
  reserve_written(bounds_, rows.bounds.capacity());
  reserve_written(compliance_, rows.bounds.capacity());
  // Of the largest island: who expects larger ones than a thousand rows pays for them when they come.
  const std::size_t island_rows = std::min<std::size_t>(most_rows, 1024);
  reserve_written(W_, island_rows * island_rows, kDenseRows * kDenseRows);
  for (auto* vector : {&sizes_, &local_unit_}) reserve_written(*vector, units);
  reserve_written(masses_, units * widest * widest);
  reserve_written(bodies_, units);
  for (auto* vector : {&J_, &Y_})
    reserve_written(*vector, island_rows * island_rows / ContactProblem::kRowsARate,
                    kDenseRows * kDenseRows / ContactProblem::kRowsARate);
}

/// A row of a contact in full, after those of the mechanisms.
void IslandProblem::write_out(const ContactRows::Contact& contact, std::size_t direction, ContactRows& all,
                              Row& row) {
  row.count = 0;
  std::vector<double>&J = all.J, &Y = all.Y;
  const Vector3 direction_W = direction == 0 ? contact.n_W : direction == 1 ? contact.t1_W : contact.t2_W;
  for (const ContactRows::Side& side : contact.sides) {
    if (side.unit == kNoUnit) continue;
    const RowUnit& unit = all.units[side.unit];
    row.units[row.count] = side.unit;
    // A mechanism's entries exist; those of two links of one mechanism are summed.
    if (!unit.is_body()) {
      const std::size_t n = unit.width(), first = side.first + direction * n;
      if (row.count == 1 && row.units[0] == side.unit) {  // two links of one mechanism
        const std::size_t other = row.first[0];
        row.first[0] = J.size();
        for (std::size_t k = 0; k < n; ++k) {
          J.push_back(J[other + k] + J[first + k]);
          Y.push_back(Y[other + k] + Y[first + k]);
        }
        continue;
      }
      row.first[row.count++] = first;
      continue;
    }
    // A body's entries are the direction and its moment, in Y divided by the inertia.
    const Vector3 linear = side.sign * direction_W, angular = cross(side.lever_W, linear);
    const Vector3 v = linear / unit.mass, w = rotate(unit.inverse_inertia_W, angular);
    const std::size_t first = J.size();
    row.first[row.count++] = first;
    J.resize(first + 6);
    Y.resize(first + 6);
    for (int k = 0; k < 3; ++k) {
      const std::size_t at = first + static_cast<std::size_t>(k);
      J[at] = linear[k], J[at + 3] = angular[k];
      Y[at] = v[k], Y[at + 3] = w[k];
    }
  }
}

/// The three rows: units as write_out() has them, of bodies without entries for now.
void IslandProblem::add_contact(std::size_t contact, ContactRows& rows) {
  const ContactRows::Contact& given = rows.contacts[contact];
  SparseContacts::Levers& levers = levers_.emplace_back();
  levers.are_of_bodies = true;
  Row row{{0, 0}, {0, 0}, 0};
  double sign = 1.0;
  for (const ContactRows::Side& side : given.sides) {
    if (side.unit == kNoUnit) continue;
    if (row.count == 0) sign = side.sign;
    levers.are_of_bodies = levers.are_of_bodies && rows.units[side.unit].is_body();
    levers.of[row.count] = side.lever_W;
    row.units[row.count++] = side.unit;
  }
  const Vector3* const directions[3] = {&given.n_W, &given.t1_W, &given.t2_W};
  for (std::size_t i = 0; i < 3; ++i) {
    levers.directions[i] = sign * *directions[i];
    rows_.push_back(row);
    if (!levers.are_of_bodies) write_out(given, i, rows, rows_.back());
  }
}

/// The rows of contacts between bodies, for W.
void IslandProblem::write_out_bodies(ContactRows& rows) {
  if (are_bodies_written_) return;
  are_bodies_written_ = true;
  for (std::size_t c = 0; c < contacts_; ++c) {
    if (!levers_[c].are_of_bodies) continue;
    for (std::size_t i = 0; i < 3; ++i)
      write_out(rows.contacts[group_rows_[3 * c] / 3], i, rows, rows_[3 * c + i]);
  }
}

void IslandProblem::number_units(std::span<const std::uint32_t> units, const ContactRows& rows) {
  units_ = units.size();
  local_unit_.resize(rows.units.size());
  for (std::size_t i = 0; i < units_; ++i) local_unit_[units[i]] = static_cast<std::uint32_t>(i);
}

void IslandProblem::load(const Islands& islands, const Island& island, ContactRows& rows) {
  rows_.clear();
  group_rows_.clear();
  levers_.clear();
  friction_.clear();
  bounds_.clear();
  compliance_.clear();
  commanded_.clear();
  contacts_ = island.contacts;
  group_entries_ = rows.J.size();
  are_bodies_written_ = false;
  number_units(islands.units_of(island), rows);
  // The island's blocks are listed in order.
  for (const std::size_t block : islands.blocks_of(island)) {
    const std::size_t first = rows.first_row(block);
    commanded_.push_back(rows.commanded[block]);
    // A contact has three rows and a coefficient of friction.
    if (block < rows.contacts.size()) {
      for (std::size_t i = 0; i < 3; ++i) group_rows_.push_back(first + i);
      add_contact(block, rows);
      friction_.push_back(rows.friction[block]);
      continue;
    }
    // A joint has one row with bounds and compliance.
    const std::size_t j = block - rows.contacts.size();
    group_rows_.push_back(first);
    const ContactRows::Joint& joint = rows.joints[j];
    rows_.push_back({{joint.units[0], joint.units[1]}, {joint.first[0], joint.first[1]}, joint.count});
    bounds_.push_back(rows.bounds[j]);
    compliance_.push_back(rows.joints[j].compliance);
  }
  // b and the start are gathered by row.
  b.resize(row_count());
  x.resize(row_count());
  for (std::size_t r = 0; r < row_count(); ++r) {
    b[r] = rows.b[group_rows_[r]];
    x[r] = rows.x[group_rows_[r]];
  }
}

/// Rows meet that act on the same body or mechanism, and the rows of one contact all act on the same.
void IslandProblem::load_couplings(bool may_be_parts, ContactRows& rows) {
  write_out_bodies(rows);
  if (may_be_parts && load_rates(rows)) return;
  rates_ = 0;
  const std::size_t n = row_count(), contact_rows = 3 * contacts_;
  W_.assign(n * n, 0.0);
  const auto size_at = [&](std::size_t row) { return row < contact_rows ? 3U : 1U; };
  for (std::size_t r = 0; r < n; r += size_at(r))
    for (std::size_t s = 0; s <= r; s += size_at(s)) {
      if (!meet(rows_[r], rows_[s])) continue;
      for (std::size_t i = r; i < r + size_at(r); ++i)
        for (std::size_t k = s; k < s + size_at(s) && k <= i; ++k)
          W_[i * n + k] = W_[k * n + i] = coupling(rows_[i], rows_[k], rows);
    }
  for (std::size_t j = 0; j < compliance_.size(); ++j) W_[(contact_rows + j) * (n + 1)] += compliance_[j];
}

/// W in its parts, where the island is of bodies that have few rates beside the rows of their contacts.
/// @return whether it is.
bool IslandProblem::load_rates(const ContactRows& rows) {
  const std::size_t n = row_count(), rates = kBodyRates * units_;
  const bool are_of_bodies = std::all_of(levers_.begin(), levers_.end(),
                                         [](const SparseContacts::Levers& of) { return of.are_of_bodies; });
  if (!compliance_.empty() || !are_of_bodies || n < ContactProblem::kRowsARate * rates) return false;
  rates_ = rates;
  J_.assign(n * rates, 0.0);
  Y_.assign(n * rates, 0.0);
  for (std::size_t r = 0; r < n; ++r)
    for (int i = 0; i < rows_[r].count; ++i) {
      const std::size_t to = r * rates + kBodyRates * local_unit_[rows_[r].units[i]],
                        from = rows_[r].first[i];
      std::copy_n(&rows.J[from], kBodyRates, &J_[to]);
      std::copy_n(&rows.Y[from], kBodyRates, &Y_[to]);
    }
  return true;
}

void IslandProblem::load_masses(const Islands& islands, const Island& island, const ContactRows& rows) {
  sizes_.clear();
  masses_.clear();
  bodies_.clear();
  for (const std::uint32_t member : islands.units_of(island)) {
    const RowUnit& unit = rows.units[member];
    const std::size_t n = unit.width(), first = masses_.size();
    sizes_.push_back(static_cast<std::uint32_t>(n));
    masses_.resize(first + n * n, 0.0);
    bodies_.push_back({unit.mass, unit.inverse_inertia_W});
    if (unit.is_body())
      write_body_mass(unit, &masses_[first]);
    else
      write_mechanism_mass(unit, &masses_[first]);
  }
  sparse_rows_.assign(rows_.begin(), rows_.end());
  for (Row& row : sparse_rows_)
    for (int i = 0; i < row.count; ++i) row.units[i] = local_unit_[row.units[i]];
}

void IslandProblem::store_impulses(ContactRows& rows) const {
  for (std::size_t k = 0; k < row_count(); ++k) rows.x[group_rows_[k]] = x[k];
}

void IslandProblem::unload(ContactRows& rows) const {
  rows.J.resize(group_entries_);
  rows.Y.resize(group_entries_);
}

}  // namespace touchstone::physics::stepping

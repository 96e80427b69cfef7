#pragma once

#include <cstdint>
#include <vector>

#include "touchstone/physics/solver/contact_problem.hpp"
#include "touchstone/physics/solver/convex_contacts.hpp"
#include "touchstone/physics/world/islands/islands.hpp"

// One island written out as the solvers take it.

namespace touchstone::physics::stepping {

/// The rows of one island, in order: dense for ContactSolver, sparse for ConvexContacts. Owns its memory.
class IslandProblem {
 public:
  void reserve(const ContactRows& rows, std::size_t units, std::size_t widest);
  /// Copies b and x. What is written out after rows.J and rows.Y, then and by load_couplings(), stays until
  /// unload(); contacts between bodies are not: sparse() has their levers.
  void load(const Islands& islands, const Island& island, ContactRows& rows);
  /// W = J M^-1 J^T, for dense(). @param may_be_parts ContactProblem::J and Y where they serve. @pre load()
  void load_couplings(bool may_be_parts, ContactRows& rows);
  /// The units' masses, for sparse(). @pre load()
  void load_masses(const Islands& islands, const Island& island, const ContactRows& rows);
  void store_impulses(ContactRows& rows) const;
  /// Takes back what load() wrote.
  void unload(ContactRows& rows) const;

  ContactProblem dense() const {
    if (rates_ > 0) return {contacts_, friction_, bounds_, {}, b, rates_, J_, Y_};
    return {contacts_, friction_, bounds_, W_, b};
  }
  /// @param is_resting see SparseContacts
  SparseContacts sparse(const ContactRows& rows, bool is_resting = false) const {
    return {sizes_, masses_, contacts_,   friction_, bounds_, sparse_rows_, rows.J,
            rows.Y, b,       compliance_, levers_,   bodies_, commanded_,   is_resting};
  }
  std::size_t row_count() const { return rows_.size(); }
  /// The index of an island's row among all rows of the group.
  std::size_t group_row(std::size_t row) const { return group_rows_[row]; }

  std::vector<double> b, x;  // by row

 private:
  using Row = SparseContacts::Row;

  void number_units(std::span<const std::uint32_t> units, const ContactRows& rows);
  void add_contact(std::size_t contact, ContactRows& rows);
  static void write_out(const ContactRows::Contact& contact, std::size_t direction, ContactRows& rows,
                        Row& row);
  void write_out_bodies(ContactRows& rows);
  bool load_rates(const ContactRows& rows);

  std::vector<Row> rows_;                // units as the group counts them
  std::vector<std::size_t> group_rows_;  // by row
  std::vector<double> W_, friction_, compliance_, commanded_;
  std::vector<double> J_, Y_;  // of a few bodies' contacts, all rates in each row
  std::size_t rates_ = 0;      // 0: dense() has W_
  std::vector<ContactProblem::Bounds> bounds_;
  std::size_t units_ = 0, contacts_ = 0, group_entries_ = 0;  // of rows.J before load()
  bool are_bodies_written_ = false;                           // contacts between bodies, after rows.J
  std::vector<std::uint32_t> sizes_, local_unit_;             // by the island's unit; by unit
  std::vector<double> masses_;                                // of the island's units
  std::vector<SparseContacts::Levers> levers_;                // by contact
  std::vector<SparseContacts::Body> bodies_;                  // by the island's unit
  std::vector<Row> sparse_rows_;                              // units as the island counts them
};

}  // namespace touchstone::physics::stepping

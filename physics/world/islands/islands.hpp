#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/disjoint_sets.hpp"
#include "touchstone/physics/world/rows/contact_rows.hpp"

// Islands: rows of a group that act on the same units, directly or through others, are one problem each.

namespace touchstone::physics::stepping {

/// A run of blocks, contacts first, and of the units that they move: see Islands.
struct Island {
  std::size_t first_block, contacts, joints, first_unit, units;

  std::size_t blocks() const { return contacts + joints; }
  std::size_t rows() const { return 3 * contacts + joints; }
};

/// Finds the islands of a group's rows. They come in the order of their first block, blocks and units in
/// theirs.
class Islands {
 public:
  void reserve(std::size_t units, std::size_t blocks);
  void find(const ContactRows& rows);

  std::span<const Island> all() const { return islands_; }
  std::span<const std::size_t> blocks_of(const Island& island) const {
    return std::span(block_order_).subspan(island.first_block, island.blocks());
  }
  std::span<const std::uint32_t> units_of(const Island& island) const {
    return std::span(unit_order_).subspan(island.first_unit, island.units);
  }

 private:
  DisjointSets sets_;
  std::vector<std::uint32_t> island_of_unit_, island_of_block_, unit_order_;
  std::vector<std::size_t> block_order_;
  std::vector<Island> islands_;
};

}  // namespace touchstone::physics::stepping

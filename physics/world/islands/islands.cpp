#include "touchstone/physics/world/islands/islands.hpp"
#include "touchstone/physics/solver/reserved.hpp"

namespace touchstone::physics::stepping {

void Islands::reserve(std::size_t units, std::size_t blocks) {
  sets_.reserve(units);
  for (auto* vector : {&island_of_unit_, &unit_order_}) reserve_written(*vector, units);
  reserve_written(island_of_block_, blocks);
  reserve_written(block_order_, blocks);
  reserve_written(islands_, units);
}

void Islands::find(const ContactRows& rows) {
  // Join the units of each contact and joint row.
  sets_.resize(rows.units.size());
  island_of_unit_.resize(rows.units.size());
  for (const std::uint32_t unit : rows.members) sets_.single(unit), island_of_unit_[unit] = kNoUnit;
  for (const ContactRows::Contact& contact : rows.contacts) {
    const std::uint32_t a = contact.sides[0].unit, b = contact.sides[1].unit;
    if (a != kNoUnit && b != kNoUnit) sets_.join(a, b);
  }
  for (const ContactRows::Joint& joint : rows.joints)
    if (joint.count == 2) sets_.join(joint.units[0], joint.units[1]);
  // Count each island's blocks and units.
  islands_.clear();
  const std::size_t blocks = rows.block_count();
  island_of_block_.resize(blocks);
  for (std::size_t i = 0; i < blocks; ++i) {
    std::uint32_t& island = island_of_unit_[sets_.least_of(rows.unit_of_block(i))];
    if (island == kNoUnit) {
      island = static_cast<std::uint32_t>(islands_.size());
      islands_.push_back({});
    }
    island_of_block_[i] = island;
    ++(i < rows.contacts.size() ? islands_[island].contacts : islands_[island].joints);
  }
  for (const std::uint32_t unit : rows.members) {
    const std::uint32_t island = island_of_unit_[sets_.least_of(unit)];
    if (island != kNoUnit) ++islands_[island].units;
  }
  // Each island's run starts where the one before ends.
  std::size_t first_block = 0, first_unit = 0;
  for (Island& island : islands_) {
    island.first_block = first_block, island.first_unit = first_unit;
    first_block += island.blocks();
    first_unit += island.units;
    island.contacts = island.joints = island.units = 0;
  }
  // Sort, counting again.
  block_order_.resize(first_block);
  unit_order_.resize(first_unit);
  for (std::size_t i = 0; i < blocks; ++i) {
    Island& island = islands_[island_of_block_[i]];
    block_order_[island.first_block + island.blocks()] = i;
    ++(i < rows.contacts.size() ? island.contacts : island.joints);
  }
  for (const std::uint32_t unit : rows.members) {
    const std::uint32_t island = island_of_unit_[sets_.least_of(unit)];
    if (island != kNoUnit) unit_order_[islands_[island].first_unit + islands_[island].units++] = unit;
  }
}

}  // namespace touchstone::physics::stepping

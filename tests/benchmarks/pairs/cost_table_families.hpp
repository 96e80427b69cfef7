#pragma once

#include <span>
#include <string_view>

#include "touchstone/examples/measures/pairs/pair_set.hpp"

namespace touchstone {

/// Names of the table's families: those where simulations live (walls, rows and stacks of equal blocks) and
/// those of measures::pair_families().
std::span<const std::string_view> cost_table_families();

/// `count` pairs of a family. @throws InputError of a name that is not known.
measures::PairSet make_cost_table_family(std::string_view name, std::uint64_t seed, std::size_t count);

}  // namespace touchstone

#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "touchstone/examples/measures/pairs/pair_families.hpp"
#include "touchstone/examples/measures/paths/path_set.hpp"

namespace touchstone::measures {

/// paths_straight, paths_turning, paths_thin, paths_grazing.
std::span<const PairFamily> path_families();

/// `count` paths of the family `name`, each as `poses` cases; path i depends on (name, seed, i) alone, has
/// the id "name:i" and the same bits on every compiler.
/// @pre poses >= 2. @throws InputError naming the known families.
PairSet make_path_family(std::string_view name, std::uint64_t seed, std::size_t count, std::size_t poses);

}  // namespace touchstone::measures

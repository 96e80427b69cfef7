#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "touchstone/examples/measures/pairs/pair_set.hpp"

namespace touchstone::measures {

struct PairFamily {
  std::string_view name;
  std::string_view description;
};

/// random, near_1e-3, near_1e-7, resting, sheared, tapered, containment, slabs_needles, far, near_parallel,
/// touching, bent.
std::span<const PairFamily> pair_families();

/// `count` pairs of the family `name`; pair i has the solids 2i and 2i+1 and the id "name:i". Pair i depends
/// on (name, seed, i) alone and has the same bits on every compiler.
/// @throws InputError naming the known families.
PairSet make_pair_family(std::string_view name, std::uint64_t seed, std::size_t count);

/// The set of the one pair "name:index", under its own id.
PairSet make_family_pair(std::string_view name, std::uint64_t seed, std::size_t index);

}  // namespace touchstone::measures

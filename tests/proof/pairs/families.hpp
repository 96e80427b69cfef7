#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "touchstone/tests/proof/pairs/posed_solids.hpp"

namespace touchstone::proof {

struct Family {
  std::string_view name;
  std::string_view description;
};

/// The families of the comparison, then: scaled (any of them by 2^-300 to 2^300), single_precision (any of
/// them, poses rounded to float), warped, slivers, decoded (random bytes through the fuzzer's decoder),
/// blocks (neighbours in walls, grids, stacks and rails).
std::span<const Family> families();

/// Pair `index` of a family depends on (family, seed, index) alone and has the same bits on every compiler.
PosedSolids make_pair(std::size_t family, std::uint64_t seed, std::uint64_t index);

}  // namespace touchstone::proof

#pragma once

#include <array>
#include <cstdint>

#include "contact_core/narrowphase/narrowphase.hpp"
#include "contact_core/native/simd/kernels.hpp"

namespace touchstone::native {

/// A call's pairs are worked off in blocks of so many, whose records fit the stack.
inline constexpr std::size_t kBlock = 256;

/// The pairs of a block that go to one kernel.
struct Batch {
  std::array<PairIndices, kBlock> pairs;
  std::array<std::uint16_t, kBlock> slots;
  std::size_t count = 0;

  void add(const SolidPair& pair, std::size_t slot) {
    pairs[count] = {pair.a, pair.b};
    slots[count++] = static_cast<std::uint16_t>(slot);
  }
};

}  // namespace touchstone::native

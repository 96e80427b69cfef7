#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"

namespace touchstone::native {

/// A call's pairs are processed in blocks of this size, whose records fit the stack.
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

template <class Object>
void prefetch(const Object& object) {
  const auto* const first = reinterpret_cast<const char*>(&object);
  for (const char* line = first; line < first + sizeof(Object); line += 64) __builtin_prefetch(line);
  __builtin_prefetch(first + sizeof(Object) - 1);
}

/// Fetches the data that a kernel reads of a pair. Solids lie in no order; fetching while a block's pairs are
/// sorted by kind overlaps all of the block's cache misses.
template <class Record>
void prefetch_pair(const GrowingList<Record>& records, std::span<const Pose> poses, const SolidPair& pair) {
  for (const SolidIndex solid : {pair.a, pair.b}) {
    prefetch(poses[solid]);
    prefetch(records[solid]);
  }
}

}  // namespace touchstone::native

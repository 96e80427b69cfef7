#pragma once

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/native/solids/placed_pair.hpp"

// Whether solids meet: filters with error bounds, the cheapest that fits the pair's kind first, then exact
// arithmetic for what they leave. The answer is the hulls' own, whichever filter found it.

namespace touchstone::native {

/// Filters for a posed pair's kind: half-extents, half edges; nothing for other kinds.
/// @pre ordinary magnitudes.
Certified certify_kinds(const SolidSet& set, const SolidPair& pair, std::span<const Pose> poses);

/// Of a placed pair: portal, search for a separating plane, exact.
bool hulls_meet(const PlacedPair& placed);

/// @param cache empty, or one entry a pair. Of general pairs in batches it keeps the last separating axis;
/// other kinds, and pairs asked one by one, are not faster for it. Any contents are legal.
void overlap(const SolidSet& set, const Kernels& kernels, std::span<const SolidPair> pairs,
             std::span<const Pose> poses, std::span<PairStatus> status, std::span<PairCacheEntry> cache = {});

}  // namespace touchstone::native

#pragma once

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/native/overlap/flush_hulls.hpp"
#include "touchstone/contact_core/native/solids/placed_pair.hpp"

// Overlap test: filters with error bounds, the cheapest that fits the pair's kind first, then exact
// arithmetic for pairs that they leave unknown. The answer is exact for the hulls, whichever filter found it.

namespace touchstone::native {

/// The filter for the pair's kind: of boxes, of parallelepipeds; unknown for other kinds.
/// @pre ordinary magnitudes.
Certified certify_kinds(const SolidSet& set, const SolidPair& pair, std::span<const Pose> poses);

/// One pair of boxes, which the filter has left open. @pre finite poses.
Certified certify_touching_pair(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                                std::span<const Pose> poses);

/// Whether a placed pair meets: its heights over the plane across the depth's axis, MPR, GJK, exact
/// predicates.
/// @param depth of the pair, which may know nothing.
/// @param along null, or what certify_flush() told along the depth's axis.
bool hulls_meet(const Kernels& kernels, const PlacedPair& placed, const DepthRecord& depth = {},
                const FlushVerdict* along = nullptr);

/// @param cache empty, or one entry a pair. It keeps the last separating axis of general pairs in batches;
/// other kinds, and single pairs, do not gain by it. Any contents are legal.
void overlap(const SolidSet& set, const Kernels& kernels, std::span<const SolidPair> pairs,
             std::span<const Pose> poses, std::span<PairStatus> status, std::span<PairCacheEntry> cache = {});

}  // namespace touchstone::native

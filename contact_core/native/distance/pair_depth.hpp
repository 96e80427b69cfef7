#pragma once

#include <span>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/native/solids/placed_pair.hpp"
#include "touchstone/contact_core/native/solids/solid_set.hpp"

// Depth records of single pairs, whatever their magnitudes.

namespace touchstone::native {

inline constexpr DepthRecord kNothingKnown{0.0, {}, {}, Certified::unknown, DepthKnown::nothing};

/// The kind whose kernels fit both.
SolidKind kind_of(const SolidSet& set, const SolidPair& pair);

/// The kernels' record of one pair; of general hexahedra `nothing`. @pre comes_first(a, b).
DepthRecord pair_depth(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                       std::span<const Pose> poses);

/// The same for a pair beyond ordinary magnitudes, found on a copy scaled by a power of two: the bits are
/// those of the ordinary pair that it is a multiple of.
DepthRecord scaled_pair_depth(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                              std::span<const Pose> poses);

/// Fetches what hull_depth() and place() read of a solid: some 20 cache lines that would be waited for one by
/// one.
void prefetch_hull(const SolidData& solid);

/// Of a placed pair of any kind; its lengths and p_A are the placed pair's own.
DepthRecord hull_depth(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                       const PlacedPair& placed);

}  // namespace touchstone::native

#pragma once

#include <span>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/native/solids/placed_pair.hpp"
#include "touchstone/contact_core/native/solids/solid_set.hpp"

// Depth records of single pairs, whatever their magnitudes.

namespace touchstone::native {

inline constexpr DepthRecord kNoDepth{0.0, {}, {}, Certified::unknown, DepthKnown::nothing, 0, false};

/// The box times 2^exponent, whatever its magnitudes.
BoxRecord scaled(const BoxRecord& box, int exponent);

// Records are written where they stay: g++ 12 misplaces what is returned of their alignment and then copied.

/// The kernels' record of one pair; of general hexahedra `nothing`. @pre comes_first(a, b).
void find_pair_depth(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                     std::span<const Pose> poses, DepthRecord& out);

/// The same for a pair beyond ordinary magnitudes, found on a copy scaled by a power of two: the bits are
/// those of the ordinary pair that it is a multiple of.
void find_scaled_pair_depth(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                            std::span<const Pose> poses, DepthRecord& out);

/// Fetches of a solid what place() reads, and of its hull, where asked for, what find_hull_depth() and
/// manifolds do.
void prefetch_hull(const SolidSet& set, SolidIndex solid, bool depth, bool faces);

/// The record of a placed pair of any kind; lengths and p_A are scaled and about its origin, as the pair is.
/// @param furthest_pose largest |coordinate| of the two poses' positions, in the world: vertices that are far
/// from their solid's own origin round by that much more than where they come to lie says.
void find_hull_depth(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                     const PlacedPair& placed, double furthest_pose, DepthRecord& out);

}  // namespace touchstone::native

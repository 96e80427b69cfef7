#pragma once

#include "contact_core/narrowphase/narrowphase.hpp"
#include "contact_core/native/solid_set.hpp"

namespace touchstone::native {

/// Distances that the kernels find by themselves: of two boxes or parallelepipeds that are apart by more than
/// rounding, of other hexahedra by more than a 64th of the pair's extent. Other records are not `found`;
/// record i depends on pair i alone.
/// @param pairs all of the one kind, in the order of comes_first().
void measure_apart(const SolidSet& set, const Kernels& kernels, SolidKind kind, std::span<const Pose> poses,
                   std::span<const PairIndices> pairs, ApartRecord* records);

/// A second try, with exact products, and on an exactly scaled copy when the pair's magnitudes ask for it.
/// @return record.found. When only record.fits is set, the rest is right for a pair that something else
/// proves to be apart.
bool measure_apart_accurately(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                              std::span<const Pose> poses, ApartRecord& record);

}  // namespace touchstone::native

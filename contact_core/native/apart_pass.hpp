#pragma once

#include "contact_core/narrowphase/narrowphase.hpp"
#include "contact_core/native/solid_set.hpp"

namespace touchstone::native {

/// Distances that the kernels find by themselves: of two boxes or parallelepipeds that are apart by more than
/// rounding. Other records are not `found`; record i depends on pair i alone.
/// @param pairs all of the one kind, not `general`, in the order of comes_first().
void measure_apart(const SolidSet& set, const Kernels& kernels, SolidKind kind, std::span<const Pose> poses,
                   std::span<const PairIndices> pairs, ApartRecord* records);

/// For magnitudes that the kernels do not take: the same on an exactly scaled copy.
/// @return false, and nothing done, when the kernels take them.
bool measure_apart_scaled(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                          std::span<const Pose> poses, ApartRecord& record);

}  // namespace touchstone::native

#pragma once

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/native/solids/pair_batch.hpp"
#include "touchstone/contact_core/native/solids/solid_set.hpp"

namespace touchstone::native {

inline constexpr ApartRecord kNoDistance{0.0, {}, {}, ApartState::open};

/// Whether the record is right for a pair that something else proves to be apart.
inline bool is_valid_if_apart(const ApartRecord& record) { return record.state >= ApartState::if_apart; }

/// Distances that the kernels find by themselves: of two boxes or parallelepipeds that are apart by more than
/// rounding. Other records are not `found`; record i depends on pair i alone.
/// @param pairs all of the one kind, not `general`, in the order of comes_first().
void measure_apart(const SolidSet& set, const Kernels& kernels, SolidKind kind, std::span<const Pose> poses,
                   std::span<const PairIndices> pairs, ApartRecord* records);

/// A second try, with exact products.
void measure_apart_accurately(const SolidSet& set, const Kernels& kernels, SolidKind kind,
                              std::span<const Pose> poses, std::span<const PairIndices> pairs,
                              ApartRecord* records);

/// Of two solids of any kind: general ones, and others so far from the world's origin that their vertices'
/// rounding shows. No record stays `open`.
void measure_hulls_apart(const SolidSet& set, const Kernels& kernels, std::span<const Pose> poses,
                         std::span<const PairIndices> pairs, ApartRecord* records);

/// All of this in turn, of the pairs of a batch that their depth records do not show to overlap.
/// @param kind not `general`. @param separated_too of pairs, too, that the depth records show to be apart.
void measure_batch_apart(const SolidSet& set, const Kernels& kernels, SolidKind kind,
                         std::span<const Pose> poses, const Batch& batch, const DepthRecord* depths,
                         bool separated_too, ApartRecord* records);

/// Whatever of this is left to try of one pair, on an exactly scaled copy when its magnitudes ask for it.
/// @param separated whether the pair is certainly apart.
/// @return whether the distance is found.
bool finish_apart(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                  std::span<const Pose> poses, bool separated, ApartRecord& record);

}  // namespace touchstone::native

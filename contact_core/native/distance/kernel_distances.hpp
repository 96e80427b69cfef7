#pragma once

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/native/solids/pair_batch.hpp"
#include "touchstone/contact_core/native/solids/solid_set.hpp"

namespace touchstone::native {

inline constexpr DistanceRecord kNoDistance{0.0, {}, {}, DistanceState::undecided};

/// Whether the record is right for a pair that is known to be separated.
inline bool is_valid_if_separated(const DistanceRecord& record) {
  return record.state >= DistanceState::if_separated;
}

/// Distances of two boxes or parallelepipeds that are separated by more than rounding, by the kernels. Other
/// records are not `found`; record i depends only on pair i.
/// @param pairs all of the one kind, not `general`, in the order of comes_first(), certified as separated by
/// their depths. @param axes DepthRecord::axis of each, or null: then each is searched for
void compute_distances(const SolidSet& set, const Kernels& kernels, SolidKind kind,
                       std::span<const Pose> poses, std::span<const PairIndices> pairs,
                       const std::uint8_t* axes, DistanceRecord* records);

/// The same with exact products, for pairs that compute_distances() left undecided.
void compute_distances_accurately(const SolidSet& set, const Kernels& kernels, SolidKind kind,
                                  std::span<const Pose> poses, std::span<const PairIndices> pairs,
                                  DistanceRecord* records);

/// Distances of two solids of any kind: general ones, and others so far from the world's origin that their
/// vertices' rounding shows. No record stays `undecided`.
void compute_hull_distances(const SolidSet& set, const Kernels& kernels, std::span<const Pose> poses,
                            std::span<const PairIndices> pairs, DistanceRecord* records);

/// Tries the three in turn on the pairs of a batch that are apart.
/// @param kind not `general`. @param decided the classes of pairs that the depth records leave unknown.
/// @param separated_too false: no distance is asked for.
void compute_batch_distances(const SolidSet& set, const Kernels& kernels, SolidKind kind,
                             std::span<const Pose> poses, const Batch& batch, const DepthRecord* depths,
                             const Certified* decided, bool separated_too, DistanceRecord* records);

/// Tries on one pair the kernels not tried yet, on an exactly scaled copy where its magnitudes are not
/// ordinary. @param separated whether the pair is certainly separated.
/// @return whether the distance is found.
bool finish_kernel_distance(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                            std::span<const Pose> poses, bool separated, DistanceRecord& record);

}  // namespace touchstone::native

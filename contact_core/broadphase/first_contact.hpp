#pragma once

#include <optional>

#include "touchstone/contact_core/broadphase/broadphase.hpp"

namespace touchstone {

/// The result of find_first_contact(): `undecided`, `failed` and `unsupported` count as contact, too.
struct FirstContact {
  SolidPair pair;
  PairStatus status;  ///< never `separated`
};

/// The lowest pair that the narrowphase does not call separated, or none. Candidates are looked for and
/// evaluated block by block and no further than needed. The first blocks are small, later ones as large as
/// `block`; their sizes do not show. No allocation after warm-up.
/// @pre The broadphase was updated with `poses`; `block` is not empty and `status` not shorter.
std::optional<FirstContact> find_first_contact(Broadphase& broadphase, const Narrowphase& narrowphase,
                                               std::span<const Pose> poses, Narrowphase::Workspace& workspace,
                                               std::span<SolidPair> block,
                                               std::span<PairStatus> status) noexcept;

}  // namespace touchstone

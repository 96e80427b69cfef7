#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/world/frame/executed_parts.hpp"
#include "touchstone/contact_core/world/frame/followers.hpp"
#include "touchstone/contact_core/world/frame/movers.hpp"
#include "touchstone/contact_core/world/model/world_model.hpp"
#include "touchstone/contact_core/world/pairs/frame_pairs.hpp"
#include "touchstone/contact_core/world/pairs/pair_watch.hpp"

/// @file
/// Objects without a command of their own that go along with a rigid mover, or a link of a mechanism: what is
/// carried from the frame's start, what is shoved from where it stopped the mover. Leader and followers take
/// the same motion part by part, checked against everything, each other too, and are stopped together.

namespace touchstone {

/// Contacts as a frame begins, for take_loads().
struct StandingContacts {
  std::span<const ContactState> known;  ///< as the frame before left them, by solids
  /// Set-up may have brought others together since. Then the watched pairs are up to date.
  bool is_fresh = false;
  NarrowphaseQuery& query;
  const PairWatch& watched;
};

/// Takes along loads that are in contact with their carrier as the frame begins, and theirs.
void take_loads(WorldModel& model, const StandingContacts& contacts, Movers& movers, Followers& followers);

/// Once a part is executed: takes along the standing objects that stopped a leader, where nothing else did.
/// @param among the part's pairs. @returns whether there is any.
bool take_shoved(WorldModel& model, std::span<const FramePair> among, Movers& movers, Followers& followers,
                 ExecutedParts& parts);

/// Lays a follower's path: its leader's motion, from where it stands.
void go_along(WorldModel& model, std::uint32_t leader, std::uint32_t root);

}  // namespace touchstone

#pragma once

#include <cstdint>
#include <span>

#include "touchstone/contact_core/world/executed_parts.hpp"
#include "touchstone/contact_core/world/frame/movers.hpp"
#include "touchstone/contact_core/world/frame_pairs.hpp"
#include "touchstone/contact_core/world/slide/followers.hpp"
#include "touchstone/contact_core/world/world_model.hpp"

/// @file
/// Objects without a command of their own that go along with a rigid mover: what is carried from the frame's
/// start, what is shoved from where it stopped the mover. Leader and followers take the same rigid motion
/// part by part, checked against everything, each other too, and are stopped together.

namespace touchstone {

/// Takes along loads that were in contact with their carrier as the frame began, and theirs.
/// @param contacts then, by solids.
void take_loads(WorldModel& model, std::span<const ContactState> contacts, Movers& movers,
                Followers& followers);

/// Once a part is executed: takes along what stopped a leader, where nothing else did. Those stood until now.
/// @param among the part's pairs. @returns whether there is any.
bool take_shoved(WorldModel& model, std::span<const FramePair> among, Movers& movers, Followers& followers,
                 ExecutedParts& parts);

/// Lays a follower's path: its leader's motion, from where it stands.
void go_along(WorldModel& model, std::uint32_t leader, std::uint32_t root);

}  // namespace touchstone

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "touchstone/contact_core/world/frame/executed_parts.hpp"
#include "touchstone/contact_core/world/frame/movers.hpp"
#include "touchstone/contact_core/world/frame/watched_pairs.hpp"
#include "touchstone/contact_core/world/model/frame_lanes.hpp"

namespace touchstone {

/// Moves objects to where their movers were stopped on the laid paths, and counts travels up to there.
void execute(WorldModel& model, WatchedPairs& watched, const Movers& movers, FrameLanes& lanes);

/// Places the closed solids of these pairs where their objects stand: execute() places open ones only, and
/// after a complete set-up contacts may end whose pairs are not watched again.
void place_closed(WorldModel& model, std::span<const ContactState> contacts);

/// Records these paths and stops as a part of the frame.
void record_part(const WorldModel& model, const Movers& movers, std::uint32_t part, ExecutedParts& parts);

/// Where the slot's object stood at s of a part: see ContactWorld::executed_pose().
Pose executed_pose(const WorldModel& model, const ExecutedParts& parts, std::uint32_t slot, std::size_t part,
                   double s);

}  // namespace touchstone

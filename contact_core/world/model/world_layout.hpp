#pragma once

#include <cstdint>

#include "touchstone/contact_core/world/model/world_model.hpp"

/// @file
/// Set-up of a world's model: what is kept by slot and by solid, from the objects and the layout.

namespace touchstone {

/// Exempt pairs of a new layout: those named, and those of mechanisms, sorted.
void list_exempt_pairs(const WorldModel& model, Layout& out);

/// For all slots and solids of the layout. @param anew as if nothing had moved yet, else values stay.
void take_room(WorldModel& model, bool anew);

/// Every object is in its body, at rest.
void place_all(WorldModel& model);
/// The slot's object moves with another body, or its own, or is gone.
void change_body(WorldModel& model, std::uint32_t slot);
/// The slot's solids stand where its object does. @pre place_all() or change_body().
void place_solids(WorldModel& model, std::uint32_t slot);
/// The slot's object is new, or gone: it has not moved yet.
void begin_object(WorldModel& model, std::uint32_t slot);
/// Paths find the poses in bodies where these are now.
void lay_resting_paths(WorldModel& model);

}  // namespace touchstone

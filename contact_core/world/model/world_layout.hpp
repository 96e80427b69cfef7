#pragma once

#include <cstdint>
#include <vector>

#include "touchstone/contact_core/world/model/world_model.hpp"

/// @file
/// Set-up of a world's model: what is kept by slot and by solid, from the objects and the layout.

namespace touchstone {

/// Exempt pairs of a new layout: those named, and those of mechanisms, sorted.
void list_exempt_pairs(const WorldModel& model, Layout& out);
/// Those of a mechanism, sorted. @pre its links' slots are laid out.
std::vector<SolidPair> exempt_pairs(const Layout& layout, const MechanismMover& mover);
/// Takes up a new mechanism's pairs of links and its exempt pairs. @pre its links' slots are laid out.
void lay_out(WorldModel& model, MechanismMover& mover);

/// For all slots and solids of the layout. @param anew as if nothing had moved yet, else values stay.
void take_room(WorldModel& model, bool anew);

/// Places every object in its body, at rest.
void place_all(WorldModel& model);
/// Takes up that the slot's object moves with another body, or alone, or was removed.
void change_body(WorldModel& model, std::uint32_t slot);
/// Places the slot's solids where its object stands. @pre place_all() or change_body().
void place_solids(WorldModel& model, std::uint32_t slot);
/// Takes up that the slot's object is new or was removed: it has not moved yet.
void begin_object(WorldModel& model, std::uint32_t slot);

}  // namespace touchstone

#pragma once

#include <cstdint>

#include "touchstone/contact_core/world/model/world_model.hpp"
#include "touchstone/contact_core/world/slide/slider.hpp"

// How far slides can still take solids: no slide increases the distance to its goal.

namespace touchstone {

/// The link of the slider's arm that `other` belongs to; the base where it belongs to none.
std::uint32_t other_link(const WorldModel& model, const Slider& slider, SolidIndex other);

/// The point about which plans turn a slider's solid: the link's origin, or the rigid mover's centre.
Vector3 slide_centre(const WorldModel& model, const Slider& slider, SolidIndex solid);

/// How far a slider's solid can still go, as seen from the other one [m].
double slide_reach(const WorldModel& model, const Slider& slider, SolidIndex solid, SolidIndex other);

/// How far the slider's solids of a pair can still go together [m]; the other solid is taken to rest.
double reach_of_pair(const WorldModel& model, const Slider& slider, const SolidPair& pair);

/// Whether more may come near a rigid slider's object than is watched. Writes how far around it pairs have to
/// be watched, into the travels.
bool needs_more_pairs(WorldModel& model, const Slider& slider, std::uint32_t slot);

/// Writes how far the path that an arm has laid takes each solid, into the travels' plan.
void measure_plan(WorldModel& model, const Slider& slider);

}  // namespace touchstone

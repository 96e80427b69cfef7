#pragma once

#include <span>

#include "touchstone/physics/contacts/touch_events.hpp"
#include "touchstone/physics/engine/dynamics_engine.hpp"

namespace touchstone::physics {

/// Touches from a step's contacts, of any engine. An engine whose narrowphase reaches beyond contact
/// touches by its own rule: where it presses. @param contacts of DynamicsEngine::list_contacts() @param h
/// the step [s]
inline void take_touches(std::span<const EngineContact> contacts, double h, TouchEvents& events) {
  events.begin();
  for (const EngineContact& contact : contacts)
    events.add({contact.solids, contact.p_W, contact.n_AB_W, contact.separation, h * contact.force_W,
                contact.impact_W});
  events.finish();
}

}  // namespace touchstone::physics

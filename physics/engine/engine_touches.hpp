#pragma once

#include <algorithm>
#include <span>

#include "touchstone/physics/contacts/touch_events.hpp"
#include "touchstone/physics/engine/dynamics_engine.hpp"

namespace touchstone::physics {

/// Touches from a step's contacts, of any engine. An engine whose narrowphase reaches beyond contact touches
/// by its own rule: where it presses. Pairs come as a < b.
/// @param contacts of DynamicsEngine::list_contacts() @param h the step [s] @param sleeps as
/// TouchEvents::finish() has it, for a < b
template <class Sleeps>
void take_touches(std::span<const EngineContact> contacts, double h, const Sleeps& sleeps,
                  TouchEvents& events) {
  events.begin();
  for (const EngineContact& contact : contacts) {
    // Engines list a pair either way round, and not in every step the same.
    const SolidPair& pair = contact.solids;
    const double sign = pair.a <= pair.b ? 1.0 : -1.0;
    events.add({{std::min(pair.a, pair.b), std::max(pair.a, pair.b)},
                contact.p_W,
                sign * contact.n_AB_W,
                contact.separation,
                sign * h * contact.force_W,
                sign * contact.impact_W});
  }
  events.finish(sleeps);
}

/// The same where nothing sleeps.
inline void take_touches(std::span<const EngineContact> contacts, double h, TouchEvents& events) {
  take_touches(
      contacts, h, [](const SolidPair&) { return false; }, events);
}

/// The same of the engine's last step: pairs that sleep persist, without points. @param contacts its list
inline void take_touches(const DynamicsEngine& engine, std::span<const EngineContact> contacts,
                         TouchEvents& events) {
  take_touches(
      contacts, engine.scene().step, [&](const SolidPair& pair) { return engine.are_asleep(pair); }, events);
}

}  // namespace touchstone::physics

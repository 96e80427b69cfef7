#pragma once

#include <algorithm>
#include <span>

#include "touchstone/physics/contacts/touch_events.hpp"
#include "touchstone/physics/engine/dynamics_engine.hpp"

namespace touchstone::physics {

/// Touches from an engine's last step. An engine whose narrowphase reaches beyond contact touches by its own
/// rule: where it presses. Pairs come as a < b; those that sleep persist, without points.
/// @param contacts of DynamicsEngine::list_contacts()
inline void take_touches(const DynamicsEngine& engine, std::span<const EngineContact> contacts,
                         TouchEvents& events) {
  const double h = engine.scene().step;
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
  events.finish([&](const SolidPair& pair) { return engine.are_asleep(pair); });
}

}  // namespace touchstone::physics

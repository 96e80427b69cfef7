#pragma once

#include "touchstone/physics/engine/engine_registry.hpp"

namespace touchstone::physics {

/// Registers `own` and every engine of this build, and names those that it lacks.
/// @param backends must outlive the registry's engines.
void register_all_engines(EngineRegistry& registry, const BackendRegistry& backends);

}  // namespace touchstone::physics

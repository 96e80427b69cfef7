#pragma once

#include "contact_core/registry.hpp"

namespace touchstone::comparison {

/// Registers every backend of this build that one process can hold: the single-precision Bullet cannot stand
/// beside the double one and is left out.
void register_all_backends(BackendRegistry& registry);

}  // namespace touchstone::comparison

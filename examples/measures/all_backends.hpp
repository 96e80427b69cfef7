#pragma once

#include <string>
#include <vector>

#include "touchstone/contact_core/registry.hpp"

namespace touchstone::comparison {

/// Registers every backend of this build that one process can hold: the single-precision Bullet cannot stand
/// beside the double one and is left out.
void register_all_backends(BackendRegistry& registry);

/// Their narrowphases' names, in the order of registration.
std::vector<std::string> all_backend_names();

}  // namespace touchstone::comparison

#pragma once

#include "contact_core/registry.hpp"
#include "examples/compare_backends/report.hpp"

namespace touchstone::comparison {

/// Registers every backend that is in this build and names those that are not.
void register_backends(BackendRegistry& registry, std::vector<Gap>& gaps);

}  // namespace touchstone::comparison

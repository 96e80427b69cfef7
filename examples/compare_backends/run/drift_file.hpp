#pragma once

#include <string>

#include "touchstone/examples/compare_backends/judge/dynamics_drift.hpp"

namespace touchstone::comparison {

/// From dynamics_run's results.json. @throws InputError for another file, or where a figure is
/// negative that cannot be.
Drift load_drift(const std::string& path);

}  // namespace touchstone::comparison

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "contact_core/registry.hpp"
#include "examples/compare_backends/progress.hpp"
#include "examples/training_run/results.hpp"

namespace touchstone::training {

/// Flies one script all ways and judges them: no check, late reports, and the contact world with each
/// backend. The first backend's flight is recorded and plotted beside the other two ways.
/// @param frame_rate replaces the script's, if it is not 0 [Hz].
ScriptResult run_script(const std::filesystem::path& file, double frame_rate, const BackendRegistry& registry,
                        const std::vector<std::string>& backends, comparison::ProgressLine& progress);

}  // namespace touchstone::training

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/program/progress.hpp"
#include "touchstone/examples/training_run/options.hpp"
#include "touchstone/examples/training_run/results.hpp"

namespace touchstone::training {

/// Flies one script all ways and judges them: no check, late reports, and the contact world with each
/// backend. Every flight is recorded where the options ask for it; the first backend's is plotted beside the
/// other two ways, and shown on the image generator.
ScriptResult run_script(const std::filesystem::path& file, const Options& options,
                        const BackendRegistry& registry, const std::vector<std::string>& backends,
                        comparison::ProgressLine& progress);

}  // namespace touchstone::training

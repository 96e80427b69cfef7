#pragma once

#include <filesystem>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/dynamics_run/options.hpp"
#include "touchstone/examples/dynamics_run/results.hpp"
#include "touchstone/examples/program/progress.hpp"
#include "touchstone/examples/program/report_files.hpp"

namespace touchstone::dynamics {

/// One scene over all backends asked for, and the reference. @throws InputError as load_dynamic_scene;
/// comparison::Interrupted.
SceneResult run_scene(const std::filesystem::path& file, const Options& options,
                      const BackendRegistry& registry, const std::vector<std::string>& backends,
                      comparison::ProgressLine& progress);

/// The report: results, series and plots.
std::vector<comparison::ReportFile> report_files(const std::vector<SceneResult>& results);

}  // namespace touchstone::dynamics

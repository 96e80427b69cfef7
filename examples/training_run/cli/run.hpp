#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/program/terminal/progress.hpp"
#include "touchstone/examples/training_run/cli/options.hpp"
#include "touchstone/examples/training_run/results/results.hpp"

namespace touchstone::training {

/// The script, or a robot's flight (robot_script()), at the options' frame rate. @param on_account gets what
/// robots came to. @throws InputError naming the file: as load_script, the readers of robots and Setting, and
/// for more frames than there is room for.
std::shared_ptr<const Setting> load_setting(const std::filesystem::path& file, const Options& options,
                                            const std::function<void(const std::string&)>& on_account = {});

/// The names of the flights' files, without extension, in the order of the flights.
std::vector<std::string> flight_names(const std::string& script, const std::vector<std::string>& backends);

/// Gets a script that is not flown by every method yet; the last one is new.
using OnMethod = std::function<void(const ScriptResult&)>;

/// Flies one script by all methods and judges them: no check, late reports, the paper's first build, and the
/// contact world with each backend. Every flight is recorded where the options ask for it; the first
/// backend's is plotted beside the other three methods, and shown on the image generator.
ScriptResult run_script(const std::filesystem::path& file, const Options& options,
                        const BackendRegistry& registry, const std::vector<std::string>& backends,
                        program::ProgressLine& progress, const OnMethod& on_method = {});

}  // namespace touchstone::training

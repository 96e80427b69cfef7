#pragma once

#include <filesystem>
#include <functional>

#include "touchstone/examples/dynamics_run/options.hpp"
#include "touchstone/examples/dynamics_run/results.hpp"
#include "touchstone/examples/program/terminal/progress.hpp"
#include "touchstone/physics/engine/engine_registry.hpp"

namespace touchstone::dynamics {

/// The scene with the options' parameters, or a robot that falls (robot_scene()). @param on_account gets what
/// robots came to. @throws InputError naming the file: as load_dynamic_scene, and for more steps or recorded
/// rows than there is room for.
physics::DynamicScene load_scene(const std::filesystem::path& file, const Options& options,
                                 const std::function<void(const std::string&)>& on_account = {});

/// Called with a scene whose runs are not all there yet; the last is new.
using OnRun = std::function<void(const SceneResult&)>;

/// One scene in all engines and over all backends asked for, and the reference: the own engine over
/// `options.reference`. @throws InputError as load_scene.
SceneResult run_scene(const std::filesystem::path& file, const Options& options,
                      const physics::EngineRegistry& engines,
                      const std::vector<physics::EngineChoice>& choices, program::ProgressLine& progress,
                      const OnRun& on_run = {});

}  // namespace touchstone::dynamics

#pragma once

#include "touchstone/examples/dynamics_run/results.hpp"
#include "touchstone/examples/program/terminal/progress.hpp"
#include "touchstone/physics/engine/engine_registry.hpp"

namespace touchstone::dynamics {

/// Returns a run's name: of the own engine by its narrowphase, else `engine` (with its own check) or
/// `engine:narrowphase`.
std::string run_name(const physics::EngineChoice& choice);

/// Runs the scene in an engine. Where a step fails the run ends there, its last good state kept and the cause
/// named.
/// @param every n-th step is recorded; 0: none.
BackendRun simulate(const physics::DynamicScene& scene, const physics::EngineRegistry& engines,
                    const physics::EngineChoice& choice, std::size_t every, program::ProgressLine& progress);

/// Sets the scene up with own:native. @throws InputError for what only that shows: see MechanismDynamics.
void check(const physics::DynamicScene& scene, const physics::EngineRegistry& engines);

/// The same run once more: each of run's steps keeps the faster of its times. Nothing else is looked at.
void repeat_timing(const physics::DynamicScene& scene, const physics::EngineRegistry& engines,
                   const physics::EngineChoice& choice, BackendRun& run, program::ProgressLine& progress);

/// `object/hexahedron` of all solids, as ContactRow counts them.
std::vector<std::string> solid_names(const physics::DynamicScene& scene);

}  // namespace touchstone::dynamics

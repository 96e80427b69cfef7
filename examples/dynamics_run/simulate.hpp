#pragma once

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/dynamics_run/results.hpp"
#include "touchstone/examples/program/progress.hpp"

namespace touchstone::dynamics {

/// Runs the scene over the contacts of one narrowphase, with the native broadphase. Where a step fails the
/// run ends there, its last good state kept and the cause named.
/// @param every n-th step is recorded; 0: none.
BackendRun simulate(const physics::DynamicScene& scene, const BackendRegistry& registry,
                    const std::string& backend, std::size_t every, comparison::ProgressLine& progress);

/// Sets the scene up with native. @throws InputError for what only that shows: see MechanismDynamics.
void check(const physics::DynamicScene& scene, const BackendRegistry& registry);

/// The same run once more: each of run's steps keeps the faster of its times. Nothing else is looked at.
void repeat_timing(const physics::DynamicScene& scene, const BackendRegistry& registry, BackendRun& run,
                   comparison::ProgressLine& progress);

/// `object/hexahedron` of all solids, as ContactRow counts them.
std::vector<std::string> solid_names(const physics::DynamicScene& scene);

}  // namespace touchstone::dynamics

#pragma once

#include <filesystem>

#include "touchstone/adapters/scene_files/scene_file.hpp"
#include "touchstone/physics/scene/dynamic_scene.hpp"

/// @file
/// Component dynamics_files: what a scene file asks of dynamics. Programs without dynamics read the same file
/// with load_scene() and link no physics.

namespace touchstone {

/// Reads a scene file with its `dynamics` (YAML; the format is described in adapters/scene_files/README.md).
/// Objects that no entry names are static, or kinematic where they have a motion.
/// @throws InputError, one line `file:line: object 'x': reason`, as load_scene; further: no `dynamics`, what
/// validate(DynamicScene) refuses, unknown objects and joints.
/// @param arm_models empty: bundled arms only.
physics::DynamicScene load_dynamic_scene(const std::filesystem::path& path,
                                         const SceneParameters& parameters = {},
                                         const ArmModels& arm_models = {});

}  // namespace touchstone

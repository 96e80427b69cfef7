#pragma once

#include "touchstone/adapters/scene_files/yaml_reader.hpp"
#include "touchstone/physics/scene/dynamic_scene.hpp"

// Private to this folder: it shows yaml-cpp.

namespace touchstone::scene_files {

/// `arms` of a scene's dynamics: bundled models, each with its links as objects. @throws InputError with file
/// and line.
void read_arms(const YamlReader& arms, physics::DynamicScene& scene);

}  // namespace touchstone::scene_files

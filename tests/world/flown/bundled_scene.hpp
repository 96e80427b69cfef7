#pragma once

#include <string>

#include "touchstone/adapters/scene_files/scene_file.hpp"

namespace touchstone {

/// @param file in examples/scenes
inline Scene scene_from(const std::string& file, const SceneParameters& parameters = {}) {
  return load_scene(std::string(TOUCHSTONE_SCENES) + "/" + file, parameters);
}

}  // namespace touchstone

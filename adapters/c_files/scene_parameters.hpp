#pragma once

#include "touchstone/adapters/c_files/touchstone_files.h"
#include "touchstone/adapters/c_interface/calls.hpp"
#include "touchstone/adapters/scene_files/scene_file.hpp"

// Private to this folder.

namespace touchstone::c_interface {

/// @throws InputError: parameters, but no array, or one without a name.
inline SceneParameters scene_parameters(const touchstone_parameter* parameters, std::size_t count) {
  if (count > 0) require(parameters, "parameters");
  SceneParameters values;
  for (std::size_t i = 0; i < count; ++i) {
    require(parameters[i].name, "parameters: name");
    values[parameters[i].name] = parameters[i].value;
  }
  return values;
}

}  // namespace touchstone::c_interface

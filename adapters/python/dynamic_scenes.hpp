#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "touchstone/physics/scene/dynamic_scene.hpp"

// Private to this folder: scenes of dynamics.

namespace touchstone::python {

/// Those of mechanisms, as "arm.elbow", then those between bodies.
std::vector<std::string> joint_names(const physics::DynamicScene& scene);

void bind_dynamic_scenes(pybind11::module_& module);

}  // namespace touchstone::python

#pragma once

#include <pybind11/pybind11.h>

#include <string_view>

/// @file
/// Each source adds its part to the module touchstone._core.

namespace touchstone {
class BackendRegistry;
class HexahedronTree;
}  // namespace touchstone

namespace touchstone::python {

void bind_shapes(pybind11::module_& module);
void bind_narrowphases(pybind11::module_& module);
void bind_fit(pybind11::module_& module);
void bind_world(pybind11::module_& module);
void bind_dynamics(pybind11::module_& module);

/// The backends of this build that one process can hold, and the plug-ins that were loaded. With Python's
/// lock held.
BackendRegistry& backends();
/// Whether a backend is of this build, and no plug-in or engine.
bool is_built_in(std::string_view name);

}  // namespace touchstone::python

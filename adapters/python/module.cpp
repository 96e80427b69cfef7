#include <pybind11/pybind11.h>

#include "touchstone/adapters/python/bindings.hpp"
#include "touchstone/contact_core/input_error.hpp"

PYBIND11_MODULE(_core, module) {
  using namespace touchstone::python;
  module.doc() = "Contact detection for convex hexahedra: what the package touchstone is made of.";
  module.attr("__version__") = TOUCHSTONE_VERSION;
  pybind11::register_exception<touchstone::InputError>(module, "InputError", PyExc_ValueError);
  bind_shapes(module);
  bind_narrowphases(module);
  bind_fit(module);
  bind_world(module);
  bind_dynamics(module);
}

#include <pybind11/pybind11.h>

#include <string>

#include "touchstone/adapters/python/bindings.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"

PYBIND11_MODULE(_core, module) {
  using namespace touchstone::python;
  module.doc() = "Contact detection for convex hexahedra: what the package touchstone is made of.";
  module.attr("__version__") = TOUCHSTONE_VERSION;
  // Chosen now: a TOUCHSTONE_ISA that is none is an ImportError, whatever is asked later.
  const std::string isa = touchstone::native::kernels().isa;
  module.def(
      "instruction_set", [isa] { return isa; },
      "Of native's kernels in this process: 'generic', 'avx2' or 'avx512', whichever is the last that the "
      "processor has. It shows in times alone.");
  pybind11::register_exception<touchstone::InputError>(module, "InputError", PyExc_ValueError);
  bind_shapes(module);
  bind_narrowphases(module);
  bind_fit(module);
  bind_world(module);
  bind_dynamics(module);
}

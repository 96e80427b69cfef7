#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <string>

#include "touchstone/adapters/python/bindings.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"

namespace {

/// pybind11 before 2.12 finds the size of NumPy 2's elements in another place: answers would be read with
/// wrong strides, without a word.
void refuse_misread_numpy() {
  if (pybind11::dtype("f8").itemsize() == sizeof(double)) return;
  const std::string numpy = pybind11::str(pybind11::module_::import("numpy").attr("__version__"));
  throw pybind11::import_error("touchstone: this module is built with pybind11 " +
                               std::to_string(PYBIND11_VERSION_MAJOR) + "." +
                               std::to_string(PYBIND11_VERSION_MINOR) + ", which misreads arrays of NumPy " +
                               numpy + ": install numpy < 2, or build it with pybind11 2.12 or later");
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  using namespace touchstone::python;
  refuse_misread_numpy();
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

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
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

/// pybind11 gives an object whose `__init__` was not called memory that nothing has written, when a method of
/// it is called: World.__new__(World).frame(), or a subclass's `__init__` before that of its base. It asks
/// for that memory here.
void refuse_objects_without_init(const pybind11::module_& module) {
  for (const auto& [name, of] : module.attr("__dict__").cast<pybind11::dict>()) {
    if (PyType_Check(of.ptr()) == 0) continue;
    auto* const type = pybind11::detail::get_type_info(reinterpret_cast<PyTypeObject*>(of.ptr()));
    if (type == nullptr) continue;  // InputError
    type->operator_new = [](std::size_t) -> void* {
      throw pybind11::type_error("touchstone: __init__() of this object was not called");
    };
  }
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
  refuse_objects_without_init(module);
}

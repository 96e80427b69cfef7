#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/adapters/python/bindings.hpp"

namespace touchstone::python {

BackendRegistry& backends() {
  // Never destroyed: narrowphases that the interpreter's end leaves may still need what a plug-in loaded.
  static BackendRegistry* const registry = [] {
    auto made = std::make_unique<BackendRegistry>();
    register_all_backends(*made);
    return made.release();
  }();
  return *registry;
}

}  // namespace touchstone::python

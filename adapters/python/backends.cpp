#include <algorithm>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/adapters/python/bindings.hpp"

namespace touchstone::python {
namespace {

std::size_t built_in = 0;  // entries of the registry, the first ones

}  // namespace

BackendRegistry& backends() {
  // Never destroyed: narrowphases that the interpreter's end leaves may still need what a plug-in loaded.
  static BackendRegistry* const registry = [] {
    auto made = std::make_unique<BackendRegistry>();
    register_all_backends(*made);
    built_in = made->narrowphases().size();
    return made.release();
  }();
  return *registry;
}

bool is_built_in(std::string_view name) {
  const auto first = backends().narrowphases().begin();
  return std::any_of(first, first + static_cast<std::ptrdiff_t>(built_in),
                     [&](const auto& entry) { return entry.name == name; });
}

}  // namespace touchstone::python

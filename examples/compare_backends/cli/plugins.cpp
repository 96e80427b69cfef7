#include "touchstone/examples/compare_backends/cli/plugins.hpp"

#include <algorithm>
#include <utility>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/cli/backends.hpp"

namespace touchstone::comparison {
namespace {

bool is_taken(const Backends& backends, const std::string& name) {
  const auto& here = backends.registry.narrowphases();
  return std::any_of(here.begin(), here.end(), [&](const auto& entry) { return entry.name == name; }) ||
         std::any_of(backends.workers.begin(), backends.workers.end(),
                     [&](const Worker& worker) { return worker.offers(name); });
}

}  // namespace

void add_plugins(Backends& backends, const std::filesystem::path& program,
                 const std::vector<std::string>& libraries) {
  for (const std::string& library : libraries) {
    Worker worker = describe_worker(worker_beside(program, "compare_backends_plugin"), {library});
    if (!worker.failure.empty()) reject("--plugin " + library, "cannot be used: " + worker.failure);
    for (const auto& [name, description] : worker.backends)
      if (is_taken(backends, name)) reject("--plugin " + library, "its name '" + name + "' is taken");
    backends.workers.push_back(std::move(worker));
  }
}

}  // namespace touchstone::comparison

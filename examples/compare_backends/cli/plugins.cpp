#include "touchstone/examples/compare_backends/cli/plugins.hpp"

#include <algorithm>
#include <sstream>
#include <utility>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/cli/backends.hpp"
#ifdef TOUCHSTONE_HAS_PROCESS_ENGINE
#include "touchstone/adapters/process_engine/process_engine.hpp"
#endif

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
                 const std::vector<std::string>& libraries, std::chrono::milliseconds time_limit) {
  for (const std::string& library : libraries) {
    Worker worker = describe_worker(worker_beside(program, "compare_backends_plugin"), {library}, time_limit);
    if (!worker.failure.empty()) reject("--plugin " + library, "cannot be used: " + worker.failure);
    for (const auto& [name, description] : worker.backends)
      if (is_taken(backends, name)) reject("--plugin " + library, "its name '" + name + "' is taken");
    backends.workers.push_back(std::move(worker));
  }
}

void add_engines(Backends& backends, const std::vector<std::string>& commands,
                 std::optional<std::chrono::milliseconds> time_limit) {
#ifdef TOUCHSTONE_HAS_PROCESS_ENGINE
  for (const std::string& command : commands) {
    ProcessEngineOptions options;
    std::istringstream words(command);
    for (std::string word; words >> word;) options.command.push_back(word);
    if (time_limit) options.time_limit = *time_limit;
    register_process_engine(backends.registry, options);
  }
#else
  static_cast<void>(backends);
  static_cast<void>(time_limit);
  if (!commands.empty()) throw InputError("--engine: not in this build: nlohmann-json was not found");
#endif
}

}  // namespace touchstone::comparison

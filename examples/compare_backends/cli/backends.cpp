#include "touchstone/examples/compare_backends/cli/backends.hpp"

#include "touchstone/adapters/all/all_backends.hpp"

namespace touchstone::comparison {

std::filesystem::path worker_beside(const std::filesystem::path& program, const char* name) {
  const std::filesystem::path folder = program.parent_path();
  const std::filesystem::path installed = folder.parent_path() / "libexec/touchstone" / name;
  return std::filesystem::exists(installed) ? installed : folder / name;
}

Backends build_backends(const std::filesystem::path& program) {
  Backends backends;
  register_all_backends(backends.registry);
  backends.sweeps = all_sweeps();
  std::vector<Gap>& gaps = backends.gaps;
  for (const BackendSource& source : backend_sources())
    if (source.register_in == nullptr)
      gaps.push_back({source.narrowphases, std::string("not in this build: ") + source.missing});
#ifdef TOUCHSTONE_HAS_BULLET_SINGLE
  Worker worker = describe_worker(worker_beside(program, "compare_backends_bullet_single"));
  if (worker.failure.empty()) {
    backends.workers.push_back(std::move(worker));
  } else {
    gaps.push_back({"bullet_single", worker.failure});
  }
#else
  (void)program;
  gaps.push_back(
      {"bullet_single, bullet_single_gjk", "not in this build: no single-precision Bullet was found"});
#endif
  return backends;
}

}  // namespace touchstone::comparison

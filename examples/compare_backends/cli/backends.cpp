#include "touchstone/examples/compare_backends/cli/backends.hpp"

#include "touchstone/examples/measures/all_backends.hpp"

namespace touchstone::comparison {

std::filesystem::path worker_beside(const std::filesystem::path& program, const char* name) {
  const std::filesystem::path folder = program.parent_path();
  const std::filesystem::path installed = folder.parent_path() / "libexec/touchstone" / name;
  return std::filesystem::exists(installed) ? installed : folder / name;
}

Backends build_backends(const std::filesystem::path& program) {
  Backends backends;
  register_all_backends(backends.registry);
  std::vector<Gap>& gaps = backends.gaps;
#ifndef TOUCHSTONE_HAS_BULLET
  gaps.push_back({"bullet, bullet_gjk", "not in this build: no double-precision Bullet was found"});
#endif
#ifndef TOUCHSTONE_HAS_ODE
  gaps.push_back({"ode", "not in this build: ODE was not found"});
#endif
#ifndef TOUCHSTONE_HAS_LIBCCD
  gaps.push_back({"libccd_gjk, libccd_mpr", "not in this build: libccd was not found"});
#endif
#ifndef TOUCHSTONE_HAS_FCL
  gaps.push_back({"fcl, fcl_indep", "not in this build: FCL was not found"});
#endif
#ifndef TOUCHSTONE_HAS_MUJOCO
  gaps.push_back({"mujoco", "not in this build: MuJoCo was not found"});
#endif
#ifndef TOUCHSTONE_HAS_EXACT
  gaps.push_back({"exact", "not in this build: errors cannot be measured without it"});
#endif
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

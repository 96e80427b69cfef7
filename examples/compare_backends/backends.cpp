#include "examples/compare_backends/backends.hpp"

#ifdef TOUCHSTONE_HAS_EXACT
#include "adapters/exact/exact.hpp"
#endif
#ifdef TOUCHSTONE_HAS_BULLET
#include "adapters/bullet/bullet.hpp"
#endif
#ifdef TOUCHSTONE_HAS_ODE
#include "adapters/ode/ode.hpp"
#endif

namespace touchstone::comparison {

Backends build_backends(const std::filesystem::path& program) {
  Backends backends;
  BackendRegistry& registry = backends.registry;
  std::vector<Gap>& gaps = backends.gaps;
  register_core(registry);
#ifdef TOUCHSTONE_HAS_BULLET
  register_bullet(registry);
#else
  gaps.push_back({"bullet, bullet_gjk", "not in this build: no double-precision Bullet was found"});
#endif
#ifdef TOUCHSTONE_HAS_ODE
  register_ode(registry);
#else
  gaps.push_back({"ode", "not in this build: ODE was not found"});
#endif
#ifdef TOUCHSTONE_HAS_EXACT
  register_exact(registry);
#else
  gaps.push_back({"exact", "not in this build: errors cannot be measured without it"});
#endif
#ifdef TOUCHSTONE_HAS_BULLET_SINGLE
  Worker worker = describe_worker(program.parent_path() / "compare_backends_bullet_single");
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

#include "touchstone/examples/measures/all_backends.hpp"

#ifdef TOUCHSTONE_HAS_EXACT
#include "touchstone/adapters/exact/exact.hpp"
#endif
#ifdef TOUCHSTONE_HAS_BULLET
#include "touchstone/adapters/bullet/bullet.hpp"
#endif
#ifdef TOUCHSTONE_HAS_ODE
#include "touchstone/adapters/ode/ode.hpp"
#endif
#ifdef TOUCHSTONE_HAS_LIBCCD
#include "touchstone/adapters/libccd/libccd.hpp"
#endif
#ifdef TOUCHSTONE_HAS_FCL
#include "touchstone/adapters/fcl/fcl.hpp"
#endif
#ifdef TOUCHSTONE_HAS_MUJOCO
#include "touchstone/adapters/mujoco/mujoco.hpp"
#endif

namespace touchstone::comparison {

void register_all_backends(BackendRegistry& registry) {
  register_core(registry);
#ifdef TOUCHSTONE_HAS_BULLET
  register_bullet(registry);
#endif
#ifdef TOUCHSTONE_HAS_ODE
  register_ode(registry);
#endif
#ifdef TOUCHSTONE_HAS_LIBCCD
  register_libccd(registry);
#endif
#ifdef TOUCHSTONE_HAS_FCL
  register_fcl(registry);
#endif
#ifdef TOUCHSTONE_HAS_MUJOCO
  register_mujoco(registry);
#endif
#ifdef TOUCHSTONE_HAS_EXACT
  register_exact(registry);
#endif
}

std::vector<std::string> all_backend_names() {
  BackendRegistry registry;
  register_all_backends(registry);
  std::vector<std::string> names;
  for (const BackendRegistry::NarrowphaseEntry& entry : registry.narrowphases()) names.push_back(entry.name);
  return names;
}

}  // namespace touchstone::comparison

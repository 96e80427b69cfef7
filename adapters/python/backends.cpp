#include "touchstone/adapters/python/bindings.hpp"
#include "touchstone/contact_core/registry.hpp"

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

namespace touchstone::python {
namespace {

void register_all(BackendRegistry& registry) {
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

}  // namespace

BackendRegistry& backends() {
  // Never destroyed: narrowphases that the interpreter's end leaves may still need what a plug-in loaded.
  static BackendRegistry* const registry = [] {
    auto made = std::make_unique<BackendRegistry>();
    register_all(*made);
    return made.release();
  }();
  return *registry;
}

}  // namespace touchstone::python

#include "tests/backend_suite/suite.hpp"

#ifdef TOUCHSTONE_HAS_EXACT
#include "adapters/exact/exact.hpp"
#endif
#ifdef TOUCHSTONE_HAS_BULLET
#include "adapters/bullet/bullet.hpp"
#endif
#ifdef TOUCHSTONE_HAS_ODE
#include "adapters/ode/ode.hpp"
#endif

namespace touchstone::suite {

void register_suite_backends(BackendRegistry& registry) {
  register_core(registry);
#ifdef TOUCHSTONE_HAS_EXACT
  register_exact(registry);
#endif
#ifdef TOUCHSTONE_HAS_BULLET
  register_bullet(registry);
#endif
#ifdef TOUCHSTONE_HAS_ODE
  register_ode(registry);
#endif
}

}  // namespace touchstone::suite

#include "touchstone/examples/measures/all_engines.hpp"

#ifdef TOUCHSTONE_HAS_BULLET_DYNAMICS
#include "touchstone/adapters/bullet_dynamics/bullet_dynamics.hpp"
#endif
#ifdef TOUCHSTONE_HAS_ODE_DYNAMICS
#include "touchstone/adapters/ode_dynamics/ode_dynamics.hpp"
#endif
#ifdef TOUCHSTONE_HAS_MUJOCO_DYNAMICS
#include "touchstone/adapters/mujoco_dynamics/mujoco_dynamics.hpp"
#endif

namespace touchstone::comparison {

void register_all_engines(physics::EngineRegistry& registry, const BackendRegistry& backends) {
  register_own_engine(registry, backends);
#ifdef TOUCHSTONE_HAS_BULLET_DYNAMICS
  register_bullet_dynamics(registry);
#else
  registry.add_missing({"bullet", "this build has no Bullet in double precision (Debian: libbullet-dev)"});
#endif
#ifdef TOUCHSTONE_HAS_ODE_DYNAMICS
  register_ode_dynamics(registry);
#else
  registry.add_missing({"ode", "this build has no ODE in double precision (Debian: libode-dev)"});
#endif
#ifdef TOUCHSTONE_HAS_MUJOCO_DYNAMICS
  register_mujoco_dynamics(registry);
#else
  registry.add_missing({"mujoco", "this build has no MuJoCo (Debian: libmujoco-dev)"});
#endif
}

}  // namespace touchstone::comparison

#include "touchstone/adapters/all/all_engines.hpp"

#include "touchstone/adapters/all/if_built.hpp"
#include "touchstone/adapters/bullet_dynamics/bullet_dynamics.hpp"
#include "touchstone/adapters/mujoco_dynamics/mujoco_dynamics.hpp"
#include "touchstone/adapters/ode_dynamics/ode_dynamics.hpp"

namespace touchstone::physics {
namespace {

/// An adapter of a dynamics engine that a build may lack.
struct EngineSource {
  const char* engine;
  void (*register_in)(EngineRegistry&, const BackendRegistry&);  // null: not in this build
  const char* missing;                                           // why, where it is not
};

constexpr EngineSource kSources[] = {
    {"bullet", TOUCHSTONE_IF_BUILT(TOUCHSTONE_BUILT_BULLET_DYNAMICS, register_bullet_dynamics),
     "this build has no Bullet in double precision (Debian: libbullet-dev)"},
    {"ode", TOUCHSTONE_IF_BUILT(TOUCHSTONE_BUILT_ODE_DYNAMICS, register_ode_dynamics),
     "this build has no ODE in double precision (Debian: libode-dev)"},
    {"mujoco", TOUCHSTONE_IF_BUILT(TOUCHSTONE_BUILT_MUJOCO_DYNAMICS, register_mujoco_dynamics),
     "this build has no MuJoCo (Debian: libmujoco-dev)"},
};

}  // namespace

void register_all_engines(EngineRegistry& registry, const BackendRegistry& backends) {
  register_own_engine(registry, backends);
  for (const EngineSource& source : kSources) {
    if (source.register_in != nullptr)
      source.register_in(registry, backends);
    else
      registry.add_missing({source.engine, source.missing});
  }
}

}  // namespace touchstone::physics

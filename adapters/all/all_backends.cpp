#include "touchstone/adapters/all/all_backends.hpp"

#include <algorithm>
#include <iterator>

#include "touchstone/adapters/all/if_built.hpp"
#include "touchstone/adapters/bullet/bullet.hpp"
#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/adapters/fcl/fcl.hpp"
#include "touchstone/adapters/libccd/libccd.hpp"
#include "touchstone/adapters/mujoco/mujoco.hpp"
#include "touchstone/adapters/ode/ode.hpp"

namespace touchstone {
namespace {

constexpr BackendSource kSources[] = {
    {"bullet, bullet_gjk", TOUCHSTONE_IF_BUILT(TOUCHSTONE_BUILT_BULLET, register_bullet),
     "no double-precision Bullet was found"},
    {"ode", TOUCHSTONE_IF_BUILT(TOUCHSTONE_BUILT_ODE, register_ode), "ODE was not found"},
    {"libccd_gjk, libccd_mpr", TOUCHSTONE_IF_BUILT(TOUCHSTONE_BUILT_LIBCCD, register_libccd),
     "libccd was not found"},
    {"fcl, fcl_indep", TOUCHSTONE_IF_BUILT(TOUCHSTONE_BUILT_FCL, register_fcl), "FCL was not found"},
    {"mujoco", TOUCHSTONE_IF_BUILT(TOUCHSTONE_BUILT_MUJOCO, register_mujoco), "MuJoCo was not found"},
    {"exact", TOUCHSTONE_IF_BUILT(TOUCHSTONE_BUILT_EXACT, register_exact),
     "errors cannot be measured without it"},
};

constexpr std::vector<SweepEntry> (*kSweepSources[])() = {
    TOUCHSTONE_IF_BUILT(TOUCHSTONE_BUILT_BULLET, bullet_sweeps),
    TOUCHSTONE_IF_BUILT(TOUCHSTONE_BUILT_FCL, fcl_sweeps),
};

}  // namespace

std::span<const BackendSource> backend_sources() { return kSources; }

void register_all_backends(BackendRegistry& registry) {
  register_core(registry);
  for (const BackendSource& source : kSources)
    if (source.register_in != nullptr) source.register_in(registry);
}

std::vector<SweepEntry> all_sweeps() {
  std::vector<SweepEntry> sweeps;
  for (const auto source : kSweepSources) {
    if (source == nullptr) continue;
    std::vector<SweepEntry> more = source();
    std::move(more.begin(), more.end(), std::back_inserter(sweeps));
  }
  return sweeps;
}

std::vector<std::string> all_backend_names() {
  BackendRegistry registry;
  register_all_backends(registry);
  std::vector<std::string> names;
  for (const BackendRegistry::NarrowphaseEntry& entry : registry.narrowphases()) names.push_back(entry.name);
  return names;
}

bool has_backend(std::string_view narrowphase) {
  const std::vector<std::string> names = all_backend_names();
  return std::find(names.begin(), names.end(), narrowphase) != names.end();
}

}  // namespace touchstone

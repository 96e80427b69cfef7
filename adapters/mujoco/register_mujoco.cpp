#include <mujoco/mujoco.h>

#include <string>

#include "touchstone/adapters/mujoco/engine.hpp"
#include "touchstone/adapters/mujoco/mujoco.hpp"
#include "touchstone/adapters/mujoco/mujoco_narrowphase.hpp"

namespace touchstone {

void register_mujoco(BackendRegistry& registry) {
  mujoco::require_version();
  mujoco::own_collision_functions();
  registry.add(BackendRegistry::NarrowphaseEntry{
      "mujoco",
      std::string("MuJoCo ") + mj_versionString() + ", double precision: its own box check, MPR for meshes",
      &mujoco::make_narrowphase, &mujoco::make_raw_check});
}

}  // namespace touchstone

#include "touchstone/adapters/mujoco_dynamics/mujoco_dynamics.hpp"

#include <mujoco/mujoco.h>

#include "touchstone/adapters/mujoco_dynamics/mujoco_world.hpp"

namespace touchstone {

void register_mujoco_dynamics(physics::EngineRegistry& registry, const BackendRegistry& backends) {
  physics::EngineRegistry::Entry entry;
  entry.name = "mujoco";
  entry.description = std::string("MuJoCo ") + mj_versionString() + ", soft contacts, Newton's method";
  physics::set_checks(entry, backends);
  entry.features = [](std::string_view) {
    using enum physics::EngineFeature;
    return physics::EngineFeatures{hulls,  arms,       joint_stops, torque_drives,
                                   brakes, set_joints, come_and_go, body_joints};
  };
  entry.after_restore = physics::EngineReturn::same_bits;
  entry.make = [&backends](const physics::DynamicScene& scene, const std::string& check) {
    return physics::mujoco_dynamics::make_world(
        scene, {check != physics::kOwnCheck, physics::make_check(backends, check, scene)});
  };
  registry.add(std::move(entry));
}

}  // namespace touchstone

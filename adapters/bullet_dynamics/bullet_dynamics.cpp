#include "touchstone/adapters/bullet_dynamics/bullet_dynamics.hpp"

#include <LinearMath/btScalar.h>

#include "touchstone/adapters/bullet_dynamics/bullet_world.hpp"

namespace touchstone {

void register_bullet_dynamics(physics::EngineRegistry& registry, const BackendRegistry& backends) {
  const int version = btGetVersion();
  physics::EngineRegistry::Entry entry;
  entry.name = "bullet";
  entry.description =
      "Bullet " + std::to_string(version / 100) + "." + std::to_string(version % 100) + ", double precision";
  physics::set_checks(entry, backends);
  entry.features = [](std::string_view) {
    using enum physics::EngineFeature;
    return physics::EngineFeatures::usual().with(set_joints).with(body_joints).with(come_and_go);
  };
  entry.after_restore = physics::EngineReturn::repeatable;
  entry.make = [&backends](const physics::DynamicScene& scene, const std::string& check) {
    return physics::bullet_dynamics::make_world(
        scene, {check != physics::kOwnCheck, physics::make_check(backends, check, scene)});
  };
  registry.add(std::move(entry));
}

}  // namespace touchstone

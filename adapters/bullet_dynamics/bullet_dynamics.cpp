#include "touchstone/adapters/bullet_dynamics/bullet_dynamics.hpp"

#include <LinearMath/btScalar.h>

#include "touchstone/adapters/bullet_dynamics/bullet_world.hpp"

namespace touchstone {

void register_bullet_dynamics(physics::EngineRegistry& registry) {
  const int version = btGetVersion();
  physics::EngineRegistry::Entry entry;
  entry.name = "bullet";
  entry.description =
      "Bullet " + std::to_string(version / 100) + "." + std::to_string(version % 100) + ", double precision";
  entry.checks = {std::string(physics::kOwnCheck), "native"};
  entry.features = [](std::string_view) {
    using enum physics::EngineFeature;
    return physics::EngineFeatures::usual().with(set_joints).with(body_joints);
  };
  entry.make = [](const physics::DynamicScene& scene, const std::string& check) {
    return physics::bullet_dynamics::make_world(scene, check == "native");
  };
  registry.add(std::move(entry));
}

}  // namespace touchstone

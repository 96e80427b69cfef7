#include "touchstone/adapters/ode_dynamics/ode_dynamics.hpp"

#include <ode/ode.h>

#include "touchstone/adapters/ode_dynamics/ode_world.hpp"

namespace touchstone {
namespace {

void add(physics::EngineRegistry& registry, const BackendRegistry& backends, const std::string& name,
         const std::string& description, bool is_direct) {
  physics::EngineRegistry::Entry entry;
  entry.name = name;
  entry.description = "ODE, double precision, " + description;
  physics::set_checks(entry, backends);
  entry.features = [is_direct](std::string_view check) {
    physics::EngineFeatures features = physics::EngineFeatures::usual();
    if (check == physics::kOwnCheck) features = features.without(physics::EngineFeature::hulls);
    using enum physics::EngineFeature;
    features = features.with(come_and_go);
    if (is_direct) return features.with(body_joints);
    // Sweeps do not converge on joints between unequal masses: an arm with 116 t makes 1e9 J in 10 s.
    for (const physics::EngineFeature each : {arms, joint_stops, torque_drives, rate_drives, brakes, latches})
      features = features.without(each);
    return features;
  };
  entry.after_restore = physics::EngineReturn::same_bits;
  entry.make = [&backends, is_direct](const physics::DynamicScene& scene, const std::string& check) {
    return physics::ode_dynamics::make_world(
        scene, {check != physics::kOwnCheck, is_direct, physics::make_check(backends, check, scene)});
  };
  registry.add(std::move(entry));
}

}  // namespace

void register_ode_dynamics(physics::EngineRegistry& registry, const BackendRegistry& backends) {
  add(registry, backends, "ode", "dWorldQuickStep", false);
  add(registry, backends, "ode_direct", "dWorldStep", true);
}

}  // namespace touchstone

#pragma once

#include <memory>

#include "touchstone/physics/engine/dynamics_engine.hpp"

namespace touchstone::bullet_dynamics {

/// @param by_native our check inside, else Bullet's own. @throws InputError: friction beyond Bullet's most.
std::unique_ptr<physics::DynamicsEngine> make_world(const physics::DynamicScene& scene, bool by_native);

}  // namespace touchstone::bullet_dynamics

#pragma once

#include <memory>

#include "touchstone/physics/engine/dynamics_engine.hpp"

namespace touchstone::physics::bullet_dynamics {

/// @param by_native our check inside, else Bullet's own. @throws InputError: friction beyond Bullet's most.
std::unique_ptr<DynamicsEngine> make_world(const DynamicScene& scene, bool by_native);

}  // namespace touchstone::physics::bullet_dynamics

#pragma once

#include <memory>

#include "touchstone/physics/engine/dynamics_engine.hpp"

namespace touchstone::physics::mujoco_dynamics {

/// @param by_native our check inside, else MuJoCo's own. @throws InputError: what MuJoCo's compiler refuses,
/// brakes without a limit.
std::unique_ptr<DynamicsEngine> make_world(const DynamicScene& scene, bool by_native);

}  // namespace touchstone::physics::mujoco_dynamics

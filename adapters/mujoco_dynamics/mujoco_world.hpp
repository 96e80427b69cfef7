#pragma once

#include <memory>

#include "touchstone/contact_core/native/check_inside.hpp"
#include "touchstone/physics/engine/dynamics_engine.hpp"

namespace touchstone::physics::mujoco_dynamics {

/// Whose check stands inside.
struct WorldCheck {
  bool is_ours = false;                           ///< else MuJoCo's own
  std::shared_ptr<CheckInside> inside = nullptr;  ///< of ours; null: native
};

/// @throws InputError: what MuJoCo's compiler refuses, brakes without a limit.
std::unique_ptr<DynamicsEngine> make_world(const DynamicScene& scene, const WorldCheck& check);

}  // namespace touchstone::physics::mujoco_dynamics

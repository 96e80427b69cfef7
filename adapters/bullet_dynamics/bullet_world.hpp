#pragma once

#include <memory>

#include "touchstone/contact_core/native/check_inside.hpp"
#include "touchstone/physics/engine/dynamics_engine.hpp"

namespace touchstone::physics::bullet_dynamics {

/// Whose check stands inside.
struct WorldCheck {
  bool is_ours = false;                           ///< else Bullet's own
  std::shared_ptr<CheckInside> inside = nullptr;  ///< of ours; null: native
};

/// @throws InputError: friction beyond Bullet's most, and what else Bullet lacks.
std::unique_ptr<DynamicsEngine> make_world(const DynamicScene& scene, const WorldCheck& check);

}  // namespace touchstone::physics::bullet_dynamics

#pragma once

#include <memory>

#include "touchstone/contact_core/native/check_inside.hpp"
#include "touchstone/physics/engine/dynamics_engine.hpp"

namespace touchstone::physics::ode_dynamics {

struct WorldOptions {
  bool is_ours = false;                           ///< a check of ours, else ODE's own
  bool is_direct = false;                         ///< dWorldStep(), else dWorldQuickStep()
  std::shared_ptr<CheckInside> inside = nullptr;  ///< of ours; null: native
};

/// @throws InputError: stops that ODE cannot hold.
std::unique_ptr<DynamicsEngine> make_world(const DynamicScene& scene, const WorldOptions& options);

}  // namespace touchstone::physics::ode_dynamics

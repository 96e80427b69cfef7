#pragma once

#include <memory>

#include "touchstone/physics/engine/dynamics_engine.hpp"

namespace touchstone::physics::ode_dynamics {

struct WorldOptions {
  bool by_native = false;  ///< our check, else ODE's own
  bool is_direct = false;  ///< dWorldStep(), else dWorldQuickStep()
};

/// @throws InputError: stops that ODE cannot hold.
std::unique_ptr<DynamicsEngine> make_world(const DynamicScene& scene, const WorldOptions& options);

}  // namespace touchstone::physics::ode_dynamics

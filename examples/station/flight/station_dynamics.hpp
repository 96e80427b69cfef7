#pragma once

#include <memory>
#include <span>

#include "touchstone/examples/training_run/setting/setting.hpp"
#include "touchstone/physics/guarded/guarded_simulation.hpp"

namespace touchstone::station {

struct LatchOption;

/// A station's scene as GuardedSimulation takes it: objects and their order are the setting's, the flown arm
/// is its one mechanism, and what may be latched are its latch options, in their order.
struct StationDynamics {
  physics::DynamicScene scene;
  physics::GuardSettings settings;
  std::size_t steps = 1;  ///< of dynamics, a frame
};

/// The `dynamics` and the `guard` in it of the script's scene file (adapters/scene_files/README.md), the arm
/// from the script. A frame has as many steps as come nearest to the file's.
/// @return null: the file has no guard. @throws InputError as load_guarded_scene(); arms, mechanisms, joints
/// or actions of the file's own, which the station does not fly; no arm to fly.
std::shared_ptr<const StationDynamics> load_station_dynamics(const training::Setting& setting,
                                                             std::span<const LatchOption> latches);

}  // namespace touchstone::station

#pragma once

#include <memory>
#include <span>
#include <vector>

#include "touchstone/examples/training_run/setting/setting.hpp"
#include "touchstone/physics/guarded/guarded_simulation.hpp"

namespace touchstone::station {

struct LatchOption;

/// A station's scene as GuardedSimulation takes it: objects and their order are the setting's, the flown arm
/// is its one mechanism, and what may be latched are its latch options, in their order. An arm that walks has
/// a joint between bodies, the scene's only one, that may hold its free end where that is.
struct StationDynamics {
  physics::DynamicScene scene;
  physics::DynamicScene things;  ///< the scene without the arm
  physics::GuardSettings settings;
  std::size_t steps = 1;            ///< of dynamics, a frame
  std::vector<std::uint32_t> ends;  ///< objects: of an arm that walks
};

/// The `dynamics` and the `guard` in it of the script's scene file (adapters/scene_files/README.md), the arm
/// from the script. A frame has as many steps as come nearest to the file's.
/// @param ends of an arm that walks: its objects; else none.
/// @return null: the file has no guard. @throws InputError as load_guarded_scene(); arms, mechanisms, joints
/// or actions of the file's own, which the station does not fly; no arm to fly.
std::shared_ptr<const StationDynamics> load_station_dynamics(const training::Setting& setting,
                                                             std::span<const LatchOption> latches,
                                                             std::vector<std::uint32_t> ends = {});

/// The scene from where `now` is on, its arm held as `arm` is: poses, velocities and latches are as there;
/// the arm's free end is held by nothing. @throws InputError as validate().
physics::DynamicScene go_on_from(const physics::GuardedSimulation& now, const StationDynamics& dynamics,
                                 const training::Setting& setting, const training::Arm& arm);

}  // namespace touchstone::station

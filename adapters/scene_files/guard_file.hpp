#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "touchstone/adapters/scene_files/dynamics_file.hpp"
#include "touchstone/contact_core/motion/mass_metric.hpp"
#include "touchstone/physics/guarded/guarded_simulation.hpp"

/// @file
/// The hands and the guard of a scene file's dynamics: GuardedSimulation runs them.

namespace touchstone {

/// A hand's command from a time on, until its next row.
struct GuardedRates {
  double time = 0.0;    ///< [s]
  Twist wanted_W = {};  ///< of the hand's point [m/s, rad/s]
};

/// A hand on a link of an arm.
struct SceneHand {
  std::string name;  ///< of the link's object
  physics::GuardedHand hand;
  std::vector<GuardedRates> rates;  ///< by time; before the first all are 0
};

/// A scene with dynamics, how it is guarded, and who leads it.
struct GuardedScene {
  physics::DynamicScene scene;
  physics::GuardSettings settings;
  std::vector<SceneHand> hands;
};

/// Reads a scene file with its `dynamics` and the `guard` in it (adapters/scene_files/README.md).
/// @throws InputError as load_dynamic_scene(); further: no guard, unknown policies, names and keys, rows out
/// of order.
/// @param arm_models empty: bundled arms only.
GuardedScene load_guarded_scene(const std::filesystem::path& path, const SceneParameters& parameters = {},
                                const ArmModels& arm_models = {});
/// Whether the file has a `guard`. @throws InputError: it is no YAML.
bool has_guard(const std::filesystem::path& path);

}  // namespace touchstone

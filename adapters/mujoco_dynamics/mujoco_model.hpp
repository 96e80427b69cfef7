#pragma once

#include <string>

#include "touchstone/physics/engine/engine_scene.hpp"

namespace touchstone::physics::mujoco_dynamics {

/// A scene as MJCF: body b of the scene is "b<b>", solid s is geom "s<s>", joint j is "j<j>", free joints are
/// "f<b>", equality constraints of joints between bodies are connect_name()s.
/// @throws InputError: more bodies than MuJoCo's tables hold, joints as shared_points().
std::string model_text(const EngineScene& scene);

}  // namespace touchstone::physics::mujoco_dynamics

#pragma once

#include <mujoco/mujoco.h>

#include <optional>

#include "touchstone/contact_core/native/engine/solid_store.hpp"

// MuJoCo's geoms in our terms.

namespace touchstone::mujoco_plugin {

/// One for the process.
const native::SolidStore& solid_store();

/// The geom's solid, remembered by this thread. Empty for what is no hexahedron.
std::optional<native::SolidHandle> solid_of(const mjModel& model, int geom);

/// X_WG, as kinematics have left it.
Pose pose_of(const mjData& data, int geom);

}  // namespace touchstone::mujoco_plugin

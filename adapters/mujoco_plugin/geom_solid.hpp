#pragma once

#include <mujoco/mujoco.h>

#include <memory>

#include "touchstone/contact_core/native/engine/solid_store.hpp"

// MuJoCo's geoms in our terms.

namespace touchstone::mujoco_plugin {

/// Native's, one for the process.
const std::shared_ptr<native::SolidStore>& solid_store();

/// The geom's solid in the store, remembered by this thread. Null for what is no hexahedron, or refused.
const native::SolidHandle* solid_of(const std::shared_ptr<native::SolidStore>& store, const mjModel& model,
                                    int geom);

/// X_WG, as kinematics have left it.
Pose pose_of(const mjData& data, int geom);

}  // namespace touchstone::mujoco_plugin

#pragma once

#include <mujoco/mujoco.h>

#include <optional>

#include "touchstone/contact_core/geometry/finite.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"

// Poses of geoms, ours and MuJoCo's.

namespace touchstone::mujoco {

/// X_SG: a box geom has its solid's frame; a mesh's is the one about its centre of mass and along its
/// principal axes, to which the compiler has moved the vertices. Empty where that is not finite.
inline std::optional<Pose> pose_in_solid(const mjModel& model, int geom) {
  Pose X_SG;
  if (model.geom_type[geom] != mjGEOM_MESH) return X_SG;
  const mjtNum* const p = model.geom_pos + 3 * static_cast<std::ptrdiff_t>(geom);
  const mjtNum* const q = model.geom_quat + 4 * static_cast<std::ptrdiff_t>(geom);
  X_SG.p = {p[0], p[1], p[2]};
  if (!is_finite(X_SG.p) || !all_finite({q, 4})) return std::nullopt;
  X_SG.R = rotation_from_quaternion(q[0], q[1], q[2], q[3]);
  return X_SG;
}

/// In place of kinematics.
inline void place(mjData& data, int geom, const Pose& X_WG) {
  mjtNum* const p = data.geom_xpos + 3 * static_cast<std::ptrdiff_t>(geom);
  mjtNum* const R = data.geom_xmat + 9 * static_cast<std::ptrdiff_t>(geom);
  for (int i = 0; i < 3; ++i) {
    p[i] = X_WG.p[i];
    for (int k = 0; k < 3; ++k) R[3 * i + k] = X_WG.R(i, k);
  }
}

}  // namespace touchstone::mujoco

#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <string>

#include "touchstone/contact_core/input_error.hpp"

// Shared by the backend and the plugin.

namespace touchstone::mujoco {

/// @throws InputError when the library loaded is not of the version that this was compiled for: its structs
/// differ.
inline void require_version() {
  if (mj_version() != mjVERSION_HEADER)
    throw InputError("MuJoCo: compiled for version " + std::to_string(mjVERSION_HEADER) + ", loaded is " +
                     std::to_string(mj_version()));
}

/// By how many of a pair are meshes: box-box, box-mesh, mesh-mesh. In MuJoCo's table the lesser type comes
/// first.
using CollisionFunctions = std::array<mjfCollision, 3>;
static_assert(mjGEOM_BOX < mjGEOM_MESH);

inline CollisionFunctions collision_functions() {
  return {mjCOLLISIONFUNC[mjGEOM_BOX][mjGEOM_BOX], mjCOLLISIONFUNC[mjGEOM_BOX][mjGEOM_MESH],
          mjCOLLISIONFUNC[mjGEOM_MESH][mjGEOM_MESH]};
}

/// Returns the process's collision table as it was when this was first called. Both sides call it before
/// either changes the table: what the plugin puts there is never among them.
inline const CollisionFunctions& own_collision_functions() {
  static const CollisionFunctions first_seen = collision_functions();
  return first_seen;
}

}  // namespace touchstone::mujoco

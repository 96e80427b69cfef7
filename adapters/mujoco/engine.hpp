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

template <class Function>
struct ContactOf;
template <class Data, class Contact>
struct ContactOf<int (*)(const mjModel*, Data*, Contact*, int, int, mjtNum)> {
  using type = Contact;
};
/// A collision function's output type, by the installed header: mjContact, or mjPreContact in later versions.
using EngineContact = ContactOf<mjfCollision>::type;

/// The normal, whose place has two names.
template <class Contact>
auto& normal_of(Contact& contact) {
  if constexpr (requires { contact.normal; })
    return contact.normal;
  else
    return contact.frame;
}

/// How many contacts a collision function may write: each pair has as many places as the engine's own check
/// fills at most, where there is mj_maxContact; before, mjMAXCONPAIR.
template <class Model>
int places_for_contacts(const Model* model, int geom1, int geom2, double margin) {
  if constexpr (requires { mj_maxContact(model, geom1, geom2, 1); })
    return mj_maxContact(model, geom1, geom2, margin > 0.0);
  else
    return mjMAXCONPAIR;
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

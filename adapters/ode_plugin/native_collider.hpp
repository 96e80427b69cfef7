#pragma once

#include <ode/ode.h>

#include <cstddef>
#include <memory>

#include "touchstone/contact_core/narrowphase/pair_observer.hpp"
#include "touchstone/contact_core/native/engine/solid_memory.hpp"
#include "touchstone/contact_core/native/engine/solid_store.hpp"

// Shared by the box override and the hexahedron geom.

namespace touchstone::ode_plugin {

/// One for the process; its users keep it alive.
std::shared_ptr<native::SolidStore> solid_store();

/// Contacts of two solids in their geoms' poses, as dCollide wants them.
/// @param flags, contacts, skip dCollide's
int collide_solids(dGeomID geom1, const native::SolidHandle& solid1, dGeomID geom2,
                   const native::SolidHandle& solid2, const native::SolidStore& store, int flags,
                   dContactGeom* contacts, int skip);

/// The solids that this thread remembers.
native::SolidMemory& thread_memory();

/// The box's solid, remembered by this thread. Null for a box of zero volume.
const native::SolidHandle* solid_of_box(dGeomID box, native::SolidMemory& memory);
const native::SolidHandle* solid_of_box(dGeomID box);

/// The i-th contact of an array with `skip` bytes from one to the next.
inline dContactGeom& contact_at(dContactGeom* contacts, int skip, int i) {
  return *reinterpret_cast<dContactGeom*>(reinterpret_cast<char*>(contacts) +
                                          static_cast<std::ptrdiff_t>(skip) * i);
}

inline int most_contacts(int flags) { return flags & 0xffff; }

Pose pose_of(dGeomID geom);

/// ODE's own answer for two boxes: what its collider makes of dBoxBox.
/// @param code dBoxBox's: which features met
int collide_boxes_as_ode(dGeomID box1, dGeomID box2, int flags, dContactGeom* contacts, int skip, int& code);

/// The observer of all pairs; may be null.
PairObserver* observer();
void set_observer(PairObserver* observer);

/// Tells of contacts that ODE's own check, or a program's, has found.
/// @param code dBoxBox's, 0 where it is not known: each contact's `pos` is then taken to be half-way between
/// the surfaces
void observe_contacts(dGeomID box1, dGeomID box2, dContactGeom* contacts, int skip, int count, int code,
                      PairObserver& observer);

void count_check();
/// Counts a pair without an answer. Returns its number of contacts, none.
int refuse();

}  // namespace touchstone::ode_plugin

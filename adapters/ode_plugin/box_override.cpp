#include <mutex>
#include <optional>

#include "touchstone/adapters/ode/ode_library.hpp"
#include "touchstone/adapters/ode_plugin/native_collider.hpp"
#include "touchstone/adapters/ode_plugin/ode_plugin.hpp"

namespace touchstone {
namespace {

using namespace ode_plugin;

/// ODE's own answer as its table gives it without an override, for an entry of an override: that one is asked
/// in reversed order and turned round, so this reverses and turns round first, and the bits are the same.
int collide_reversed_as_ode(dGeomID box2, dGeomID box1, int flags, dContactGeom* contacts, int skip) {
  int code;
  const int count = collide_boxes_as_ode(box1, box2, flags, contacts, skip, code);
  if (PairObserver* const who = observer()) observe_contacts(box1, box2, contacts, skip, count, code, *who);
  for (int i = 0; i < count; ++i) {
    dContactGeom& contact = contact_at(contacts, skip, i);
    for (int k = 0; k < 3; ++k) contact.normal[k] = -contact.normal[k];
    contact.g1 = box2, contact.g2 = box1;
  }
  return count;
}

int collide_boxes(dGeomID box1, dGeomID box2, int flags, dContactGeom* contacts, int skip) {
  native::SolidMemory& memory = thread_memory();
  const native::SolidHandle* const solid1 = solid_of_box(box1, memory);
  const native::SolidHandle* const solid2 = solid1 ? solid_of_box(box2, memory) : nullptr;
  if (!solid1 || !solid2) return collide_reversed_as_ode(box1, box2, flags, contacts, skip);
  static const std::shared_ptr<native::SolidStore> store = solid_store();
  return collide_solids(box1, *solid1, box2, *solid2, *store, flags, contacts, skip);
}

/// State that all live overrides share.
struct Overrides {
  std::mutex mutex;
  int count = 0;
  dColliderFn* before = nullptr;
  std::optional<ode::LibraryUse> library;
};

Overrides& overrides() {
  static Overrides shared;
  return shared;
}

/// The collider that a program named, observed.
int collide_as_before(dGeomID box1, dGeomID box2, int flags, dContactGeom* contacts, int skip) {
  const int count = overrides().before(box1, box2, flags, contacts, skip);
  if (PairObserver* const who = observer()) observe_contacts(box1, box2, contacts, skip, count, 0, *who);
  return count;
}

}  // namespace

OdeBoxOverride::OdeBoxOverride(const Options& options) {
  Overrides& shared = overrides();
  const std::scoped_lock lock(shared.mutex);
  if (shared.count++ > 0) return;
  shared.library.emplace();
  dAllocateODEDataForThread(dAllocateMaskAll);
  shared.before = options.previous != nullptr ? options.previous : &collide_reversed_as_ode;
  set_observer(options.observer);
  dColliderFn* collider = &collide_boxes;
  if (options.check == EngineCheck::own)
    collider = options.previous != nullptr ? &collide_as_before : &collide_reversed_as_ode;
  dSetColliderOverride(dBoxClass, dBoxClass, collider);
}

OdeBoxOverride::~OdeBoxOverride() {
  Overrides& shared = overrides();
  const std::scoped_lock lock(shared.mutex);
  if (--shared.count > 0) return;
  set_observer(nullptr);
  dSetColliderOverride(dBoxClass, dBoxClass, shared.before);
  shared.library.reset();
}

}  // namespace touchstone

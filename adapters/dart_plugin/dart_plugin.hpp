#pragma once

#include <cstdint>
#include <memory>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/narrowphase/pair_observer.hpp"

/// @file
/// Our check inside DART 6, in place of its own for boxes and hexahedral meshes, each against each. DART's
/// headers are not needed here.
///
///     world->setCollisionDetector(touchstone::make_dart_detector());  // a dart::simulation::World
///
/// The detector is DART's default one, over FCL, which finds the pairs (its tree of bounding boxes) and
/// checks those that are not ours; distance() and raycast() are its own. Shapes that our check handles:
/// BoxShape, and MeshShape whose mesh has eight vertices that differ and are those of a convex hexahedron,
/// which is then solid (to FCL a mesh is a surface).
///
/// Conventions. DART's: `normal` points from object 2 to object 1, `penetrationDepth` is at least 0, `point`
/// is half-way between the two surfaces. Touching is contact, of depth 0, where the bounding boxes meet.
/// Options hold as they do for DART: the filter is asked about every pair of bounding boxes, at most
/// maxNumContacts are added to the result, contacts of FCL's pairs first, and without a result or with
/// enableContact false the first contact ends the check. A pose that is not finite has none.
///
/// Memory: nothing is allocated for shapes that a thread has seen (it remembers the last 1024) but what DART
/// and FCL allocate, and the list of pairs as it grows. Threads: as DART's own, one at a time per detector.
/// It is registered in DART's factory as "touchstone" by register_dart_detector().

namespace dart::collision {
class CollisionDetector;
}  // namespace dart::collision

namespace touchstone {

/// Limits and observer of our check in DART.
struct DartOptions {
  int most_contacts = kMaxManifoldPoints;  ///< a pair, 1 to 8
  /// Called with every pair that our check answered (not with failed ones, nor after the contact that was
  /// enough); must outlive the detector. May be null.
  PairObserver* observer = nullptr;
};

/// @throws InputError for most_contacts out of range.
std::shared_ptr<dart::collision::CollisionDetector> make_dart_detector(const DartOptions& options = {});

/// Adds "touchstone" to dart::collision::CollisionDetector::getFactory(), for programs that choose by name.
/// Again: nothing.
void register_dart_detector();

/// Pairs that our check has answered in this process so far.
std::uint64_t dart_native_checks();

}  // namespace touchstone

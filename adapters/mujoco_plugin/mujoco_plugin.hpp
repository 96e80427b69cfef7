#pragma once

#include <cstdint>
#include <memory>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/narrowphase/pair_observer.hpp"
#include "touchstone/contact_core/native/check_inside.hpp"

/// @file
/// Our check inside MuJoCo, in place of its own for boxes and hexahedral meshes, each against each. MuJoCo's
/// headers are not needed here.
///
///     const touchstone::MujocoOverride native;  // every model and mj_step of the process, until it goes
///
/// Geoms that our check handles: box geoms, and mesh geoms whose hull has 8 vertices that are a convex
/// hexahedron, in any order. MuJoCo stores vertices as floats, about the mesh's inertial frame: the solid is
/// the hull of what it stores, faces bent by that rounding included. Geoms of any other kind, other meshes,
/// and boxes of zero volume go to what MuJoCo's table held before.
///
/// Conventions. MuJoCo's: the normal is the first axis of the contact's frame and points from geom 1 to
/// geom 2, `dist` is below 0 where they penetrate, `pos` is half-way between the two surfaces; the other axes
/// are left for the engine to make. Contacts are the points at most the pair's margin apart (the margin that
/// mj_collision hands over), the deepest among them; touching is contact, of distance 0, which MuJoCo lists
/// and at margin 0 does not act on. At most 8 a pair (MuJoCo takes mjMAXCONPAIR, 50): the deepest, and of the
/// others those with the largest area. A pose that is not finite has none.
///
/// Memory: nothing is allocated for shapes that a thread has seen (it remembers the last 1024), nor by this
/// from MuJoCo's stack. Threads: several may step, each with its own mjData; none while an override comes or
/// goes.

namespace touchstone {

/// While one of these lives, our check stands in mjCOLLISIONFUNC for box-box, box-mesh and mesh-mesh, in the
/// whole process; then the three entries are what they were. Of several that live at once the first decides;
/// one with another check inside than it has is refused.
/// The backend `mujoco` (adapters/mujoco) asks MuJoCo's own all the same.
class MujocoOverride {
 public:
  /// Whose check decides, how many contacts it may give, and the observer.
  struct Options {
    EngineCheck check = EngineCheck::native;  ///< own: what was there decides, and is observed
    int most_contacts = kMaxManifoldPoints;   ///< a pair, 1 to 8
    /// Called with every pair that is ours to check; must outlive this. May be null.
    PairObserver* observer = nullptr;
    /// With EngineCheck::native: whose answers stand inside instead of native's. Null: native's. Geoms that
    /// it refuses go to what MuJoCo's table held before, as those that are no hexahedra do. Each thread
    /// remembers the solids of the one that it met last.
    std::shared_ptr<CheckInside> inside = nullptr;
  };

  /// @throws InputError when the library loaded is not of the version that this was compiled for (its structs
  /// differ), for most_contacts out of range, or where one with another check inside lives.
  MujocoOverride() : MujocoOverride(Options{}) {}
  explicit MujocoOverride(const Options& options);
  ~MujocoOverride();
  MujocoOverride(const MujocoOverride&) = delete;
  MujocoOverride& operator=(const MujocoOverride&) = delete;
};

/// Pairs that our check has answered, or an observer was called with, in this process so far.
std::uint64_t mujoco_native_checks();

}  // namespace touchstone

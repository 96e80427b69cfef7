#pragma once

#include <cstdint>
#include <memory>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/narrowphase/pair_observer.hpp"
#include "touchstone/contact_core/native/check_inside.hpp"

/// @file
/// Our check inside the Open Dynamics Engine (double precision), in place of its own for boxes, and a geom
/// for any convex hexahedron. ODE's headers are not needed here.
///
///     const touchstone::OdeBoxOverride native;                       // boxes, until it goes
///     dGeomID geom = touchstone::create_ode_hexahedron(space, solid);  // any hexahedron
///
/// Conventions. ODE's: the normal points into geom 1, depths are positive. `pos` is half-way between the two
/// surfaces, so that it is the same in whichever order ODE asks. Only points that penetrate or touch are
/// contacts; touching is contact, with depth 0. dCollide's flags are honoured: at most as many contacts as
/// asked for and at most 8, the deepest first among those kept, of the others those with the largest area;
/// with CONTACTS_UNIMPORTANT any of them. `skip` is the stride from one contact to the next.
///
/// ODE asks for a pair of one class in reversed order (by its table, for every override) and reverses the
/// answer; the answer is the same in both orders.
///
/// Two boxes of which one has a side of 0 go to ODE's dBoxBox. Nothing answers for such a box against a
/// hexahedron geom, for a geom of its class that was made without a solid (dCreateGeom), for a hexahedron
/// that is no box against a mesh or a height field, or for a pose that is not finite: these pairs have no
/// contacts, and ode_native_refusals() counts them.
///
/// Memory: nothing is allocated for boxes whose sizes a thread has seen (it remembers the last 1024),
/// nor for hexahedra. Threads: as ODE itself.

struct dxGeom;
struct dxSpace;
struct dContactGeom;

namespace touchstone {

/// Ours for pairs of boxes in the whole process, while one of these lives; then what was there. ODE does not
/// reveal what that is: a program that has overridden box against box itself names its collider here.
class OdeBoxOverride {
 public:
  /// ODE's dColliderFn.
  using Collider = int(dxGeom*, dxGeom*, int, dContactGeom*, int);

  /// All of it counts in the first of several that live at once.
  struct Options {
    Collider* previous = nullptr;             ///< null: ODE's own
    EngineCheck check = EngineCheck::native;  ///< own: `previous` decides, and is observed
    /// Receives every pair of boxes, and of hexahedra and boxes; must outlive this. Null: nobody.
    PairObserver* observer = nullptr;
  };

  /// Initialises ODE where that is not done, and keeps it so; allocates ODE's data for this thread.
  OdeBoxOverride() : OdeBoxOverride(Options{}) {}
  explicit OdeBoxOverride(const Options& options);
  ~OdeBoxOverride();
  OdeBoxOverride(const OdeBoxOverride&) = delete;
  OdeBoxOverride& operator=(const OdeBoxOverride&) = delete;
};

/// Pairs that our colliders were asked for, in this process so far.
std::uint64_t ode_native_checks();

/// Pairs that they had no answer to, so that there were no contacts, in this process so far.
std::uint64_t ode_native_refusals();

/// A geom for a hexahedron: placeable, as any other, to be destroyed by dGeomDestroy (or its space).
///
/// It meets boxes, planes and others of its kind by our check. With the rest of ODE's classes a box is as a
/// dBox is, by ODE's own checks. Of other hexahedra:
/// - spheres, capsules and rays: closed forms of ours, right to rounding (bent faces as the planes through
///   them). A capsule that lies on a face has a contact at each end; a ray's depth is the distance along it
///   to the first hit, from within to the exit.
/// - cylinders and convexes (dConvex): ODE's check of a dConvex, by libccd. Its depths are ODE's: 0.044 m for
///   a cylinder that is 0.03 m in a face.
/// - trimeshes and height fields: refused, no contacts, counted by ode_native_refusals(). (ODE's check of
///   convexes ends the process where a mesh has no face angles.)
/// Geoms of other user classes meet it only where they bring a collider for it.
/// @param space may be null
/// @param inside whose answers decide about it and others of its kind with the same one; null: native's. Two
/// geoms with different ones, and one with another than native's and a dBox, are refused and counted. Planes
/// and the rest meet it as before.
/// @throws InputError for a solid of zero volume, or that `inside` refuses
dxGeom* create_ode_hexahedron(dxSpace* space, const Hexahedron& solid,
                              const std::shared_ptr<CheckInside>& inside = nullptr);

/// Its class, for dGeomGetClass. One of ODE's four user classes is taken on the first call of either function
/// and kept; ODE stays initialised from then on.
int ode_hexahedron_class();

}  // namespace touchstone

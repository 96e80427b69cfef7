#pragma once

#include <cstdint>
#include <memory>

#include "touchstone/contact_core/narrowphase/pair_observer.hpp"
#include "touchstone/contact_core/native/check_inside.hpp"

/// @file
/// Our check inside Bullet, in place of the engine's own, for boxes and hexahedral hulls. Bullet's headers
/// are not needed here. The library `touchstone::bullet_plugin` is for Bullet in double precision (compile
/// with BT_USE_DOUBLE_PRECISION, as pkg-config's bullet-float64 does), `touchstone::bullet_plugin_single` for
/// the stock build; the wrong one does not link.
///
///     btCollisionDispatcher dispatcher(&configuration);
///     touchstone::BulletPlugin native(dispatcher);        // that is all
///
/// Shapes that our check handles: btBoxShape, and btConvexHullShape of 8 points that are a convex hexahedron
/// (in any order; collapsed and warped ones in the order of Hexahedron), each against each. Other pairs,
/// hulls of other points among them, go to what the dispatcher had before.
///
/// How shapes are read. A box is a sharp box of the half-extents that it was made with: Bullet's margin is
/// inside of these. A hull with a margin m is the hull grown by a ball of m, as Bullet has it: our check sees
/// the hull of the points, sharp and exact, and m is taken off the distance along the normal. Set the margin
/// to 0 for what you see.
///
/// Conventions. Bullet's: the normal is on B and points to A, distances below 0 penetrate, the point is on B.
/// A contact begins when the solids (with their margins) touch, and goes on while they are apart by less than
/// the contact breaking threshold along much the same normal (45 degrees): a non-empty manifold is not
/// overlap. So it is with the engine's box check; its hull check also begins contacts across that gap, with
/// the normal of the gap, and a box that slides over flush neighbours catches on their sides. The first time
/// that a pair is looked at it also touches where rounding alone (8 ulps) may have it apart, as it has every
/// other pair of a stack that a program puts together. Closest-point queries get what is within the threshold
/// plus the one asked for.
///
/// Persistence. At most 4 points: the deepest, and of all choices of the others the one with the largest
/// area. Each step they are found anew; a point made by the same features as one of the last step is that
/// point, and keeps its impulses, lifetime and user data; failing that, the nearest within the breaking
/// threshold. No point is kept that the check did not find. The solver takes them in their order: the deepest
/// last; of hulls with a margin the start rotates by one each step, and the direction is reversed after each
/// round, unless all are of one depth. With Options::middle_first four points are one that the check did not
/// find, in their midst, and the three deepest: the middle first, the others as found, margin or not. Points
/// that somebody else puts into a manifold (btPersistentManifold::addManifoldPoint, deSerialize) are taken
/// out by the next step's update, or matched with what it finds, if the manifold was had from
/// getAllContactManifolds(); else, for boxes apart that have no points, only once they touch or part. A
/// distance that the engine's rounding of the two positions may have made of touching (an ulp of the larger
/// coordinate along the normal) is 0 in a manifold that the solver gets, not in the answer to a query.
///
/// Capture. With an observer (such as a PairCapture of adapters/scene_files) each pair, its poses and the
/// answer are passed to it, ours or, with EngineCheck::own, the engine's; a hull's margin is taken out of the
/// answer then.
///
/// Memory. An algorithm is smaller than an element of the default configuration's pool; the constructor
/// throws where it is not (Bullet would write beyond the element in release builds). Nothing is allocated in
/// steps that bring no new pair and no new shape.
///
/// Threads: as the dispatcher; btCollisionDispatcherMt may run our algorithms on several.

class btCollisionDispatcher;

namespace touchstone {

#ifdef BT_USE_DOUBLE_PRECISION
inline namespace bullet_plugin_double {
#else
inline namespace bullet_plugin_single {
#endif

/// While it lives, new pairs of the dispatcher are checked by us, contacts and closest points; then the
/// dispatcher has what it had before. Pairs that overlap in the broadphase keep the check they began with,
/// also after this is gone, until they part or are cleaned (btOverlappingPairCache::cleanProxyFromPairs).
///
/// Of several on one dispatcher the last one made decides; they may go in any order. An entry of its tables
/// that a program has written after this was made is left as it is; if that one calls what it found, it must
/// go first.
class BulletPlugin {
 public:
  /// Since the plugin was made; with EngineCheck::own `checks` counts the pairs that were observed.
  struct Statistics {
    std::uint64_t checks = 0;   ///< pairs checked by us
    std::uint64_t refused = 0;  ///< of these without an answer: a pose not finite, a shape that became none
  };

  /// Whose check decides, and the observer.
  struct Options {
    EngineCheck check = EngineCheck::native;
    PairObserver* observer = nullptr;  ///< called with every pair of hexahedra; must outlive the plugin
    /// Where four points hold a pair: a point in their midst first, and the three deepest. It begins in the
    /// middle and goes to where the last steps' impulses act. For few iterations (4 to 10) and long steps:
    /// one row there carries what rests on the face without turning it, where four corners turn it to and fro
    /// and leave some of that in every step. The points keep their normal while the pair does not slide, and
    /// the faces turn from it by no more than moves the three corners about that point by a hundredth of the
    /// breaking threshold. It costs a corner: a box that slides over flush ones strays by 0.5 um, not 1e-14
    /// m.
    bool middle_first = false;
    /// With EngineCheck::native: whose answers stand inside instead of native's. Null: native's. A shape that
    /// it refuses goes to what the dispatcher had before, as one that is no hexahedron does.
    std::shared_ptr<CheckInside> inside = nullptr;
  };

  /// @throws InputError when the dispatcher's pool has elements too small for our algorithm.
  /// @pre the dispatcher outlives this.
  explicit BulletPlugin(btCollisionDispatcher& dispatcher) : BulletPlugin(dispatcher, Options{}) {}
  BulletPlugin(btCollisionDispatcher& dispatcher, const Options& options);
  ~BulletPlugin();
  BulletPlugin(const BulletPlugin&) = delete;
  BulletPlugin& operator=(const BulletPlugin&) = delete;

  Statistics statistics() const;

 private:
  class Registration;
  std::unique_ptr<Registration> registration_;
};

}  // namespace bullet_plugin_double or bullet_plugin_single
}  // namespace touchstone

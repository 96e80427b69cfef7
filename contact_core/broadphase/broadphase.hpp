#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/threads/task_runner.hpp"

/// @file
/// The coarse check: which pairs of solids may be within `margin` of each other.

namespace touchstone {

/// The scene that a broadphase is built over: objects, each one rigid body with a tree of hexahedra. Solid
/// indices count through the trees in order. Solids of one object are never paired.
struct BroadphaseInput {
  std::span<const HexahedronTree* const> trees;
  /// Pairs come up when their bounding volumes are within this [m]. Finite, >= 0.
  double margin = 0.0;
  /// One flag an object, or empty: none is static. Pairs of two static objects need not come up (those of
  /// `native` and `brute_force` never do), and static objects cost next to nothing while they stay. They may
  /// be moved all the same: name them in `moved`.
  std::span<const std::uint8_t> is_static = {};
  /// Threads that update() and find_pairs() may use besides the caller's; the pairs are the same with any.
  /// Borrowed until the next build(). Null: none.
  TaskRunner* threads = nullptr;
};

/// The paths of all solids in a frame: each from one pose to another, perhaps with bends and turns in
/// between.
struct SolidPaths {
  std::span<const Pose> from;  ///< X_WS of every solid at the start
  std::span<const Pose> to;    ///< and at the end
  /// One a solid, or empty: all 0. At any time the centre of the solid's bounding_sphere() is within this [m]
  /// of the straight segment between where it is at the start and at the end. Finite, >= 0. A solid that
  /// turns about its centre needs none, however far it turns. See swept_sphere.hpp for bounds.
  std::span<const double> bulge = {};
};

/// The place at which find_pairs() goes on. A default-made cursor starts from the lowest pair.
struct PairCursor {
  SolidPair next{0, 0};  ///< no pair below this comes up again
  bool done = false;
};

/// The coarse check's interface. One thread at a time; inside, the threads of BroadphaseInput::threads.
/// @see find_first_contact(), register_broadphases()
class Broadphase {
 public:
  virtual ~Broadphase() = default;

  virtual std::string_view name() const noexcept = 0;

  /// Cold path; copies what it needs. Solid indices count through the trees in order: tree 0's solids, then
  /// tree 1's, ...
  /// @throws InputError on a null tree, a bad margin or a wrong number of static flags.
  virtual void build(const BroadphaseInput& input) = 0;

  /// @param poses X_WS of every solid. @param moved indices of *objects* (trees) whose solids' poses changed
  /// since the last update; the first update after build() or update_paths() takes every pose, whatever
  /// `moved` lists. No allocation after warm-up.
  virtual void update(std::span<const Pose> poses, std::span<const std::uint32_t> moved) noexcept = 0;

  /// Whole paths instead of poses: find_pairs() then never misses a pair that could come within `margin` with
  /// either solid anywhere on its path, at the same time or not, so that a pair stays covered when one of
  /// them is stopped early. @param moved objects whose paths changed since the last update_paths(), those
  /// that came to rest among them (from = to); the first one after build() or update() takes every path.
  /// No allocation after warm-up: the first call. Returns false, and changes nothing, where a broadphase
  /// takes poses only.
  virtual bool update_paths(const SolidPaths& paths, std::span<const std::uint32_t> moved) noexcept {
    static_cast<void>(paths), static_cast<void>(moved);
    return false;
  }

  /// Replaces the tree of object `object` by one of as many solids; the number of objects appends a new one.
  /// Null removes the object: its solids keep their indices, and no pair names them. The next update() or
  /// update_paths() must list it in `moved`, unless it was removed; that call may allocate. Costs about what
  /// one object costs, now and then the whole scene.
  /// Returns false, and changes nothing, in a broadphase that must be built anew; any may.
  /// @pre build() was called; the tree outlives this call. @throws InputError as build().
  virtual bool set_object(std::uint32_t object, const HexahedronTree* tree, bool is_static) {
    static_cast<void>(object), static_cast<void>(tree), static_cast<void>(is_static);
    return false;
  }

  /// Appends to `out` the solids that find_pairs() pairs with this one, lower and higher ones, in any order.
  /// Returns false, and appends nothing, where a broadphase cannot tell without searching for all pairs.
  /// Allocates only where `out` has no room. Not concurrent with update(), find_pairs() or itself.
  virtual bool find_partners(SolidIndex solid, std::vector<SolidIndex>& out) noexcept {
    static_cast<void>(solid), static_cast<void>(out);
    return false;
  }

  /// Appends to `out`, a < b and ascending, those pairs of find_pairs() with a solid of an object that the
  /// last update() or update_paths() took as moved: what may have changed since the frame before. Where
  /// little moves this costs a small part of find_pairs(), which lists all pairs again. Pairs that ceased to
  /// be candidates are not reported. Returns false, and appends nothing, where a broadphase has nothing
  /// quicker than find_pairs(). Allocates only where `out` has no room. Not concurrent with update(),
  /// find_pairs() or itself.
  virtual bool find_moved_pairs(std::vector<SolidPair>& out) noexcept {
    static_cast<void>(out);
    return false;
  }

  /// Appends to `out` all pairs of find_pairs(), each once with a < b, in an order in which those that follow
  /// one another are near each other: a narrowphase that is asked in this order finds more of what it reads
  /// in the caches, and sorting is saved. `native` has such an order after updates in which many objects
  /// moved, in scenes of one solid an object that are spread evenly, and for some time after that while few
  /// move; after others it appends the pairs in the order of find_pairs(), ascending, and returns true all
  /// the same. The same order for the same calls since build(), on any number of threads. Returns false, and
  /// appends nothing, where a broadphase has nothing quicker than find_pairs(). Allocates only where `out`
  /// has no room. Not concurrent with update(), find_pairs() or itself.
  virtual bool find_pairs_by_place(std::vector<SolidPair>& out) noexcept {
    static_cast<void>(out);
    return false;
  }

  /// Writes the next candidate pairs, a < b, strictly ascending through the whole sweep, into `block` and
  /// advances the cursor. Returns how many were written; cursor.done is set when none are left. Never misses
  /// a pair whose solids are within `margin`; block size does not change the sequence. To stop at the first
  /// contact, use small blocks: the search may be lazy. No allocation after warm-up. Not concurrent with
  /// update() or itself.
  virtual std::size_t find_pairs(PairCursor& cursor, std::span<SolidPair> block) noexcept = 0;
};

}  // namespace touchstone

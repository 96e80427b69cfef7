#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "contact_core/geometry/hexahedron_tree.hpp"
#include "contact_core/narrowphase/narrowphase.hpp"

// The coarse check: which pairs of solids may be within `margin` of each other.

namespace touchstone {

/// What a broadphase is built over: objects, each one rigid body with a tree of hexahedra. Solid indices
/// count through the trees in order. Solids of one object are never paired.
struct BroadphaseInput {
  std::span<const HexahedronTree* const> trees;
  /// Pairs come up when their bounding volumes are within this [m]. Finite, >= 0.
  double margin = 0.0;
};

/// Where find_pairs goes on. A default-made cursor starts from the lowest pair.
struct PairCursor {
  SolidPair next{0, 0};  ///< no pair below this comes up again
  bool done = false;
};

class Broadphase {
 public:
  virtual ~Broadphase() = default;

  virtual std::string_view name() const noexcept = 0;

  /// Cold path; copies what it needs. Solid indices count through the trees in order: tree 0's solids, then
  /// tree 1's, ...
  /// @throws InputError on a null tree or a bad margin.
  virtual void build(const BroadphaseInput& input) = 0;

  /// @param poses X_WS of every solid. @param moved indices of *objects* (trees) whose solids' poses changed
  /// since the last update; the first update after build() takes every pose whatever `moved` says. No
  /// allocation after warm-up.
  virtual void update(std::span<const Pose> poses, std::span<const std::uint32_t> moved) noexcept = 0;

  /// Writes the next candidate pairs, a < b, strictly ascending through the whole sweep, into `block` and
  /// advances the cursor. Returns how many were written; cursor.done is set when none are left. Never misses
  /// a pair whose solids are within `margin`; block size does not change the sequence. No allocation after
  /// warm-up. Not concurrent with update().
  virtual std::size_t find_pairs(PairCursor& cursor, std::span<SolidPair> block) noexcept = 0;
};

}  // namespace touchstone

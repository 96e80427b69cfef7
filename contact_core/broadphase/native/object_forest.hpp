#pragma once

#include "touchstone/contact_core/broadphase/native/solid_bounds.hpp"
#include "touchstone/contact_core/broadphase/native/tree_join.hpp"

namespace touchstone {

/// The trees over a scene's objects: moving and static ones have one each, so that static ones are neither
/// refitted nor paired with each other.
class ObjectForest {
 public:
  static constexpr int kMoving = 0, kStatic = 1;
  static constexpr int kTrees = 2;

  /// When at most one object in kFew moves, trees are mended, not made anew.
  static constexpr std::uint32_t kFew = 16;

  /// Cold. Keeps `bounds`, and `threads`, which may be null.
  ObjectForest(const SolidBounds& bounds, TaskRunner* threads);

  const ObjectTree& tree(int i) const { return trees_[i].tree; }
  /// Of the object in a slot of a tree.
  const Sphere& sphere_at(int i, std::uint32_t slot) const { return trees_[i].sphere_at[slot]; }

  /// @param was_static what the object was in `bounds`, when it came.
  void erase(std::uint32_t object, bool was_static);
  /// After it was added there. Its place in the trees waits for an update that names it.
  void insert(std::uint32_t object);

  /// After all objects were placed anew.
  void update_all() noexcept;
  /// After these were.
  void update(std::span<const std::uint32_t> moved) noexcept;

  /// Calls visit(other) for the objects from `first` on that pair with this one, until it returns false.
  template <class Visit>
  bool for_each_partner(std::uint32_t object, std::uint32_t first, Visit visit) const noexcept {
    if (bounds_.is_gone(object)) return true;
    const Box box = bounds_.object_box(object);
    bool goes_on = true;
    for (int i = 0; i < (bounds_.is_static(object) ? kStatic : kTrees); ++i)
      trees_[i].tree.for_each_from(first, box, [&](std::uint32_t other) {
        if (goes_on && other != object && bounds_.may_pair(object, other)) goes_on = visit(other);
      });
    return goes_on;
  }

 private:
  struct Tree {
    ObjectTree tree;
    std::vector<Sphere> sphere_at;  // of the object in each slot
    std::size_t moves_since_sort = 0;
    bool is_void = false;  // until it is sorted and refitted
  };

  /// One that comes stands where there is room: that is as bad as so many moves.
  static constexpr std::size_t kMovesOfNew = 8;

  int tree_of(std::uint32_t object) const { return bounds_.is_static(object) ? kStatic : kMoving; }
  void sort(int i) noexcept;
  bool has_outgrown(const FloatFrame& fit) const noexcept;
  void refit(Tree& tree) noexcept;

  const SolidBounds& bounds_;
  TaskRunner* threads_;
  Tree trees_[kTrees];
  FloatFrame frame_;
  bool is_sorted_ = false;
  std::vector<std::uint32_t> slot_of_;  // of each object, in its tree
};

}  // namespace touchstone

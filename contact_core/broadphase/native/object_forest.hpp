#pragma once

#include "touchstone/contact_core/broadphase/native/solid_bounds.hpp"
#include "touchstone/contact_core/broadphase/native/tree_join.hpp"
#include "touchstone/contact_core/broadphase/native/tree_renewal.hpp"

namespace touchstone {

/// The trees over a scene's objects: moving and static ones have one each, so that static ones are neither
/// refitted nor paired with each other.
class ObjectForest {
 public:
  static constexpr int kMoving = 0, kStatic = 1;
  static constexpr int kTrees = 2;

  /// When at most one object in kFew moves, trees are refitted and renewed by shares, not made anew.
  static constexpr std::uint32_t kFew = 16;
  /// An update's share of a renewal, for each object that moved or came: so that a tree is renewed before a
  /// quarter of its objects have moved.
  static constexpr std::size_t kWorkPerMove = 5 * TreeRenewal::kWorkPerObject, kLeastWork = 256;

  /// Cold. Keeps `bounds`, and `threads`, which may be null.
  ObjectForest(const SolidBounds& bounds, TaskRunner* threads);

  const ObjectTree& tree(int i) const { return trees_[i].now.tree; }
  /// The sphere of the object in a slot of a tree.
  const Sphere& sphere_at(int i, std::uint32_t slot) const { return trees_[i].now.sphere_at[slot]; }
  /// How often a tree was sorted within one update, and how often one was renewed by shares.
  std::size_t sorts() const { return sorts_; }
  std::size_t renewals() const { return renewals_; }

  /// @param was_static what the object was in `bounds`, when it came.
  void erase(std::uint32_t object, bool was_static);
  /// Adds an object that was added to `bounds`. It enters a tree with the next update that names it.
  void insert(std::uint32_t object);

  /// After all objects were placed anew.
  void update_all() noexcept;
  /// After these objects were placed anew.
  void update(std::span<const std::uint32_t> moved) noexcept;

  /// Sorts objects by their places in the trees: in this order, the nodes that one object needs are mostly in
  /// the caches from the object before.
  void sort_by_place(std::span<std::uint32_t> objects) const noexcept;

  /// Calls visit(other) for the objects from `first` on that pair with this one, until it returns false.
  template <class Visit>
  bool for_each_partner(std::uint32_t object, std::uint32_t first, Visit visit) const noexcept {
    if (bounds_.is_gone(object)) return true;
    const Box box = bounds_.object_box(object);
    bool goes_on = true;
    for (int i = 0; i < (bounds_.is_static(object) ? kStatic : kTrees); ++i)
      trees_[i].now.tree.for_each_from(first, box, [&](std::uint32_t other) {
        if (goes_on && other != object && bounds_.may_pair(object, other)) goes_on = visit(other);
      });
    return goes_on;
  }

 private:
  struct Tree {
    PlacedTree now;
    TreeRenewal renewal;
    MortonSort sort;
    std::size_t moves_since_sort = 0;
    std::size_t new_moves = 0;  // since the last update, of those that came
    bool is_void = false;       // until it is sorted and refitted
  };

  /// A new object enters wherever there is room, which harms a tree as much as this many moves.
  static constexpr std::size_t kMovesOfNew = 8;

  int tree_of(std::uint32_t object) const { return bounds_.is_static(object) ? kStatic : kMoving; }
  std::uint32_t slot_of(std::uint32_t object) const { return trees_[tree_of(object)].now.slot_of[object]; }
  void reserve(Tree& tree);
  void sort(int i) noexcept;
  void renew(int i, std::size_t moves) noexcept;
  bool decides_frame(int i) const noexcept;
  bool has_outgrown(const FloatFrame& fit) const noexcept;
  void refit(Tree& tree) noexcept;

  const SolidBounds& bounds_;
  TaskRunner* threads_;
  Tree trees_[kTrees];
  FloatFrame frame_;
  bool is_sorted_ = false;
  std::size_t sorts_ = 0, renewals_ = 0;
};

}  // namespace touchstone

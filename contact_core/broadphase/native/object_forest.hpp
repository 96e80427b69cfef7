#pragma once

#include "touchstone/contact_core/broadphase/native/object_grid.hpp"
#include "touchstone/contact_core/broadphase/native/solid_bounds.hpp"
#include "touchstone/contact_core/broadphase/native/tree_join.hpp"
#include "touchstone/contact_core/broadphase/native/tree_renewal.hpp"

namespace touchstone {

/// The trees over a scene's objects: moving and static ones have one each, so that static ones are neither
/// refitted nor paired with each other. After an update in which many move, a grid over all objects may stand
/// in for them: making it anew costs less than sorting and refitting a tree. While few move after that, the
/// grid follows them, and the tree of what moves is made anew by shares.
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
  /// The grid while it stands in for the trees, of which that of moving objects is void then; else null.
  const ObjectGrid* grid() const { return has_grid_ ? &grid_ : nullptr; }
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
  /// the caches from the object before. @param keys scratch, with room for as many.
  void sort_by_place(std::span<std::uint32_t> objects, std::vector<std::uint64_t>& keys) const noexcept;

  /// Calls visit(other) for the objects from `first` on that pair with this one, until it returns false.
  template <class Visit>
  bool for_each_partner(std::uint32_t object, std::uint32_t first, Visit visit) const noexcept {
    if (bounds_.is_gone(object)) return true;
    if (has_grid_) return for_each_in_grid(object, first, visit);
    for (int i = 0; i < (bounds_.is_static(object) ? kStatic : kTrees); ++i)
      if (!for_each_in_tree(i, object, first, visit)) return false;
    return true;
  }

  /// Calls visit(object, other) for all that pair with one of these, until it returns false.
  template <class Visit>
  bool for_each_pair_of(std::span<const std::uint32_t> objects, Visit visit) const noexcept {
    if (has_grid_) return for_each_in_grid_of(objects, visit);
    if (bounds_.on_paths()) {
      for (const std::uint32_t object : objects)
        if (!for_each_partner(object, 0, [&](std::uint32_t other) { return visit(object, other); }))
          return false;
      return true;
    }
    for (std::size_t first = 0; first < objects.size(); first += ObjectTree::kTogether) {
      const std::size_t count = std::min<std::size_t>(ObjectTree::kTogether, objects.size() - first);
      for (int i = 0; i < kTrees; ++i)
        if (!for_each_in_tree_of(i, objects.subspan(first, count), visit)) return false;
    }
    return true;
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

  template <class Visit>
  bool for_each_in_grid(std::uint32_t object, std::uint32_t first, Visit visit) const noexcept {
    bool goes_on = true;
    grid_.for_each_near(bounds_.object_spheres_W()[object], [&](std::uint32_t other) {
      if (!goes_on || other < first || other == object) return;
      if (may_pair_in_grid(object, other)) goes_on = visit(other);
    });
    return goes_on;
  }

  template <class Visit>
  bool for_each_in_grid_of(std::span<const std::uint32_t> objects, Visit& visit) const noexcept {
    bool goes_on = true;
    const std::span<const Sphere> spheres_W = bounds_.object_spheres_W();
    for (std::size_t first = 0; first < objects.size() && goes_on; first += ObjectGrid::kTogether) {
      std::array<std::uint32_t, ObjectGrid::kTogether> asked;
      std::uint32_t count = 0;
      for (std::size_t i = first; i < std::min(first + ObjectGrid::kTogether, objects.size()); ++i)
        if (!bounds_.is_gone(objects[i])) asked[count++] = objects[i];
      grid_.for_each_near_of(
          count, [&](std::uint32_t k) { return spheres_W[asked[k]]; },
          [&](std::uint32_t k, std::uint32_t other, bool is_sure) {
            const std::uint32_t object = asked[k];
            if (!goes_on || other == object) return;
            if (is_sure || may_pair_in_grid(object, other)) goes_on = visit(object, other);
          });
    }
    return goes_on;
  }
  bool may_pair_in_grid(std::uint32_t object, std::uint32_t other) const noexcept {
    return bounds_.may_pair(object, other) && !bounds_.is_gone(other) &&
           !(bounds_.is_static(object) && bounds_.is_static(other));
  }

  /// Spheres are tested a moment after they are found: they are fetched meanwhile.
  template <class Visit>
  bool for_each_in_tree(int i, std::uint32_t object, std::uint32_t first, Visit visit) const noexcept {
    constexpr std::size_t kMost = 64;
    std::array<std::array<std::uint32_t, 2>, kMost> found;  // objects and slots
    std::size_t count = 0;
    bool goes_on = true;
    const Sphere& sphere_W = bounds_.object_spheres_W()[object];
    const auto test = [&] {
      for (std::size_t k = 0; k < count && goes_on; ++k) {
        const auto [other, slot] = found[k];
        if (bounds_.on_paths() ? bounds_.paths_may_pair(object, other)
                               : may_touch(sphere_W, sphere_at(i, slot), bounds_.margin()))
          goes_on = visit(other);
      }
      count = 0;
    };
    const auto keep = [&](std::uint32_t other, std::uint32_t slot) {
      if (other == object || !goes_on) return;
      __builtin_prefetch(&sphere_at(i, slot));
      found[count++] = {other, slot};
      if (count == kMost) test();
    };
    trees_[i].now.tree.for_each_from(first, bounds_.object_box(object), keep);
    test();
    return goes_on;
  }

  /// The same for a few objects at once.
  template <class Visit>
  bool for_each_in_tree_of(int i, std::span<const std::uint32_t> objects, Visit& visit) const noexcept {
    // Static objects do not pair with each other.
    std::array<std::uint32_t, ObjectTree::kTogether> asked;
    std::uint32_t count = 0;
    for (const std::uint32_t object : objects)
      if (!bounds_.is_gone(object) && (i == kMoving || !bounds_.is_static(object))) asked[count++] = object;
    struct Found {
      std::uint32_t object, other, slot;
    };
    std::array<Found, 256> found;
    std::size_t kept = 0;
    bool goes_on = true;
    const auto test = [&] {
      for (std::size_t k = 0; k < kept && goes_on; ++k)
        if (may_touch(bounds_.object_spheres_W()[found[k].object], sphere_at(i, found[k].slot),
                      bounds_.margin()))
          goes_on = visit(found[k].object, found[k].other);
      kept = 0;
    };
    const auto keep = [&](std::uint32_t k, std::uint32_t other, std::uint32_t slot) {
      if (other == asked[k] || !goes_on) return;
      __builtin_prefetch(&sphere_at(i, slot));
      found[kept++] = {asked[k], other, slot};
      if (kept == found.size()) test();
    };
    trees_[i].now.tree.for_each_of(
        count, [&](std::uint32_t k) { return bounds_.object_box(asked[k]); }, keep);
    test();
    return goes_on;
  }

  int tree_of(std::uint32_t object) const { return bounds_.is_static(object) ? kStatic : kMoving; }
  std::uint32_t slot_of(std::uint32_t object) const { return trees_[tree_of(object)].now.slot_of[object]; }
  void reserve(Tree& tree);
  void sort(int i) noexcept;
  void renew(int i, std::size_t moves) noexcept;
  void renew_behind_grid(std::span<const std::uint32_t> moved, std::size_t moves) noexcept;
  bool update_grid(std::span<const std::uint32_t> moved, bool is_many) noexcept;
  bool decides_frame(int i) const noexcept;
  bool has_outgrown(const FloatFrame& fit) const noexcept;
  bool needs_frame(int i, const FloatFrame& fit) noexcept;
  void refit(Tree& tree) noexcept;
  void place_one_by_one(std::span<const std::uint32_t> moved, const bool (&one_by_one)[kTrees]) noexcept;

  const SolidBounds& bounds_;
  TaskRunner* threads_;
  Tree trees_[kTrees];
  FloatFrame frame_;
  ObjectGrid grid_;
  bool has_grid_ = false;
  bool is_sorted_ = false;
  std::size_t sorts_ = 0, renewals_ = 0;
};

}  // namespace touchstone

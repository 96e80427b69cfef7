#pragma once

#include "touchstone/contact_core/broadphase/native/object_tree.hpp"
#include "touchstone/contact_core/broadphase/native/solid_bounds.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"

namespace touchstone {

/// A tree and where its objects are in it.
struct PlacedTree {
  ObjectTree tree;
  GrowingList<Sphere> sphere_at;       // of the object in each slot
  GrowingList<std::uint32_t> slot_of;  // by object

  /// Fetches what place() changes first.
  void prefetch(std::uint32_t object) const noexcept {
    tree.prefetch(slot_of[object]);
    __builtin_prefetch(&sphere_at[slot_of[object]], 1);
  }
  void place(std::uint32_t object, const SolidBounds& bounds) noexcept {
    sphere_at[slot_of[object]] = bounds.object_spheres_W()[object];
    tree.refit_one(slot_of[object], bounds.object_box(object));
  }
};

/// Sorts a new tree, a share at a time, while the old one still serves; then the two change places. It
/// follows objects that come, go and move in between.
class TreeRenewal {
 public:
  /// Renewal takes about this much work for each object of the tree, counted in objects looked at.
  static constexpr std::size_t kWorkPerObject = 13;

  bool is_under_way() const { return stage_ != Stage::none; }
  /// Cold. The number of objects, of all trees.
  void set_objects(std::size_t objects);
  /// Cold. can_begin() for a tree of up to this many slots. @pre not under way.
  void reserve(std::uint32_t room);
  /// Whether there is memory for a renewal.
  bool can_begin(const ObjectTree& now) const;
  /// @pre can_begin().
  void begin(const ObjectTree& now) noexcept;
  void stop() noexcept { stage_ = Stage::none; }

  /// Cold. An object came into the tree that serves.
  void note_new(std::uint32_t object);
  /// An object left that tree.
  void note_gone(std::uint32_t object) noexcept;
  /// An object of that tree was placed anew.
  void note_moved(std::uint32_t object, const SolidBounds& bounds) noexcept;

  enum class Progress : std::uint8_t { goes_on, changes_frame, has_no_room, done };
  /// @param belongs belongs(object): it is in the tree that serves. @param outgrown outgrown(frame): the new
  /// tree wants another one. Done: the two have changed places.
  template <class Belongs, class Outgrown>
  Progress go_on(PlacedTree& now, const SolidBounds& bounds, const FloatFrame& frame, MortonSort& sort,
                 std::size_t work, const Belongs& belongs, const Outgrown& outgrown) noexcept {
    // Each stage takes of the work and leads to the next one.
    while (work > 0) {
      if (stage_ == Stage::room) {
        if (make_room(work)) stage_ = Stage::copy;
      } else if (stage_ == Stage::copy) {
        if (copy(now.tree, work)) sort.begin(next_.tree.size()), stage_ = Stage::sort;
      } else if (stage_ == Stage::sort) {
        if (!sort.go_on(bounds.object_spheres_W(), next_.tree.order(), work)) continue;
        if (outgrown(sort.frame())) return Progress::changes_frame;
        next_.tree.begin_boxes(frame);
        stage_ = Stage::place, at_ = 0;
      } else if (stage_ == Stage::place) {
        if (place(bounds, work, belongs)) stage_ = Stage::levels, at_ = 0, level_ = 1;
      } else if (stage_ == Stage::levels) {
        if (refit(work)) stage_ = Stage::add, at_ = 0;
      } else {
        // Objects that came during the renewal are the last; then the new tree serves.
        if (!add(bounds, work, belongs)) return Progress::has_no_room;
        if (at_ < added_.size()) continue;
        std::swap(now, next_);
        stage_ = Stage::none;
        return Progress::done;
      }
    }
    return Progress::goes_on;
  }

 private:
  enum class Stage : std::uint8_t { none, room, copy, sort, place, levels, add };
  static constexpr std::uint32_t kNowhere = ObjectTree::kNoObject;
  /// A box costs as much as this many other steps.
  static constexpr std::size_t kBoxWork = 4;
  /// As many take as much memory as a node.
  static constexpr std::size_t kSpheresOfANode = sizeof(ObjectTree::Node) / sizeof(Sphere);
  /// Objects are fetched as many before they are placed.
  static constexpr std::uint32_t kAhead = 16;

  bool make_room(std::size_t& work) noexcept;
  bool copy(const ObjectTree& now, std::size_t& work) noexcept;
  bool refit(std::size_t& work) noexcept;

  /// @returns whether all are.
  template <class Belongs>
  bool place(const SolidBounds& bounds, std::size_t& work, const Belongs& belongs) noexcept {
    for (; at_ < next_.tree.room() && take(work); ++at_) {
      if (at_ + kAhead < next_.tree.size()) fetch(next_.tree.object_at(at_ + kAhead), bounds);
      const std::uint32_t object = at_ < next_.tree.size() ? next_.tree.object_at(at_) : kNowhere;
      if (object == kNowhere || !belongs(object) || next_.slot_of[object] != kNowhere) {
        next_.tree.leave_empty(at_);
        continue;
      }
      next_.slot_of[object] = at_;
      next_.sphere_at[at_] = bounds.object_spheres_W()[object];
      next_.tree.place(at_, bounds.object_box(object));
    }
    return at_ == next_.tree.room();
  }

  /// @returns false: there is no room.
  template <class Belongs>
  bool add(const SolidBounds& bounds, std::size_t& work, const Belongs& belongs) noexcept {
    for (; at_ < added_.size() && take(work); ++at_) {
      const std::uint32_t object = added_[at_];
      if (!belongs(object) || next_.slot_of[object] != kNowhere) continue;
      const std::uint32_t slot = next_.tree.insert(object);
      if (slot == kNowhere) return false;
      next_.slot_of[object] = slot;
      next_.place(object, bounds);
    }
    return true;
  }

  void fetch(std::uint32_t object, const SolidBounds& bounds) const noexcept {
    if (object == kNowhere) return;
    __builtin_prefetch(&next_.slot_of[object], 1), __builtin_prefetch(&bounds.object_spheres_W()[object]);
  }

  static bool take(std::size_t& work) noexcept {
    if (work == 0) return false;
    work -= std::min(work, kBoxWork);
    return true;
  }

  Stage stage_ = Stage::none;
  PlacedTree next_;
  std::uint32_t at_ = 0, end_ = 0, level_ = 0;
  std::vector<std::uint32_t> added_;
};

}  // namespace touchstone

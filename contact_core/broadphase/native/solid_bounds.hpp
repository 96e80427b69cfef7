#pragma once

#include "touchstone/contact_core/broadphase/swept_sphere.hpp"
#include "touchstone/contact_core/broadphase/world_spheres.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"

namespace touchstone {

/// Where the solids and objects of a scene are: at poses or on paths, whichever was placed last. Within an
/// object, the paper's tree of spheres. Different objects may be placed on different threads.
class SolidBounds {
 public:
  /// Cold. @throws InputError as make_solid_table() does.
  explicit SolidBounds(const BroadphaseInput& input);

  /// See Broadphase::set_object(). @throws InputError as the free set_object() does.
  void set_object(std::uint32_t object, const HexahedronTree* tree, bool is_static);

  std::uint32_t objects() const { return table_.objects(); }
  std::uint32_t solids() const { return table_.solids(); }
  double margin() const { return margin_; }
  bool is_static(std::uint32_t object) const { return table_.is_static[object] != 0; }
  bool has_static() const {
    return std::find(table_.is_static.begin(), table_.is_static.end(), 1) != table_.is_static.end();
  }
  bool is_gone(std::uint32_t object) const { return table_.is_gone[object] != 0; }
  bool is_single(std::uint32_t object) const { return are_single() || node_count_[object] == 1; }
  /// Whether all objects are.
  bool are_single() const { return solids() == objects(); }
  std::uint32_t first_solid(std::uint32_t object) const { return table_.first_solid[object]; }
  std::uint32_t solids_of(std::uint32_t object) const {
    return table_.first_solid[object + 1] - table_.first_solid[object];
  }
  std::uint32_t object_of(SolidIndex s) const { return table_.object_of[s]; }

  /// All objects must be placed anew, at poses or on paths; the first time on paths takes memory.
  void start_poses() noexcept { on_paths_ = false; }
  void start_paths() noexcept;
  bool on_paths() const { return on_paths_; }

  void place(std::uint32_t object, std::span<const Pose> poses) noexcept;
  /// Fetches what place() will read and write.
  void prefetch(std::uint32_t object, std::span<const Pose> poses) const noexcept;
  void place_path(std::uint32_t object, const SolidPaths& paths) noexcept;

  /// One an object; on paths only the centres count, to sort by.
  std::span<const Sphere> object_spheres_W() const { return object_sphere_W_; }

  Box object_box(std::uint32_t object) const noexcept {
    if (on_paths_) return node_box_[first_node_[object]];
    if (!is_single(object)) return object_box_[object];
    return bounding_box(object_sphere_W_[object], 0.5 * margin_);
  }

  /// Whether any of their solids may touch; exact enough to stand for them where both have one solid.
  bool may_pair(std::uint32_t object, std::uint32_t other) const noexcept {
    if (on_paths_) return paths_may_pair(object, other);
    return may_touch(object_sphere_W_[object], object_sphere_W_[other], margin_);
  }
  bool paths_may_pair(std::uint32_t object, std::uint32_t other) const noexcept {
    if (!overlap(node_box_[first_node_[object]], node_box_[first_node_[other]])) return false;
    if (!is_single(object) || !is_single(other)) return true;
    return swept_may_touch(first_solid(object), first_solid(other));
  }

  /// Appends, in ascending order, the solids of `other` that may touch solid `a`. @param box solid_box(a)
  void append_partners(SolidIndex a, const Box& box, std::uint32_t other,
                       std::vector<SolidIndex>& partners) noexcept;
  Box solid_box(SolidIndex s) const noexcept;

 private:
  // Of an object's sphere tree, in world. Inner spheres are refitted around their children's world spheres,
  // so they hold whatever rounding the poses carry; children follow their parent in the array.
  struct Node {
    using MovesByBits = Node;  ///< see kMovesByBits

    Sphere sphere_W;                  // kept of objects of several solids
    std::int32_t left, right, solid;  // left and right relative to the object's first node; solid is global
  };

  void reserve(std::size_t objects, std::size_t solids);
  void resize_spheres();
  void add_nodes(const HexahedronTree& tree, std::uint32_t first_solid);
  void replace_nodes(const HexahedronTree& tree, std::uint32_t object);
  Box box_around_solids(std::uint32_t object) const noexcept;
  const Sphere& solid_sphere_W(SolidIndex s) const noexcept;
  bool swept_may_touch(SolidIndex s, SolidIndex t) const noexcept;
  template <class MayTouch>
  void descend(std::uint32_t root, std::vector<SolidIndex>& partners, MayTouch node_may_touch) noexcept;

  SolidTable table_;
  double margin_;
  bool on_paths_ = false;
  GrowingList<Node> nodes_;
  GrowingList<std::uint32_t> first_node_, node_count_;    // by object
  GrowingList<Sphere> solid_sphere_W_, object_sphere_W_;  // the former of objects of several solids
  GrowingList<Box> object_box_;                           // of those of several solids, if there are any
  GrowingList<SweptSphere> swept_;                        // of solids, and the boxes of nodes: on paths only
  GrowingList<Box> node_box_;
  GrowingList<std::uint32_t> stack_;
};

}  // namespace touchstone

#pragma once

#include <array>
#include <bit>
#include <span>
#include <utility>
#include <vector>

#include "touchstone/contact_core/broadphase/native/float_frame.hpp"
#include "touchstone/contact_core/broadphase/native/float_lanes.hpp"
#include "touchstone/contact_core/broadphase/native/morton_sort.hpp"
#include "touchstone/contact_core/broadphase/world_spheres.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/threads/task_runner.hpp"

namespace touchstone {

/// A packed tree over some objects in Morton order: every node holds the boxes of four children, level by
/// level; level 0's children are objects. Its shape decides how fast pairs are found, never which.
class ObjectTree {
 public:
  static constexpr std::uint32_t kWidth = 4;

  struct alignas(16) Node {
    Floats low[3], high[3];  // low > high where there is no child
    Ints highest_object;     // -1: no child
  };

  static constexpr std::uint32_t kNoObject = kNoIndex;

  /// A number of slots with room for growth.
  static std::uint32_t room_for(std::uint32_t objects) {
    return (objects + objects / 8 + 64 + kWidth - 1) / kWidth * kWidth;
  }

  /// Cold. Takes `objects` with room for more; boxes and order need sort() and refit().
  explicit ObjectTree(std::span<const std::uint32_t> objects = {});

  /// The number of slots, in use or not.
  std::uint32_t room() const { return static_cast<std::uint32_t>(order_.size()); }

  /// The number of slots in use, including those of objects that left.
  std::uint32_t size() const { return size_; }
  /// The object in a slot in use; kNoObject where it has left.
  std::uint32_t object_at(std::uint32_t slot) const { return order_[slot]; }

  /// Takes up one more object, wherever there is room, for refit_one(). kNoObject: there is no room.
  std::uint32_t insert(std::uint32_t object) noexcept;
  void erase(std::uint32_t slot) noexcept;
  /// Cold. Makes room for more, once there is none. Boxes are void until sort() and refit().
  void make_room();

  /// Puts the objects in Morton order of the spheres' centres, both indexed by object, and writes each
  /// object's slot. Returns the frame that suits them.
  FloatFrame sort(MortonSort& sort, std::span<const Sphere> spheres,
                  std::span<std::uint32_t> slot_of) noexcept;

  // Built step by step in the place of another one: begin_anew(), make_nodes(), append() each object,
  // order(), then begin_boxes(), place() or leave_empty() each slot from 0 to room(), refit_child() each
  // child of each level from 1 to levels() - 1. insert(), erase() and refit_one() are for slots that are
  // placed.

  /// Cold. As many slots do not take memory later; where it has to grow for that, it is void.
  void reserve(std::uint32_t room);
  bool has_reserved(std::uint32_t room) const {
    return room <= order_.capacity() && nodes_for(room) <= nodes_.capacity();
  }
  /// Empty, with this many slots. Takes no memory where they are reserved.
  void begin_anew(std::uint32_t room) noexcept;
  /// Makes up to `most` of the nodes that it lacks: their memory may be new. @returns whether it has all.
  bool make_nodes(std::size_t most) noexcept;
  void append(std::uint32_t object) noexcept { order_[size_++] = object; }
  std::span<std::uint32_t> order() { return std::span(order_).first(size_); }
  void begin_boxes(const FloatFrame& frame) noexcept { frame_ = frame; }
  void place(std::uint32_t slot, const Box& box) noexcept { set_lane(slot, box); }
  void leave_empty(std::uint32_t slot) noexcept;
  std::uint32_t levels() const { return static_cast<std::uint32_t>(level_start_.size()) - 1; }
  std::uint32_t children(std::uint32_t level) const { return level_start_[level] - level_start_[level - 1]; }
  void refit_child(std::uint32_t level, std::uint32_t child) noexcept;

  /// Takes box_of(slot, object), a Box, for every object; called once each, on any of the threads.
  template <class BoxOf>
  void refit(const FloatFrame& frame, const BoxOf& box_of, TaskRunner* threads) noexcept {
    frame_ = frame;
    const std::uint32_t leaves = level_start_[1];
    const std::uint32_t tasks = (leaves + kLeavesPerTask - 1) / kLeavesPerTask;
    auto refit_leaves = [&](std::size_t task) {
      const auto first = static_cast<std::uint32_t>(task) * kLeavesPerTask;
      const std::uint32_t last = std::min(leaves, first + kLeavesPerTask);
      for (std::uint32_t slot = kWidth * first; slot < std::min(kWidth * last, size()); ++slot)
        if (order_[slot] != kNoObject) set_lane(slot, box_of(slot, order_[slot]));
    };
    run_tasks(threads, tasks, refit_leaves);
    for (std::size_t level = 1; level + 1 < level_start_.size(); ++level) refit_level(level);
  }

  /// Takes the new box of one object and refits what is above it.
  void refit_one(std::uint32_t slot, const Box& box) noexcept;

  /// Fetches what refit_one() changes first.
  void prefetch(std::uint32_t slot) const noexcept { prefetch_node(nodes_[slot / kWidth]); }

  /// Calls visit(b, slot of b) for every object b >= first whose box overlaps `box`. Level by level, so that
  /// the nodes of a level are fetched while those before them are looked at.
  template <class Visit>
  void for_each_from(std::uint32_t first, const Box& box, Visit visit) const noexcept {
    const Query query = query_of(first, box);
    std::array<std::uint32_t, kFrontier> now{}, next;
    std::size_t count = 1;
    for (std::uint32_t level = levels(); level-- > 0 && count > 0;) {
      std::size_t found = 0;
      for (std::size_t i = 0; i < count; ++i)
        for_each_hit(query, {level, now[i]}, visit, [&](const Entry& below) {
          if (found == kFrontier) {
            walk(query, below, visit);
            return;
          }
          prefetch_node(at(below));
          next[found++] = below.index;
        });
      now.swap(next);
      count = found;
    }
  }

  /// As many boxes are asked about together at most.
  static constexpr std::uint32_t kTogether = 8;

  /// Calls visit(k, b, slot of b) for every object b whose box overlaps box_of(k), k < count. The nodes of
  /// all of these boxes are fetched meanwhile: in a tree that is in no cache a box alone waits for a few
  /// only.
  template <class BoxOf, class Visit>
  void for_each_of(std::uint32_t count, BoxOf box_of, Visit visit) const noexcept {
    std::array<Query, kTogether> queries;
    NodesOfQueries lists[2], *now = &lists[0], *next = &lists[1];
    for (std::uint32_t k = 0; k < count; ++k) queries[k] = query_of(0, box_of(k)), now->add({k, 0}, 1);
    for (std::uint32_t level = levels(); level-- > 0;) {
      for (std::size_t i = 0; i < std::min(now->count, kAhead); ++i)
        prefetch_node(at({level, now->nodes[i].index}));
      next->count = 0;
      for (std::size_t i = 0; i < now->count; ++i) {
        if (i + kAhead < now->count) prefetch_node(at({level, now->nodes[i + kAhead].index}));
        const std::uint32_t k = now->nodes[i].query, index = now->nodes[i].index;
        if (!next->has_room()) {
          const auto visit_one = [&](std::uint32_t other, std::uint32_t slot) { visit(k, other, slot); };
          walk(queries[k], {level, index}, visit_one);
          continue;
        }
        // The children that are hit are kept without a branch, which none could predict.
        const std::uint32_t hits = hit_lanes(queries[k], at({level, index}));
        for (std::uint32_t lane = 0; lane < kWidth; ++lane)
          next->add({k, index * kWidth + lane}, hits >> lane & 1u);
      }
      std::swap(now, next);
    }
    for (const auto& [k, slot] : std::span(now->nodes).first(now->count))
      visit(k, static_cast<std::uint32_t>(nodes_[slot / kWidth].highest_object[slot % kWidth]), slot);
  }

  struct Entry {
    std::uint32_t level, index;  // index within the level
  };
  Entry root() const { return {static_cast<std::uint32_t>(level_start_.size()) - 2, 0}; }
  const Node& at(const Entry& entry) const { return nodes_[level_start_[entry.level] + entry.index]; }
  bool exists(const Entry& entry) const {
    return entry.index < level_start_[entry.level + 1] - level_start_[entry.level];
  }

 private:
  static constexpr std::uint32_t kLeavesPerTask = 512;
  static constexpr std::size_t kMostLevels = 17;

  struct Query {
    float low[3], high[3];
    std::int32_t least;
  };
  /// Nodes of a level that are kept; below the others, one is looked at after the other.
  static constexpr std::size_t kFrontier = 64;
  /// The same for several queries; at last slots.
  struct NodeOfQuery {
    std::uint32_t query, index;
  };
  struct NodesOfQueries {
    std::array<NodeOfQuery, kTogether * kFrontier> nodes;
    std::size_t count = 0;

    bool has_room() const { return count + kWidth <= nodes.size(); }
    void add(const NodeOfQuery& node, std::uint32_t if_one) { nodes[count] = node, count += if_one; }
  };
  /// Nodes are fetched as many before they are looked at.
  static constexpr std::size_t kAhead = 8;

  Query query_of(std::uint32_t first, const Box& box) const noexcept {
    Query query{};
    for (int i = 0; i < 3; ++i) {
      query.low[i] = frame_.to_float(box.low[i], i);
      query.high[i] = frame_.to_float(box.high[i], i);
    }
    query.least = static_cast<std::int32_t>(first);
    return query;
  }

  static std::uint32_t hit_lanes(const Query& query, const Node& node) noexcept {
    Ints hit = node.highest_object >= query.least;
    for (int i = 0; i < 3; ++i) hit &= (node.low[i] <= query.high[i]) & (node.high[i] >= query.low[i]);
    return lane_mask(hit);
  }

  /// Calls visit(object, slot) or below(entry) for the children of a node that the query meets.
  template <class Visit, class Below>
  void for_each_hit(const Query& query, Entry entry, const Visit& visit, Below below) const noexcept {
    const Node& node = at(entry);
    for (std::uint32_t lanes = hit_lanes(query, node); lanes != 0; lanes &= lanes - 1) {
      const auto k = static_cast<std::uint32_t>(std::countr_zero(lanes));
      const std::uint32_t child = entry.index * kWidth + k;
      if (entry.level == 0)
        visit(static_cast<std::uint32_t>(node.highest_object[k]), child);
      else
        below({entry.level - 1, child});
    }
  }

  /// for_each_from() below one node.
  template <class Visit>
  void walk(const Query& query, const Entry& start, const Visit& visit) const noexcept {
    std::array<Entry, 64> stack;  // at most 16 levels for 2^32 objects, three siblings kept a level
    std::size_t top = 0;
    stack[top++] = start;
    while (top > 0)
      for_each_hit(query, stack[--top], visit, [&](const Entry& below) { stack[top++] = below; });
  }

  static void prefetch_node(const Node& node) noexcept {
    const auto* const first = reinterpret_cast<const char*>(&node);
    __builtin_prefetch(first), __builtin_prefetch(first + sizeof(Node) - 1);
  }
  void drop_gone() noexcept;
  void empty_lane(std::uint32_t slot) noexcept;
  void refit_above(std::uint32_t slot) noexcept;
  /// At least: a quarter a level, rounded up.
  static std::size_t nodes_for(std::uint32_t room) { return room / (kWidth - 1) + 2 * kMostLevels; }
  void find_levels() noexcept;
  void clear_nodes() noexcept;
  void refit_level(std::size_t level) noexcept;
  bool refit_lane(std::size_t level, std::uint32_t child) noexcept;

  void set_lane(std::uint32_t slot, const Box& box) noexcept {
    Node& node = nodes_[slot / kWidth];
    const std::uint32_t lane = slot % kWidth;
    node.highest_object[lane] = static_cast<std::int32_t>(order_[slot]);
    for (int i = 0; i < 3; ++i) {
      node.low[i][lane] = frame_.to_float(box.low[i], i);
      node.high[i][lane] = frame_.to_float(box.high[i], i);
    }
  }

  FloatFrame frame_;
  GrowingList<Node> nodes_;
  std::vector<std::uint32_t> level_start_;  // and the number of nodes at the end
  std::uint32_t size_ = 0;                  // slots in use, of those that there is room for:
  GrowingList<std::uint32_t> order_;
  std::vector<std::uint32_t> gone_;  // slots in use whose objects went
};

}  // namespace touchstone

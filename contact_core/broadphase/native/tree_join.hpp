#pragma once

#include "touchstone/contact_core/broadphase/native/object_tree.hpp"

// All overlapping pairs of one tree, or between two, by walking pairs of nodes down from the roots.

namespace touchstone {

/// Two nodes whose boxes may overlap; the same node twice stands for the pairs within it.
struct NodePair {
  ObjectTree::Entry a, b;
};

class TreeJoin {
 public:
  /// Between two trees, or the pairs within one: &a == &b.
  TreeJoin(const ObjectTree& a, const ObjectTree& b) : a_(a), b_(b), within_(&a == &b) {}

  NodePair root() const { return {a_.root(), b_.root()}; }
  static bool is_leaf(const NodePair& pair) { return pair.a.level == 0 && pair.b.level == 0; }

  /// Calls push(NodePair) at most 16 times for the pairs below one that is no leaf.
  template <class Push>
  void expand(const NodePair& pair, Push push) const noexcept {
    if (within_ && pair.a.index == pair.b.index)
      expand_same(pair.a, push);
    else if (pair.a.level > pair.b.level)
      for_each_lane(lanes_near(a_.at(pair.a), b_.at(pair.b)), [&](std::uint32_t k) {
        push({child(pair.a, k), pair.b});
      });
    else if (pair.a.level < pair.b.level)
      for_each_lane(lanes_near(b_.at(pair.b), a_.at(pair.a)), [&](std::uint32_t k) {
        push({pair.a, child(pair.b, k)});
      });
    else
      for_each_lane(lane_pairs(a_.at(pair.a), b_.at(pair.b)), [&](std::uint32_t bit) {
        push({child(pair.a, bit / kWidth), child(pair.b, bit % kWidth)});
      });
  }

  /// Calls visit(slot in a, slot in b) at most 16 times, for the overlapping pairs of a leaf pair.
  template <class Visit>
  void visit_leaf(const NodePair& pair, Visit visit) const noexcept {
    std::uint32_t pairs = lane_pairs(a_.at(pair.a), b_.at(pair.b));
    if (within_ && pair.a.index == pair.b.index) pairs &= kAscending;
    for_each_lane(pairs, [&](std::uint32_t bit) {
      visit(pair.a.index * kWidth + bit / kWidth, pair.b.index * kWidth + bit % kWidth);
    });
  }

  /// Walks everything below `start`; leaf(NodePair) returns false to end it.
  template <class Leaf>
  void walk(const NodePair& start, Leaf leaf) const noexcept {
    // A step takes one pair away and puts at most 16 back, at most 16 + 16 levels deep.
    std::array<NodePair, 512> stack;
    std::size_t top = 0;
    stack[top++] = start;
    while (top > 0) {
      const NodePair pair = stack[--top];
      if (!is_leaf(pair))
        expand(pair, [&](const NodePair& below) { stack[top++] = below; });
      else if (!leaf(pair))
        return;
    }
  }

 private:
  static constexpr std::uint32_t kWidth = ObjectTree::kWidth;
  static constexpr std::uint32_t kAscending = 0x8CE;  // bits 4 i + j with i < j
  using Node = ObjectTree::Node;

  static ObjectTree::Entry child(const ObjectTree::Entry& entry, std::uint32_t k) {
    return {entry.level - 1, entry.index * kWidth + k};
  }

  template <class Visit>
  static void for_each_lane(std::uint32_t lanes, Visit visit) noexcept {
    for (; lanes != 0; lanes &= lanes - 1) visit(static_cast<std::uint32_t>(std::countr_zero(lanes)));
  }

  // Bit 4 i + j: lane i of a overlaps lane j of b. All sixteen, without branches, which none could predict.
  static std::uint32_t lane_pairs(const Node& a, const Node& b) noexcept {
    std::uint32_t pairs = 0;
    for (std::uint32_t i = 0; i < kWidth; ++i) {
      Ints hit = (b.low[0] <= a.high[0][i]) & (b.high[0] >= a.low[0][i]);
      hit &= (b.low[1] <= a.high[1][i]) & (b.high[1] >= a.low[1][i]);
      hit &= (b.low[2] <= a.high[2][i]) & (b.high[2] >= a.low[2][i]);
      pairs |= lane_mask(hit) << (kWidth * i);
    }
    return pairs;
  }

  // Lanes that overlap the other node's whole box.
  static std::uint32_t lanes_near(const Node& node, const Node& other) noexcept {
    const std::uint32_t pairs = lane_pairs(node, other);
    std::uint32_t lanes = 0;
    for (std::uint32_t i = 0; i < kWidth; ++i)
      if ((pairs >> (kWidth * i) & 15u) != 0) lanes |= 1u << i;
    return lanes;
  }

  template <class Push>
  void expand_same(const ObjectTree::Entry& entry, Push push) const noexcept {
    for_each_lane(lane_pairs(a_.at(entry), a_.at(entry)) & kAscending, [&](std::uint32_t bit) {
      push({child(entry, bit / kWidth), child(entry, bit % kWidth)});
    });
    for (std::uint32_t k = 0; k < kWidth; ++k)
      if (a_.exists(child(entry, k))) push({child(entry, k), child(entry, k)});
  }

  const ObjectTree& a_;
  const ObjectTree& b_;
  bool within_;
};

}  // namespace touchstone

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "contact_core/broadphase/register_broadphases.hpp"
#include "contact_core/broadphase/world_spheres.hpp"

namespace touchstone {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kWidth = 4;
// GCC's and Clang's vector types: one register of four lanes, on any instruction set.
using Floats = float __attribute__((vector_size(16)));
using Ints = std::int32_t __attribute__((vector_size(16)));

struct Box {
  std::array<double, 3> low, high;
};

// Contains the sphere inflated by margin so generously (8 eps against 4 roundings) that the sphere test alone
// decides.
Box bounding_box(const Sphere& sphere, double margin) {
  Box box;
  for (int i = 0; i < 3; ++i) {
    const double reach = sphere.radius + margin;
    const double slack = 16 * std::numeric_limits<double>::epsilon() * (reach + std::abs(sphere.centre(i)));
    // may_touch() lets distances up to sqrt(DBL_MIN) pass where squares underflow.
    const double half = reach + slack + 0x1p-510;
    const bool finite = std::isfinite(sphere.centre(i)) && std::isfinite(half);
    box.low[i] = finite ? sphere.centre(i) - half : -kInfinity;
    box.high[i] = finite ? sphere.centre(i) + half : kInfinity;
  }
  return box;
}

template <class Lanes>
auto largest_lane(Lanes v) {
  return std::max(std::max(v[0], v[1]), std::max(v[2], v[3]));
}

// Bit k: lane k is set (all ones, as comparisons leave it).
std::uint32_t lane_mask(Ints hit) {
#ifdef __SSE2__
  return static_cast<std::uint32_t>(_mm_movemask_ps(reinterpret_cast<__m128>(hit)));
#else
  return (hit[0] & 1u) | (hit[1] & 2u) | (hit[2] & 4u) | (hit[3] & 8u);
#endif
}

// Interleaves the low 10 bits with two zeros between each.
std::uint32_t spread_bits(std::uint32_t v) {
  v = (v | (v << 16)) & 0x030000FF;
  v = (v | (v << 8)) & 0x0300F00F;
  v = (v | (v << 4)) & 0x030C30C3;
  return (v | (v << 2)) & 0x09249249;
}

// A packed tree over the objects in Morton order: every node holds the boxes of four children, level by
// level; level 0's children are objects. Its shape decides how fast pairs are found, never which.
//
// Boxes are floats, (x - origin) * scale: each of these roundings is monotone, so boxes that overlap in
// double overlap here as well, and what comes up too much is left to the sphere test.
struct ObjectTree {
  struct alignas(16) Node {
    Floats low[3], high[3];
    Ints highest_object;  // -1: no child
  };
  std::vector<Node> nodes;
  std::vector<std::uint32_t> level_start;  // and the number of nodes at the end
  std::vector<std::uint32_t> order, order_scratch, keys, keys_scratch;
  std::vector<Sphere> sphere_at;  // of the object order[slot]
  Vector3 origin = Vector3::Zero();
  Vector3 scale = Vector3::Ones();

  void resize(std::uint32_t objects) {
    order.resize(objects), order_scratch.resize(objects), keys.resize(objects), keys_scratch.resize(objects);
    sphere_at.resize(objects);
    std::iota(order.begin(), order.end(), 0u);
    level_start = {0};
    std::uint32_t count = objects;
    do {
      count = (count + kWidth - 1) / kWidth;
      level_start.push_back(level_start.back() + std::max(count, 1u));
    } while (count > 1);
    nodes.resize(level_start.back());
  }

  void sort(std::span<const Sphere> spheres) noexcept {
    std::iota(order.begin(), order.end(), 0u);
    sort_range(spheres, 0, static_cast<std::uint32_t>(order.size()), true);
  }

  // Morton order within the range's own bounds. Objects that share a cell are sorted again within theirs, so
  // that a crowd far smaller than the scene is told apart as well. A level zooms in by 1023: doubles end it.
  void sort_range(std::span<const Sphere> spheres, std::uint32_t first, std::uint32_t last,
                  bool whole) noexcept {
    Vector3 low = Vector3::Constant(kInfinity);
    Vector3 high = Vector3::Constant(-kInfinity);
    for (std::uint32_t slot = first; slot < last; ++slot) {
      const Vector3& c = spheres[order[slot]].centre;
      if (is_finite(c)) low = low.cwiseMin(c), high = high.cwiseMax(c);
    }
    Vector3 cells_per_metre = Vector3::Zero();
    for (int i = 0; i < 3; ++i) {
      const double per_metre = 1023.0 / (high(i) - low(i));
      const bool usable = std::isfinite(low(i)) && std::isfinite(per_metre) && per_metre > 0.0;
      if (usable) cells_per_metre(i) = per_metre;
      if (whole) scale(i) = usable ? per_metre : 1.0;
    }
    const bool distinct = cells_per_metre.x() > 0.0 || cells_per_metre.y() > 0.0 || cells_per_metre.z() > 0.0;
    if (distinct) {
      for (std::uint32_t slot = first; slot < last; ++slot)
        keys[slot] = morton_key(spheres[order[slot]].centre, low, cells_per_metre);
      sort_by_key(first, last);
      for (std::uint32_t run = first, end = first; run < last; run = end) {
        while (end < last && keys[end] == keys[run]) ++end;
        if (end - run > 4 * kWidth) sort_range(spheres, run, end, false);
      }
    }
    // Floats are finest about their origin: put it where objects are, whatever strays.
    if (whole && last > 0) {
      const Vector3& middle = spheres[order[last / 2]].centre;
      origin = is_finite(middle) ? middle : Vector3(Vector3::Zero());
    }
  }

  static std::uint32_t morton_key(const Vector3& p, const Vector3& low,
                                  const Vector3& cells_per_metre) noexcept {
    std::uint32_t key = 0;
    for (int i = 0; i < 3; ++i) {
      const double cell = (p(i) - low(i)) * cells_per_metre(i);
      key |= spread_bits(cell > 0.0 ? static_cast<std::uint32_t>(std::min(cell, 1023.0)) : 0u) << i;
    }
    return key;
  }

  void sort_by_key(std::uint32_t first, std::uint32_t last) noexcept {
    for (int shift = 0; shift < 30; shift += 10) {
      std::array<std::uint32_t, 1024> start{};
      for (std::uint32_t i = first; i < last; ++i) ++start[(keys[i] >> shift) & 1023];
      std::exclusive_scan(start.begin(), start.end(), start.begin(), first);
      for (std::uint32_t i = first; i < last; ++i) {
        const std::uint32_t slot = start[(keys[i] >> shift) & 1023]++;
        keys_scratch[slot] = keys[i], order_scratch[slot] = order[i];
      }
      std::copy(keys_scratch.begin() + first, keys_scratch.begin() + last, keys.begin() + first);
      std::copy(order_scratch.begin() + first, order_scratch.begin() + last, order.begin() + first);
    }
  }

  float to_float(double x, int axis) const noexcept {
    constexpr double kLargest = std::numeric_limits<float>::max();
    return static_cast<float>(std::clamp((x - origin(axis)) * scale(axis), -kLargest, kLargest));
  }

  void refit(std::span<const Sphere> spheres, double margin) noexcept {
    for (std::uint32_t slot = 0; slot < kWidth * level_start[1]; ++slot) {
      Node& node = nodes[slot / kWidth];
      const std::uint32_t lane = slot % kWidth;
      const bool used = slot < order.size();
      node.highest_object[lane] = used ? static_cast<std::int32_t>(order[slot]) : -1;
      Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
      if (used) sphere_at[slot] = spheres[order[slot]], box = bounding_box(sphere_at[slot], 0.5 * margin);
      for (int i = 0; i < 3; ++i) {
        node.low[i][lane] = to_float(box.low[i], i);
        node.high[i][lane] = to_float(box.high[i], i);
      }
    }
    for (std::size_t level = 1; level + 1 < level_start.size(); ++level) refit_level(level);
  }

  void refit_level(std::size_t level) noexcept {
    const std::uint32_t children = level_start[level] - level_start[level - 1];
    for (std::uint32_t slot = 0; slot < kWidth * (level_start[level + 1] - level_start[level]); ++slot) {
      Node& node = nodes[level_start[level] + slot / kWidth];
      const std::uint32_t lane = slot % kWidth;
      node.highest_object[lane] = -1;
      if (slot >= children) continue;
      const Node& child = nodes[level_start[level - 1] + slot];
      node.highest_object[lane] = largest_lane(child.highest_object);
      for (int i = 0; i < 3; ++i) {
        node.low[i][lane] = -largest_lane(-child.low[i]);
        node.high[i][lane] = largest_lane(child.high[i]);
      }
    }
  }

  /// Calls visit(slot, slot) once for every two slots whose boxes overlap, until it returns false.
  /// Returns whether all were visited.
  template <class Visit>
  bool for_each_pair(Visit visit) const noexcept {
    for (std::uint32_t leaf = 0; leaf < level_start[1]; ++leaf)
      if (!join_leaf(leaf, visit)) return false;
    return true;
  }

  // Pairs within the leaf and with the leaves after it.
  template <class Visit>
  bool join_leaf(std::uint32_t leaf, Visit& visit) const noexcept {
    const Node& own = nodes[leaf];
    float low[3], high[3];
    for (int i = 0; i < 3; ++i) low[i] = -largest_lane(-own.low[i]), high[i] = largest_lane(own.high[i]);
    if (!join_lanes(leaf, leaf, visit)) return false;
    std::array<Entry, 64> stack;
    int top = 0;
    const auto root_level = static_cast<std::uint32_t>(level_start.size()) - 2;
    if (root_level > 0) stack[top++] = {root_level, 0};
    while (top > 0) {
      const Entry entry = stack[--top];
      const Node& node = nodes[level_start[entry.level] + entry.index];
      Ints hit = node.highest_object >= 0;
      for (int i = 0; i < 3; ++i) hit &= (node.low[i] <= high[i]) & (node.high[i] >= low[i]);
      const std::uint32_t lanes = lane_mask(hit);
      const std::uint32_t child_level = entry.level - 1;
      const std::uint32_t first_child = child_level == 0 ? leaf + 1 : leaf >> (2 * child_level);
      for (std::uint32_t k = 0; k < kWidth; ++k) {
        const std::uint32_t child = entry.index * kWidth + k;
        if ((lanes >> k & 1) == 0 || child < first_child) continue;
        if (child_level > 0)
          stack[top++] = {child_level, child};
        else if (!join_lanes(leaf, child, visit))
          return false;
      }
    }
    return true;
  }

  template <class Visit>
  bool join_lanes(std::uint32_t leaf, std::uint32_t other, Visit& visit) const noexcept {
    const Node& a = nodes[leaf];
    const Node& b = nodes[other];
    for (std::uint32_t k = 0; k < kWidth; ++k) {
      if (a.highest_object[k] < 0) break;
      Ints hit = b.highest_object >= 0;
      for (int i = 0; i < 3; ++i) hit &= (b.low[i] <= a.high[i][k]) & (b.high[i] >= a.low[i][k]);
      std::uint32_t lanes = lane_mask(hit);
      if (leaf == other) lanes &= ~0u << (k + 1);
      for (; lanes != 0; lanes &= lanes - 1)
        if (!visit(leaf * kWidth + k, other * kWidth + static_cast<std::uint32_t>(std::countr_zero(lanes))))
          return false;
    }
    return true;
  }

  struct Entry {
    std::uint32_t level, index;  // index within the level
  };

  /// Calls visit(b) for every object b > a whose box overlaps a's.
  template <class Visit>
  void for_each_above(std::uint32_t object, const Box& box, Visit visit) const noexcept {
    float low[3], high[3];
    for (int i = 0; i < 3; ++i) low[i] = to_float(box.low[i], i), high[i] = to_float(box.high[i], i);
    const auto a = static_cast<std::int32_t>(object);
    std::array<Entry, 64> stack;  // at most 16 levels for 2^32 objects, three siblings kept a level
    int top = 0;
    stack[top++] = {static_cast<std::uint32_t>(level_start.size()) - 2, 0};
    while (top > 0) {
      const Entry entry = stack[--top];
      const Node& node = nodes[level_start[entry.level] + entry.index];
      Ints hit = node.highest_object > a;
      for (int i = 0; i < 3; ++i) hit &= (node.low[i] <= high[i]) & (node.high[i] >= low[i]);
      for (std::uint32_t k = 0; k < kWidth; ++k) {
        if (!hit[k]) continue;
        if (entry.level == 0)
          visit(static_cast<std::uint32_t>(node.highest_object[k]));
        else
          stack[top++] = {entry.level - 1, entry.index * kWidth + k};
      }
    }
  }
};

// One object's sphere tree (the paper's), its spheres in world. Inner spheres are refitted around their
// children's world spheres, so they hold whatever rounding the poses carry; children follow their parent in
// the array.
struct SphereNode {
  Sphere sphere_W;
  std::int32_t left, right, solid;  // left and right relative to the object's first node; solid is global
};

class Native final : public Broadphase {
 public:
  std::string_view name() const noexcept override { return "native"; }

  void build(const BroadphaseInput& input) override {
    Native fresh;
    fresh.table_ = make_solid_table(input);
    fresh.margin_ = input.margin;
    for (std::uint32_t object = 0; object < fresh.table_.objects(); ++object)
      fresh.add_nodes(*input.trees[object], fresh.table_.first_solid[object]);
    const std::uint32_t objects = fresh.table_.objects();
    fresh.solid_sphere_W_.resize(fresh.table_.solids());
    fresh.object_sphere_W_.resize(objects);
    fresh.list_.resize(kListedPairsPerObject * std::size_t{objects});
    fresh.listed_.resize(fresh.list_.size());
    fresh.list_end_.resize(objects);
    fresh.partner_objects_.reserve(objects), fresh.partners_.reserve(fresh.table_.solids());
    fresh.stack_.resize(fresh.nodes_.size() + 1);
    fresh.object_tree_.resize(objects);
    *this = std::move(fresh);
  }

  void update(std::span<const Pose> poses, std::span<const std::uint32_t> moved) noexcept override {
    const bool everything = is_first_update_;
    is_first_update_ = false;
    gathered_solid_ = gathered_object_ = kNone;
    list_state_ = ListState::due;
    if (everything)
      for (std::uint32_t object = 0; object < table_.objects(); ++object) place(object, poses);
    else
      for (std::uint32_t object : moved) place(object, poses);
    if (!everything && moved.empty()) return;
    // Sorting costs about as much as refitting; a tree whose objects have all moved once since is due.
    moves_since_sort_ += moved.size();
    if (everything || moves_since_sort_ >= table_.objects())
      object_tree_.sort(object_sphere_W_), moves_since_sort_ = 0;
    object_tree_.refit(object_sphere_W_, margin_);
  }

  std::size_t find_pairs(PairCursor& cursor, std::span<SolidPair> block) noexcept override {
    std::size_t count = 0;
    for (SolidIndex a = cursor.next.a; a < table_.solids(); ++a) {
      gather_partners(a);
      auto b = partners_.begin();
      if (a == cursor.next.a) b = std::lower_bound(b, partners_.end(), cursor.next.b);
      for (; b != partners_.end(); ++b) {
        if (count == block.size()) {
          cursor.next = {a, *b};
          return count;
        }
        block[count++] = {a, *b};
      }
    }
    cursor.next = {table_.solids(), 0};
    cursor.done = true;
    return count;
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  void add_nodes(const HexahedronTree& tree, std::uint32_t first_solid) {
    first_node_.push_back(static_cast<std::uint32_t>(nodes_.size()));
    for (const HexahedronTree::Node& node : tree.nodes())
      nodes_.push_back({{Vector3::Zero(), 0.0},
                        node.left,
                        node.right,
                        node.solid < 0 ? -1 : static_cast<std::int32_t>(first_solid) + node.solid});
    node_count_.push_back(static_cast<std::uint32_t>(tree.nodes().size()));
  }

  void place(std::uint32_t object, std::span<const Pose> poses) noexcept {
    SphereNode* const nodes = &nodes_[first_node_[object]];
    for (std::uint32_t i = node_count_[object]; i-- > 0;) {
      SphereNode& node = nodes[i];
      if (node.solid >= 0)
        node.sphere_W = solid_sphere_W_[node.solid] =
            world_sphere(table_.sphere_S[node.solid], poses[node.solid]);
      else
        node.sphere_W = enclosing_sphere(nodes[node.left].sphere_W, nodes[node.right].sphere_W);
    }
    object_sphere_W_[object] = nodes[0].sphere_W;
  }

  // All pairs of objects at once, in tree order, which is kind to caches, then by counting into one ascending
  // list per object.
  void list_partner_objects() noexcept {
    list_state_ = ListState::full;
    std::fill(list_end_.begin(), list_end_.end(), 0u);
    const std::vector<Sphere>& spheres = object_tree_.sphere_at;
    const std::vector<std::uint32_t>& order = object_tree_.order;
    std::size_t count = 0;
    const bool complete = object_tree_.for_each_pair([&](std::uint32_t slot, std::uint32_t other) {
      if (!may_touch(spheres[slot], spheres[other], margin_)) return true;
      if (count == listed_.size()) return false;
      const auto [a, b] = std::minmax(order[slot], order[other]);
      listed_[count++] = {a, b};
      ++list_end_[a];
      return true;
    });
    if (!complete) return;
    list_state_ = ListState::complete;
    std::exclusive_scan(list_end_.begin(), list_end_.end(), list_end_.begin(), 0u);
    for (std::size_t i = 0; i < count; ++i) list_[list_end_[listed_[i].a]++] = listed_[i].b;
    std::uint32_t first = 0;
    for (std::uint32_t end : list_end_) {
      std::sort(list_.begin() + first, list_.begin() + end);
      first = end;
    }
  }

  std::span<const std::uint32_t> partner_objects(std::uint32_t object) noexcept {
    if (list_state_ == ListState::due) list_partner_objects();
    if (list_state_ == ListState::full) {
      gather_partner_objects(object);
      return partner_objects_;
    }
    const std::uint32_t first = object == 0 ? 0 : list_end_[object - 1];
    return std::span(list_).subspan(first, list_end_[object] - first);
  }

  void gather_partner_objects(std::uint32_t object) noexcept {
    if (gathered_object_ == object) return;
    gathered_object_ = object;
    partner_objects_.clear();
    const Box box = bounding_box(object_sphere_W_[object], 0.5 * margin_);
    object_tree_.for_each_above(object, box, [&](std::uint32_t other) {
      if (may_touch(object_sphere_W_[object], object_sphere_W_[other], margin_))
        partner_objects_.push_back(other);
    });
    std::sort(partner_objects_.begin(), partner_objects_.end());
  }

  void gather_partners(SolidIndex a) noexcept {
    if (gathered_solid_ == a) return;
    gathered_solid_ = a;
    partners_.clear();
    const std::uint32_t object = table_.object_of[a];
    const bool single = node_count_[object] == 1;
    for (std::uint32_t other : partner_objects(object)) {
      if (single && node_count_[other] == 1) {  // their spheres have been tested
        partners_.push_back(table_.first_solid[other]);
        continue;
      }
      const auto first = static_cast<std::ptrdiff_t>(partners_.size());
      gather_below(first_node_[other], solid_sphere_W_[a]);
      std::sort(partners_.begin() + first, partners_.end());
    }
  }

  void gather_below(std::uint32_t root, const Sphere& sphere) noexcept {
    std::size_t top = 0;
    stack_[top++] = 0;
    while (top > 0) {
      const SphereNode& node = nodes_[root + stack_[--top]];
      if (!may_touch(node.sphere_W, sphere, margin_)) continue;
      if (node.solid >= 0) {
        partners_.push_back(static_cast<SolidIndex>(node.solid));
      } else {
        stack_[top++] = static_cast<std::uint32_t>(node.right),
        stack_[top++] = static_cast<std::uint32_t>(node.left);
      }
    }
  }

  SolidTable table_{{}, {0}, {}};
  double margin_ = 0.0;
  std::vector<SphereNode> nodes_;
  std::vector<std::uint32_t> first_node_, node_count_;
  std::vector<Sphere> solid_sphere_W_, object_sphere_W_;
  ObjectTree object_tree_;
  std::size_t moves_since_sort_ = 0;
  bool is_first_update_ = true;

  // Pairs of objects, listed by the first find_pairs after an update. Scenes so dense that the space does not
  // hold them are asked object by object: there the answer is most of the work.
  static constexpr std::size_t kListedPairsPerObject = 16;
  enum class ListState { due, complete, full } list_state_ = ListState::due;
  std::vector<SolidPair> listed_;        // in tree order; of objects here
  std::vector<std::uint32_t> list_;      // the higher objects, by the lower
  std::vector<std::uint32_t> list_end_;  // of each object's part of list_

  // What find_pairs gathered last, kept for the next block.
  std::uint32_t gathered_object_ = kNone, gathered_solid_ = kNone;
  std::vector<std::uint32_t> partner_objects_;
  std::vector<SolidIndex> partners_;
  std::vector<std::uint32_t> stack_;
};

}  // namespace

std::unique_ptr<Broadphase> make_native_broadphase() { return std::make_unique<Native>(); }

}  // namespace touchstone

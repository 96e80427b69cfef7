#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "contact_core/broadphase/register_broadphases.hpp"
#include "contact_core/broadphase/world_spheres.hpp"

namespace touchstone {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kLeafObjects = 4;

struct Box {
  std::array<double, 3> low, high;
};

void merge(Box& into, const Box& box) {
  for (int i = 0; i < 3; ++i) {
    into.low[i] = std::min(into.low[i], box.low[i]);
    into.high[i] = std::max(into.high[i], box.high[i]);
  }
}

bool overlap(const Box& a, const Box& b) {
  return (a.low[0] <= b.high[0]) & (b.low[0] <= a.high[0]) & (a.low[1] <= b.high[1]) &
         (b.low[1] <= a.high[1]) & (a.low[2] <= b.high[2]) & (b.low[2] <= a.high[2]);
}

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

// Interleaves the low 10 bits with two zeros between each.
std::uint32_t spread_bits(std::uint32_t v) {
  v = (v | (v << 16)) & 0x030000FF;
  v = (v | (v << 8)) & 0x0300F00F;
  v = (v | (v << 4)) & 0x030C30C3;
  return (v | (v << 2)) & 0x09249249;
}

// A complete binary tree over the objects in Morton order, four objects a leaf; node i has children 2i + 1
// and 2i + 2. Its shape decides how fast pairs are found, never which.
struct ObjectTree {
  struct Node {
    Box box;
    std::uint32_t highest_object;
  };
  std::vector<Node> nodes;
  std::vector<std::uint32_t> order, order_scratch, keys, keys_scratch;
  std::uint32_t leaves = 1;

  void resize(std::uint32_t objects) {
    order.resize(objects), order_scratch.resize(objects), keys.resize(objects), keys_scratch.resize(objects);
    std::iota(order.begin(), order.end(), 0u);
    leaves = 1;
    while (leaves * kLeafObjects < objects) leaves *= 2;
    nodes.resize(2 * leaves - 1);
  }

  void sort(std::span<const Sphere> spheres) noexcept {
    Vector3 low = Vector3::Constant(kInfinity);
    Vector3 high = Vector3::Constant(-kInfinity);
    for (const Sphere& sphere : spheres)
      if (is_finite(sphere.centre)) low = low.cwiseMin(sphere.centre), high = high.cwiseMax(sphere.centre);
    Vector3 scale;
    for (int i = 0; i < 3; ++i) scale(i) = high(i) > low(i) ? 1023.0 / (high(i) - low(i)) : 0.0;
    for (std::uint32_t object = 0; object < order.size(); ++object) {
      std::uint32_t key = 0;
      for (int i = 0; i < 3; ++i) {
        const double cell = (spheres[object].centre(i) - low(i)) * scale(i);
        key |= spread_bits(cell > 0.0 ? static_cast<std::uint32_t>(std::min(cell, 1023.0)) : 0u) << i;
      }
      order[object] = object, keys[object] = key;
    }
    for (int shift = 0; shift < 30; shift += 10) sort_by_digit(shift);
  }

  void sort_by_digit(int shift) noexcept {
    std::array<std::uint32_t, 1024> start{};
    for (std::uint32_t key : keys) ++start[(key >> shift) & 1023];
    std::exclusive_scan(start.begin(), start.end(), start.begin(), 0u);
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const std::uint32_t slot = start[(keys[i] >> shift) & 1023]++;
      keys_scratch[slot] = keys[i], order_scratch[slot] = order[i];
    }
    keys.swap(keys_scratch), order.swap(order_scratch);
  }

  void refit(std::span<const Box> boxes) noexcept {
    for (std::uint32_t leaf = 0; leaf < leaves; ++leaf) {
      Node& node = nodes[leaves - 1 + leaf];
      node.box.low.fill(kInfinity), node.box.high.fill(-kInfinity);
      node.highest_object = 0;
      for (std::uint32_t i = first_of(leaf); i < first_of(leaf + 1); ++i) {
        merge(node.box, boxes[order[i]]);
        node.highest_object = std::max(node.highest_object, order[i]);
      }
    }
    for (std::uint32_t i = leaves - 1; i-- > 0;) {
      nodes[i] = nodes[2 * i + 1];
      merge(nodes[i].box, nodes[2 * i + 2].box);
      nodes[i].highest_object = std::max(nodes[i].highest_object, nodes[2 * i + 2].highest_object);
    }
  }

  // Objects spread evenly over the leaves, at most kLeafObjects each.
  std::uint32_t first_of(std::uint32_t leaf) const noexcept {
    return static_cast<std::uint32_t>(std::uint64_t{leaf} * order.size() / leaves);
  }

  /// Calls visit(b) for every object b > a whose box overlaps a's.
  template <class Visit>
  void for_each_above(std::uint32_t a, const Box& box, std::span<const Box> boxes,
                      Visit visit) const noexcept {
    std::array<std::uint32_t, 64> stack;  // depth is below 32, one sibling kept per level
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const std::uint32_t index = stack[--top];
      const Node& node = nodes[index];
      if (node.highest_object <= a || !overlap(node.box, box)) continue;
      if (index < leaves - 1) {
        stack[top++] = 2 * index + 2, stack[top++] = 2 * index + 1;
        continue;
      }
      const std::uint32_t leaf = index - (leaves - 1);
      for (std::uint32_t i = first_of(leaf); i < first_of(leaf + 1); ++i)
        if (order[i] > a && overlap(boxes[order[i]], box)) visit(order[i]);
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
    fresh.object_sphere_W_.resize(objects), fresh.object_box_W_.resize(objects);
    fresh.partner_objects_.reserve(objects), fresh.partners_.reserve(fresh.table_.solids());
    fresh.stack_.resize(fresh.nodes_.size() + 1);
    fresh.object_tree_.resize(objects);
    *this = std::move(fresh);
  }

  void update(std::span<const Pose> poses, std::span<const std::uint32_t> moved) noexcept override {
    const bool everything = is_first_update_;
    is_first_update_ = false;
    gathered_solid_ = gathered_object_ = kNone;
    if (everything)
      for (std::uint32_t object = 0; object < table_.objects(); ++object) place(object, poses);
    else
      for (std::uint32_t object : moved) place(object, poses);
    if (!everything && moved.empty()) return;
    // Sorting costs about as much as refitting; a tree whose objects have all moved once since is due.
    moves_since_sort_ += moved.size();
    if (everything || moves_since_sort_ >= table_.objects())
      object_tree_.sort(object_sphere_W_), moves_since_sort_ = 0;
    object_tree_.refit(object_box_W_);
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
    object_box_W_[object] = bounding_box(nodes[0].sphere_W, 0.5 * margin_);
  }

  void gather_partner_objects(std::uint32_t object) noexcept {
    if (gathered_object_ == object) return;
    gathered_object_ = object;
    partner_objects_.clear();
    object_tree_.for_each_above(object, object_box_W_[object], object_box_W_, [&](std::uint32_t other) {
      if (may_touch(object_sphere_W_[object], object_sphere_W_[other], margin_))
        partner_objects_.push_back(other);
    });
    std::sort(partner_objects_.begin(), partner_objects_.end());
  }

  void gather_partners(SolidIndex a) noexcept {
    if (gathered_solid_ == a) return;
    gathered_solid_ = a;
    partners_.clear();
    gather_partner_objects(table_.object_of[a]);
    for (std::uint32_t other : partner_objects_) {
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
  std::vector<Box> object_box_W_;
  ObjectTree object_tree_;
  std::size_t moves_since_sort_ = 0;
  bool is_first_update_ = true;

  // What find_pairs gathered last, kept for the next block.
  std::uint32_t gathered_object_ = kNone, gathered_solid_ = kNone;
  std::vector<std::uint32_t> partner_objects_;
  std::vector<SolidIndex> partners_;
  std::vector<std::uint32_t> stack_;
};

}  // namespace

std::unique_ptr<Broadphase> make_native_broadphase() { return std::make_unique<Native>(); }

}  // namespace touchstone

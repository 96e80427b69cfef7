#include "touchstone/contact_core/broadphase/native/solid_bounds.hpp"

#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {

SolidBounds::SolidBounds(const BroadphaseInput& input)
    : table_(make_solid_table(input)), margin_(input.margin) {
  reserve(objects(), solids());
  for (std::uint32_t object = 0; object < objects(); ++object)
    add_nodes(*input.trees[object], table_.first_solid[object]);
  resize_spheres();
  stack_.resize(nodes_.size() + 1);
}

/// What objects of several solids need is kept where there are any.
void SolidBounds::resize_spheres() {
  object_sphere_W_.resize(objects());
  if (!are_single()) solid_sphere_W_.resize(solids()), object_box_.resize(objects());
}

/// And for more, which come one by one.
void SolidBounds::reserve(std::size_t objects, std::size_t solids) {
  const std::size_t nodes = 2 * solids;  // of n solids n - 1 are inner nodes
  reserve_more(nodes_, nodes), reserve_more(first_node_, objects), reserve_more(node_count_, objects);
  reserve_more(solid_sphere_W_, solids), reserve_more(object_sphere_W_, objects);
  reserve_more(object_box_, objects), reserve_more(swept_, solids);
  reserve_more(node_box_, nodes), reserve_more(stack_, nodes + 1);
}

void SolidBounds::add_nodes(const HexahedronTree& tree, std::uint32_t first_solid) {
  first_node_.push_back(static_cast<std::uint32_t>(nodes_.size()));
  for (const HexahedronTree::Node& node : tree.nodes())
    nodes_.push_back({{Vector3::Zero(), 0.0},
                      node.left,
                      node.right,
                      node.solid < 0 ? -1 : static_cast<std::int32_t>(first_solid) + node.solid});
  node_count_.push_back(static_cast<std::uint32_t>(tree.nodes().size()));
}

// As many as before: a tree of n solids has n - 1 inner nodes.
void SolidBounds::replace_nodes(const HexahedronTree& tree, std::uint32_t object) {
  const std::uint32_t first = first_node_[object], first_solid = table_.first_solid[object];
  for (std::uint32_t i = 0; i < node_count_[object]; ++i) {
    const HexahedronTree::Node& node = tree.nodes()[i];
    nodes_[first + i].left = node.left, nodes_[first + i].right = node.right;
    nodes_[first + i].solid = node.solid < 0 ? -1 : static_cast<std::int32_t>(first_solid) + node.solid;
  }
}

void SolidBounds::set_object(std::uint32_t object, const HexahedronTree* tree, bool is_static) {
  const bool is_new = object == objects();
  touchstone::set_object(table_, object, tree, is_static);
  if (tree == nullptr) return;
  if (!is_new) {
    replace_nodes(*tree, object);
    return;
  }
  reserve(objects(), solids());
  add_nodes(*tree, table_.first_solid[object]);
  resize_spheres();
  if (on_paths_) start_paths();
  stack_.resize(nodes_.size() + 1);
}

void SolidBounds::start_paths() noexcept {
  on_paths_ = true;
  swept_.resize(solids()), node_box_.resize(nodes_.size());
}

void SolidBounds::prefetch(std::uint32_t object, std::span<const Pose> poses) const noexcept {
  if (!are_single()) return;
  const auto* const pose = reinterpret_cast<const char*>(&poses[object]);
  __builtin_prefetch(pose), __builtin_prefetch(pose + sizeof(Pose) - 1);
  __builtin_prefetch(&table_.sphere_S[object]);
  __builtin_prefetch(&object_sphere_W_[object], 1);
}

void SolidBounds::place(std::uint32_t object, std::span<const Pose> poses) noexcept {
  if (is_single(object)) {
    const std::uint32_t s = are_single() ? object : table_.first_solid[object];
    object_sphere_W_[object] = world_sphere(table_.sphere_S[s], poses[s]);
    return;
  }
  Node* const nodes = &nodes_[first_node_[object]];
  for (std::uint32_t i = node_count_[object]; i-- > 0;) {
    Node& node = nodes[i];
    if (node.solid >= 0)
      node.sphere_W = solid_sphere_W_[node.solid] =
          world_sphere(table_.sphere_S[node.solid], poses[node.solid]);
    else
      node.sphere_W = enclosing_sphere(nodes[node.left].sphere_W, nodes[node.right].sphere_W);
  }
  object_sphere_W_[object] = nodes[0].sphere_W;
  object_box_[object] = box_around_solids(object);
}

// Of a long object it is far smaller than its sphere's.
Box SolidBounds::box_around_solids(std::uint32_t object) const noexcept {
  Box box = solid_box(table_.first_solid[object]);
  for (std::uint32_t s = table_.first_solid[object] + 1; s < table_.first_solid[object + 1]; ++s)
    box = union_of(box, solid_box(s));
  return box;
}

const Sphere& SolidBounds::solid_sphere_W(SolidIndex s) const noexcept {
  const std::uint32_t object = are_single() ? s : object_of(s);
  return is_single(object) ? object_sphere_W_[object] : solid_sphere_W_[s];
}

Box SolidBounds::solid_box(SolidIndex s) const noexcept {
  if (on_paths_) return bounding_box(swept_[s], 0.5 * margin_);
  return bounding_box(solid_sphere_W(s), 0.5 * margin_);
}

// Paths are long and thin: boxes of all swept below, not spheres.
void SolidBounds::place_path(std::uint32_t object, const SolidPaths& paths) noexcept {
  const Node* const nodes = &nodes_[first_node_[object]];
  Box* const boxes = &node_box_[first_node_[object]];
  for (std::uint32_t i = node_count_[object]; i-- > 0;) {
    const std::int32_t s = nodes[i].solid;
    if (s >= 0) {
      const double bulge = paths.bulge.empty() ? 0.0 : paths.bulge[s];
      swept_[s] = swept_sphere(table_.sphere_S[s], paths.from[s], paths.to[s], bulge);
      boxes[i] = solid_box(static_cast<SolidIndex>(s));
    } else {
      boxes[i] = union_of(boxes[nodes[i].left], boxes[nodes[i].right]);
    }
  }
  Sphere& sphere = object_sphere_W_[object];
  for (int i = 0; i < 3; ++i) sphere.centre(i) = 0.5 * boxes[0].low[i] + 0.5 * boxes[0].high[i];
}

// In one order, so that it does not matter who asks.
bool SolidBounds::swept_may_touch(SolidIndex s, SolidIndex t) const noexcept {
  return may_touch(swept_[std::min(s, t)], swept_[std::max(s, t)], margin_);
}

void SolidBounds::append_partners(SolidIndex a, const Box& box, std::uint32_t other,
                                  std::vector<SolidIndex>& partners) noexcept {
  if (!overlap(box, object_box(other))) return;
  // Of few solids all are tried, in order, which saves a tree's walk and sorting.
  constexpr std::uint32_t kFew = 8;
  const Sphere& sphere_W = solid_sphere_W(a);
  if (!on_paths_ && solids_of(other) <= kFew && !is_single(other)) {
    for (SolidIndex s = first_solid(other); s < first_solid(other) + solids_of(other); ++s)
      if (may_touch(solid_sphere_W_[s], sphere_W, margin_)) partners.push_back(s);
    return;
  }
  // Of many those that the tree leads to.
  const auto first = static_cast<std::ptrdiff_t>(partners.size());
  const std::uint32_t root = first_node_[other];
  if (on_paths_)
    descend(root, partners, [&](std::uint32_t node) {
      if (!overlap(node_box_[node], box)) return false;
      return nodes_[node].solid < 0 || swept_may_touch(a, static_cast<SolidIndex>(nodes_[node].solid));
    });
  else if (is_single(other)) {
    if (may_touch(object_sphere_W_[other], sphere_W, margin_)) partners.push_back(table_.first_solid[other]);
  } else
    descend(root, partners,
            [&](std::uint32_t node) { return may_touch(nodes_[node].sphere_W, sphere_W, margin_); });
  std::sort(partners.begin() + first, partners.end());
}

template <class MayTouch>
void SolidBounds::descend(std::uint32_t root, std::vector<SolidIndex>& partners,
                          MayTouch node_may_touch) noexcept {
  std::size_t top = 0;
  stack_[top++] = 0;
  while (top > 0) {
    const std::uint32_t index = root + stack_[--top];
    if (!node_may_touch(index)) continue;
    const Node& node = nodes_[index];
    if (node.solid >= 0) {
      partners.push_back(static_cast<SolidIndex>(node.solid));
    } else {
      stack_[top++] = static_cast<std::uint32_t>(node.right);
      stack_[top++] = static_cast<std::uint32_t>(node.left);
    }
  }
}

}  // namespace touchstone

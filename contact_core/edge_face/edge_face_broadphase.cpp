#include "touchstone/contact_core/edge_face/edge_face_broadphase.hpp"

#include <algorithm>
#include <forward_list>

#include "touchstone/contact_core/broadphase/world_spheres.hpp"

namespace touchstone {
namespace {

class EdgeFaceBroadphase final : public Broadphase {
 public:
  std::string_view name() const noexcept override { return "edge_face"; }

  void build(const BroadphaseInput& input) override {
    SolidTable table = make_solid_table(input);
    std::vector<Object> objects;
    for (std::size_t i = 0; i < input.trees.size(); ++i)
      objects.push_back(make_object(*input.trees[i], table.first_solid[i]));
    objects_ = std::move(objects);
    margin_ = input.margin;
    in_range_.clear();
    reached_ = in_range_.cbegin();
  }

  void update(std::span<const Pose> poses, std::span<const std::uint32_t>) noexcept override {
    in_range_.clear();
    for (Object& object : objects_) place(object, poses);
    for (std::size_t i = 0; i < objects_.size(); ++i)
      for (std::size_t j = i + 1; j < objects_.size(); ++j) list_in_range(objects_[i], 0, objects_[j], 0);
    in_range_.sort();
    reached_ = in_range_.cbegin();
  }

  std::size_t find_pairs(PairCursor& cursor, std::span<SolidPair> block) noexcept override {
    // A list is walked from its start unless the cursor is the one that came last.
    auto at = reached_;
    if (at == in_range_.cend() || *at != cursor.next) at = in_range_.cbegin();
    while (at != in_range_.cend() && *at < cursor.next) ++at;
    std::size_t count = 0;
    for (; at != in_range_.cend() && count < block.size(); ++at) block[count++] = *at;
    reached_ = at;
    cursor.done = at == in_range_.cend();
    if (!cursor.done) cursor.next = *at;
    return count;
  }

 private:
  struct Node {
    double radius;  // about the frame's origin
    std::int32_t left, right;
    std::int32_t solid;  // among all; -1 at an inner node
    Vector3 centre_W;
  };
  struct Object {
    SolidIndex first_solid;
    Vector3 p_SO;             // the object's origin in the frame of its first solid
    std::vector<Node> nodes;  // as in the user's tree
  };

  static Object make_object(const HexahedronTree& tree, SolidIndex first_solid) {
    Object object{first_solid, inverse(tree.solids()[0].X_OS).p, {}};
    for (const HexahedronTree::Node& node : tree.nodes())
      object.nodes.push_back({0.0, node.left, node.right,
                              node.solid < 0 ? -1 : static_cast<std::int32_t>(first_solid) + node.solid,
                              Vector3::Zero()});
    find_radii(tree, 0, object.nodes);
    return object;
  }

  /// @return the radius about the object's frame, which a leaf does not keep.
  static double find_radii(const HexahedronTree& tree, std::int32_t index, std::vector<Node>& nodes) {
    const HexahedronTree::Node& node = tree.nodes()[index];
    if (node.solid < 0)
      return nodes[index].radius =
                 std::max(find_radii(tree, node.left, nodes), find_radii(tree, node.right, nodes));
    const PlacedHexahedron& placed = tree.solids()[node.solid];
    double about_object = 0.0;
    for (const Vector3& vertex_S : placed.solid.vertices()) {
      nodes[index].radius = std::max(nodes[index].radius, norm(vertex_S));
      about_object = std::max(about_object, norm(transform(placed.X_OS, vertex_S)));
    }
    nodes[index].radius += placed.solid.radius();
    return about_object + placed.solid.radius();
  }

  static void place(Object& object, std::span<const Pose> poses) noexcept {
    const Vector3 p_WO = transform(poses[object.first_solid], object.p_SO);
    for (Node& node : object.nodes) node.centre_W = node.solid < 0 ? p_WO : poses[node.solid].p;
  }

  void list_in_range(const Object& object, std::int32_t a, const Object& other, std::int32_t b) noexcept {
    const Node& node = object.nodes[a];
    const Node& node_b = other.nodes[b];
    if (!(norm(node.centre_W - node_b.centre_W) < (node.radius + node_b.radius) + margin_)) return;
    if (node.solid < 0) {
      list_in_range(object, node.left, other, b);
      list_in_range(object, node.right, other, b);
    } else if (node_b.solid < 0) {
      list_in_range(object, a, other, node_b.left);
      list_in_range(object, a, other, node_b.right);
    } else {
      in_range_.push_front({static_cast<SolidIndex>(node.solid), static_cast<SolidIndex>(node_b.solid)});
    }
  }

  std::vector<Object> objects_;
  double margin_ = 0.0;
  std::forward_list<SolidPair> in_range_;
  std::forward_list<SolidPair>::const_iterator reached_ = in_range_.cend();  // where the last block ended
};

}  // namespace

std::unique_ptr<Broadphase> make_edge_face_broadphase() { return std::make_unique<EdgeFaceBroadphase>(); }

void register_edge_face_broadphase(BackendRegistry& registry) {
  registry.add(BackendRegistry::BroadphaseEntry{
      "edge_face", "the paper's: sphere trees of every two objects, in range listed anew each frame",
      [] { return make_edge_face_broadphase(); }});
}

}  // namespace touchstone

#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "touchstone/contact_core/fit/triangle_mesh.hpp"

// Private to this folder.

namespace touchstone::cover_proof {

/// Triangles under a tree of bounding boxes, halved at the middle of their order along the longest side.
class TriangleBoxes {
 public:
  /// @param chosen triangles of the mesh, which must outlive this
  TriangleBoxes(const TriangleMesh& mesh, std::vector<std::uint32_t> chosen);

  Vector3 corner(std::uint32_t triangle, int i) const { return mesh_.vertices[mesh_.triangles[triangle][i]]; }
  /// A point of a triangle, to rounding of its coordinates. The nearest to p, up to blur().
  Vector3 closest(const Vector3& p, std::uint32_t triangle) const;
  /// Squared distance to closest() [m2].
  double squared_distance(const Vector3& p, std::uint32_t triangle) const;
  /// The nearest triangle and the squared distance to it; none: infinite.
  /// @param triangle in: a chosen one to begin with, the sooner found the nearer it is
  double nearest(const Vector3& p, std::uint32_t& triangle) const;
  /// How much farther than the nearest point of a triangle closest() can be: where a triangle is so thin that
  /// rounding turns its normal, its foot of a perpendicular is another [m].
  double blur() const { return blur_; }
  /// Calls `visit` with every triangle whose bounding box meets this one.
  template <class Visit>
  void meeting(const Vector3& low, const Vector3& high, const Visit& visit) const {
    if (!order_.empty()) meeting(0, low, high, visit);
  }

 private:
  struct Node {
    Vector3 low, high;
    std::uint32_t begin, end;
    std::uint32_t right = 0;  ///< the left child is next; 0: a leaf
  };

  void build(std::uint32_t begin, std::uint32_t end);
  void nearest(std::uint32_t node, const Vector3& p, double& best, std::uint32_t& triangle) const;
  template <class Visit>
  void meeting(std::uint32_t index, const Vector3& low, const Vector3& high, const Visit& visit) const {
    const Node& node = nodes_[index];
    for (int axis = 0; axis < 3; ++axis)
      if (node.low(axis) > high(axis) || node.high(axis) < low(axis)) return;
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) visit(order_[i]);
    } else {
      meeting(index + 1, low, high, visit);
      meeting(node.right, low, high, visit);
    }
  }

  const TriangleMesh& mesh_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
  double blur_ = 0.0;
};

}  // namespace touchstone::cover_proof

#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"

namespace touchstone {

/// A box along a frame's axes.
struct AxisBox {
  Vector3 centre = Vector3::Zero();
  Vector3 half = Vector3::Zero();

  static AxisBox around(std::span<const Vector3> points);
  static AxisBox around(const AxisBox& a, const AxisBox& b);
};

/// A turned box in the world.
struct TurnedBox {
  TurnedBox() = default;
  TurnedBox(const AxisBox& box, const Matrix3& R, const Vector3& p_W);

  Vector3 centre_W;
  Matrix3 R, absolute;  ///< its axes in the world, by columns; magnitudes
  Vector3 half;         ///< along its own axes
  Vector3 extent_W;     ///< half sides of the box along the world's axes that encloses it
};

/// False where one of the six faces' directions separates the two by more than `slack`; edges are not looked
/// at.
inline bool may_meet(const AxisBox& a, const TurnedBox& b, double slack) {
  const Vector3 d = a.centre - b.centre_W;
  for (int i = 0; i < 3; ++i)
    if (std::abs(d[i]) > (a.half[i] + b.extent_W[i]) + slack) return false;
  for (int i = 0; i < 3; ++i)
    if (std::abs(dot(b.R.col(i), d)) > (b.half[i] + dot(b.absolute.col(i), a.half)) + slack) return false;
  return true;
}

/// The same, of two turned boxes.
bool may_meet(const TurnedBox& a, const TurnedBox& b, double slack);

/// A binary tree of boxes over obstacles at rest.
class ObstacleTree {
 public:
  /// @param boxes of the obstacles, by index.
  explicit ObstacleTree(std::vector<AxisBox> boxes = {});

  const AxisBox& box(std::uint32_t thing) const { return boxes_[thing]; }

  /// Calls visit(obstacle) for every obstacle that may_meet() the box, in the tree's order, until visit
  /// returns false. Returns whether it never did.
  template <class Visit>
  bool for_each(const TurnedBox& box, double slack, const Visit& visit) const noexcept {
    if (nodes_.empty()) return true;
    std::array<std::uint32_t, kMostLevels> left_over;
    std::size_t count = 0;
    left_over[count++] = 0;
    while (count > 0) {
      const Node& node = nodes_[left_over[--count]];
      if (!may_meet(node.box, box, slack)) continue;
      if (node.thing == kInner) {
        left_over[count++] = node.right;
        left_over[count++] = node.left;
      } else if (!visit(node.thing)) {
        return false;
      }
    }
    return true;
  }

 private:
  static constexpr std::uint32_t kInner = kNoIndex;
  static constexpr std::size_t kMostLevels = 40;  // halves of at most 2^32

  struct Node {
    AxisBox box;
    std::uint32_t thing = kInner;
    std::uint32_t left = 0, right = 0;
  };

  std::uint32_t build(std::span<std::uint32_t> things);

  std::vector<AxisBox> boxes_;
  std::vector<Node> nodes_;
};

}  // namespace touchstone

#include "touchstone/contact_core/mechanism/obstacle_tree.hpp"

#include <algorithm>
#include <numeric>

namespace touchstone {
namespace {

/// A few roundings of a coordinate.
constexpr double kRounding = 0x1p-50;

AxisBox between(const Vector3& low, const Vector3& high) {
  AxisBox box{0.5 * (low + high), 0.5 * (high - low)};
  // The middle and the half are rounded.
  box.half += kRounding * (low.cwiseAbs() + high.cwiseAbs());
  return box;
}

}  // namespace

AxisBox AxisBox::around(std::span<const Vector3> points) {
  Vector3 low = points[0], high = points[0];
  for (const Vector3& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return between(low, high);
}

AxisBox AxisBox::around(const AxisBox& a, const AxisBox& b) {
  return between((a.centre - a.half).cwiseMin(b.centre - b.half),
                 (a.centre + a.half).cwiseMax(b.centre + b.half));
}

TurnedBox::TurnedBox(const AxisBox& box, const Matrix3& R_in, const Vector3& p_W)
    : centre_W(rotate(R_in, box.centre) + p_W),
      R(R_in),
      absolute(R_in.cwiseAbs()),
      half(box.half),
      extent_W(rotate(absolute, box.half)) {}

bool may_meet(const TurnedBox& a, const TurnedBox& b, double slack) {
  const Vector3 d = b.centre_W - a.centre_W;
  for (int i = 0; i < 3; ++i)
    if (std::abs(d[i]) > (a.extent_W[i] + b.extent_W[i]) + slack) return false;
  // Of each side of b's, how long it is along a's axes; and the other way round.
  Matrix3 along;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) along(i, j) = std::abs(dot(a.R.col(i), b.R.col(j)));
  for (int i = 0; i < 3; ++i) {
    const Vector3 row(along(i, 0), along(i, 1), along(i, 2));
    if (std::abs(dot(a.R.col(i), d)) > (a.half[i] + dot(row, b.half)) + slack) return false;
    if (std::abs(dot(b.R.col(i), d)) > (b.half[i] + dot(along.col(i), a.half)) + slack) return false;
  }
  return true;
}

ObstacleTree::ObstacleTree(std::vector<AxisBox> boxes) : boxes_(std::move(boxes)) {
  if (boxes_.empty()) return;
  std::vector<std::uint32_t> things(boxes_.size());
  std::iota(things.begin(), things.end(), 0u);
  nodes_.reserve(2 * boxes_.size());
  build(things);
}

std::uint32_t ObstacleTree::build(std::span<std::uint32_t> things) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  AxisBox all = boxes_[things[0]];
  for (const std::uint32_t thing : things) all = AxisBox::around(all, boxes_[thing]);
  nodes_[index].box = all;
  if (things.size() == 1) {
    nodes_[index].thing = things[0];
    return index;
  }
  int longest = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (all.half[axis] > all.half[longest]) longest = axis;
  const std::size_t middle = things.size() / 2;
  // Ties by index: the tree is the same everywhere.
  std::sort(things.begin(), things.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double x = boxes_[a].centre[longest], y = boxes_[b].centre[longest];
    return x < y || (x == y && a < b);
  });
  const std::uint32_t left = build(things.first(middle));
  const std::uint32_t right = build(things.subspan(middle));
  nodes_[index].left = left, nodes_[index].right = right;
  return index;
}

}  // namespace touchstone

#include "touchstone/adapters/cover_proof/triangle_boxes.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"

#include <algorithm>
#include <utility>

namespace touchstone::cover_proof {
namespace {

Vector3 on_segment(const Vector3& p, const Vector3& a, const Vector3& b) {
  const Vector3 ab = b - a;
  const double length = dot(ab, ab);
  return a + (length > 0.0 ? std::clamp(dot(p - a, ab) / length, 0.0, 1.0) : 0.0) * ab;
}

double squared(const Vector3& v) { return dot(v, v); }

double to_box(const Vector3& p, const Vector3& low, const Vector3& high) {
  double squared = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double off = std::max({low(axis) - p(axis), p(axis) - high(axis), 0.0});
    squared += off * off;
  }
  return squared;
}

}  // namespace

TriangleBoxes::TriangleBoxes(const TriangleMesh& mesh, std::vector<std::uint32_t> chosen)
    : mesh_(mesh), order_(std::move(chosen)) {
  if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()));
  // Within a triangle no point is farther from the edges than the height; rounding turns the normal by the
  // ratio of length to height.
  for (const std::uint32_t t : order_) {
    const Vector3 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
    const double longest = std::max({norm(b - a), norm(c - b), norm(a - c)});
    if (!(longest > 0.0)) continue;
    const double height = norm(cross(b - a, c - a)) / longest;
    if (height > 0.0) blur_ = std::max(blur_, std::min(height, 0x1p-48 * longest * (longest / height)));
  }
}

void TriangleBoxes::build(std::uint32_t begin, std::uint32_t end) {
  const std::size_t self = nodes_.size();
  Vector3 low = Vector3::Constant(1e300), high = -low;
  for (std::uint32_t i = begin; i < end; ++i) {
    for (int c = 0; c < 3; ++c) {
      low = low.cwiseMin(corner(order_[i], c));
      high = high.cwiseMax(corner(order_[i], c));
    }
  }
  nodes_.push_back({low, high, begin, end, 0});
  if (end - begin == 1) return;  // a look at a box costs less than one at a triangle
  int axis = 0;
  for (int other = 1; other < 3; ++other)
    if (high(other) - low(other) > high(axis) - low(axis)) axis = other;
  const std::uint32_t middle = begin + (end - begin) / 2;
  const auto place = [&](std::uint32_t t) {
    return std::pair(corner(t, 0)(axis) + corner(t, 1)(axis) + corner(t, 2)(axis), t);
  };
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
  build(begin, middle);
  nodes_[self].right = static_cast<std::uint32_t>(nodes_.size());
  build(middle, end);
}

// The nearest of the edges' points, and of the foot of the perpendicular where that is in the triangle: by
// its weights, so that it is in it whatever the normal.
Vector3 TriangleBoxes::closest(const Vector3& p, std::uint32_t triangle) const {
  const Vector3 a = corner(triangle, 0), b = corner(triangle, 1), c = corner(triangle, 2);
  const Vector3 n = cross(b - a, c - a);
  const double wa = dot(n, cross(c - b, p - b)), wb = dot(n, cross(a - c, p - c)),
               wc = dot(n, cross(b - a, p - a)), sum = wa + wb + wc;
  Vector3 best = on_segment(p, a, b);
  for (const Vector3& other : {on_segment(p, b, c), on_segment(p, c, a)})
    if (squared(p - other) < squared(p - best)) best = other;
  if (!(wa >= 0.0 && wb >= 0.0 && wc >= 0.0 && sum > 0.0)) return best;
  const Vector3 foot = a + (wb / sum) * (b - a) + (wc / sum) * (c - a);
  return squared(p - foot) < squared(p - best) ? foot : best;
}

double TriangleBoxes::squared_distance(const Vector3& p, std::uint32_t triangle) const {
  return squared(p - closest(p, triangle));
}

double TriangleBoxes::nearest(const Vector3& p, std::uint32_t& triangle) const {
  if (order_.empty()) return kInfinity;
  double best = squared_distance(p, triangle);
  nearest(0, p, best, triangle);
  return best;
}

void TriangleBoxes::nearest(std::uint32_t index, const Vector3& p, double& best,
                            std::uint32_t& triangle) const {
  const Node& node = nodes_[index];
  if (node.right == 0) {
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
      const double squared = squared_distance(p, order_[i]);
      if (squared >= best) continue;
      best = squared;
      triangle = order_[i];
    }
    return;
  }
  std::uint32_t near = index + 1, far = node.right;
  double near_squared = to_box(p, nodes_[near].low, nodes_[near].high);
  double far_squared = to_box(p, nodes_[far].low, nodes_[far].high);
  if (far_squared < near_squared) {
    std::swap(near, far);
    std::swap(near_squared, far_squared);
  }
  if (near_squared < best) nearest(near, p, best, triangle);
  if (far_squared < best) nearest(far, p, best, triangle);
}

}  // namespace touchstone::cover_proof

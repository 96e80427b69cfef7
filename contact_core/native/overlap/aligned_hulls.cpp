#include "touchstone/contact_core/native/overlap/aligned_hulls.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace touchstone::native {
namespace {

struct Interval {
  double low, high;
};

/// Of one hull: the intervals that its coordinates fill, and those of a box that it holds.
struct AlignedHull {
  std::array<Interval, 3> outer, inner;
  bool has_inner;
};

bool meet(const Interval& p, const Interval& q) { return p.low <= q.high && q.low <= p.high; }
bool holds(const Interval& p, double x) { return p.low <= x && x <= p.high; }

const std::array<double, 8>& coordinate(const WorldVertices& v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

AlignedHull align(const WorldVertices& v) {
  AlignedHull out;
  std::array<unsigned, 8> octant{};
  out.has_inner = true;
  for (int axis = 0; axis < 3; ++axis) {
    const std::array<double, 8>& c = coordinate(v, axis);
    Interval outer{c[0], c[0]};
    for (const double x : c) outer = {std::min(outer.low, x), std::max(outer.high, x)};
    const double middle = 0.5 * outer.low + 0.5 * outer.high;
    Interval inner = outer;
    for (int i = 0; i < 8; ++i) {
      const bool is_high = c[i] > middle;
      octant[i] |= (is_high ? 1u : 0u) << axis;
      inner.low = is_high ? inner.low : std::max(inner.low, c[i]);
      inner.high = is_high ? std::min(inner.high, c[i]) : inner.high;
    }
    out.outer[axis] = outer, out.inner[axis] = inner;
    out.has_inner &= inner.low <= inner.high;
  }
  unsigned octants = 0;
  for (const unsigned o : octant) octants |= 1u << o;
  out.has_inner &= octants == 0xff;
  return out;
}

bool holds_a_vertex(const AlignedHull& hull, const WorldVertices& v) {
  for (int i = 0; i < 8; ++i)
    if (holds(hull.inner[0], v.x[i]) && holds(hull.inner[1], v.y[i]) && holds(hull.inner[2], v.z[i]))
      return true;
  return false;
}

/// Half the box's reach along the world's axes. False where an axis of the box is none of them.
bool world_half_extents(const Vector3& half, const Matrix3& R, Vector3& half_W) {
  for (int row = 0; row < 3; ++row) {
    const double x = std::abs(R(row, 0)), y = std::abs(R(row, 1)), z = std::abs(R(row, 2));
    // One entry of magnitude 1 and zeros, not what a sum rounds away: of rotations, that leaves one a column.
    const double second = std::max({std::min(x, y), std::min(y, z), std::min(z, x)});
    if (!(std::max({x, y, z}) == 1.0 && second == 0.0)) return false;
    half_W(row) = (x * half.x() + y * half.y()) + z * half.z();
  }
  return true;
}

}  // namespace

Certified certify_aligned_boxes(const Vector3& half_a, const Pose& X_WA, const Vector3& half_b,
                                const Pose& X_WB) {
  Vector3 a, b;
  if (!world_half_extents(half_a, X_WA.R, a) || !world_half_extents(half_b, X_WB.R, b))
    return Certified::unknown;
  bool meets = true;
  for (int k = 0; k < 3; ++k)
    meets &= meet({X_WA.p(k) - a(k), X_WA.p(k) + a(k)}, {X_WB.p(k) - b(k), X_WB.p(k) + b(k)});
  return meets ? Certified::overlapping : Certified::separated;
}

Certified certify_aligned(const WorldVertices& a_W, const WorldVertices& b_W) {
  const AlignedHull a = align(a_W), b = align(b_W);
  bool outer_meet = true, inner_meet = a.has_inner && b.has_inner;
  for (int axis = 0; axis < 3; ++axis) {
    outer_meet &= meet(a.outer[axis], b.outer[axis]);
    inner_meet &= meet(a.inner[axis], b.inner[axis]);
  }
  if (!outer_meet) return Certified::separated;
  if (inner_meet || (a.has_inner && holds_a_vertex(a, b_W)) || (b.has_inner && holds_a_vertex(b, a_W)))
    return Certified::overlapping;
  return Certified::unknown;
}

}  // namespace touchstone::native

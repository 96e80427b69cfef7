#include "touchstone/contact_core/native/overlap/aligned_hulls.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/contact_core/native/common/lanes.hpp"

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

const std::array<double, 8>& coordinate(const WorldVertices& v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

Interval interval_of(Double2 low, Double2 high) {
  return {std::min(low[0], low[1]), std::max(high[0], high[1])};
}

Interval outer_of(const std::array<double, 8>& c) {
  Double2 low = load(&c[0]), high = low;
  for (int i = 2; i < 8; i += 2) low = least(load(&c[i]), low), high = greatest(load(&c[i]), high);
  return interval_of(low, high);
}

/// @return bit i: vertex i lies above the middle
unsigned align(const std::array<double, 8>& c, Interval& outer, Interval& inner) {
  outer = outer_of(c);
  const Double2 middle = all<Double2>(0.5 * outer.low + 0.5 * outer.high);
  // From the highest of the low vertices to the lowest of the high ones.
  Double2 from = all<Double2>(outer.low), to = all<Double2>(outer.high);
  unsigned above = 0;
  for (int i = 0; i < 8; i += 2) {
    const Double2 p = load(&c[i]);
    const baseline::Mask2 is_high = p > middle;
    from = greatest(is_high ? from : p, from), to = least(is_high ? p : to, to);
    above |= bits(is_high) << i;
  }
  inner = {std::max(from[0], from[1]), std::min(to[0], to[1])};
  return above;
}

AlignedHull align(const WorldVertices& v) {
  AlignedHull out;
  std::array<unsigned, 3> above;
  out.has_inner = true;
  for (int axis = 0; axis < 3; ++axis) {
    above[axis] = align(coordinate(v, axis), out.outer[axis], out.inner[axis]);
    out.has_inner &= out.inner[axis].low <= out.inner[axis].high;
  }
  for (unsigned octant = 0; octant < 8; ++octant) {
    const auto side = [&](int axis) {
      return (octant >> axis & 1u) != 0 ? above[axis] : ~above[axis] & 0xffu;
    };
    out.has_inner &= (side(0) & side(1) & side(2)) != 0;
  }
  return out;
}

/// Whether a line between two vertices, or a vertex, certainly has a point in the hull's inner box: of those
/// that the box's other two intervals hold, one lies at most at the end of an interval, one at least at its
/// start. The line between them keeps to the other two, too.
bool goes_through(const AlignedHull& hull, const WorldVertices& v) {
  std::array<unsigned, 3> below{}, above{};  // a bit for each vertex
  for (int axis = 0; axis < 3; ++axis) {
    const Double2 low = all<Double2>(hull.inner[axis].low), high = all<Double2>(hull.inner[axis].high);
    const std::array<double, 8>& c = coordinate(v, axis);
    for (int i = 0; i < 8; i += 2) {
      const Double2 p = load(&c[i]);
      below[axis] |= bits(p <= high) << i, above[axis] |= bits(low <= p) << i;
    }
  }
  bool out = false;
  for (int axis = 0; axis < 3; ++axis) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    const unsigned beside = below[next] & above[next] & below[last] & above[last];
    out |= (beside & below[axis]) != 0 && (beside & above[axis]) != 0;
  }
  return out;
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

bool are_apart_by_coordinates(const WorldVertices& a_W, const WorldVertices& b_W) {
  bool meet_all = true;
  for (int axis = 0; axis < 3; ++axis)
    meet_all &= meet(outer_of(coordinate(a_W, axis)), outer_of(coordinate(b_W, axis)));
  return !meet_all;
}

Certified certify_aligned(const WorldVertices& a_W, const WorldVertices& b_W) {
  const AlignedHull a = align(a_W), b = align(b_W);
  bool outer_meet = true, inner_meet = a.has_inner && b.has_inner;
  for (int axis = 0; axis < 3; ++axis) {
    outer_meet &= meet(a.outer[axis], b.outer[axis]);
    inner_meet &= meet(a.inner[axis], b.inner[axis]);
  }
  if (!outer_meet) return Certified::separated;
  if (inner_meet || (a.has_inner && goes_through(a, b_W)) || (b.has_inner && goes_through(b, a_W)))
    return Certified::overlapping;
  return Certified::unknown;
}

}  // namespace touchstone::native

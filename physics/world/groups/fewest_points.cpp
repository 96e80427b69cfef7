#include "touchstone/physics/world/groups/fewest_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace touchstone::physics::stepping {
namespace {

constexpr std::size_t kMostKept = 4;
constexpr std::size_t kNone = static_cast<std::size_t>(-1);

using Corners = std::array<std::size_t, kMostKept>;

bool are_of_one_manifold(const GroupPoint& p, const GroupPoint& q) {
  return p.contact->a == q.contact->a && p.contact->b == q.contact->b &&
         p.contact->n_AB_W == q.contact->n_AB_W;
}

/// Of the points, the one with the largest figure above 0; the first of equal ones.
template <class Figure>
std::size_t largest(std::span<const GroupPoint> points, const Figure& figure) {
  std::size_t best = kNone;
  double most = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double value = figure(points[i]);
    if (value > most) most = value, best = i;
  }
  return best;
}

/// Which of a manifold's points are kept; kNone: none.
Corners corners_of(std::span<const GroupPoint> points) {
  const Vector3& n_W = points.front().contact->n_AB_W;
  const auto at = [](const GroupPoint& point) -> const Vector3& { return point.contact->p_A_W; };
  std::size_t deepest = 0;
  const auto separation = [&](std::size_t i) {
    return dot(n_W, points[i].contact->p_B_W - points[i].contact->p_A_W);
  };
  for (std::size_t i = 1; i < points.size(); ++i)
    if (separation(i) < separation(deepest)) deepest = i;
  const Vector3 from_W = at(points[deepest]);
  const auto offset = [&](const GroupPoint& point) -> Vector3 { return at(point) - from_W; };
  const std::size_t farthest =
      largest(points, [&](const GroupPoint& point) { return dot(offset(point), offset(point)); });
  if (farthest == kNone) return {deepest, kNone, kNone, kNone};
  const Vector3 across_W = cross(n_W, offset(points[farthest]));
  return {deepest, farthest,
          largest(points, [&](const GroupPoint& point) { return dot(across_W, offset(point)); }),
          largest(points, [&](const GroupPoint& point) { return -dot(across_W, offset(point)); })};
}

}  // namespace

void keep_fewest(GroupState& group) {
  std::vector<GroupPoint>& points = group.points;
  std::size_t kept = 0;  // before it those that are kept, from it on to the next manifold the others
  for (std::size_t begin = 0, end = 0; begin < points.size(); begin = end) {
    while (end < points.size() && are_of_one_manifold(points[begin], points[end])) ++end;
    const bool are_all_kept = end - begin <= kMostKept;
    const Corners corners =
        are_all_kept ? Corners{} : corners_of(std::span(points).subspan(begin, end - begin));
    for (std::size_t i = begin; i < end; ++i) {
      if (!are_all_kept && std::find(corners.begin(), corners.end(), i - begin) == corners.end()) continue;
      if (kept != i) std::swap(points[kept], points[i]);
      ++kept;
    }
  }
  group.spare.assign(points.begin() + static_cast<std::ptrdiff_t>(kept), points.end());
  points.resize(kept);
}

}  // namespace touchstone::physics::stepping

#include "touchstone/adapters/cover_proof/solid_side.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

namespace touchstone::cover_proof {
namespace {

using Place = std::tuple<double, double, double>;

Place place(const Vector3& p) { return {p.x() + 0.0, p.y() + 0.0, p.z() + 0.0}; }  // -0 is 0

std::size_t root_of(std::vector<std::size_t>& parents, std::size_t i) {
  while (parents[i] != i) i = parents[i] = parents[parents[i]];
  return i;
}

}  // namespace

SolidSide::SolidSide(const TriangleMesh& mesh, const Grid& grid)
    : mesh_(mesh), grid_(grid), boxes_(mesh, closed_triangles()), has_closed_(!closed_triangles().empty()) {}

// Shells are joined at places; a shell is closed when its directed edges cancel.
std::vector<std::uint32_t> SolidSide::closed_triangles() const {
  // Vertices at one place are one, so that shells close over seams.
  std::map<Place, std::size_t> numbers;
  std::vector<std::array<std::size_t, 3>> corners;
  for (const auto& triangle : mesh_.triangles) {
    auto& own = corners.emplace_back();
    for (int i = 0; i < 3; ++i)
      own[i] = numbers.try_emplace(place(mesh_.vertices[triangle[i]]), numbers.size()).first->second;
  }
  // Edges join triangles to shells, and count the walks each way.
  std::vector<std::size_t> parents(numbers.size());
  std::iota(parents.begin(), parents.end(), std::size_t{0});
  std::map<std::pair<std::size_t, std::size_t>, int> turns;
  for (const auto& own : corners) {
    for (int i = 0; i < 3; ++i) {
      const std::size_t a = own[i], b = own[(i + 1) % 3];
      parents[root_of(parents, a)] = root_of(parents, b);
      if (a != b) turns[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  // A shell is closed where every edge is walked as often both ways.
  std::vector<bool> is_open(numbers.size(), false);
  for (const auto& [edge, sum] : turns)
    if (sum != 0) is_open[root_of(parents, edge.first)] = true;
  std::vector<std::uint32_t> closed;
  for (std::size_t t = 0; t < corners.size(); ++t)
    if (!is_open[root_of(parents, corners[t][0])]) closed.push_back(static_cast<std::uint32_t>(t));
  return closed;
}

namespace {

// Sign of the turn a, b, p in the plane across the axis; a and b with w = 1.
int turn(const Point& a, const Point& b, const Point& p, int axis) {
  const auto part = [](const Point& q, int i) -> const mpz_class& {
    return i == 0 ? q.x : i == 1 ? q.y : q.z;
  };
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  return sgn(mpz_class((part(b, u) - part(a, u)) * (part(p, v) - part(a, v) * p.w) -
                       (part(b, v) - part(a, v)) * (part(p, u) - part(a, u) * p.w)));
}

// Height of p over the plane of a, b, c, by its normal (b - a) x (c - a): the sign.
int height_sign(const Point& a, const Point& b, const Point& c, const Point& p) {
  const mpz_class ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z, vx = c.x - a.x, vy = c.y - a.y,
                  vz = c.z - a.z;
  const mpz_class nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
  return sgn(mpz_class(nx * (p.x - a.x * p.w) + ny * (p.y - a.y * p.w) + nz * (p.z - a.z * p.w)));
}

// The sign of a sum of products from its terms' sizes, 0 where rounding may have turned it: 2^-48 of them
// holds the dozen roundings on the way. A product of two that underflows is off by 2^-1075, times a third
// factor of at most 1e70: below 2^-840.
int sure_sign(double value, double size) {
  if (std::abs(value) <= 0x1p-48 * size + 0x1p-800) return 0;
  return value > 0.0 ? 1 : -1;
}

int sure_turn(const Vector3& a, const Vector3& b, const Vector3& p, int axis) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const double left = (b(u) - a(u)) * (p(v) - a(v)), right = (b(v) - a(v)) * (p(u) - a(u));
  return sure_sign(left - right, std::abs(left) + std::abs(right));
}

int sure_height_sign(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& p) {
  const Vector3 u = b - a, v = c - a, d = p - a;
  double value = 0.0, size = 0.0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    value += d(i) * (u(j) * v(k) - u(k) * v(j));
    size += std::abs(d(i)) * (std::abs(u(j) * v(k)) + std::abs(u(k) * v(j)));
  }
  return sure_sign(value, size);
}

// The same as SolidSide::crossing(); nothing where doubles do not tell.
std::optional<int> sure_crossing(const std::array<Vector3, 3>& t, const Vector3& p, int axis,
                                 bool is_upward) {
  const int ab = sure_turn(t[0], t[1], p, axis), bc = sure_turn(t[1], t[2], p, axis);
  if (ab * bc < 0) return 0;
  const int ca = sure_turn(t[2], t[0], p, axis);
  if (ab * ca < 0 || bc * ca < 0) return 0;
  if (ab == 0 || bc == 0 || ca == 0) return std::nullopt;
  const int over = sure_height_sign(t[0], t[1], t[2], p) * ab;
  if (over == 0) return std::nullopt;
  if (is_upward ? over < 0 : over > 0) return is_upward ? ab : -ab;
  return 0;
}

}  // namespace

std::optional<int> SolidSide::crossing(std::uint32_t t, const Point& p, int axis, bool is_upward) const {
  const Point a = grid_.on_grid(boxes_.corner(t, 0)), b = grid_.on_grid(boxes_.corner(t, 1)),
              c = grid_.on_grid(boxes_.corner(t, 2));
  const int ab = turn(a, b, p, axis), bc = turn(b, c, p, axis), ca = turn(c, a, p, axis);
  if ((ab > 0 || bc > 0 || ca > 0) && (ab < 0 || bc < 0 || ca < 0)) return 0;  // the line passes by
  if (ab == 0 || bc == 0 || ca == 0) return std::nullopt;
  // Seen along the axis the triangle turns as its normal's part there has its sign; p before it is below.
  const int facing = ab, over = height_sign(a, b, c, p) * facing;
  if (is_upward ? over < 0 : over > 0) return is_upward ? facing : -facing;
  return 0;
}

std::optional<int> SolidSide::winding_beyond(const Point& p, int axis, bool is_upward) const {
  const Vector3 near = grid_.to_metres(p);
  const Vector3 slack = 0x1p-40 * near.cwiseAbs() + Vector3::Constant(0x1p-1000);
  Vector3 low = near - slack, high = near + slack;
  (is_upward ? high : low)(axis) = is_upward ? 1e300 : -1e300;
  std::optional<int> winding = 0;
  boxes_.meeting(low, high, [&](std::uint32_t t) {
    if (!winding) return;
    const std::optional<int> each = crossing(t, p, axis, is_upward);
    winding = each ? std::optional<int>(*winding + *each) : std::nullopt;
  });
  return winding;
}

std::optional<int> SolidSide::winding_beyond(const Vector3& p, int axis, bool is_upward) const {
  Vector3 low = p, high = p;
  (is_upward ? high : low)(axis) = is_upward ? 1e300 : -1e300;
  std::optional<int> winding = 0;
  std::optional<Point> exact;
  boxes_.meeting(low, high, [&](std::uint32_t t) {
    if (!winding) return;
    std::optional<int> each =
        sure_crossing({boxes_.corner(t, 0), boxes_.corner(t, 1), boxes_.corner(t, 2)}, p, axis, is_upward);
    if (!each) {
      if (!exact) exact = grid_.on_grid(p);
      each = crossing(t, *exact, axis, is_upward);
    }
    winding = each ? std::optional<int>(*winding + *each) : std::nullopt;
  });
  return winding;
}

std::vector<Polygon> SolidSide::uncrossed(const Polygon& piece, const FacetPlane& facet) const {
  Vector3 low = grid_.to_metres(piece.front()), high = low;
  for (const Point& p : piece) {
    low = low.cwiseMin(grid_.to_metres(p));
    high = high.cwiseMax(grid_.to_metres(p));
  }
  const Vector3 slack = 0x1p-40 * low.cwiseAbs().cwiseMax(high.cwiseAbs()) + Vector3::Constant(0x1p-1000);
  std::vector<Polygon> parts{piece};
  boxes_.meeting(low - slack, high + slack, [&](std::uint32_t t) {
    bool is_above = false, is_on_or_below = false;
    for (int i = 0; i < 3; ++i)
      (side(facet, boxes_.corner(t, i), grid_) > 0 ? is_above : is_on_or_below) = true;
    if (is_above && is_on_or_below)
      divide(parts, facet,
             {grid_.on_grid(boxes_.corner(t, 0)), grid_.on_grid(boxes_.corner(t, 1)),
              grid_.on_grid(boxes_.corner(t, 2))});
  });
  return parts;
}

std::optional<int> SolidSide::winding_about(const Vector3& p) const {
  for (int axis = 0; axis < 3; ++axis)
    for (const bool is_upward : {true, false})
      if (const std::optional<int> winding = winding_beyond(p, axis, is_upward)) return winding;
  return std::nullopt;
}

bool SolidSide::is_before(std::uint32_t triangle, const Vector3& p) const {
  return sure_height_sign(boxes_.corner(triangle, 0), boxes_.corner(triangle, 1), boxes_.corner(triangle, 2),
                          p) > 0;
}

namespace {

// Whether all are in one plane across an axis.
bool is_level(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& p) {
  for (int axis = 0; axis < 3; ++axis)
    if (p(axis) == a(axis) && p(axis) == b(axis) && p(axis) == c(axis)) return true;
  return false;
}

}  // namespace

bool SolidSide::is_all_on(std::uint32_t plane, std::uint32_t triangle, int sign) const {
  const Vector3 a = boxes_.corner(plane, 0), b = boxes_.corner(plane, 1), c = boxes_.corner(plane, 2);
  for (int i = 0; i < 3; ++i) {
    const Vector3 p = boxes_.corner(triangle, i);
    if (p == a || p == b || p == c || is_level(a, b, c, p)) continue;  // on it
    int height = sure_height_sign(a, b, c, p);
    if (height == 0)
      height = height_sign(grid_.on_grid(a), grid_.on_grid(b), grid_.on_grid(c), grid_.on_grid(p));
    if (height * sign < 0) return false;
  }
  return true;
}

namespace {

// Whether an edge of the triangle, which turns as `facing` says, has all of the other one on its outer side
// or on it.
bool has_beside(const std::array<Point, 3>& triangle, const std::array<Point, 3>& other, int facing,
                int axis) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Point &a = triangle[i], &b = triangle[(i + 1) % 3];
    if (std::all_of(other.begin(), other.end(),
                    [&](const Point& p) { return turn(a, b, p, axis) * facing <= 0; }))
      return true;
  }
  return false;
}

}  // namespace

bool SolidSide::may_be_passed_at_once(std::uint32_t first, std::uint32_t second) const {
  if (!is_all_on(first, second, 1) || !is_all_on(first, second, -1)) return false;
  std::array<Point, 3> a, b;
  for (int i = 0; i < 3; ++i) {
    a[static_cast<std::size_t>(i)] = grid_.on_grid(boxes_.corner(first, i));
    b[static_cast<std::size_t>(i)] = grid_.on_grid(boxes_.corner(second, i));
  }
  // They are seen along an axis along which both have an area.
  for (int axis = 0; axis < 3; ++axis) {
    const int facing = turn(a[0], a[1], a[2], axis), other = turn(b[0], b[1], b[2], axis);
    if (facing == 0 || other == 0) continue;
    return facing == other && !has_beside(a, b, facing, axis) && !has_beside(b, a, facing, axis);
  }
  return true;  // one has no area, and so no plane
}

bool SolidSide::is_inside(const Vector3& p, double clearance) const {
  constexpr std::array<std::array<double, 3>, 5> kOffsets = {
      {{0, 0, 0}, {0.21, 0.13, -0.31}, {-0.17, 0.29, 0.11}, {0.07, -0.23, 0.19}, {-0.27, -0.09, -0.15}}};
  for (const auto& offset : kOffsets) {
    const Vector3 q = p + clearance * Vector3(offset[0], offset[1], offset[2]);
    if (const std::optional<int> winding = winding_about(q)) return *winding != 0;
  }
  return false;  // not known: the proof looks at smaller pieces
}

}  // namespace touchstone::cover_proof

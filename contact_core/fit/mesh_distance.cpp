#include "touchstone/contact_core/fit/mesh_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "touchstone/contact_core/geometry/norms.hpp"

namespace touchstone {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;
constexpr int kDeepest = 64;
constexpr double kEndless = 1e300;
constexpr double kOnSurface = 1e-9;  // of the largest coordinate: nearer, rounding may decide on the side
constexpr double kEdge = 1e-9;       // of the triangle: nearer to an edge another ray is asked

// From the point of a triangle that is nearest to p to p: the region of the plane that p projects into
// decides (Ericson, Real-Time Collision Detection, 5.1.5). Triangles without area end in the cases of their
// edges, those of which two corners are one in that of the edge that is left.
Vector3 offset_from(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return ap;
  const Vector3 bp = p - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return bp;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3) return ap - ab * (d1 / (d1 - d3));
  const Vector3 cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return cp;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6) return ap - ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return bp - (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const double scale = 1.0 / (va + vb + vc);
  return ap - ab * (vb * scale) - ac * (vc * scale);
}

double squared_distance(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 offset = offset_from(p, a, b, c);
  return dot(offset, offset);
}

// Whether the axis has the two on different sides, `room` between them.
bool is_between(const Vector3& axis, const std::array<Vector3, 4>& t, const std::array<Vector3, 3>& u,
                double room) {
  double t_low = 1e300, t_high = -1e300, u_low = 1e300, u_high = -1e300;
  for (const Vector3& p : t) {
    const double at = dot(axis, p - t[0]);
    t_low = std::min(t_low, at);
    t_high = std::max(t_high, at);
  }
  for (const Vector3& p : u) {
    const double at = dot(axis, p - t[0]);
    u_low = std::min(u_low, at);
    u_high = std::max(u_high, at);
  }
  const double gap = std::max(u_low - t_high, t_low - u_high);
  return gap > 0.0 && gap > room * norm(axis);
}

// As the box about the tetrahedron tells, and the axes of both.
bool are_apart(const std::array<Vector3, 4>& t, const Bounds& box, const std::array<Vector3, 3>& u,
               double room) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::min({u[0][axis], u[1][axis], u[2][axis]}) > box.high[axis] + room) return true;
    if (std::max({u[0][axis], u[1][axis], u[2][axis]}) < box.low[axis] - room) return true;
  }
  constexpr std::array<std::array<int, 3>, 4> kFaces = {{{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}}};
  if (is_between(cross(u[1] - u[0], u[2] - u[0]), t, u, room)) return true;
  for (const auto& f : kFaces)
    if (is_between(cross(t[f[1]] - t[f[0]], t[f[2]] - t[f[0]]), t, u, room)) return true;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j)
      for (int k = 0; k < 3; ++k)
        if (is_between(cross(t[j] - t[i], u[(k + 1) % 3] - u[k]), t, u, room)) return true;
  return false;
}

// The same of a box, as far as the axes of both, and the triangle's normal, tell.
bool are_apart(const Bounds& box, const std::array<Vector3, 3>& u, double room) {
  const Vector3 low = u[0].cwiseMin(u[1]).cwiseMin(u[2]), high = u[0].cwiseMax(u[1]).cwiseMax(u[2]);
  if ((low - box.high).maxCoeff() > room || (box.low - high).maxCoeff() > room) return true;
  const Vector3 middle = 0.5 * (box.low + box.high), half = 0.5 * (box.high - box.low);
  const auto is_apart_along = [&](const Vector3& axis) {
    const double a = dot(axis, u[0] - middle), b = dot(axis, u[1] - middle), c = dot(axis, u[2] - middle);
    const double reach = dot(axis.cwiseAbs(), half) + room * norm(axis);
    return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
  };
  if (is_apart_along(cross(u[1] - u[0], u[2] - u[0]))) return true;
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 3; ++i)
      if (is_apart_along(cross(Vector3(Vector3::Unit(i)), u[(k + 1) % 3] - u[k]))) return true;
  return false;
}

double squared_distance(const Vector3& p, const Vector3& low, const Vector3& high) {
  const Vector3 out = (low - p).cwiseMax(p - high).cwiseMax(0.0);
  return dot(out, out);
}

bool ray_meets(const Vector3& p, const Vector3& inverse, double length, const Vector3& low,
               const Vector3& high) {
  double begin = 0.0, end = length;
  for (int axis = 0; axis < 3; ++axis) {
    const double t0 = (low(axis) - p(axis)) * inverse(axis), t1 = (high(axis) - p(axis)) * inverse(axis);
    begin = std::max(begin, std::min(t0, t1));
    end = std::min(end, std::max(t0, t1));
  }
  return begin <= end * (1.0 + 1e-12) + 1e-300;
}

}  // namespace

MeshDistance::MeshDistance(const TriangleMesh& mesh) : mesh_(mesh), shells_(find_shells(mesh)) {
  for (const auto& triangle : mesh_.triangles)
    for (const std::uint32_t corner : triangle) bounds_.add(mesh_.vertices[corner]);
  largest_coordinate_ = std::max(norm_inf(bounds_.low), norm_inf(bounds_.high));
  has_closed_ = std::find(shells_.is_closed.begin(), shells_.is_closed.end(), 1) != shells_.is_closed.end();
  order_.resize(mesh_.triangles.size());
  std::iota(order_.begin(), order_.end(), 0U);
  nodes_.emplace_back();
  split(0, 0, static_cast<std::uint32_t>(order_.size()));
  for (const std::uint32_t t : order_) {
    const auto& i = mesh_.triangles[t];
    const Vector3 &a = mesh_.vertices[i[0]], &b = mesh_.vertices[i[1]], &c = mesh_.vertices[i[2]];
    const bool is_closed = shells_.is_closed[shells_.shell_of_triangle[t]] != 0;
    corners_.push_back({a, b, c, is_closed ? kEdge * (norm(b - a) * norm(c - a)) : 0.0});
  }
}

void MeshDistance::split(std::uint32_t node, std::uint32_t begin, std::uint32_t end) {
  Bounds box, centres;
  const auto centre = [&](std::uint32_t t) {
    const auto& i = mesh_.triangles[t];
    return Vector3((mesh_.vertices[i[0]] + mesh_.vertices[i[1]] + mesh_.vertices[i[2]]) / 3.0);
  };
  // The node's box holds its triangles.
  for (std::uint32_t i = begin; i < end; ++i) {
    for (const std::uint32_t corner : mesh_.triangles[order_[i]]) box.add(mesh_.vertices[corner]);
    centres.add(centre(order_[i]));
  }
  nodes_[node].low = box.low;
  nodes_[node].high = box.high;
  // Few triangles make a leaf.
  if (end - begin <= kLeafTriangles) {
    nodes_[node].first = begin;
    nodes_[node].count = end - begin;
    return;
  }
  // More are halved at the median of their centres, along the longest axis.
  Eigen::Index axis = 0;
  (centres.high - centres.low).maxCoeff(&axis);
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double ca = centre(a)(axis), cb = centre(b)(axis);
                     return ca != cb ? ca < cb : a < b;
                   });
  // Both halves become nodes, one after the other.
  const auto left = static_cast<std::uint32_t>(nodes_.size());
  nodes_[node].first = left;
  nodes_.resize(nodes_.size() + 2);
  split(left, begin, middle);
  split(left + 1, middle, end);
}

MeshDistance::Nearest MeshDistance::nearest_within(const Vector3& p, Nearest known) const {
  struct Open {
    double squared;
    std::uint32_t node;
  };
  // Nodes are searched depth first.
  std::array<Open, kDeepest> stack{};
  int size = 0;
  double best = known.distance * known.distance;
  std::uint32_t triangle = known.triangle;
  stack[size++] = {0.0, 0};
  while (size > 0) {
    const Open open = stack[--size];
    if (open.squared >= best) continue;
    const Node& node = nodes_[open.node];
    // A leaf compares its triangles.
    for (std::uint32_t i = 0; i < node.count; ++i) {
      const Corners& t = corners_[node.first + i];
      // The box about it is sooner known to be too far.
      const Vector3 low = t.a.cwiseMin(t.b).cwiseMin(t.c), high = t.a.cwiseMax(t.b).cwiseMax(t.c);
      if (squared_distance(p, low, high) >= best) continue;
      const double squared = squared_distance(p, t.a, t.b, t.c);
      if (squared >= best) continue;
      best = squared;
      triangle = order_[node.first + i];
    }
    if (node.count > 0) continue;
    // The nearer child goes on top of the stack.
    Open left{squared_distance(p, nodes_[node.first].low, nodes_[node.first].high), node.first};
    Open right{squared_distance(p, nodes_[node.first + 1].low, nodes_[node.first + 1].high), node.first + 1};
    if (left.squared < right.squared) std::swap(left, right);
    stack[size++] = left;
    stack[size++] = right;
  }
  return {std::sqrt(best), triangle};
}

bool MeshDistance::is_near(const Vector3& p, double distance) const {
  const double most = distance * distance;
  std::array<std::uint32_t, kDeepest> stack{};
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const Node& node = nodes_[stack[--size]];
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
      if (squared_distance(p, corners_[i].a, corners_[i].b, corners_[i].c) <= most) return true;
    if (node.count > 0) continue;
    // The nearer child goes on top of the stack, as it is likelier to have such a triangle.
    const double left = squared_distance(p, nodes_[node.first].low, nodes_[node.first].high),
                 right = squared_distance(p, nodes_[node.first + 1].low, nodes_[node.first + 1].high);
    const bool is_left_first = left <= right;
    if ((is_left_first ? right : left) <= most) stack[size++] = node.first + (is_left_first ? 1 : 0);
    if ((is_left_first ? left : right) <= most) stack[size++] = node.first + (is_left_first ? 0 : 1);
  }
  return false;
}

double MeshDistance::to_triangle(const Vector3& p, std::uint32_t triangle) const {
  const auto& i = mesh_.triangles[triangle];
  return std::sqrt(squared_distance(p, mesh_.vertices[i[0]], mesh_.vertices[i[1]], mesh_.vertices[i[2]]));
}

Vector3 MeshDistance::closest_on(const Vector3& p, std::uint32_t triangle) const {
  const auto& i = mesh_.triangles[triangle];
  return p - offset_from(p, mesh_.vertices[i[0]], mesh_.vertices[i[1]], mesh_.vertices[i[2]]);
}

// Triangles of the leaves that meet the box, until one is refused. @return whether none was
template <class Accepts>
bool MeshDistance::all_near(const Bounds& box, double room, const Accepts& accepts) const {
  std::array<std::uint32_t, kDeepest> stack{};
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const Node& node = nodes_[stack[--size]];
    if ((node.low - box.high).maxCoeff() > room || (box.low - node.high).maxCoeff() > room) continue;
    if (node.count == 0) {
      stack[size++] = node.first;
      stack[size++] = node.first + 1;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
      if (!accepts(corners_[i])) return false;
  }
  return true;
}

namespace {

// A triangle and its plane, for what is surely on one side of it.
struct Facing {
  std::array<Vector3, 3> corners;
  Vector3 normal;  // unit; zero: no area
  double unsure;   // a height within this may have either sign [m]

  double above(const Vector3& p) const { return dot(normal, p - corners[0]); }
  bool has_corner(const Vector3& p) const { return p == corners[0] || p == corners[1] || p == corners[2]; }
  // All of another triangle, some of it off the plane: corners that are this one's, too, are on it.
  bool has_all(const Facing& other, double side) const {
    bool is_off = false;
    for (const Vector3& p : other.corners) {
      if (has_corner(p)) continue;
      if (!(side * above(p) > unsure)) return false;
      is_off = true;
    }
    return is_off;
  }
};

// Rounding turns the normal by some roundings of its edges' product over the area, and so moves the height.
Facing facing_of(const std::array<Vector3, 3>& corners, double room) {
  const Vector3 u = corners[1] - corners[0], v = corners[2] - corners[0], across = cross(u, v);
  const double area = norm(across);
  if (!(area > 0.0)) return {corners, Vector3::Zero(), 0.0};
  return {corners, across / area, room * (1.0 + norm(u) * norm(v) / area)};
}

// The walks along a common edge are opposite, as of neighbours on one surface.
bool share_an_edge(const Facing& one, const Facing& other) {
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k)
      if (one.corners[i] == other.corners[(k + 1) % 3] && one.corners[(i + 1) % 3] == other.corners[k])
        return true;
  return false;
}

// Both in one plane across an axis, exactly, where an edge of one surely has all of the other beside it.
bool lie_beside_in_a_plane(const Facing& one, const Facing& other) {
  const auto is_flat = [&](int axis) {
    const double at = one.corners[0][axis];
    const auto is_at = [&](const Vector3& p) { return p[axis] == at; };
    return std::all_of(one.corners.begin(), one.corners.end(), is_at) &&
           std::all_of(other.corners.begin(), other.corners.end(), is_at);
  };
  int axis = 0;
  while (axis < 3 && !is_flat(axis)) ++axis;
  if (axis == 3) return false;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const auto is_beside = [&](const Facing& of, const Vector3& a, const Vector3& b, const Vector3& p) {
    if (p == a || p == b) return true;
    const double left = (b[u] - a[u]) * (p[v] - a[v]), right = (b[v] - a[v]) * (p[u] - a[u]);
    // Two differences and a product each, and a difference: 4 roundings, with room.
    return (of.normal[axis] > 0.0 ? right - left : left - right) >
           0x1p-50 * (std::abs(left) + std::abs(right)) + 0x1p-1000;
  };
  const auto has_beside = [&](const Facing& of, const Facing& all) {
    for (std::size_t i = 0; i < 3; ++i)
      if (std::all_of(all.corners.begin(), all.corners.end(), [&](const Vector3& p) {
            return is_beside(of, of.corners[i], of.corners[(i + 1) % 3], p);
          }))
        return true;
    return false;
  };
  return has_beside(one, other) || has_beside(other, one);
}

// Whether no straight way passes both from back to front. Of neighbours at an edge the one has the other
// behind it, or the other has the one in front, or both lie in one plane and beside each other; so it is
// whichever way rounding turns them.
bool exclude_each_other(const Facing& one, const Facing& other) {
  if (share_an_edge(one, other) || lie_beside_in_a_plane(one, other)) return true;
  const bool one_first = one.has_all(other, -1.0) || other.has_all(one, 1.0);
  return one_first && (other.has_all(one, -1.0) || one.has_all(other, 1.0));
}

// Of triangles that do not surely show a point their front: each group has one at most that a straight way
// from the point passes from back to front.
int groups_of_backs(const Vector3& from, std::span<const Facing> met) {
  constexpr std::size_t kMostBacks = 24;
  std::array<std::pair<const Facing*, int>, kMostBacks> backs;
  std::size_t count = 0;
  int groups = 0;
  for (const Facing& back : met) {
    const bool has_area = back.normal != Vector3::Zero();
    if (has_area && back.above(from) > back.unsure) continue;
    // It joins the first group all of which it excludes; one without area none.
    const auto fits = [&](int group) {
      return std::all_of(
          backs.begin(), backs.begin() + static_cast<std::ptrdiff_t>(count),
          [&](const auto& other) { return other.second != group || exclude_each_other(back, *other.first); });
    };
    int joined = has_area ? 0 : groups;
    while (joined < groups && !fits(joined)) ++joined;
    groups = std::max(groups, joined + 1);
    backs[count++] = {&back, joined};
  }
  return groups;
}

// Whether a point is so near to a triangle that rounding may count it on either side.
bool may_be_on(const Facing& t, const Vector3& p) {
  const Vector3 low = t.corners[0].cwiseMin(t.corners[1]).cwiseMin(t.corners[2]);
  const Vector3 high = t.corners[0].cwiseMax(t.corners[1]).cwiseMax(t.corners[2]);
  return std::abs(t.above(p)) <= t.unsure && (low - p).maxCoeff() <= t.unsure &&
         (p - high).maxCoeff() <= t.unsure;
}

}  // namespace

bool MeshDistance::is_solid(const std::array<Vector3, 4>& tetrahedron, const Known& near) const {
  constexpr std::size_t kMostMet = 24;  // of more triangles a part is looked at
  constexpr int kMostBacks = 2;         // more shells hardly lie in each other
  Bounds box;
  for (const Vector3& p : tetrahedron) box.add(p);
  const double room = 0x1p-46 * largest_coordinate_;
  std::array<Facing, kMostMet> met;
  std::size_t count = 0;
  const bool are_few = all_near(box, room, [&](const Corners& t) {
    if (are_apart(tetrahedron, box, {t.a, t.b, t.c}, room)) return true;
    if (count == kMostMet) return false;
    met[count++] = facing_of({t.a, t.b, t.c}, room);
    return true;
  });
  if (!are_few) return false;
  // Its middle and its corners are asked in turn, unless they are on a wall.
  const std::span<const Facing> walls = std::span<const Facing>(met).first(count);
  const Vector3 middle = 0.25 * ((tetrahedron[0] + tetrahedron[1]) + (tetrahedron[2] + tetrahedron[3]));
  if (count == 0) return winding_near(near, middle) != 0;
  for (const Vector3& from : {middle, tetrahedron[0], tetrahedron[1], tetrahedron[2], tetrahedron[3]}) {
    if (std::any_of(walls.begin(), walls.end(), [&](const Facing& wall) { return may_be_on(wall, from); }))
      continue;
    const int backs = groups_of_backs(from, walls);
    if (backs > kMostBacks) continue;
    const std::optional<int> winding = winding_about(from, near);
    if (winding && *winding > backs) return true;
  }
  return false;
}

// A wall without a rim in the box: the other triangle at an edge in the box is one of these, turned alike and
// so on the edge's other side.
bool MeshDistance::is_one_wall(const Bounds& box, const Plane& plane, double room) const {
  double turn = 0.0;
  const bool is_wall = all_near(box, room, [&](const Corners& t) {
    if (are_apart(box, {t.a, t.b, t.c}, room)) return true;
    if (t.edge == 0.0) return false;
    for (const Vector3& p : {t.a, t.b, t.c})
      if (std::abs(plane.signed_distance(p)) > room) return false;
    const double along = dot(cross(t.b - t.a, t.c - t.a), plane.normal);
    if (along == 0.0 || along * turn < 0.0) return false;
    turn = along;
    return true;
  });
  return is_wall && turn != 0.0;
}

bool MeshDistance::count_crossings(const Vector3& p, const Vector3& direction, double length,
                                   int& winding) const {
  const Vector3 inverse = direction.cwiseInverse();
  // Nodes that the way meets are opened.
  std::array<std::uint32_t, kDeepest> stack{};
  int size = 0;
  stack[size++] = 0;
  winding = 0;
  while (size > 0) {
    const Node& node = nodes_[stack[--size]];
    if (!ray_meets(p, inverse, length, node.low, node.high)) continue;
    if (node.count == 0) {
      stack[size++] = node.first;
      stack[size++] = node.first + 1;
      continue;
    }
    // Triangles that the way crosses count by their side; one near an edge decides nothing.
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const Corners& t = corners_[i];
      if (t.edge == 0.0) continue;
      const Vector3 ab = t.b - t.a, ac = t.c - t.a, h = cross(direction, ac), ap = p - t.a;
      const double det = dot(ab, h), sign = det < 0.0 ? -1.0 : 1.0, u = sign * dot(ap, h);
      if (u < -t.edge) continue;
      const Vector3 q = cross(ap, ab);
      const double v = sign * dot(direction, q), w = std::abs(det) - u - v;
      const double lowest = std::min({u, v, w}), along = dot(ac, q);
      if (lowest < -t.edge) continue;
      if (std::abs(det) <= t.edge || lowest <= t.edge) return false;
      if (sign * along > 0.0 && sign * along < length * std::abs(det)) winding += det < 0.0 ? 1 : -1;
    }
  }
  return true;
}

int MeshDistance::winding(const Vector3& p) const {
  if (!has_closed_ || (p - bounds_.low).minCoeff() < 0.0 || (bounds_.high - p).minCoeff() < 0.0) return 0;
  return winding_about(p).value_or(0);
}

int MeshDistance::winding_near(const Known& known, const Vector3& p) const {
  if (!has_closed_) return 0;
  return winding_about(p, known).value_or(0);
}

std::optional<int> MeshDistance::winding_about(const Vector3& p, const Known& near) const {
  const Vector3 way = near.p - p;
  const double length = norm(way);
  if (near.distance > length * (1.0 + 1e-9)) return near.winding;
  int more = 0;
  if (near.distance > kOnSurface * largest_coordinate_ && way.cwiseAbs().minCoeff() > 0.0 &&
      count_crossings(p, way / length, length, more))
    return near.winding + more;
  if ((p - bounds_.low).minCoeff() < 0.0 || (bounds_.high - p).minCoeff() < 0.0) return 0;
  return winding_about(p);
}

std::optional<int> MeshDistance::winding_about(const Vector3& p) const {
  // Directions without a pattern, the first towards the nearest side; one that meets no edge decides.
  Eigen::Index low_axis = 0, high_axis = 0;
  const double to_low = (p - bounds_.low).minCoeff(&low_axis);
  const double to_high = (bounds_.high - p).minCoeff(&high_axis);
  const Eigen::Index axis = to_low < to_high ? low_axis : high_axis;
  Vector3 direction(0.1417, 0.1417, 0.1417);
  direction((axis + 1) % 3) = 0.1171;
  direction(axis) = to_low < to_high ? -0.9829 : 0.9829;
  int winding = 0;
  for (int attempt = 0; attempt < 40; ++attempt) {
    if (count_crossings(p, direction, kEndless, winding)) return winding;
    direction = Vector3(direction.y() * 1.137 - 0.319 * direction.z(), direction.z() + 0.271 * direction.x(),
                        direction.x() - 0.613 * direction.y());
    direction /= norm(direction);
  }
  return std::nullopt;
}

double MeshDistance::signed_distance(const Vector3& p) const {
  const double distance = nearest(p).distance;
  return is_inside(p) ? -distance : distance;
}

double MeshDistance::to_solid(const Vector3& p) const { return is_inside(p) ? 0.0 : nearest(p).distance; }

}  // namespace touchstone

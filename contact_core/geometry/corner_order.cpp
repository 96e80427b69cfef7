#include "touchstone/contact_core/geometry/corner_order.hpp"

#include <algorithm>
#include <utility>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/orientation.hpp"

namespace touchstone {
namespace {

constexpr int kPoints = Hexahedron::kVertices;

// True if the plane through i, j, k has all points on one side. No plane (collinear points) has: the points
// are not all in one.
bool supports_hull(const Corners& points, int i, int j, int k) {
  bool above = false, below = false;
  for (const Vector3& p : points) {
    const int side = numerics::orient3d_sign(points[i], points[j], points[k], p);
    above = above || side > 0;
    below = below || side < 0;
  }
  return above != below;
}

// The three faces at vertex 0 as sets of points, sorted, and its three neighbours named after them: which
// neighbours the points get does not depend on the order in which cubes are tried.
CornerOrder named_by_faces(const CornerOrder& cube) {
  struct Face {
    std::array<int, 4> points;
    int opposite;  // the neighbour of vertex 0 that is not on it
  };
  std::array<Face, 3> faces = {{{{cube[0], cube[2], cube[1], cube[3]}, cube[4]},
                                {{cube[0], cube[4], cube[1], cube[5]}, cube[2]},
                                {{cube[0], cube[4], cube[2], cube[6]}, cube[1]}}};
  for (Face& face : faces) std::sort(face.points.begin(), face.points.end());
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.points < b.points; });
  const auto holds = [](const Face& face, int point) {
    return std::find(face.points.begin(), face.points.end(), point) != face.points.end();
  };
  CornerOrder named{};
  for (int point : cube) {
    int bits = 0;
    for (int axis = 0; axis < 3; ++axis)
      if (!holds(faces[axis], point)) bits |= 4 >> axis;
    named[bits] = point;
  }
  return named;
}

// Calls `visit` with every cube that has point 0 as vertex 0 and p, q, r as its neighbours.
template <class Visit>
void visit_cubes(int p, int q, int r, Visit visit) {
  std::array<int, 4> rest{};
  for (int i = 1, found = 0; i < kPoints; ++i)
    if (i != p && i != q && i != r) rest[found++] = i;
  do {
    visit(CornerOrder{0, r, q, rest[0], p, rest[1], rest[2], rest[3]});
  } while (std::next_permutation(rest.begin(), rest.end()));
}

}  // namespace

Corners in_order(const Corners& points, const CornerOrder& order) {
  Corners out;
  for (int i = 0; i < kPoints; ++i) out[i] = points[order[i]];
  return out;
}

HullEdges hull_edges(const Corners& points) {
  HullEdges hull;
  const auto join = [&hull](int i, int j) {
    hull.to[i] |= static_cast<std::uint8_t>(1 << j);
    hull.to[j] |= static_cast<std::uint8_t>(1 << i);
  };
  for (int i = 0; i < kPoints; ++i) {
    for (int j = i + 1; j < kPoints; ++j) {
      for (int k = j + 1; k < kPoints; ++k) {
        if (!supports_hull(points, i, j, k)) continue;
        join(i, j), join(j, k), join(i, k);
        hull.on_hull |= static_cast<std::uint8_t>(1 << i | 1 << j | 1 << k);
      }
    }
  }
  for (int i = 0; i < kPoints; ++i)
    for (int j = i + 1; j < kPoints; ++j)
      if (points[i] == points[j]) join(i, j), hull.coincident = true;
  return hull;
}

bool fits_hull(const HullEdges& hull, const CornerOrder& order) {
  for (const auto& [start, end] : Hexahedron::kEdgeVertices)
    if (!hull.has(order[start], order[end])) return false;
  return std::all_of(Hexahedron::kFaceVertices.begin(), Hexahedron::kFaceVertices.end(), [&](const auto& v) {
    return hull.has(order[v[0]], order[v[2]]) || hull.has(order[v[1]], order[v[3]]);
  });
}

FlattestOrder flattest_order(const Corners& points, const HullEdges& hull) {
  FlattestOrder out;
  const auto take = [&](const CornerOrder& cube) {
    if (!fits_hull(hull, cube)) return;
    const double bend = largest_bend(in_order(points, cube));
    out.next_bend = std::min(out.next_bend, std::max(bend, out.bend));
    if (bend < out.bend) out.order = cube, out.bend = bend;
  };
  for (int p = 1; p < kPoints; ++p)
    for (int q = p + 1; q < kPoints; ++q)
      for (int r = q + 1; r < kPoints; ++r) visit_cubes(p, q, r, take);
  if (out.bend < kInfinity) out.order = named_by_faces(out.order);
  return out;
}

}  // namespace touchstone

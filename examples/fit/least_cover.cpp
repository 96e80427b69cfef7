#include "touchstone/examples/fit/least_cover.hpp"

#include <algorithm>
#include <array>
#include <bitset>
#include <utility>
#include <vector>

#include "touchstone/examples/fit/samples.hpp"

namespace touchstone::fitting {
namespace {

constexpr std::size_t kVertices = 128, kOnEdges = 96, kInZones = 128;  // in zones
constexpr std::size_t kOtherVertices = 64, kAnywhere = 48;
constexpr std::size_t kDraws = 200'000;  // to find those in zones
constexpr unsigned kParts = 16;          // of a segment, whose ends are looked at
constexpr double kRounding = 0x1p-40;    // of the largest coordinate: more than points and distances are off

using Others = std::bitset<kVertices + kOnEdges + kInZones + kOtherVertices + kAnywhere>;

// `inside` by this much [m].
bool is_in(std::span<const Bounds> zones, const Vector3& p, double inside) {
  return std::any_of(zones.begin(), zones.end(), [&](const Bounds& zone) {
    return (p - zone.low).minCoeff() >= inside && (zone.high - p).minCoeff() >= inside;
  });
}

/// At most so many of all, evenly taken.
void add_evenly(std::span<const Vector3> all, std::size_t most, std::vector<Vector3>& points) {
  const std::size_t step = all.size() / most + 1;
  for (std::size_t i = 0; i < all.size(); i += step) points.push_back(all[i]);
}

/// The part of the way from a to b that is in the zone, in shares of it; empty where the first is larger.
std::pair<double, double> part_in(const Bounds& zone, const Vector3& a, const Vector3& b) {
  double from = 0.0, to = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double way = b[axis] - a[axis];
    const double low = zone.low[axis] - a[axis], high = zone.high[axis] - a[axis];
    if (way == 0.0) {
      if (low > 0.0 || high < 0.0) return {1.0, 0.0};
      continue;
    }
    from = std::max(from, std::min(low / way, high / way));
    to = std::min(to, std::max(low / way, high / way));
  }
  return {from, to};
}

/// Points of the triangles' edges in zones, as far from one another along them: what stands out most.
void add_on_edges(const TriangleMesh& mesh, std::span<const Bounds> zones, std::vector<Vector3>& points) {
  // Parts of edges, each edge of a closed shell once.
  std::vector<std::array<Vector3, 2>> parts;
  double length = 0.0;
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      if (t[i] > t[(i + 1) % 3]) continue;
      const Vector3 &a = mesh.vertices[t[i]], &b = mesh.vertices[t[(i + 1) % 3]];
      for (const Bounds& zone : zones) {
        const auto [from, to] = part_in(zone, a, b);
        if (from >= to) continue;
        parts.push_back({Vector3(a + from * (b - a)), Vector3(a + to * (b - a))});
        length += (to - from) * norm(b - a);
      }
    }
  }
  // Along all of them, every so far.
  double left = 0.5 * length / kOnEdges;
  std::size_t added = 0;
  for (const auto& [a, b] : parts) {
    const double way = norm(b - a);
    for (; left < way && added < kOnEdges; left += length / kOnEdges, ++added)
      points.push_back(a + left / way * (b - a));
    left -= way;
  }
}

std::vector<Vector3> points_of(const MeshDistance& mesh, std::span<const Bounds> zones) {
  std::vector<Vector3> points;
  // Vertices in zones and elsewhere, and points of edges in zones.
  std::vector<Vector3> vertices, others;
  for (const Vector3& v : mesh.mesh().vertices) (is_in(zones, v, 0.0) ? vertices : others).push_back(v);
  add_evenly(vertices, kVertices, points);
  add_evenly(others, kOtherVertices, points);
  add_on_edges(mesh.mesh(), zones, points);
  // Random points in zones, and anywhere.
  SurfacePoints random(mesh.mesh());
  for (std::size_t i = 0; i < kAnywhere; ++i) points.push_back(random.next());
  std::size_t found = 0;
  for (std::size_t i = 0; i < kDraws && found < kInZones; ++i) {
    const Vector3 p = random.next();
    if (is_in(zones, p, 0.0)) points.push_back(p), ++found;
  }
  return points;
}

/// Whether no convex part of such a cover holds both.
bool are_apart(const MeshDistance& mesh, std::span<const Bounds> zones, double over, const Vector3& a,
               const Vector3& b) {
  const double rounding = kRounding * mesh.largest_coordinate();  // of points, and of distances
  // The middle first, then ever smaller parts.
  for (unsigned parts = 2; parts <= kParts; parts *= 2) {
    for (unsigned i = 1; i < parts; i += 2) {
      const Vector3 p = a + (static_cast<double>(i) / parts) * (b - a);
      if (is_in(zones, p, rounding) && !mesh.is_near(p, over + rounding) && !mesh.is_inside(p)) return true;
    }
  }
  return false;
}

/// Points each two of which are apart: from each point on the one that leaves most to choose from is added.
std::size_t most_apart(const std::vector<Others>& apart) {
  std::size_t most = 0;
  for (std::size_t first = 0; first < apart.size(); ++first) {
    Others left = apart[first];
    std::size_t count = 1;
    for (; left.any(); ++count) {
      std::size_t best = 0, best_left = 0;
      for (std::size_t i = 0; i < apart.size(); ++i) {
        if (!left[i]) continue;
        const std::size_t leaves = (left & apart[i]).count() + 1;
        if (leaves > best_left) best = i, best_left = leaves;
      }
      left &= apart[best];
    }
    most = std::max(most, count);
  }
  return most;
}

}  // namespace

std::size_t least_hexahedra(const MeshDistance& mesh, std::span<const Bounds> zones, double over) {
  const std::vector<Vector3> points = points_of(mesh, zones);
  std::vector<Others> apart(points.size());
  for (std::size_t a = 0; a < points.size(); ++a)
    for (std::size_t b = a + 1; b < points.size(); ++b)
      if (are_apart(mesh, zones, over, points[a], points[b])) apart[a][b] = apart[b][a] = true;
  return most_apart(apart);
}

}  // namespace touchstone::fitting

#include "touchstone/examples/fit/least_cover.hpp"

#include <algorithm>
#include <bitset>
#include <vector>

#include "touchstone/examples/fit/samples.hpp"

namespace touchstone::fitting {
namespace {

constexpr std::size_t kVertices = 192, kInZones = 192, kAnywhere = 64;
constexpr std::size_t kDraws = 200'000;  // to find those in zones
constexpr unsigned kParts = 16;          // of a segment, whose ends are looked at
constexpr double kRounding = 0x1p-40;    // of the largest coordinate: more than points and distances are off

using Others = std::bitset<kVertices + kInZones + kAnywhere>;

// `inside` by this much [m].
bool is_in(std::span<const Bounds> zones, const Vector3& p, double inside) {
  return std::any_of(zones.begin(), zones.end(), [&](const Bounds& zone) {
    return (p - zone.low).minCoeff() >= inside && (zone.high - p).minCoeff() >= inside;
  });
}

std::vector<Vector3> points_of(const MeshDistance& mesh, std::span<const Bounds> zones) {
  std::vector<Vector3> points;
  // Vertices in zones, evenly taken.
  std::vector<Vector3> vertices;
  for (const Vector3& v : mesh.mesh().vertices)
    if (is_in(zones, v, 0.0)) vertices.push_back(v);
  const std::size_t step = vertices.size() / kVertices + 1;
  for (std::size_t i = 0; i < vertices.size(); i += step) points.push_back(vertices[i]);
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

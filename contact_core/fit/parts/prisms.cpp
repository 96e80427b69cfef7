#include "touchstone/contact_core/fit/parts/prisms.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/fit/parts/sectors.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"

namespace touchstone::fit {
namespace {

constexpr double kRoom = 1.0 / 512.0;  // of the limit: what corners may be off
constexpr double kLeastSine = 0.25;    // of a slab's sides to its levels: SixPlanes takes 0.2
constexpr std::size_t kMostAxes = 64;  // tried of a shell

using Point = std::array<double, 2>;

struct Shell {
  std::vector<std::uint32_t> triangles;
  Bounds box;
  double volume = 0.0;  // negative: inside out
};

std::vector<Shell> closed_shells(const MeshDistance& distance) {
  const TriangleMesh& mesh = distance.mesh();
  std::vector<Shell> shells(distance.shells().count());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t shell = distance.shells().shell_of_triangle[t];
    if (distance.shells().is_closed[shell] == 0) continue;
    shells[shell].triangles.push_back(t);
    for (const std::uint32_t corner : mesh.triangles[t]) shells[shell].box.add(mesh.vertices[corner]);
    const Vector3 foot = mesh.vertices[mesh.triangles[t][0]] - distance.bounds().low;
    shells[shell].volume += dot(foot, area_vector(mesh, t)) / 6.0;
  }
  std::erase_if(shells, [](const Shell& shell) { return shell.triangles.empty(); });
  return shells;
}

bool overlap(const Bounds& a, const Bounds& b) {
  return (a.low - b.high).maxCoeff() <= 0.0 && (b.low - a.high).maxCoeff() <= 0.0;
}

double turn(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// Counter-clockwise (Andrew's monotone chain), points within `room` of the chain before left out.
std::vector<Point> hull_of(std::vector<Point> points, double room) {
  std::sort(points.begin(), points.end());
  std::vector<Point> hull;
  const auto add = [&](const Point& p, std::size_t keep) {
    while (hull.size() >= keep + 2) {
      const Point &a = hull[hull.size() - 2], &b = hull.back();
      if (turn(a, b, p) > room * std::hypot(p[0] - a[0], p[1] - a[1])) break;
      hull.pop_back();
    }
    hull.push_back(p);
  };
  for (const Point& p : points) add(p, 0);
  const std::size_t lower = hull.size() - 1;
  for (std::size_t i = points.size() - 1; i-- > 0;) add(points[i], lower);
  hull.pop_back();
  return hull;
}

double area_of(const std::vector<Point>& polygon) {
  double twice = 0.0;
  for (std::size_t i = 2; i < polygon.size(); ++i) twice += turn(polygon[0], polygon[i - 1], polygon[i]);
  return 0.5 * twice;
}

// Heights of the corners, those within `room` as one.
std::vector<double> levels_of(std::vector<double> heights, double room) {
  std::sort(heights.begin(), heights.end());
  std::vector<double> levels;
  for (const double height : heights)
    if (levels.empty() || height - levels.back() > room) levels.push_back(height);
  return levels;
}

// Turns the section so that its corners lie on fewest levels.
void choose_up(Prism& prism, double room) {
  std::vector<double> fewest;
  Point best = {1.0, 0.0};
  for (std::size_t i = 0; i < prism.section.size(); ++i) {
    const Point &a = prism.section[i], &b = prism.section[(i + 1) % prism.section.size()];
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
    const Point up = {(b[1] - a[1]) / length, -(b[0] - a[0]) / length};
    std::vector<double> heights;
    for (const Point& p : prism.section) heights.push_back(up[0] * p[0] + up[1] * p[1]);
    std::vector<double> levels = levels_of(std::move(heights), room);
    if (!fewest.empty() && levels.size() >= fewest.size()) continue;
    fewest = std::move(levels);
    best = up;
  }
  const Vector3 up = best[0] * prism.up + best[1] * prism.side;
  const Vector3 side = best[0] * prism.side - best[1] * prism.up;
  prism.up = up;
  prism.side = side;
  for (Point& p : prism.section) p = {best[0] * p[0] + best[1] * p[1], best[0] * p[1] - best[1] * p[0]};
  // Corners of one level may be a rounding apart: the strips' borders are a little above the lowest.
  for (std::size_t i = 1; i + 1 < fewest.size(); ++i) prism.borders.push_back(fewest[i] + 0.5 * room);
}

// Angles of 29 degrees and more.
bool has_blunt_edges(const std::vector<Point>& section) {
  constexpr double kMostCosine = 0.875;  // of twice the angle whose sine is a quarter
  for (std::size_t i = 0; i < section.size(); ++i) {
    const Point &a = section[i], &b = section[(i + 1) % section.size()],
                &c = section[(i + 2) % section.size()];
    const double along = (a[0] - b[0]) * (c[0] - b[0]) + (a[1] - b[1]) * (c[1] - b[1]);
    if (along > kMostCosine * std::hypot(a[0] - b[0], a[1] - b[1]) * std::hypot(c[0] - b[0], c[1] - b[1]))
      return false;
  }
  return true;
}

// Whether each triangle is of one end, or on one edge of the section: nothing of the shell then is inside.
bool has_plane_sides(const TriangleMesh& mesh, const Shell& shell, const Prism& prism, double room) {
  const std::vector<Point>& section = prism.section;
  return std::all_of(shell.triangles.begin(), shell.triangles.end(), [&](std::uint32_t t) {
    std::array<Point, 3> flat;
    int low = 0, high = 0;
    for (int i = 0; i < 3; ++i) {
      const Vector3& p = mesh.vertices[mesh.triangles[t][i]];
      flat[i] = {dot(prism.up, p), dot(prism.side, p)};
      low += dot(prism.axis, p) - prism.low <= room ? 1 : 0;
      high += prism.high - dot(prism.axis, p) <= room ? 1 : 0;
    }
    if (low == 3 || high == 3) return true;
    for (std::size_t i = 0; i < section.size(); ++i) {
      const Point &a = section[i], &b = section[(i + 1) % section.size()];
      const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
      if (std::all_of(flat.begin(), flat.end(),
                      [&](const Point& p) { return std::abs(turn(a, b, p)) <= room * length; }))
        return true;
    }
    return false;
  });
}

// A prism without a section yet.
Prism frame_along(const TriangleMesh& mesh, const Shell& shell, const Vector3& axis, double room) {
  Prism prism{};
  prism.axis = axis;
  prism.low = kInfinity;
  prism.high = -prism.low;
  for (const std::uint32_t t : shell.triangles) {
    for (const std::uint32_t corner : mesh.triangles[t]) {
      const double at = dot(axis, mesh.vertices[corner]);
      prism.low = std::min(prism.low, at);
      prism.high = std::max(prism.high, at);
    }
  }
  const Vector3 hint = std::abs(axis.x()) < 0.7 ? Vector3::UnitX() : Vector3::UnitY();
  prism.up = hint - dot(hint, axis) * axis;
  prism.up /= norm(prism.up);
  prism.side = cross(axis, prism.up);
  prism.box = shell.box;
  prism.room = room;
  prism.triangles = shell.triangles;
  return prism;
}

double length_around(const std::vector<Point>& section) {
  double around = 0.0;
  for (std::size_t i = 0; i < section.size(); ++i) {
    const Point &a = section[i], &b = section[(i + 1) % section.size()];
    around += std::hypot(b[0] - a[0], b[1] - a[1]);
  }
  return around;
}

// Along the axis all corners are at two heights, and their hull is as large as the shell.
std::optional<Prism> prism_along(const TriangleMesh& mesh, const Shell& shell, const Vector3& axis,
                                 double over) {
  const double room = kRoom * over;
  Prism prism = frame_along(mesh, shell, axis, room);
  const double length = prism.high - prism.low;
  if (length < kThick * over) return std::nullopt;
  // Seen along the axis the corners of both ends have one hull.
  std::vector<Point> corners;
  for (const std::uint32_t t : shell.triangles) {
    for (const std::uint32_t corner : mesh.triangles[t]) {
      const Vector3& p = mesh.vertices[corner];
      if (std::min(dot(axis, p) - prism.low, prism.high - dot(axis, p)) > room) return std::nullopt;
      corners.push_back({dot(prism.up, p), dot(prism.side, p)});
    }
  }
  prism.section = hull_of(std::move(corners), room);
  if (prism.section.size() < 3 || !has_blunt_edges(prism.section)) return std::nullopt;
  // A frustum's sides are on no edge of it, and its volume is another.
  if (!has_plane_sides(mesh, shell, prism, room)) return std::nullopt;
  const double area = area_of(prism.section),
               off = 2.0 * room * (area + length_around(prism.section) * length);
  if (std::abs(area * length - shell.volume) > off) return std::nullopt;
  choose_up(prism, room);
  return prism;
}

// Between parallel lines at the section's corners: no convex polygon is thinner than between its edges.
double thickness(const Prism& prism) {
  double least = kInfinity;
  for (std::size_t i = 0; i < prism.section.size(); ++i) {
    const Point &a = prism.section[i], &b = prism.section[(i + 1) % prism.section.size()];
    double most = 0.0;
    for (const Point& p : prism.section) most = std::max(most, turn(a, b, p));
    least = std::min(least, most / std::hypot(b[0] - a[0], b[1] - a[1]));
  }
  return least;
}

// From the middle of the corners at one end to that of those at the other: ends are small, and their
// triangles' normals as wrong as rounded corners let them be.
Vector3 refined(const TriangleMesh& mesh, const Shell& shell, const Vector3& axis) {
  std::vector<std::uint32_t> corners;
  for (const std::uint32_t t : shell.triangles)
    corners.insert(corners.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  double low = kInfinity, high = -low;
  for (const std::uint32_t corner : corners) {
    low = std::min(low, dot(axis, mesh.vertices[corner]));
    high = std::max(high, dot(axis, mesh.vertices[corner]));
  }
  std::array<Vector3, 2> sums = {Vector3::Zero(), Vector3::Zero()};
  std::array<double, 2> counts = {0.0, 0.0};
  for (const std::uint32_t corner : corners) {
    const int end = dot(axis, mesh.vertices[corner]) - low > high - dot(axis, mesh.vertices[corner]) ? 1 : 0;
    sums[end] += mesh.vertices[corner] - mesh.vertices[corners.front()];
    counts[end] += 1.0;
  }
  const Vector3 along = sums[1] / counts[1] - sums[0] / counts[0];
  const double length = norm(along);
  return length > 0.0 && dot(along, axis) > 0.999 * length ? Vector3(along / length) : axis;
}

std::optional<Prism> prism_of(const TriangleMesh& mesh, const Shell& shell, double over) {
  std::vector<Vector3> tried;
  for (const std::uint32_t t : shell.triangles) {
    const Vector3 n = area_vector(mesh, t);
    const double area = norm(n);
    if (area == 0.0) continue;
    const Vector3 axis = n / area;
    if (std::any_of(tried.begin(), tried.end(),
                    [&](const Vector3& other) { return std::abs(dot(other, axis)) > 1.0 - 1e-9; }))
      continue;
    if (tried.size() == kMostAxes) return std::nullopt;
    tried.push_back(axis);
    std::optional<Prism> prism = prism_along(mesh, shell, refined(mesh, shell, axis), over);
    if (prism && thickness(*prism) >= kThick * over) return prism;
  }
  return std::nullopt;
}

}  // namespace

double Prism::distance(const Vector3& p) const {
  const double at = dot(axis, p);
  const double along = std::max({low - at, at - high, 0.0});
  const Point q = {dot(up, p), dot(side, p)};
  // Outside of an edge, the nearest point of the section is on one of those edges.
  double least = kInfinity;
  bool is_outside = false;
  for (std::size_t i = 0; i < section.size(); ++i) {
    const Point &a = section[i], &b = section[(i + 1) % section.size()];
    if (turn(a, b, q) >= 0.0) continue;
    is_outside = true;
    const double dx = b[0] - a[0], dy = b[1] - a[1];
    const double share =
        std::clamp(((q[0] - a[0]) * dx + (q[1] - a[1]) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
    least = std::min(least, std::hypot(q[0] - a[0] - share * dx, q[1] - a[1] - share * dy));
  }
  return is_outside ? std::hypot(along, least) : along;
}

double Prism::bound(const std::array<Vector3, 8>& corners) const {
  double most = 0.0;
  for (const Vector3& p : corners) most = std::max(most, distance(p));
  return most + 5.0 * room;
}

bool Prism::is_about(const SixPlanes& solid, double limit) const {
  if (!solid.is_hexahedron()) return false;
  const std::array<Vector3, 8> corners = solid.corners();
  return std::all_of(corners.begin(), corners.end(), [&](const Vector3& p) { return distance(p) <= limit; });
}

double Prism::lowest() const { return (*std::min_element(section.begin(), section.end()))[0]; }

double Prism::highest() const { return (*std::max_element(section.begin(), section.end()))[0]; }

double Prism::outermost(double height, double out) const {
  double most = -kInfinity;
  for (std::size_t i = 0; i < section.size(); ++i) {
    const Point &a = section[i], &b = section[(i + 1) % section.size()];
    if (std::min(a[0], b[0]) > height || std::max(a[0], b[0]) < height) continue;
    const double share = a[0] == b[0] ? 0.0 : (height - a[0]) / (b[0] - a[0]);
    most = std::max(most, out * (a[1] + share * (b[1] - a[1])));
    if (a[0] == b[0]) most = std::max(most, out * b[1]);
  }
  return out * most;
}

SixPlanes Prism::slab(std::span<const Vector3> points, std::size_t first, std::size_t last) const {
  const double bottom = first == 0 ? -kInfinity : borders[first - 1],
               top = last + 1 == strips() ? kInfinity : borders[last];
  const double most_up = std::sqrt(1.0 - kLeastSine * kLeastSine);
  // A side may lean as any edge of the section that is between the levels, or stand upright.
  std::array<std::vector<Vector3>, 2> leans;
  leans[0].push_back(-side);
  leans[1].push_back(side);
  for (std::size_t i = 0; i < section.size(); ++i) {
    const Point &a = section[i], &b = section[(i + 1) % section.size()];
    if (std::max(a[0], b[0]) <= bottom || std::min(a[0], b[0]) >= top) continue;
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
    const double lean = std::clamp((b[1] - a[1]) / length, -most_up, most_up), out = -(b[0] - a[0]) / length;
    const double upright = std::sqrt(1.0 - lean * lean);
    leans[out < 0.0 ? 0 : 1].push_back(lean * up + (out < 0.0 ? -upright : upright) * side);
  }
  // Or as the chord from its lowest point there to its highest.
  for (int k = 0; k < 2; ++k) {
    const double out = k == 0 ? -1.0 : 1.0;
    const double from = std::max(bottom, lowest()), to = std::min(top, highest());
    const double lean = out * (outermost(from, out) - outermost(to, out)) /
                        std::hypot(to - from, outermost(to, out) - outermost(from, out));
    const double kept = std::clamp(lean, -most_up, most_up);
    leans[k].push_back(kept * up + out * std::sqrt(1.0 - kept * kept) * side);
  }
  // Each corner is on one side alone, so that each side is chosen by itself.
  std::array<Vector3, 2> best = {leans[0].front(), leans[1].front()};
  const auto about = [&](const std::array<Vector3, 2>& sides) {
    return enclosing(std::array<Vector3, 6>{-up, up, sides[0], sides[1], -axis, axis}, points);
  };
  const SixPlanes upright = about(best);
  for (int k = 0; k < 2; ++k) {
    double least = kInfinity;
    for (const Vector3& lean : leans[k]) {
      std::array<Vector3, 2> sides = {leans[0].front(), leans[1].front()};
      sides[k] = lean;
      const std::array<Vector3, 8> corners = about(sides).corners();
      double most = 0.0;
      for (int i = 0; i < 8; ++i)
        if ((i >> 1 & 1) == k) most = std::max(most, distance(corners[i]));
      if (most >= least) continue;
      least = most;
      best[k] = lean;
    }
  }
  const SixPlanes solid = about(best);
  return solid.is_hexahedron() ? solid : upright;
}

std::vector<Prism> find_prisms(const MeshDistance& mesh, double over) {
  const std::vector<Shell> shells = closed_shells(mesh);
  std::vector<Prism> prisms;
  for (const Shell& shell : shells) {
    if (!(shell.volume > 0.0) || (shell.box.high - shell.box.low).minCoeff() <= 0.0) continue;
    const bool may_have_cavity = std::any_of(shells.begin(), shells.end(), [&](const Shell& other) {
      return !(other.volume > 0.0) && overlap(shell.box, other.box);
    });
    if (may_have_cavity) continue;
    if (std::optional<Prism> prism = prism_of(mesh.mesh(), shell, over)) prisms.push_back(*std::move(prism));
  }
  return prisms;
}

std::optional<MeshDistance> without(const MeshDistance& mesh, std::span<const Prism> prisms) {
  std::vector<std::uint8_t> is_out(mesh.mesh().triangles.size(), 0);
  for (const Prism& prism : prisms)
    for (const std::uint32_t t : prism.triangles) is_out[t] = 1;
  TriangleMesh rest;
  rest.vertices = mesh.mesh().vertices;
  for (std::size_t t = 0; t < is_out.size(); ++t)
    if (is_out[t] == 0) rest.triangles.push_back(mesh.mesh().triangles[t]);
  if (rest.triangles.empty()) return std::nullopt;
  return MeshDistance(weld(rest));
}

}  // namespace touchstone::fit

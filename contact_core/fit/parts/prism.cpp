#include "touchstone/contact_core/fit/parts/prism.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone::fit {
namespace {

constexpr double kLeastSine = 0.15;  // of a slab's sides to its levels

}  // namespace

Plane Prism::plane_through(const Point& across, double at) const {
  const double rises = across[0] * leans[0] + across[1] * leans[1] - narrows * at;  // over the length
  const double slope = rises / (high - low), length = std::sqrt(1.0 + slope * slope);
  const Vector3 normal = (across[0] * up + across[1] * side - slope * axis) / length;
  return {normal, (slope * low - at) / length};
}

Prism::Point Prism::in_section(const Vector3& p) const {
  if (!is_tapered()) return {dot(up, p), dot(side, p)};
  const double along = std::min((dot(axis, p) - low) / (high - low), 1.0), scale = 1.0 - narrows * along;
  return {(dot(up, p) - along * leans[0]) / scale, (dot(side, p) - along * leans[1]) / scale};
}

double Prism::distance(const Vector3& p) const {
  if (is_tapered()) return shell->to_solid(p);
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
  if (is_tapered()) return kInfinity;
  double most = 0.0;
  for (const Vector3& p : corners) most = std::max(most, distance(p));
  return most + 5.0 * room;
}

bool Prism::is_about(const SixPlanes& solid, double limit) const {
  if (!solid.is_hexahedron(kLeastDeterminant)) return false;
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
  std::array<std::vector<Point>, 2> leaning;
  leaning[0].push_back({0.0, -1.0});
  leaning[1].push_back({0.0, 1.0});
  for (std::size_t i = 0; i < section.size(); ++i) {
    const Point &a = section[i], &b = section[(i + 1) % section.size()];
    if (std::max(a[0], b[0]) <= bottom || std::min(a[0], b[0]) >= top) continue;
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
    const double lean = std::clamp((b[1] - a[1]) / length, -most_up, most_up), out = -(b[0] - a[0]) / length;
    const double upright = std::sqrt(1.0 - lean * lean);
    leaning[out < 0.0 ? 0 : 1].push_back({lean, out < 0.0 ? -upright : upright});
  }
  // Or as the chord from its lowest point there to its highest.
  for (int k = 0; k < 2; ++k) {
    const double out = k == 0 ? -1.0 : 1.0;
    const double from = std::max(bottom, lowest()), to = std::min(top, highest());
    const double lean = out * (outermost(from, out) - outermost(to, out)) /
                        std::hypot(to - from, outermost(to, out) - outermost(from, out));
    const double kept = std::clamp(lean, -most_up, most_up);
    leaning[k].push_back({kept, out * std::sqrt(1.0 - kept * kept)});
  }
  // Each corner is on one side alone, so that each side is chosen by itself.
  std::array<Point, 2> best = {leaning[0].front(), leaning[1].front()};
  std::vector<Point> places;
  for (const Vector3& p : points) places.push_back(in_section(p));
  const auto normal = [&](const Point& across) {
    double at = -kInfinity;
    for (const Point& q : places) at = std::max(at, across[0] * q[0] + across[1] * q[1]);
    return plane_through(across, at).normal;
  };
  const Vector3 downwards = normal({-1.0, 0.0}), upwards = normal({1.0, 0.0});
  const auto about = [&](const std::array<Point, 2>& sides) {
    return enclosing(
        std::array<Vector3, 6>{downwards, upwards, normal(sides[0]), normal(sides[1]), -axis, axis}, points);
  };
  const SixPlanes upright = about(best);
  for (int k = 0; k < 2; ++k) {
    double least = kInfinity;
    for (const Point& lean : leaning[k]) {
      std::array<Point, 2> sides = {leaning[0].front(), leaning[1].front()};
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
  return solid.is_hexahedron(kLeastDeterminant) ? solid : upright;
}

}  // namespace touchstone::fit

#include "touchstone/contact_core/fit/parts/sectors.hpp"

#include <algorithm>
#include <cmath>

namespace touchstone::fit {
namespace {

constexpr int kFewest = 6;  // a bore that so few go around is as well left to other hexahedra
const double kTurn = 2.0 * std::acos(-1.0);

bool is_about(const RoundPart& part, const RoundPart& bore) {
  const Vector3 off = part.foot - bore.foot;
  return std::abs(dot(part.axis, bore.axis)) > 1.0 - 1e-6 &&
         norm(off - dot(off, bore.axis) * bore.axis) < 1e-3 * bore.radius && part.radius > bore.radius;
}

// Chords of a bore, or tangents of what is round about it, that leave at most `limit`.
int fewest(double radius, double limit, bool is_bore) {
  const double cosine = is_bore ? 1.0 - limit / radius : radius / (radius + limit);
  return std::max(3, static_cast<int>(std::ceil(0.5 * kTurn / std::acos(std::max(cosine, 0.0)))));
}

// No more than the facets that the part has: one hexahedron holds what is behind a facet, or two corners.
int fewest(const RoundPart& part, double limit) {
  const int chords = fewest(part.radius, limit, part.is_bore);
  return part.facets > 0 ? std::min(chords, part.facets) : chords;
}

// Whether both have the same facets, with their corners in the same directions from the axis.
bool have_same_facets(const RoundPart& part, const RoundPart& bore) {
  if (part.facets == 0 || part.facets != bore.facets) return false;
  const double sine = dot(cross(bore.start, part.start), bore.axis), cosine = dot(bore.start, part.start);
  return std::cos(bore.facets * std::atan2(sine, cosine)) > 1.0 - 1e-6;
}

}  // namespace

Plane Sectors::border(int i) const {
  const double angle = kTurn * i / count;
  const Vector3 y = cross(bore.axis, bore.start);
  const Vector3 normal = std::cos(angle) * y - std::sin(angle) * bore.start;
  return {normal, -dot(normal, bore.foot)};
}

Vector3 Sectors::middle(int i) const {
  const double angle = kTurn * (i + 0.5) / count;
  return std::cos(angle) * bore.start + std::sin(angle) * cross(bore.axis, bore.start);
}

bool Sectors::touches(const Vector3& low, const Vector3& high) const {
  const double most = std::max(outer, 1.5 * bore.radius);
  const Vector3 middle = 0.5 * (low + high), off = middle - bore.foot;
  const double half = 0.5 * norm(high - low), along = dot(off, bore.axis);
  const double away = norm(off - along * bore.axis);
  return away <= most + half && along >= -half - bore.radius && along <= bore.length + half + bore.radius;
}

bool Sectors::is_ring(double over) const {
  return std::min(outer - bore.radius, bore.length) >= kThick * over;
}

std::vector<Sectors> sectors_about_bores(std::span<const RoundPart> parts, const AllowedSpace& allowed,
                                         int most) {
  std::vector<Sectors> result;
  for (const RoundPart& bore : parts) {
    if (!bore.is_bore) continue;
    const auto limit_at = [&](const RoundPart& part) {
      return allowed.limit_at(part.foot + 0.5 * part.length * part.axis + part.radius * part.start);
    };
    Sectors sectors{bore, fewest(bore, limit_at(bore)), bore.radius};
    for (const RoundPart& part : parts) {
      if (!is_about(part, bore)) continue;
      sectors.outer = std::max(sectors.outer, part.radius);
      if (part.is_bore) continue;
      sectors.count =
          std::max(sectors.count, have_same_facets(part, bore) ? fewest(part, limit_at(part))
                                                               : fewest(part.radius, limit_at(part), false));
    }
    if (sectors.count >= kFewest && sectors.count <= most) result.push_back(sectors);
  }
  return result;
}

}  // namespace touchstone::fit

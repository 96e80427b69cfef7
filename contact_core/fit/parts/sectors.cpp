#include "touchstone/contact_core/fit/parts/sectors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone::fit {
namespace {

constexpr double kNear = 1e-3;      // of the radius, as round parts have it
constexpr int kFewest = 6;          // a bore that so few go around is as well left to other hexahedra
constexpr double kRounding = 1e-9;  // of a limit that a count of sectors was chosen by

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

// Whether a triangle is at one end of the room between both, or on one of its walls: all its corners are. A
// face from wall to wall along the axis, as a slit has, is on none.
bool is_on_ring(const TriangleMesh& mesh, std::uint32_t t, const RoundPart& bore, const RoundPart& outer) {
  const double near = kNear * bore.radius;
  std::array<int, 4> corners_on = {0, 0, 0, 0};
  for (const std::uint32_t corner : mesh.triangles[t]) {
    const Vector3 off = mesh.vertices[corner] - bore.foot;
    const double along = dot(off, bore.axis), away = norm(off - along * bore.axis);
    const std::array<double, 4> beside = {along, along - bore.length, away - bore.radius,
                                          away - outer.radius};
    if (std::min(std::abs(beside[0]), std::abs(beside[1])) > near ||
        std::min(std::abs(beside[2]), std::abs(beside[3])) > near)
      return false;
    for (std::size_t i = 0; i < 4; ++i) corners_on[i] += std::abs(beside[i]) <= near ? 1 : 0;
  }
  return *std::max_element(corners_on.begin(), corners_on.end()) == 3;
}

// Whether triangles have corners on both walls wherever facets meet, and nowhere else.
bool goes_around(const TriangleMesh& mesh, std::span<const std::uint32_t> shell, const RoundPart& bore) {
  const double near = kNear * bore.radius, facets = bore.facets;
  std::array<std::vector<bool>, 2> has_corner;
  for (std::vector<bool>& wall : has_corner) wall.assign(static_cast<std::size_t>(bore.facets), false);
  for (const std::uint32_t t : shell)
    for (const std::uint32_t corner : mesh.triangles[t]) {
      const Vector3 off = mesh.vertices[corner] - bore.foot, across = off - dot(off, bore.axis) * bore.axis;
      const double turn = std::atan2(dot(cross(bore.start, across), bore.axis), dot(bore.start, across));
      const double at = (turn < 0.0 ? turn + kTurn : turn) / kTurn * facets, away = norm(across);
      // Both walls' axes and starts are found to `near`.
      if (std::abs(at - std::round(at)) * kTurn / facets * away > 2.0 * near) return false;
      has_corner[away > bore.radius + near ? 1 : 0]
                [static_cast<std::size_t>(std::lround(at)) % static_cast<std::size_t>(bore.facets)] = true;
    }
  const auto is_full = [](const std::vector<bool>& wall) {
    return std::find(wall.begin(), wall.end(), false) == wall.end();
  };
  return is_full(has_corner[0]) && is_full(has_corner[1]);
}

// Whether triangles hold as much as a ring between both, to what corners may be off.
bool has_volume_of_ring(const TriangleMesh& mesh, std::span<const std::uint32_t> shell, const RoundPart& bore,
                        const RoundPart& outer) {
  double volume = 0.0, surface = 0.0;
  for (const std::uint32_t t : shell) {
    const Vector3 twice = area_vector(mesh, t);
    volume += dot(mesh.vertices[mesh.triangles[t][0]] - bore.foot, twice) / 6.0;
    surface += 0.5 * norm(twice);
  }
  const double section = 0.5 * bore.facets * std::sin(kTurn / bore.facets) *
                         (outer.radius * outer.radius - bore.radius * bore.radius);
  return std::abs(volume - section * bore.length) <= kNear * bore.radius * surface;
}

// The triangles of the one closed shell that is such a ring and nothing else; none where there are two.
std::vector<std::uint32_t> ring_shell(const MeshDistance& distance, const RoundPart& bore,
                                      const RoundPart& outer) {
  // Walls and ends have to be farther apart than corners may be off.
  if (std::min(outer.radius - bore.radius, bore.length) <= 2.0 * kNear * bore.radius) return {};
  const TriangleMesh& mesh = distance.mesh();
  const MeshShells& shells = distance.shells();
  std::vector<std::uint8_t> is_ring = shells.is_closed;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if (!is_on_ring(mesh, t, bore, outer)) is_ring[shells.shell_of_triangle[t]] = 0;
  if (std::count(is_ring.begin(), is_ring.end(), 1) != 1) return {};
  std::vector<std::uint32_t> ring;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if (is_ring[shells.shell_of_triangle[t]] != 0) ring.push_back(t);
  const bool is_one = goes_around(mesh, ring, bore) && has_volume_of_ring(mesh, ring, bore, outer);
  return is_one ? ring : std::vector<std::uint32_t>();
}

// The least that is allowed on one of the ring's walls.
double limit_on(const TriangleMesh& mesh, std::span<const std::uint32_t> shell, const RoundPart& wall,
                const AllowedSpace& allowed) {
  double least = kInfinity;
  for (const std::uint32_t t : shell) {
    std::array<Vector3, 3> corners;
    int on = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      corners[i] = mesh.vertices[mesh.triangles[t][i]];
      const Vector3 off = corners[i] - wall.foot;
      on +=
          std::abs(norm(off - dot(off, wall.axis) * wall.axis) - wall.radius) <= kNear * wall.radius ? 1 : 0;
    }
    if (on == 3) least = std::min(least, allowed.least_limit(corners));
  }
  return least;
}

// As many as facets, or a part of them.
int whole_part(int fewest, int facets) {
  for (int count = fewest; count < facets; ++count)
    if (facets % count == 0) return count;
  return facets;
}

}  // namespace

double Sectors::begin(int i) const {
  if (chords.empty() || i == count) return (chords.empty() ? 0.0 : chords.front().begin) + kTurn * i / count;
  return chords[static_cast<std::size_t>(i)].begin;
}

Plane Sectors::border(int i) const {
  const double angle = begin(i);
  const Vector3 y = cross(bore.axis, bore.start);
  const Vector3 normal = std::cos(angle) * y - std::sin(angle) * bore.start;
  return {normal, -dot(normal, bore.foot)};
}

Vector3 Sectors::out(int i) const {
  const double angle = chords.empty() ? kTurn * (i + 0.5) / count : chords[static_cast<std::size_t>(i)].out;
  return std::cos(angle) * bore.start + std::sin(angle) * cross(bore.axis, bore.start);
}

std::vector<Polygon> Sectors::surface(const TriangleMesh& mesh) const {
  std::vector<Polygon> polygons;
  for (const std::uint32_t t : shell) {
    const auto& corners = mesh.triangles[t];
    polygons.push_back({mesh.vertices[corners[0]], mesh.vertices[corners[1]], mesh.vertices[corners[2]]});
  }
  return polygons;
}

std::vector<Polygon> Sectors::part_of(const std::vector<Polygon>& polygons, int i) const {
  return parts_of(parts_of(polygons, border(i), 1.0), border((i + 1) % count), -1.0);
}

SixPlanes Sectors::about(int i, std::span<const Vector3> points) const {
  const Vector3 outwards = out(i);
  return enclosing(std::array<Vector3, 6>{-outwards, outwards, -border(i).normal,
                                          border((i + 1) % count).normal, -bore.axis, bore.axis},
                   points);
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

namespace {

// Whether a hexahedron a sector keeps to what is allowed: then there is a cover of such. Where corners of
// facets are within a sector it goes into the bore and beyond the outer wall, at places that are on neither.
bool has_cover(const TriangleMesh& mesh, const Sectors& ring, const AllowedSpace& allowed) {
  const double inner = ring.bore.radius;
  const std::vector<Polygon> surface = ring.surface(mesh);
  for (int i = 0; i < ring.count; ++i) {
    std::vector<Vector3> points;
    for (const Polygon& part : ring.part_of(surface, i))
      points.insert(points.end(), part.begin(), part.end());
    if (points.empty()) return false;
    const SixPlanes solid = ring.about(i, points);
    if (!allowed.allows_samples(solid)) return false;
    const Chord chord = chord_between(ring.bore.facets, ring.begin(i), ring.begin(i + 1));
    if (chord.depth == 0.0) continue;
    // What of it is in the bore is below the circle, what is outside beyond the outer wall's chord.
    const double foot = dot(ring.out(i), ring.bore.foot);
    SixPlanes in_bore = solid, outside = solid;
    in_bore.planes[1].offset = -(foot + inner);
    outside.planes[0].offset = foot + ring.outer * chord.height;
    const ChordLimits limits = {(1.0 + kRounding) * allowed.least_limit(in_bore.corners()) / inner,
                                (1.0 + kRounding) * allowed.least_limit(outside.corners()) / ring.outer};
    if (!limits.allow(chord)) return false;
  }
  return true;
}

// Of a closed shell that is a ring, with as many sectors as the least that is asked on its walls takes.
std::optional<Sectors> ring_about(const MeshDistance& mesh, std::uint32_t index,
                                  std::span<const RoundPart> parts, const AllowedSpace& allowed, int most) {
  const RoundPart& bore = parts[index];
  for (const RoundPart& part : parts) {
    if (part.is_bore || !is_about(part, bore) || !have_same_facets(part, bore)) continue;
    Sectors ring{bore, 0, index, part.radius, ring_shell(mesh, bore, part)};
    const double inner = limit_on(mesh.mesh(), ring.shell, bore, allowed),
                 outer = limit_on(mesh.mesh(), ring.shell, part, allowed);
    if (!ring.is_ring(std::min(inner, outer))) continue;  // without a shell, too
    // Sectors of as many facets each, or fewer that begin within facets.
    ring.count = whole_part(std::max(fewest(bore, inner), fewest(part, outer)), bore.facets);
    Sectors unequal = ring;
    unequal.chords = fewest_chords(bore.facets, {inner / bore.radius, outer / part.radius});
    unequal.count = static_cast<int>(unequal.chords.size());
    const auto serves = [&](const Sectors& sectors) {
      return sectors.count <= most && has_cover(mesh.mesh(), sectors, allowed);
    };
    if (unequal.count < ring.count && serves(unequal)) return unequal;
    if (serves(ring)) return ring;
  }
  return std::nullopt;
}

}  // namespace

std::vector<Sectors> sectors_about_bores(const MeshDistance& mesh, std::span<const RoundPart> parts,
                                         const AllowedSpace& allowed, std::span<const std::uint32_t> no_rings,
                                         int most) {
  std::vector<Sectors> result;
  for (std::uint32_t i = 0; i < parts.size(); ++i) {
    const RoundPart& bore = parts[i];
    if (!bore.is_bore) continue;
    const auto limit_at = [&](const RoundPart& part) {
      return allowed.limit_at(part.foot + 0.5 * part.length * part.axis + part.radius * part.start);
    };
    // The parts about the same axis give the outer radius, and the count that their errors ask for.
    Sectors sectors{bore, fewest(bore, limit_at(bore)), i, bore.radius};
    for (const RoundPart& part : parts) {
      if (!is_about(part, bore)) continue;
      sectors.outer = std::max(sectors.outer, part.radius);
      if (part.is_bore) continue;
      sectors.count =
          std::max(sectors.count, have_same_facets(part, bore) ? fewest(part, limit_at(part))
                                                               : fewest(part.radius, limit_at(part), false));
    }
    // A ring that closes about the bore takes precedence.
    const bool may_be_ring = std::find(no_rings.begin(), no_rings.end(), i) == no_rings.end();
    std::optional<Sectors> ring = may_be_ring ? ring_about(mesh, i, parts, allowed, most) : std::nullopt;
    if (ring)
      result.push_back(*std::move(ring));
    else if (sectors.count >= kFewest && sectors.count <= most)
      result.push_back(sectors);
  }
  return result;
}

}  // namespace touchstone::fit

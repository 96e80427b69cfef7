#include "touchstone/contact_core/fit/parts/prisms.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/fit/parts/sectors.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"

namespace touchstone::fit {
namespace {

constexpr double kRoom = 1.0 / 512.0;   // of the limit: what corners may be off
constexpr std::size_t kMostAxes = 64;   // tried of a shell
constexpr std::size_t kMostSteps = 16;  // along an axis of a shell
constexpr double kSurely = 0.9;         // of the limit: what slabs of one strip may take
constexpr double kTip = 0.25;           // of the limit, from the middle: the end that slabs have at a tip

using Point = Prism::Point;

struct Shell {
  std::vector<std::uint32_t> triangles;
  std::vector<Vector3> corners;  // three a triangle
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
    for (const std::uint32_t corner : mesh.triangles[t]) {
      shells[shell].corners.push_back(mesh.vertices[corner]);
      shells[shell].box.add(mesh.vertices[corner]);
    }
    const Vector3 foot = mesh.vertices[mesh.triangles[t][0]] - distance.bounds().low;
    shells[shell].volume += dot(foot, area_vector(mesh, t)) / 6.0;
  }
  std::erase_if(shells, [](const Shell& shell) { return shell.triangles.empty(); });
  return shells;
}

bool overlap(const Bounds& a, const Bounds& b) {
  return (a.low - b.high).maxCoeff() <= 0.0 && (b.low - a.high).maxCoeff() <= 0.0;
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
  const auto turned = [&best](const Point& p) {
    return Point{best[0] * p[0] + best[1] * p[1], best[0] * p[1] - best[1] * p[0]};
  };
  for (Point& p : prism.section) p = turned(p);
  prism.leans = turned(prism.leans);
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
bool has_plane_sides(const Shell& shell, const Prism& prism, double room) {
  const std::vector<Point>& section = prism.section;
  const auto is_on_a_side = [&](std::size_t t) {
    std::array<Point, 3> flat;
    int low = 0, high = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3& p = shell.corners[t + i];
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
  };
  for (std::size_t t = 0; t < shell.corners.size(); t += 3)
    if (!is_on_a_side(t)) return false;
  return true;
}

// A prism without a section yet.
Prism frame_along(const Shell& shell, const Vector3& axis, double over) {
  Prism prism{};
  prism.axis = axis;
  prism.low = kInfinity;
  prism.high = -prism.low;
  for (const Vector3& p : shell.corners) {
    prism.low = std::min(prism.low, dot(axis, p));
    prism.high = std::max(prism.high, dot(axis, p));
  }
  const Vector3 hint = std::abs(axis.x()) < 0.7 ? Vector3::UnitX() : Vector3::UnitY();
  prism.up = hint - dot(hint, axis) * axis;
  prism.up /= norm(prism.up);
  prism.side = cross(axis, prism.up);
  prism.box = shell.box;
  prism.over = over;
  prism.room = kRoom * over;
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

// Between parallel lines at the section's corners: no convex polygon is thinner than between its edges.
double thickness(const std::vector<Point>& section) {
  double least = kInfinity;
  for (std::size_t i = 0; i < section.size(); ++i) {
    const Point &a = section[i], &b = section[(i + 1) % section.size()];
    double most = 0.0;
    for (const Point& p : section) most = std::max(most, turn(a, b, p));
    least = std::min(least, most / std::hypot(b[0] - a[0], b[1] - a[1]));
  }
  return least;
}

// Along the axis all corners are at two heights: those seen along it, of each end.
std::optional<std::array<std::vector<Point>, 2>> ends_of(const Shell& shell, const Prism& frame) {
  std::array<std::vector<Point>, 2> ends;
  for (const Vector3& p : shell.corners) {
    const double above = dot(frame.axis, p) - frame.low, below = frame.high - dot(frame.axis, p);
    if (std::min(above, below) > frame.room) return std::nullopt;
    ends[above > frame.room ? 1 : 0].push_back({dot(frame.up, p), dot(frame.side, p)});
  }
  return ends;
}

// A right prism: the corners of both ends have one hull, which is as large as the shell.
std::optional<Prism> right_prism(const Shell& shell, Prism prism,
                                 const std::array<std::vector<Point>, 2>& ends) {
  const double length = prism.high - prism.low, room = prism.room;
  std::vector<Point> corners = ends[0];
  corners.insert(corners.end(), ends[1].begin(), ends[1].end());
  prism.section = hull_of(std::move(corners), room);
  if (prism.section.size() < 3 || !has_blunt_edges(prism.section)) return std::nullopt;
  // A frustum's sides are on no edge of it, and its volume is another.
  if (!has_plane_sides(shell, prism, room)) return std::nullopt;
  const double area = area_of(prism.section),
               off = 2.0 * room * (area + length_around(prism.section) * length);
  if (std::abs(area * length - shell.volume) > off) return std::nullopt;
  return prism;
}

// The middle of a polygon's area.
Point middle_of(const std::vector<Point>& polygon) {
  Point sum = {0.0, 0.0};
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const double twice = turn(polygon[0], polygon[i - 1], polygon[i]);
    for (int k = 0; k < 2; ++k) sum[k] += twice * (polygon[0][k] + polygon[i - 1][k] + polygon[i][k]) / 6.0;
  }
  const double area = area_of(polygon);
  return {sum[0] / area, sum[1] / area};
}

// Whether each triangle is of one end or on one of its sides, and nothing of the shell is outside of these.
bool has_tapered_sides(const Shell& shell, const Prism& prism) {
  std::vector<Plane> sides;
  for (std::size_t i = 0; i < prism.section.size(); ++i) {
    const Point &a = prism.section[i], &b = prism.section[(i + 1) % prism.section.size()];
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
    const Point across = {(b[1] - a[1]) / length, -(b[0] - a[0]) / length};
    sides.push_back(prism.plane_through(across, across[0] * a[0] + across[1] * a[1]));
  }
  for (std::size_t t = 0; t < shell.corners.size(); t += 3) {
    const std::span<const Vector3> corners = std::span(shell.corners).subspan(t, 3);
    const auto are_all = [&](const auto& is_there) {
      return std::all_of(corners.begin(), corners.end(), is_there);
    };
    bool is_on_one =
        are_all([&](const Vector3& p) { return dot(prism.axis, p) - prism.low <= prism.room; }) ||
        are_all([&](const Vector3& p) { return prism.high - dot(prism.axis, p) <= prism.room; });
    for (const Plane& side : sides) {
      if (!are_all([&](const Vector3& p) { return side.signed_distance(p) <= prism.room; })) return false;
      is_on_one =
          is_on_one || are_all([&](const Vector3& p) { return side.signed_distance(p) >= -prism.room; });
    }
    if (!is_on_one) return false;
  }
  return true;
}

// Where a place in the section is at one of the ends.
Vector3 place_of(const Prism& prism, const Point& q, bool is_high) {
  if (!is_high) return q[0] * prism.up + q[1] * prism.side + prism.low * prism.axis;
  const double share = 1.0 - prism.narrows;
  return (share * q[0] + prism.leans[0]) * prism.up + (share * q[1] + prism.leans[1]) * prism.side +
         prism.high * prism.axis;
}

// The closed shell that it is.
TriangleMesh mesh_of(const Prism& prism) {
  TriangleMesh mesh;
  const auto count = static_cast<std::uint32_t>(prism.section.size());
  for (const Point& q : prism.section)
    for (const bool is_high : {false, true}) mesh.vertices.push_back(place_of(prism, q, is_high));
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % count);
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
    if (i == 0 || i + 1 == count) continue;
    mesh.triangles.push_back({0, b, a});
    mesh.triangles.push_back({1, a + 1, b + 1});
  }
  return mesh;
}

// A tapered one, the larger end at `low`: the smaller one is like it, or a point.
std::optional<Prism> tapered_prism(const Shell& shell, Prism prism,
                                   const std::array<std::vector<Point>, 2>& ends) {
  const double length = prism.high - prism.low, room = prism.room;
  prism.section = hull_of(ends[0], room);
  if (prism.section.size() < 3 || !has_blunt_edges(prism.section)) return std::nullopt;
  // Both sections' areas and middles tell how one becomes the other.
  const double area = area_of(prism.section);
  const Point middle = middle_of(prism.section);
  const std::vector<Point> top = hull_of(ends[1], room);
  const double top_area = top.size() < 3 ? 0.0 : area_of(top);
  const Point top_middle = top_area > 0.0 ? middle_of(top) : ends[1].front();
  if (top_area > area) return std::nullopt;
  const double share = std::sqrt(top_area / area);
  prism.narrows = 1.0 - share;
  prism.leans = {top_middle[0] - share * middle[0], top_middle[1] - share * middle[1]};
  if (!has_tapered_sides(shell, prism)) return std::nullopt;
  const double volume = area * length * (1.0 + share + share * share) / 3.0,
               off = 2.0 * room * (area + length_around(prism.section) * length);
  if (std::abs(volume - shell.volume) > off) return std::nullopt;
  // At a tip slabs stand a little off, as their ends need a width.
  double reach = 0.0;
  for (const Point& q : prism.section)
    reach = std::max(reach, std::hypot(q[0] - middle[0], q[1] - middle[1]));
  const double kept = std::max(share, std::min(kTip * prism.over / reach, 1.0));
  prism.narrows = 1.0 - kept;
  prism.leans = {top_middle[0] - kept * middle[0], top_middle[1] - kept * middle[1]};
  prism.shell = std::make_shared<const MeshDistance>(weld(mesh_of(prism)));
  return prism;
}

// Between borders of strips: corners of the section, and where the borders meet its edges, at both ends.
std::vector<Vector3> corners_of_strip(const Prism& prism, std::size_t strip) {
  const double bottom = strip == 0 ? prism.lowest() : prism.borders[strip - 1],
               top = strip + 1 == prism.strips() ? prism.highest() : prism.borders[strip];
  std::vector<Point> flat;
  for (const Point& q : prism.section)
    if (q[0] >= bottom && q[0] <= top) flat.push_back(q);
  for (const double height : {bottom, top})
    for (const double out : {-1.0, 1.0}) flat.push_back({height, prism.outermost(height, out)});
  std::vector<Vector3> points;
  for (const Point& q : flat)
    for (const bool is_high : {false, true}) points.push_back(place_of(prism, q, is_high));
  return points;
}

// Whether a slab a strip keeps to what is asked: then there is a cover of such.
bool has_cover(const Prism& prism) {
  for (std::size_t strip = 0; strip < prism.strips(); ++strip)
    if (!prism.is_about(prism.slab(corners_of_strip(prism, strip), strip, strip), kSurely * prism.over))
      return false;
  return true;
}

// Right or tapered, however thin, and whether or not slabs of its strips keep to what is asked.
std::optional<Prism> shape_along(const Shell& shell, const Vector3& axis, double over) {
  const Prism frame = frame_along(shell, axis, over);
  const std::optional<std::array<std::vector<Point>, 2>> ends = ends_of(shell, frame);
  if (!ends || (*ends)[0].empty() || (*ends)[1].empty()) return std::nullopt;
  std::optional<Prism> prism = right_prism(shell, frame, *ends);
  if (!prism) prism = tapered_prism(shell, frame, *ends);
  if (!prism) return std::nullopt;
  choose_up(*prism, prism->room);
  prism->thickness = std::min(thickness(prism->section), prism->high - prism->low);
  prism->triangles = shell.triangles;
  for (std::size_t t = 0; t < shell.corners.size(); t += 3)
    prism->surface.push_back({shell.corners[t], shell.corners[t + 1], shell.corners[t + 2]});
  return prism;
}

// One that has a cover of slabs.
std::optional<Prism> prism_along(const Shell& shell, const Vector3& axis, double over) {
  std::optional<Prism> prism = shape_along(shell, axis, over);
  if (prism && !has_cover(*prism)) return std::nullopt;
  return prism;
}

// One of `count` stairs that a tapered one is cut into across its axis: covered by upright slabs on its lower
// end, as far as these keep to what is asked of the tapered one.
Prism stair_of(const Prism& tapered, std::size_t index, std::size_t count) {
  Prism stair = tapered;
  const double share = static_cast<double>(index) / static_cast<double>(count),
               length = tapered.high - tapered.low;
  stair.low = tapered.low + share * length;
  stair.high = tapered.low + static_cast<double>(index + 1) / static_cast<double>(count) * length;
  // The section is what the tapered one has at this height.
  for (Point& q : stair.section)
    for (int k = 0; k < 2; ++k) q[k] = (1.0 - share * tapered.narrows) * q[k] + share * tapered.leans[k];
  stair.narrows = 0.0;
  stair.leans = {0.0, 0.0};
  stair.borders.clear();
  choose_up(stair, stair.room);
  stair.thickness = std::min(thickness(stair.section), stair.high - stair.low);
  // Nothing is cut off the ends of the first and the last one.
  if (index > 0) stair.surface = parts_of(stair.surface, {stair.axis, -stair.low}, 1.0);
  if (index + 1 < count) stair.surface = parts_of(stair.surface, {stair.axis, -stair.high}, -1.0);
  return stair;
}

// A tapered slice that widens so fast that the sides of slabs would be too nearly in one plane: as few stairs
// as have a cover each; none where many would not do.
std::vector<Prism> stairs_along(const Shell& slice, const Vector3& axis, double over) {
  std::optional<Prism> tapered = shape_along(slice, axis, over);
  if (!tapered || !tapered->is_tapered()) tapered = shape_along(slice, -axis, over);
  if (!tapered || !tapered->is_tapered()) return {};
  for (std::size_t count = 2; count <= kMostSteps; ++count) {
    std::vector<Prism> stairs;
    while (stairs.size() < count) {
      stairs.push_back(stair_of(*tapered, stairs.size(), count));
      if (!has_cover(stairs.back())) break;
      if (stairs.size() == count) return stairs;
    }
  }
  return {};
}

// The heights along the axis at which a shell has corners, those within `room` as one; none where they are
// many.
std::vector<double> steps_of(const Shell& shell, const Vector3& axis, double room) {
  std::vector<double> steps;
  for (const Vector3& p : shell.corners) {
    const double at = dot(axis, p);
    const auto above = std::lower_bound(steps.begin(), steps.end(), at);
    if (above != steps.end() && *above - at <= room) continue;
    if (above != steps.begin() && at - *std::prev(above) <= room) continue;
    if (steps.size() == kMostSteps) return {};
    steps.insert(above, at);
  }
  return steps;
}

// Whether a polygon lies in a step: it bounds slices from their ends.
bool is_flat(const Polygon& polygon, const Vector3& axis, double room) {
  double low = kInfinity, high = -low;
  for (const Vector3& p : polygon) {
    low = std::min(low, dot(axis, p));
    high = std::max(high, dot(axis, p));
  }
  return high - low <= room;
}

// What of the polygons is between two steps. What reaches over a step by rounding is flat there: it is put to
// the others that are.
Shell slice_of(const std::vector<Polygon>& polygons, const Vector3& axis, double low, double high,
               double room, std::vector<Polygon>& flat) {
  // Its volume is that which the sides have with what is across the axis: the ends have none.
  Shell slice;
  for (Polygon& part : parts_of(parts_of(polygons, {axis, -low}, 1.0), {axis, -high}, -1.0)) {
    if (is_flat(part, axis, room)) {
      flat.push_back(std::move(part));
      continue;
    }
    for (std::size_t i = 2; i < part.size(); ++i) {
      const Vector3 middle = (part[0] + part[i - 1] + part[i]) / 3.0 - polygons.front().front();
      const Vector3 across = middle - dot(axis, middle) * axis;
      slice.volume += 0.25 * dot(across, cross(part[i - 1] - part[0], part[i] - part[0]));
      slice.corners.insert(slice.corners.end(), {part[0], part[i - 1], part[i]});
    }
  }
  for (const Vector3& p : slice.corners) slice.box.add(p);
  return slice;
}

// Gives each to a slice that holds it. @return whether there always is one
bool give_flat_ones(const std::vector<Polygon>& flat, double room, std::vector<Prism>& slices) {
  for (const Polygon& each : flat) {
    const auto slice = std::find_if(slices.begin(), slices.end(), [&](const Prism& prism) {
      return std::all_of(each.begin(), each.end(), [&](const Vector3& p) {
        const double at = dot(prism.axis, p);
        return at >= prism.low - 2.0 * room && at <= prism.high + 2.0 * room &&
               prism.distance(p) <= 2.0 * room;
      });
    });
    if (slice == slices.end()) return false;
    slice->surface.push_back(each);
  }
  return true;
}

// A shell that steps along the axis, slice by slice.
std::vector<Prism> stack_along(const Shell& shell, const Vector3& axis, double over) {
  // Heights at which the shell's outline changes.
  const double room = kRoom * over;
  std::vector<double> steps = steps_of(shell, axis, room);
  if (steps.size() < 3) return {};
  steps.front() -= 2.0 * room;  // nothing is cut off its ends
  steps.back() += 2.0 * room;
  // Triangles along the axis, and those across it.
  std::vector<Polygon> sides, flat;
  for (std::size_t t = 0; t < shell.corners.size(); t += 3) {
    Polygon triangle = {shell.corners[t], shell.corners[t + 1], shell.corners[t + 2]};
    (is_flat(triangle, axis, room) ? flat : sides).push_back(std::move(triangle));
  }
  if (sides.empty()) return {};
  // A prism from step to step; stairs where there is none.
  std::vector<Prism> slices;
  for (std::size_t i = 1; i < steps.size(); ++i) {
    Shell slice = slice_of(sides, axis, steps[i - 1], steps[i], room, flat);
    if (slice.corners.empty()) return {};
    slice.triangles = shell.triangles;
    std::optional<Prism> prism = prism_along(slice, axis, over);
    if (!prism) prism = prism_along(slice, -axis, over);
    if (prism) {
      slices.push_back(*std::move(prism));
      continue;
    }
    std::vector<Prism> stairs = stairs_along(slice, axis, over);
    if (stairs.empty()) return {};
    for (Prism& stair : stairs) slices.push_back(std::move(stair));
  }
  return give_flat_ones(flat, room, slices) ? slices : std::vector<Prism>();
}

// Of all of a shell's triangles, each once.
std::vector<std::uint32_t> vertices_of(const TriangleMesh& mesh, const Shell& shell) {
  std::vector<std::uint32_t> vertices;
  for (const std::uint32_t t : shell.triangles)
    vertices.insert(vertices.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

// From the middle of the corners at one end to that of those at the other: ends are small, and their
// triangles' normals as wrong as rounded corners let them be.
Vector3 refined(const TriangleMesh& mesh, const std::vector<std::uint32_t>& corners, const Vector3& axis) {
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

bool are_thick(const std::vector<Prism>& prisms) {
  return std::any_of(prisms.begin(), prisms.end(),
                     [](const Prism& prism) { return prism.thickness >= kThick * prism.over; });
}

// One, or one of each step along an axis.
std::vector<Prism> prisms_of(const TriangleMesh& mesh, const Shell& shell, double over) {
  std::vector<Vector3> tried;
  const std::vector<std::uint32_t> vertices = vertices_of(mesh, shell);
  for (const std::uint32_t t : shell.triangles) {
    const Vector3 n = area_vector(mesh, t);
    const double area = norm(n);
    if (area == 0.0) continue;
    const Vector3 axis = n / area;
    if (std::any_of(tried.begin(), tried.end(),
                    [&](const Vector3& other) { return std::abs(dot(other, axis)) > 1.0 - 1e-9; }))
      continue;
    if (tried.size() == kMostAxes) return {};
    tried.push_back(axis);
    const Vector3 along = refined(mesh, vertices, axis);
    for (const Vector3& each : {along, Vector3(-along), axis, Vector3(-axis)})
      if (std::optional<Prism> prism = prism_along(shell, each, over); prism && are_thick({*prism}))
        return {*std::move(prism)};
    std::vector<Prism> stack = stack_along(shell, axis, over);
    if (are_thick(stack)) return stack;
  }
  return {};
}

}  // namespace

std::vector<Prism> find_prisms(const MeshDistance& mesh, double over, std::span<const LimitBox> boxes) {
  const std::vector<Shell> shells = closed_shells(mesh);
  std::vector<Prism> prisms;
  std::vector<Bounds> cavities;
  for (const Shell& shell : shells)
    if (!(shell.volume > 0.0)) cavities.push_back(shell.box);
  for (const Shell& shell : shells) {
    if (!(shell.volume > 0.0) || (shell.box.high - shell.box.low).minCoeff() <= 0.0) continue;
    const double least = least_limit(over, boxes, shell.corners);
    if (shell.box.diagonal() < kThick * least) continue;  // no part of it is thick
    const bool may_have_cavity = std::any_of(cavities.begin(), cavities.end(),
                                             [&](const Bounds& box) { return overlap(shell.box, box); });
    if (may_have_cavity) continue;
    for (Prism& prism : prisms_of(mesh.mesh(), shell, least)) prisms.push_back(std::move(prism));
  }
  return prisms;
}

std::optional<MeshDistance> without(const MeshDistance& mesh, const std::vector<std::uint8_t>& is_out) {
  TriangleMesh rest;
  rest.vertices = mesh.mesh().vertices;
  for (std::size_t t = 0; t < is_out.size(); ++t)
    if (is_out[t] == 0) rest.triangles.push_back(mesh.mesh().triangles[t]);
  if (rest.triangles.empty()) return std::nullopt;
  return MeshDistance(weld(rest));
}

}  // namespace touchstone::fit

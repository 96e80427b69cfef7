#include "touchstone/adapters/cover_proof/exact_cover.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <tuple>

namespace touchstone::cover_proof {
namespace {

struct Direction {
  mpz_class x, y, z;
};

Direction difference(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }  // w = 1

Direction cross(const Direction& u, const Direction& v) {
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

mpz_class dot(const Direction& u, const Direction& v) { return u.x * v.x + u.y * v.y + u.z * v.z; }

mpz_class height(const FacetPlane& plane, const Point& p) {
  return plane.x * p.x + plane.y * p.y + plane.z * p.z + plane.d * p.w;
}

// Divides by what all four have in common, so that numbers stay as long as the point needs.
void reduce(Point& p) {
  mpz_class common = gcd(p.x, p.y);
  common = gcd(common, p.z);
  common = gcd(common, p.w);
  if (common <= 1) return;
  p.x /= common;
  p.y /= common;
  p.z /= common;
  p.w /= common;
}

// Where the segment from a, hb below... to b meets the plane: heights ha > 0 > hb or the reverse.
Point meeting_point(const Point& a, const mpz_class& ha, const Point& b, const mpz_class& hb) {
  const mpz_class u = abs(hb), v = abs(ha);
  Point p{a.x * u + b.x * v, a.y * u + b.y * v, a.z * u + b.z * v, a.w * u + b.w * v};
  reduce(p);
  return p;
}

struct Cut {
  Polygon inside, outside;
};

// A polygon that lies in the plane is inside: hulls are closed.
Cut cut(const Polygon& polygon, const FacetPlane& plane) {
  std::vector<mpz_class> heights;
  for (const Point& p : polygon) heights.push_back(height(plane, p));
  const bool is_out = std::any_of(heights.begin(), heights.end(), [](const mpz_class& h) { return h > 0; });
  const bool is_in = std::any_of(heights.begin(), heights.end(), [](const mpz_class& h) { return h < 0; });
  if (!is_out) return {polygon, {}};
  if (!is_in) return {{}, polygon};
  Cut result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const std::size_t j = (i + 1) % polygon.size();
    if (heights[i] <= 0) result.inside.push_back(polygon[i]);
    if (heights[i] >= 0) result.outside.push_back(polygon[i]);
    if (sgn(heights[i]) * sgn(heights[j]) >= 0) continue;
    const Point p = meeting_point(polygon[i], heights[i], polygon[j], heights[j]);
    result.inside.push_back(p);
    result.outside.push_back(p);
  }
  return result;
}

// Counter-clockwise from outside: after each vertex the one that has all others to its left.
std::vector<int> loop(const std::vector<int>& corners, const std::array<Point, 8>& points,
                      const Direction& n) {
  // Turns and lengths are integers, so that their signs are exact.
  const auto turn = [&](int a, int b, int c) {
    return sgn(dot(n, cross(difference(points[b], points[a]), difference(points[c], points[a]))));
  };
  const auto squared = [&](int a, int b) {
    const Direction d = difference(points[b], points[a]);
    return dot(d, d);
  };
  // Gift wrapping begins at a corner of the hull.
  int first = corners[0];  // the lowest by coordinates is extreme
  const auto key = [&](int i) { return std::tie(points[i].x, points[i].y, points[i].z); };
  for (const int i : corners)
    if (key(i) < key(first)) first = i;
  std::vector<int> result{first};
  // The next corner has all others to one side; of corners in line the farthest counts.
  while (result.size() <= corners.size()) {
    const int from = result.back();
    int next = -1;
    for (const int i : corners) {
      if (key(i) == key(from)) continue;
      const int side = next < 0 ? -1 : turn(from, next, i);
      if (side < 0 || (side == 0 && squared(from, i) > squared(from, next))) next = i;
    }
    if (next < 0 || key(next) == key(first)) break;
    result.push_back(next);
  }
  return result;
}

FacetPlane make_plane(const Direction& n, const Point& p, const std::array<Point, 8>& points,
                      const std::array<Vector3, 8>& vertices, int foot) {
  FacetPlane plane{n.x, n.y, n.z, -(n.x * p.x + n.y * p.y + n.z * p.z), Vector3::Zero(), vertices[foot], {}};
  mpz_class common = gcd(gcd(plane.x, plane.y), gcd(plane.z, plane.d));
  plane.x /= common;
  plane.y /= common;
  plane.z /= common;
  plane.d /= common;
  const std::array<const mpz_class*, 3> parts = {&plane.x, &plane.y, &plane.z};
  long largest = 0;
  for (const mpz_class* part : parts)
    largest = std::max(largest, static_cast<long>(mpz_sizeinbase(part->get_mpz_t(), 2)));
  for (int axis = 0; axis < 3; ++axis) {
    long exponent = 0;
    const double mantissa = mpz_get_d_2exp(&exponent, parts[axis]->get_mpz_t());
    plane.normal(axis) =
        mantissa == 0.0 ? 0.0 : std::ldexp(mantissa, static_cast<int>(std::max(exponent - largest, -900L)));
  }
  std::vector<int> corners;
  for (int i = 0; i < 8; ++i)
    if (height(plane, points[i]) == 0) corners.push_back(i);
  plane.corners = loop(corners, points, n);
  return plane;
}

bool has_area(const Polygon& polygon) { return polygon.size() >= 3; }

}  // namespace

void Grid::include(const Vector3& p) {
  for (int axis = 0; axis < 3; ++axis) {
    if (p(axis) == 0.0) continue;
    int exponent = 0;
    std::frexp(p(axis), &exponent);
    const long lowest = exponent - 53L;
    exponent_ = is_empty_ ? lowest : std::min(exponent_, lowest);
    is_empty_ = false;
  }
}

Point Grid::on_grid(const Vector3& p) const {
  Grid own = *this;  // as fine as this point needs
  own.include(p);
  const auto whole = [&own](double value) {
    if (value == 0.0) return mpz_class(0);
    int exponent = 0;
    const double mantissa = std::frexp(value, &exponent);
    mpz_class result = static_cast<long>(std::ldexp(mantissa, 53));
    result <<= static_cast<mp_bitcnt_t>(exponent - 53L - own.exponent_);
    return result;
  };
  mpz_class unit = 1;
  if (!is_empty_) unit <<= static_cast<mp_bitcnt_t>(exponent_ - own.exponent_);
  return {whole(p.x()), whole(p.y()), whole(p.z()), unit};
}

double Grid::to_metres(const mpz_class& numerator, const mpz_class& denominator) const {
  const mpq_class ratio(numerator, denominator);
  return std::ldexp(ratio.get_d(), static_cast<int>(exponent_));
}

Vector3 Grid::to_metres(const Point& p) const {
  return {to_metres(p.x, p.w), to_metres(p.y, p.w), to_metres(p.z, p.w)};
}

Hull make_hull(const std::array<Vector3, 8>& vertices, const Grid& grid) {
  Hull hull;
  // Exact tests use points of the grid, searches the box in doubles.
  hull.low = hull.high = vertices[0];
  for (int i = 0; i < 8; ++i) {
    hull.points[i] = grid.on_grid(vertices[i]);
    hull.low = hull.low.cwiseMin(vertices[i]);
    hull.high = hull.high.cwiseMax(vertices[i]);
  }
  // Three vertices span a facet where all others lie to one side of their plane.
  for (int i = 0; i < 8; ++i) {
    for (int j = i + 1; j < 8; ++j) {
      for (int k = j + 1; k < 8; ++k) {
        Direction n =
            cross(difference(hull.points[j], hull.points[i]), difference(hull.points[k], hull.points[i]));
        if (n.x == 0 && n.y == 0 && n.z == 0) continue;
        int highest = 0, lowest = 0;
        for (const Point& p : hull.points) {
          const int s = sgn(dot(n, difference(p, hull.points[i])));
          highest = std::max(highest, s);
          lowest = std::min(lowest, s);
        }
        if (highest == lowest) return hull;  // all in one plane: no volume
        if (highest > 0 && lowest < 0) continue;
        // Normals point outwards; a facet of more than three corners comes up again.
        if (highest > 0) n = {-n.x, -n.y, -n.z};
        FacetPlane plane = make_plane(n, hull.points[i], hull.points, vertices, i);
        const bool is_known =
            std::any_of(hull.planes.begin(), hull.planes.end(), [&](const FacetPlane& other) {
              return other.x == plane.x && other.y == plane.y && other.z == plane.z && other.d == plane.d;
            });
        if (!is_known) hull.planes.push_back(std::move(plane));
      }
    }
  }
  return hull;
}

int side(const FacetPlane& plane, const Point& p) { return sgn(height(plane, p)); }

int side(const FacetPlane& plane, const Vector3& p, const Grid& grid) {
  const Vector3 d = p - plane.foot;
  const double x = plane.normal.x() * d.x(), y = plane.normal.y() * d.y(), z = plane.normal.z() * d.z();
  const double value = (x + y) + z;
  // Six roundings of relative 2^-52 at most; 2^-48 holds them with room. Underflow leaves it to integers.
  if (std::abs(value) > 0x1p-48 * (std::abs(x) + std::abs(y) + std::abs(z)) + 0x1p-800)
    return value > 0.0 ? 1 : -1;
  return side(plane, grid.on_grid(p));
}

bool subtract(const Polygon& polygon, std::span<const Hull* const> others, std::size_t most_left,
              std::vector<Polygon>& left) {
  if (others.empty()) {
    left.push_back(polygon);
    return left.size() < most_left;
  }
  const Hull& hull = *others.front();
  Polygon rest = polygon;
  std::vector<Polygon> outside;
  for (const FacetPlane& plane : hull.planes) {
    Cut parts = cut(rest, plane);
    if (has_area(parts.outside)) outside.push_back(std::move(parts.outside));
    rest = std::move(parts.inside);
    if (!has_area(rest)) break;
  }
  const std::span<const Hull* const> remaining = others.subspan(1);
  if (!has_area(rest)) return subtract(polygon, remaining, most_left, left);
  for (const Polygon& part : outside)
    if (!subtract(part, remaining, most_left, left)) return false;
  return true;
}

namespace {

// Whether a line along an edge of the part has all of the part on one side and the trace on the other. Both
// lie in the facet's plane.
bool is_apart(const Polygon& part, const FacetPlane& facet, const Polygon& trace) {
  const auto scaled_difference = [](const Point& a, const Point& b) {  // times both denominators
    return Direction{a.x * b.w - b.x * a.w, a.y * b.w - b.y * a.w, a.z * b.w - b.z * a.w};
  };
  for (std::size_t i = 0; i < part.size(); ++i) {
    const Point &from = part[i], &to = part[(i + 1) % part.size()];
    const Direction across = cross(Direction{facet.x, facet.y, facet.z}, scaled_difference(to, from));
    const auto turn = [&](const Point& p) { return sgn(dot(across, scaled_difference(p, from))); };
    int inner = 0;
    for (const Point& p : part)
      if (inner == 0) inner = turn(p);
    if (inner == 0) continue;  // no edge
    if (std::all_of(trace.begin(), trace.end(), [&](const Point& p) { return inner * turn(p) <= 0; }))
      return true;
  }
  return false;
}

}  // namespace

void divide(std::vector<Polygon>& parts, const FacetPlane& facet, const std::array<Point, 3>& triangle) {
  // A triangle that nowhere rises above the facet divides nothing.
  std::array<mpz_class, 3> heights;
  for (int i = 0; i < 3; ++i) heights[i] = height(facet, triangle[i]);
  if (std::none_of(heights.begin(), heights.end(), [](const mpz_class& h) { return h > 0; })) return;
  // The triangle meets the facet's plane in a segment, a corner, or not at all.
  Polygon trace;  // of the triangle in the facet's plane
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (heights[i] == 0) trace.push_back(triangle[i]);
    if (sgn(heights[i]) * sgn(heights[j]) < 0)
      trace.push_back(meeting_point(triangle[i], heights[i], triangle[j], heights[j]));
  }
  if (trace.empty()) return;
  // Only parts that the trace may meet are cut by the triangle's plane.
  const Direction n = cross(difference(triangle[1], triangle[0]), difference(triangle[2], triangle[0]));
  const Point& a = triangle[0];
  const FacetPlane plane{
      n.x, n.y, n.z, -(n.x * a.x + n.y * a.y + n.z * a.z), Vector3::Zero(), Vector3::Zero(), {}};
  std::vector<Polygon> divided;
  for (Polygon& part : parts) {
    if (is_apart(part, facet, trace)) {
      divided.push_back(std::move(part));
      continue;
    }
    Cut halves = cut(part, plane);
    if (has_area(halves.inside)) divided.push_back(std::move(halves.inside));
    if (has_area(halves.outside)) divided.push_back(std::move(halves.outside));
  }
  parts = std::move(divided);
}

std::string text_of(const Vector3& p) {
  std::ostringstream text;
  text.precision(9);
  text << "(" << p.x() << ", " << p.y() << ", " << p.z() << ")";
  return text.str();
}

}  // namespace touchstone::cover_proof

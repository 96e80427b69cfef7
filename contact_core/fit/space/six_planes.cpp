#include "touchstone/contact_core/fit/space/six_planes.hpp"

#include <algorithm>
#include <cmath>

namespace touchstone::fit {
namespace {

double determinant(const Plane& a, const Plane& b, const Plane& c) {
  return dot(a.normal, cross(b.normal, c.normal));
}

Vector3 meeting_point(const Plane& a, const Plane& b, const Plane& c) {
  const Vector3 bc = cross(b.normal, c.normal), ca = cross(c.normal, a.normal),
                ab = cross(a.normal, b.normal);
  return -(bc * a.offset + ca * b.offset + ab * c.offset) / dot(a.normal, bc);
}

// The part on the side of a plane that `sign` names.
Polygon clipped(const Polygon& polygon, const Plane& plane, double sign) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double hp = sign * plane.signed_distance(p), hq = sign * plane.signed_distance(q);
    if (hp >= 0.0) kept.push_back(p);
    if ((hp > 0.0 && hq < 0.0) || (hp < 0.0 && hq > 0.0)) kept.push_back(p + (q - p) * (hp / (hp - hq)));
  }
  return kept;
}

}  // namespace

std::array<Vector3, 8> SixPlanes::corners() const {
  std::array<Vector3, 8> result;
  for (int i = 0; i < 8; ++i)
    result[i] = meeting_point(planes[i >> 2 & 1], planes[2 + (i >> 1 & 1)], planes[4 + (i & 1)]);
  return result;
}

double SixPlanes::above(const Vector3& p) const {
  double highest = -1e300;
  for (const Plane& plane : planes) highest = std::max(highest, plane.signed_distance(p));
  return highest;
}

bool SixPlanes::is_hexahedron(double least_determinant) const {
  for (int i = 0; i < 8; ++i) {
    const Plane &a = planes[i >> 2 & 1], &b = planes[2 + (i >> 1 & 1)], &c = planes[4 + (i & 1)];
    const double det = determinant(a, b, c);
    const bool is_mirrored = ((i >> 2 & 1) + (i >> 1 & 1) + (i & 1)) % 2 == 0;
    if ((is_mirrored ? -det : det) < least_determinant) return false;
  }
  const std::array<Vector3, 8> points = corners();
  for (int i = 0; i < 8; ++i) {
    const std::array<int, 3> opposite = {1 - (i >> 2 & 1), 3 - (i >> 1 & 1), 5 - (i & 1)};
    for (const int f : opposite)
      if (!(planes[f].signed_distance(points[i]) < 0.0)) return false;
  }
  return true;
}

std::vector<Polygon> parts_of(const std::vector<Polygon>& polygons, const Plane& plane, double sign) {
  std::vector<Polygon> kept;
  for (const Polygon& polygon : polygons) {
    Polygon part = clipped(polygon, plane, sign);
    if (!part.empty()) kept.push_back(std::move(part));
  }
  return kept;
}

}  // namespace touchstone::fit

#include "touchstone/contact_core/fit/space/six_planes.hpp"

#include <algorithm>
#include <cmath>

namespace touchstone::fit {
namespace {

constexpr double kSmallestDeterminant = 0.2;  // of three unit normals: corners stay within 10 offsets' errors

double determinant(const Plane& a, const Plane& b, const Plane& c) {
  return dot(a.normal, cross(b.normal, c.normal));
}

Vector3 meeting_point(const Plane& a, const Plane& b, const Plane& c) {
  const Vector3 bc = cross(b.normal, c.normal), ca = cross(c.normal, a.normal),
                ab = cross(a.normal, b.normal);
  return -(bc * a.offset + ca * b.offset + ab * c.offset) / dot(a.normal, bc);
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

bool SixPlanes::is_hexahedron() const {
  for (int i = 0; i < 8; ++i) {
    const Plane &a = planes[i >> 2 & 1], &b = planes[2 + (i >> 1 & 1)], &c = planes[4 + (i & 1)];
    const double det = determinant(a, b, c);
    const bool is_mirrored = ((i >> 2 & 1) + (i >> 1 & 1) + (i & 1)) % 2 == 0;
    if ((is_mirrored ? -det : det) < kSmallestDeterminant) return false;
  }
  const std::array<Vector3, 8> points = corners();
  for (int i = 0; i < 8; ++i) {
    const std::array<int, 3> opposite = {1 - (i >> 2 & 1), 3 - (i >> 1 & 1), 5 - (i & 1)};
    for (const int f : opposite)
      if (!(planes[f].signed_distance(points[i]) < 0.0)) return false;
  }
  return true;
}

}  // namespace touchstone::fit

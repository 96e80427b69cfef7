#include "touchstone/contact_core/fit/space/growth.hpp"

#include <algorithm>

namespace touchstone::fit {
namespace {

Plane through(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& outwards) {
  Vector3 n = cross(b - a, c - a);
  const double length = norm(n);
  if (length == 0.0) return {Vector3::Zero(), 0.0};
  n /= dot(n, outwards) < 0.0 ? -length : length;
  return {n, -dot(n, a)};
}

}  // namespace

Normals box_normals(const Vector3& x, const Vector3& y, const Vector3& z) { return {-x, x, -y, y, -z, z}; }

// Beyond the mesh there is nothing to cover.
double Growth::reach(const Plane& plane) const {
  const Bounds& box = mesh_.bounds();
  Vector3 far;
  for (int axis = 0; axis < 3; ++axis) far(axis) = plane.normal(axis) > 0.0 ? box.high(axis) : box.low(axis);
  return plane.signed_distance(far);
}

bool Growth::has_good_corners(const SixPlanes& solid, int face) const {
  if (!solid.is_hexahedron()) return false;
  const std::array<Vector3, 8> corners = solid.corners();
  const auto& loop = Hexahedron::kFaceVertices[face];
  return std::all_of(loop.begin(), loop.end(), [&](int i) { return space_.allows(corners[i]); });
}

bool Growth::push_face(SixPlanes& solid, int face) {
  const double far = reach(solid.planes[face]);
  if (far <= resolution_) return false;
  const double room = space_.room(solid, face, far);
  if (room <= resolution_) return false;
  const double offset = solid.planes[face].offset;
  const double share = largest_share([&](double s) {
    solid.planes[face].offset = offset - s * room;
    return has_good_corners(solid, face);
  });
  solid.planes[face].offset = offset - share * room;
  return share > 0.0;
}

void Growth::push(SixPlanes& solid, std::span<const int> faces) {
  for (int round = 0; round < 4; ++round) {
    bool has_moved = false;
    for (const int face : faces) has_moved = push_face(solid, face) || has_moved;
    if (!has_moved) return;
  }
}

bool Growth::tilt_face(SixPlanes& solid, int face, int edge) {
  const std::array<Vector3, 8> corners = solid.corners();
  const auto& loop = Hexahedron::kFaceVertices[face];
  const Vector3 &a = corners[loop[edge]], &b = corners[loop[(edge + 1) % 4]],
                &c = corners[loop[(edge + 2) % 4]];
  const Plane before = solid.planes[face];
  Vector3 across = cross(before.normal, b - a);
  const double length = norm(across);
  if (length == 0.0) return false;
  across /= dot(across, c - b) < 0.0 ? -length : length;
  const double width = dot(across, c - b);
  const double far = std::min(norm(c - b), reach(before) + norm(c - b));
  if (far <= resolution_ || width <= resolution_) return false;
  const double slope = space_.slope(solid, face, a, across, far / width);
  if (slope * width <= resolution_) return false;
  const double share = largest_share([&](double s) {
    solid.planes[face] = through(a, b, c + s * slope * width * before.normal, before.normal);
    return has_good_corners(solid, face);
  });
  if (share > 0.0)
    solid.planes[face] = through(a, b, c + share * slope * width * before.normal, before.normal);
  else
    solid.planes[face] = before;
  return share > 0.0;
}

void Growth::tilt(SixPlanes& solid) {
  for (int face = 0; face < 6; ++face)
    for (int edge = 0; edge < 4; ++edge) tilt_face(solid, face, edge);
}

}  // namespace touchstone::fit

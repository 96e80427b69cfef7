#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/contacts/narrowphase_contacts.hpp"

// Pairs that touch along an edge or at a corner of both alone, as cubes of two rows and columns of a wall do.

namespace touchstone::physics {
namespace {

// Of the smaller solid's size: solids that overlap by no more than this along a direction touch there.
constexpr double kNarrow = 0x1p-20;
// Cosine of the angle between directions at right angles: what closes along one of them closes along the
// other by a thousandth at most.
constexpr double kAcross = 0x1p-10;

/// Twice the area of the manifold's polygon, 0 of fewer than three points [m^2].
double area_of(std::span<const ContactPoint> points) {
  Vector3 area = Vector3::Zero();
  for (std::size_t i = 2; i < points.size(); ++i)
    area += cross(points[i - 1].p_A_W - points[0].p_A_W, points[i].p_A_W - points[0].p_A_W);
  return norm(area);
}

}  // namespace

/// Whether the pair is free along a direction at right angles to its normal, or along two at right angles to
/// each other, between which the normal is chance: a face of one of them has all of the other one beyond it.
/// It passes where they do not close across such faces in the step. Neither direction needs the other then:
/// on such an edge what slides down a wall would catch, and columns that touch would stand on each other.
/// @param points of its manifold, as the solids are placed
NarrowphaseContacts::CornerTouch NarrowphaseContacts::corner_touch(const SolidPair& pair,
                                                                   const Vector3& n_AB_W,
                                                                   std::span<const ContactPoint> points,
                                                                   const Placed& placed) const {
  // No more than a face that touches: a polygon as long as the smaller solid, and that narrow.
  const double size = std::min(solid_of(pair.a).size(), solid_of(pair.b).size());
  if (points.empty() || area_of(points) > 2.0 * kNarrow * size * size) return CornerTouch::none;
  // Directions that are free.
  FreeFaces free;
  find_free(pair.a, pair.b, placed, free);
  find_free(pair.b, pair.a, placed, free);
  // It closes unless a direction, or two, stay free.
  CornerTouch touch = CornerTouch::none;
  const std::span<const FreeFaces::Face> faces = std::span(free.faces).first(free.count);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    bool is_free = std::abs(dot(faces[i].normal_W, n_AB_W)) <= kAcross, stays = is_free && faces[i].stays;
    for (std::size_t j = 0; j < i; ++j) {
      if (std::abs(dot(faces[i].normal_W, faces[j].normal_W)) > kAcross) continue;
      is_free = true;
      stays = stays || (faces[i].stays && faces[j].stays);
    }
    if (stays) return CornerTouch::passes;
    if (is_free) touch = CornerTouch::closes;
  }
  return touch;
}

/// Adds the faces of `solid` beyond which all of `other` is, and says whether all of its vertices stay there
/// in the step.
void NarrowphaseContacts::find_free(SolidIndex solid, SolidIndex other, const Placed& placed,
                                    FreeFaces& free) const {
  const Hexahedron &hexahedron = solid_of(solid), &its = solid_of(other);
  const double room = kNarrow * std::min(hexahedron.size(), its.size());
  // Round edges have normals of their own; a bent solid leaves its faces' planes.
  if (hexahedron.is_rounded() || its.is_rounded() || hexahedron.out_of_plane() > room) return;
  const Pose& X_WS = placed.poses[solid];
  const Pose X_SO = compose(inverse(X_WS), placed.poses[other]);
  const Vector3 middle_S = touchstone::transform(X_SO, its.bounding_sphere().centre);
  for (int f = 0; f < 6; ++f) {
    // Most faces have the other's middle before them.
    const Plane plane = hexahedron.face_plane(f);
    if (!(plane.signed_distance(middle_S) > 0.0)) continue;
    const Vector3 normal_W = rotate(X_WS.R, plane.normal);
    double now = kInfinity, then = kInfinity;
    for (const Vector3& vertex : its.vertices()) {
      const double distance = plane.signed_distance(touchstone::transform(X_SO, vertex));
      now = std::min(now, distance);
      if (!(now >= -room)) break;
      const Vector3 p_W = touchstone::transform(placed.poses[other], vertex);
      const Vector3 v_W = velocity_at(other, p_W, placed.t) - velocity_at(solid, p_W, placed.t);
      const double opening = dot(normal_W, v_W) * step_;
      then = std::min(then, distance + std::min(opening, 0.0));
    }
    if (now >= -room) free.faces[free.count++] = {normal_W, then >= -room};
  }
}

/// Of a solid's point, as its mover goes in the step, after t of it.
Vector3 NarrowphaseContacts::velocity_at(SolidIndex solid, const Vector3& p_W, double t) const {
  const Part& part = part_of(solid);
  return part.v_W + cross(part.w_W, p_W - (part.p_W + t * part.v_W));
}

}  // namespace touchstone::physics

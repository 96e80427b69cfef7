#pragma once

#include "touchstone/contact_core/broadphase/world_spheres.hpp"

/// @file
/// Bounds of a solid's motion between two poses.

namespace touchstone {

/// Encloses a solid on its whole path: every point of it is always within `radius` of the segment.
struct SweptSphere {
  using MovesByBits = SweptSphere;  ///< see kMovesByBits

  Vector3 from_W, to_W;  ///< ends of the segment [m]
  double radius;         ///< [m]
};

/// Encloses the solid's world vertices, as rounded by world_vertices(), at every valid pose on a path whose
/// bulge is at most `bulge` (see SolidPaths).
SweptSphere swept_sphere(const Sphere& sphere_S, const Pose& X_WS_from, const Pose& X_WS_to, double bulge);

/// Contains the swept sphere grown by `margin`; see bounding_box(Sphere, margin).
Box bounding_box(const SweptSphere& swept, double margin);

/// False only when no point of one path is within `margin` of any of the other, at whatever times. Not-finite
/// ones may touch everything. Which of two that are apart by a rounding only may touch depends on the order.
bool may_touch(const SweptSphere& a, const SweptSphere& b, double margin);

// Bounds on how far a point of a moving body leaves the straight segment between the two ends of its path.

/// How far a point that travels `length` [m] at most can leave the straight line between its ends.
double bulge_of_path_length(double length, const Vector3& from_W, const Vector3& to_W);

/// The same of a point `arm` [m] at most from a pivot that moves straight and evenly, while the body turns
/// evenly about a fixed direction. @param cos_half_turn cos of half the whole turn; -1 for turns of more than
/// 360 degrees.
double bulge_of_turn(double arm, double cos_half_turn);

/// The same for the path interpolate(X_WO_from, X_WO_to, s); `arm` from O's origin. Covers the poses'
/// tolerance and the rounding of interpolate().
double bulge_of_interpolation(double arm, const Pose& X_WO_from, const Pose& X_WO_to);

}  // namespace touchstone

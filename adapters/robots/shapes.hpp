#pragma once

#include <string>

#include "touchstone/contact_core/mechanism/round_parts.hpp"

/// @file
/// Spheres, capsules and ellipsoids as hexahedra that hold them: bands between circles of latitude, each a
/// frustum over a regular polygon, cut into slices as cylinders are. Band and polygon touch the round shape
/// with all their faces.

namespace touchstone {

/// A sphere about the frame's origin; (facets / 2 - 1)^2 hexahedra. `error` of the figure is the distance of
/// the farthest corner from the sphere, no less than that of any point of the hexahedra.
/// @param facets of the polygon round z, and of the one along a meridian: 4, 8, 12, ... 1024.
/// @throws InputError naming `name` and the figure.
RoundPart make_sphere(double radius, int facets, const Pose& X_OS, const std::string& name);

/// All points within `radius` of the segment from z = -length / 2 to length / 2. @param length > 0 [m].
/// @throws InputError as make_sphere().
RoundPart make_capsule(double radius, double length, int facets, const Pose& X_OS, const std::string& name);

/// An ellipsoid with its half axes along x, y and z: a sphere's hexahedra stretched. `radius` of the figure
/// is the largest half axis, `error` that times the unit sphere's, which no point exceeds.
/// @throws InputError as make_sphere().
RoundPart make_ellipsoid(const Vector3& half_axes, int facets, const Pose& X_OS, const std::string& name);

}  // namespace touchstone

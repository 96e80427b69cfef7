#pragma once

#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/examples/measures/common/random.hpp"

// Where the families of pairs and of paths place their solids.

namespace touchstone::measures {

/// Within 1 m of the origin along each axis.
Pose random_pose(Random& random);
/// A turn about z with z coordinates left exact: cos and sin from the half-angle's tangent t.
Matrix3 turn_about_z(double t);
inline Vector3 unit(const Vector3& v) { return v / norm(v); }

}  // namespace touchstone::measures

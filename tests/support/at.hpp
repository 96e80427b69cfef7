#pragma once

#include "touchstone/contact_core/geometry/pose.hpp"

namespace touchstone {

inline Pose at(const Vector3& p, const Matrix3& R = Matrix3::Identity()) { return {R, p}; }
inline Pose at(double x, double y, double z) { return at({x, y, z}); }

}  // namespace touchstone

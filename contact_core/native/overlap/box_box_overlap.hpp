#pragma once

#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/contact_core/numerics/certified.hpp"

// Overlap of two boxes from their half-extents: the separating-axis test (Gottschalk, Lin, Manocha 1996) on
// 15 axes, as a filter for what the solids are by definition, the hulls of their rounded world vertices. The
// bounds are derived in the source.

namespace touchstone::native {

using numerics::Certified;

/// @pre half-extents and |position| within [2^-120, 2^120] (see native.cpp); valid poses.
Certified certify_boxes(const Vector3& half_a, const Pose& X_WA, const Vector3& half_b, const Pose& X_WB);

}  // namespace touchstone::native

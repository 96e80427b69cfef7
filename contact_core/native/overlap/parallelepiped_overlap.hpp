#pragma once

#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/contact_core/native/solids/parallelepiped.hpp"
#include "touchstone/contact_core/numerics/certified.hpp"

// Overlap of two parallelepipeds: the separating-axis test on 15 axes, as a filter for the hulls of the
// rounded world vertices. Nothing is assumed about the poses' orthonormality. The bounds are derived in the
// source.

namespace touchstone::native {

using numerics::Certified;

/// @pre magnitudes as for certify_boxes.
Certified certify_parallelepipeds(const Parallelepiped& a, const Pose& X_WA, const Parallelepiped& b,
                                  const Pose& X_WB);

}  // namespace touchstone::native

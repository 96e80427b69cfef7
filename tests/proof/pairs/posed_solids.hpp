#pragma once

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"

namespace touchstone::proof {

/// The question: two solids in their poses.
struct PosedSolids {
  Hexahedron a, b;
  Pose X_WA, X_WB;
};

}  // namespace touchstone::proof

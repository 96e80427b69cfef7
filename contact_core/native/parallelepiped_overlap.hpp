#pragma once

#include <array>
#include <optional>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/native/box_box_overlap.hpp"

// Overlap of two parallelepipeds: the separating-axis test on 15 axes, as a filter for the hulls of the
// rounded world vertices. Nothing is assumed about the poses' orthonormality. The bounds are derived in the
// source.

namespace touchstone::native {

/// centre + x half_edges[0] + y half_edges[1] + z half_edges[2], x, y, z in [-1, 1], in the solid's frame.
struct Parallelepiped {
  Vector3 centre = Vector3::Zero();
  std::array<Vector3, 3> half_edges{Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  double deviation = 0.0;  ///< no coordinate of a vertex is further than this from that form's [m]
};

/// The solid in this form, if its vertices fit to 16 eps * size.
std::optional<Parallelepiped> as_parallelepiped(const Hexahedron& solid);

/// @pre magnitudes as for certify_boxes.
Certified certify_parallelepipeds(const Parallelepiped& a, const Pose& X_WA, const Parallelepiped& b,
                                  const Pose& X_WB);

}  // namespace touchstone::native

#pragma once

#include <array>
#include <optional>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone::native {

/// centre + x half_edges[0] + y half_edges[1] + z half_edges[2], x, y, z in [-1, 1], in the solid's frame.
struct Parallelepiped {
  Vector3 centre = Vector3::Zero();
  std::array<Vector3, 3> half_edges{Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  double deviation = 0.0;  ///< no coordinate of a vertex is further than this from that form's [m]
};

/// The solid in this form, if its vertices fit to 16 eps * size.
std::optional<Parallelepiped> as_parallelepiped(const Hexahedron& solid);

}  // namespace touchstone::native

#pragma once

#include <vector>

#include "touchstone/contact_core/fit/mesh_distance.hpp"

namespace touchstone {

/// A round wall that closes about an axis: that of a bore or of a pin.
struct RoundPart {
  Vector3 foot;   ///< on the axis, at the lower end; the mesh's frame [m]
  Vector3 axis;   ///< unit
  Vector3 start;  ///< unit, across the axis, to a corner of the wall's facets
  double length;  ///< along the axis [m]
  double radius;  ///< of the circle that the corners lie on [m]
  bool is_bore;   ///< the solid is outside of the wall
  int facets;     ///< as many of equal width go around, from a corner at `start` on; 0: they are not equal

  /// The box along the mesh's axes about it.
  Bounds bounds() const;
};

/// The round walls of a mesh: facets that turn by at most 35 degrees from one to the next, each along the
/// axis to a thousandth, with corners on a circle to a thousandth of its radius, no gap wider than 45
/// degrees. In the order of the mesh's triangles.
std::vector<RoundPart> find_round_parts(const MeshDistance& mesh);

}  // namespace touchstone

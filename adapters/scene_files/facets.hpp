#pragma once

#include <string>
#include <vector>

#include "touchstone/contact_core/mechanism/round_parts.hpp"

namespace touchstone::scene_files {

/// An annulus about z from z = 0 to `height`, as `facets` hexahedra. Facet i is centred on the angle 2 pi i /
/// facets, so facet 0 has its normals along +-x. All lengths [m].
struct RingSize {
  double outer_radius;
  double inner_radius;
  double height;
  int facets;      ///< >= 3
  bool inscribed;  ///< corners on both circles; otherwise the facets touch them (inradius = radius)
};

/// Names `name.0`, `name.1`, ... @throws InputError naming the figure.
RoundPart make_ring(const RingSize& size, const Pose& X_OS, const std::string& name);

/// A truncated pyramid about z: half widths `bottom` at z = 0, `top` (may be zero) at z = height.
struct FrustumSize {
  double bottom_x, bottom_y;
  double top_x, top_y;
  double height;
};
PlacedHexahedron make_frustum(const FrustumSize& size, const Pose& X_OS, const std::string& name);

/// A hollow box about the origin: `inner_size` inside, walls of `thickness` around it, none at the `open`
/// sides. Side: 0 -x, 1 +x, 2 -y, 3 +y, 4 -z, 5 +z. Walls are boxes and do not overlap, but for a rounding:
/// the x walls span all, the y walls fit between them.
struct WallsSize {
  Vector3 inner_size;
  double thickness;
  std::vector<int> open;
};
/// Names `name.-x`, `name.+x`, ...
std::vector<PlacedHexahedron> make_walls(const WallsSize& size, const Pose& X_OS, const std::string& name);

}  // namespace touchstone::scene_files

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"

namespace touchstone::comparison {

/// A proven cover of a mesh: its union holds the mesh's solid, and no point of it is farther from the solid
/// than `error`.
struct FittedCover {
  double error;         ///< certified [m]
  HexahedronTree tree;  ///< in the mesh's frame
};

/// A solid near the mesh, at poses at which the two are apart by at most `range`.
struct ClearancePoses {
  Hexahedron probe;
  double range;             ///< [m]
  std::vector<Pose> poses;  ///< X_MP, of the probe in the mesh's frame
};

/// The poses asked for.
struct PosesRequest {
  double side;   ///< of the probe, a cube [m]
  double range;  ///< [m]
  std::size_t count;
  std::uint64_t seed;
};

/// Turned at random, the probe is put above a random point of the surface, by area, a random part of the
/// range away; poses at which it is not within the range of the mesh, or meets the finest cover, are left
/// out. @throws InputError: fewer than asked for are found.
ClearancePoses make_poses(const TriangleMesh& mesh, const FittedCover& finest, const PosesRequest& request);

}  // namespace touchstone::comparison

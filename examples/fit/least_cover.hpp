#pragma once

#include <cstddef>
#include <span>

#include "touchstone/contact_core/fit/mesh_distance.hpp"

namespace touchstone::fitting {

/// A bound from below on the hexahedra of any cover of which no point in the zones is farther than `over`
/// from the mesh's solid, whatever it does elsewhere.
///
/// Two points of the surface that one hexahedron holds have their segment in it. So of points each two of
/// which have a point of their segment in a zone and farther than `over` from the solid, each needs a
/// hexahedron of its own. As many as are found among some hundred points (vertices and random ones in zones
/// and anywhere, points of edges in zones) are counted; there may be more.
/// @param over [m]
std::size_t least_hexahedra(const MeshDistance& mesh, std::span<const Bounds> zones, double over);

}  // namespace touchstone::fitting

#pragma once

#include <optional>
#include <string>

#include "touchstone/contact_core/fit/triangle_mesh.hpp"
#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"

namespace touchstone::fitting {

/// A mesh's triangles as plates below them, prisms of this thickness [m], to be flown as the mesh itself: of
/// closed shells that face outwards no point of the plates is outside by more than the thickness (at edges
/// sharper than a right angle a plate below one side stands out of the other), and all of the surface is
/// theirs.
/// @return nothing where that is too much or cannot be: more than 65 536 triangles, none, or one that is so
/// thin that it makes no plate (without an area it is left out).
std::optional<HexahedronTree> surface_tree(const TriangleMesh& mesh, double thickness,
                                           const std::string& name);

}  // namespace touchstone::fitting

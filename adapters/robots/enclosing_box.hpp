#pragma once

#include "touchstone/adapters/robots/robot.hpp"

namespace touchstone {

/// One box that holds the mesh: of the turned ones that a search finds, the smallest by volume, or the one
/// along the mesh's axes where turning gains less than 1 %. The search turns the box about one of its axes at
/// a time to the least rectangle around the vertices (O'Rourke, "Finding minimal enclosing boxes", 1985, has
/// the full problem), until nothing is gained.
///
/// That the box, as the hull of its eight rounded vertices, holds every vertex is decided exactly; it is
/// grown by roundings until it does. `error` is an upper bound on the distance of any point of the box from
/// the mesh's surface: over a grid of cells, that from the cell's centre to the nearest of up to 2000
/// triangles and half the cell's diagonal. Inside a solid it counts as well, so that a block's error is not
/// 0.
/// @pre the mesh has a triangle with an area. @throws InputError naming `name`: coordinates so flat or large
/// that no box of doubles holds them.
MeshCover enclosing_box(const TriangleMesh& mesh, const std::string& name);

}  // namespace touchstone

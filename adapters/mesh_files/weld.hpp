#pragma once

#include "touchstone/adapters/mesh_files/mesh_file.hpp"
#include "touchstone/adapters/mesh_files/soup.hpp"

// Private to this folder.

namespace touchstone::mesh_files {

/// One vertex for each place, zero-area triangles left out, edges and shells counted; in the soup's unit.
/// @throws InputError: a coordinate that is not finite, an index out of range, no triangle with an area.
LoadedMesh weld(const Soup& soup, const ReadTask& task);

}  // namespace touchstone::mesh_files

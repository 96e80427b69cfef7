#pragma once

#include <cstdint>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"

// Private to this folder.

namespace touchstone::gltf {

struct Mesh {
  std::vector<float> positions;        ///< x, y, z in the object's frame [m]
  std::vector<std::uint32_t> indices;  ///< three a triangle, counter-clockwise from outside
};

/// A tree's hexahedra, each with its 8 vertices and 12 triangles. A warped face is folded as the hull is. A
/// rounded solid has 128 vertices on its surface: a drawing, inside of it by up to 2 % of the radius.
Mesh make_mesh(const HexahedronTree& tree);

}  // namespace touchstone::gltf

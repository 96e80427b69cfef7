#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/geometry/vector.hpp"

namespace touchstone {

/// A part's surface as plain data, nothing checked: see validate(const TriangleMesh&).
///
/// Frame: the part's own, as its file has it; no axis is turned. Unit: metres; readers multiply by the scale
/// that the user states, once, rounded to nearest. Triangles are counter-clockwise seen from outside where
/// the part is a solid. Vertices at one place may stand more than once (STL files have three a triangle):
/// what joins triangles is the place, see weld().
struct TriangleMesh {
  std::vector<Vector3> vertices;                        ///< [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices into `vertices`, each below their number
};

/// The normal of triangle `t`, as long as twice its area [m^2].
inline Vector3 area_vector(const TriangleMesh& mesh, std::size_t t) {
  const auto& i = mesh.triangles[t];
  return cross(mesh.vertices[i[1]] - mesh.vertices[i[0]], mesh.vertices[i[2]] - mesh.vertices[i[0]]);
}

/// @throws InputError naming `name` and the triangle (counted from 0): no triangle, an invalid index, a
/// coordinate that is not finite or beyond 1e70.
void validate(const TriangleMesh& mesh, std::string_view name = "mesh");

/// The same triangles with one vertex a place: vertices are joined where all three coordinates are equal, and
/// nothing moves. Order: by first use. Triangles with two corners at one place stay.
/// @pre validate(mesh) passes.
TriangleMesh weld(const TriangleMesh& mesh);

/// The solid parts of a mesh. Triangles that share a vertex's place are one shell. A shell is closed when
/// each edge is used as often in one direction as in the other: winding numbers are then whole numbers
/// everywhere off the surface, whether or not the shell meets itself or others. An open shell is a sheet.
struct MeshShells {
  std::vector<std::uint32_t> shell_of_triangle;  ///< a triangle
  std::vector<std::uint8_t> is_closed;           ///< a shell
  std::size_t open_edges = 0;                    ///< directed edges without a partner, of all shells

  std::size_t count() const { return is_closed.size(); }
};

/// @pre `mesh` is welded.
MeshShells find_shells(const TriangleMesh& mesh);

}  // namespace touchstone

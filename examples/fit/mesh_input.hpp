#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "touchstone/adapters/mesh_files/mesh_file.hpp"

namespace touchstone::fitting {

/// How the files of meshes are read: nothing of it is guessed.
struct MeshInput {
  std::optional<double> metres_per_unit;  ///< of STL, OBJ and PLY; DAE states its own
  UpAxis up = UpAxis::as_written;
  std::optional<double> expected_size = {};  ///< diagonal; 20 times off is refused [m]
};

/// .stl, .obj, .ply or .dae, in any case.
bool is_mesh_file(const std::filesystem::path& file);

/// `text` of --up: "as-written", "stated", "x", "y" or "z". @throws InputError for anything else.
UpAxis parse_up(const std::string& text);

/// A mesh in metres with z up, or axes as written, and what a user should know of it, a line; may be empty.
struct ReadMesh {
  TriangleMesh mesh;
  double metres_per_unit = 1.0;  ///< DAE: 1, its coordinates come in metres
  std::string note;
};

/// Triangles without an area are left out and noted; of an STL file they are kept unless the others bound a
/// solid that they leave open. An STL file with axes as written is read twice, and has as many triangles and
/// shells as it likes.
/// @throws InputError as load_mesh(), and for a unit that is missing.
ReadMesh read_mesh(const std::filesystem::path& file, const MeshInput& input);

}  // namespace touchstone::fitting

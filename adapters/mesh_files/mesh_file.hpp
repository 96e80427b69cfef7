#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/fit/triangle_mesh.hpp"

/// @file
/// Triangle meshes from STL (contact_core/fit/stl_file.hpp), OBJ and PLY, and from DAE (COLLADA), read by
/// assimp where it is built in, with what a user should know about them. Set-up only; several threads may
/// read at once.

namespace touchstone {

/// Which axis of the file points up, and so becomes z. Nothing is guessed from a file's name or shape.
enum class UpAxis : std::uint8_t {
  as_written,  ///< coordinates stay as they are in the file, whatever it states (as URDF readers do)
  stated,      ///< what the file states: DAE's `up_axis`; an error for formats that state none
  x,
  y,
  z,
};

/// Parses "as-written", "stated", "x", "y" and "z"; nothing for any other text.
std::optional<UpAxis> up_axis_of(std::string_view text);
/// The text of it.
const char* to_string(UpAxis up);

/// How a mesh file is read.
struct MeshFileOptions {
  /// The file's unit of length [m], for STL, OBJ and PLY, which state none: without it they are refused. DAE
  /// states its own, which counts.
  std::optional<double> metres_per_unit = {};
  UpAxis up = UpAxis::as_written;
  /// About how large the part is, as the diagonal of its box along the axes [m]. A mesh that is 20 times
  /// larger or smaller is refused: wrong units are off by 25.4, 39.4, 1000.
  std::optional<double> expected_size = {};
  std::size_t most_triangles = 50'000'000;
  std::size_t most_shells = 100'000;
  /// Called now and then with the share that is done, 0 to 1; from the caller's thread.
  std::function<void(double)> progress = {};
};

/// Findings about a mesh. Triangle indices are those of the file, from 0.
struct MeshReport {
  std::size_t triangles_read = 0;
  std::size_t polygons_split = 0;  ///< faces of more than three corners
  std::size_t vertices_read = 0;
  std::size_t vertices_welded = 0;  ///< had the same coordinates as one before
  std::size_t zero_area = 0;        ///< triangles left out: two corners are one, or all on a line (exactly)
  std::size_t first_zero_area = 0;  ///< index of the first of them
  std::size_t open_edges = 0;       ///< edges of one triangle
  std::size_t first_open = 0;       ///< index of a triangle with such an edge
  std::size_t crowded_edges = 0;    ///< edges of more than two triangles
  std::size_t first_crowded = 0;
  std::size_t turned_edges = 0;  ///< edges that both triangles run along in one direction, after the next
  std::size_t first_turned = 0;
  /// Ascending indices of the triangles that were turned so that a surface faces one way. Only surfaces
  /// without a boundary, each edge between two triangles, with two sides, of which some triangles face one
  /// and some the other are turned: outwards, or, where another may enclose them (their box is within its
  /// box), as at least three quarters of their triangles face, as they may be cavities. Others stay.
  std::vector<std::uint32_t> triangles_turned;
  std::size_t shells = 0;  ///< parts that share no vertex
  double volume = 0.0;     ///< signed, by the triangles' order [m3]; below 0: inside out. Closed meshes only
  Vector3 low = Vector3::Zero(), high = Vector3::Zero();  ///< corners of the box along the axes [m]
  /// By how much a coordinate may be off from the file's own [m]: 0 but for DAE, which assimp reads with
  /// single precision.
  double rounding = 0.0;

  double size() const { return norm(high - low); }  ///< diagonal of the box [m]
  bool is_closed() const { return open_edges == 0; }
  bool is_manifold() const { return is_closed() && crowded_edges == 0; }
  bool is_oriented() const { return turned_edges == 0; }
  /// Closed, manifold, oriented and not inside out: it bounds a solid, unless it passes through itself (not
  /// looked for).
  bool bounds_a_solid() const { return is_manifold() && is_oriented() && volume > 0.0; }
};
/// One line: triangles, shells, size, and what is wrong with the first triangle for each.
std::string to_string(const MeshReport& report);

/// A mesh in metres, and what was found in it.
struct LoadedMesh {
  TriangleMesh mesh;  ///< equal vertices are one; vertices of triangles that were left out are kept
  MeshReport report;
};

/// True where this build reads DAE.
bool reads_dae();

/// Reads a mesh by the format that its extension names, in any case: .stl, .obj, .ply, .dae.
/// @throws InputError, one line that names the file and the line or triangle: not to be read, an extension
/// that is none of these, truncated or malformed, a coordinate that is not finite, an index out of range, no
/// triangle with an area, more triangles or shells than asked for, no unit, a size that was not expected.
LoadedMesh load_mesh(const std::filesystem::path& file, const MeshFileOptions& options);

}  // namespace touchstone

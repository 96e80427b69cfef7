#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "touchstone/contact_core/fit/triangle_mesh.hpp"

namespace touchstone {

/// Reads an STL file, binary or ASCII, whatever its first five letters are: a file of exactly 84 + 50 n
/// bytes, n being its count of triangles, is binary. Coordinates are read as they stand (floats in the binary
/// form, the nearest double in ASCII) and multiplied by `scale`. Normals and attributes are passed by: the
/// order of the corners counts. Other formats: adapters.
/// @param scale metres a unit of the file, 1e-3 for millimetres: STL files do not state it.
/// @throws InputError, one line: the file's name and the triangle (binary, from 0) or line (ASCII): cannot be
/// read, empty, cut off (ASCII: a solid without `endsolid`, too), no number, not finite, no triangle.
TriangleMesh read_stl(const std::string& path, double scale);

/// How many triangles a binary STL file of these bytes has; empty where they are no such file.
std::optional<std::size_t> binary_stl_triangles(std::string_view bytes);

/// read_stl() from a file's bytes; `name` stands in errors.
TriangleMesh parse_stl(const std::string& bytes, double scale, const std::string& name);

}  // namespace touchstone

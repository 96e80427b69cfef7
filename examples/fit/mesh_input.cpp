#include "touchstone/examples/fit/mesh_input.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "touchstone/contact_core/fit/stl_file.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::fitting {
namespace {

std::string extension_of(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extension;
}

}  // namespace

bool is_mesh_file(const std::filesystem::path& file) {
  const std::string extension = extension_of(file);
  return extension == ".stl" || extension == ".obj" || extension == ".ply" || extension == ".dae";
}

UpAxis parse_up(const std::string& text) {
  if (const std::optional<UpAxis> up = up_axis_of(text)) return *up;
  reject("--up", "'" + text + "' is none of as-written, stated, x, y, z");
}

ReadMesh read_mesh(const std::filesystem::path& file, const MeshInput& input) {
  const bool states_unit = extension_of(file) == ".dae";
  if (!input.metres_per_unit && !states_unit)
    reject("--unit", "is missing: " + file.filename().string() + " does not say its unit");
  ReadMesh out;
  out.metres_per_unit = states_unit ? 1.0 : *input.metres_per_unit;
  const bool is_plain_stl = extension_of(file) == ".stl" && input.up == UpAxis::as_written;
  MeshFileOptions options = {input.metres_per_unit, input.up, input.expected_size};
  // An STL file's own mesh may be sheets of any number; that load_mesh() reads it, too, is for the report.
  if (is_plain_stl) options.most_triangles = options.most_shells = std::numeric_limits<std::size_t>::max();
  LoadedMesh loaded = load_mesh(file, options);
  if (is_plain_stl) out.mesh = read_stl(file.string(), out.metres_per_unit);
  const std::vector<std::uint32_t>& turned = loaded.report.triangles_turned;
  if (is_plain_stl)
    for (const std::uint32_t t : turned) std::swap(out.mesh.triangles[t][1], out.mesh.triangles[t][2]);
  const bool is_whole = loaded.report.bounds_a_solid();
  // Triangles without an area close seams, or hang on a solid that is closed without them.
  const bool hang = is_plain_stl && is_whole && find_shells(weld(out.mesh)).open_edges > 0;
  if (!is_whole || !turned.empty() || hang || loaded.report.rounding > 0.0)
    out.note = to_string(loaded.report);
  if (!is_plain_stl || hang) out.mesh = std::move(loaded.mesh);
  return out;
}

}  // namespace touchstone::fitting

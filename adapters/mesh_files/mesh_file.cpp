#include "touchstone/adapters/mesh_files/mesh_file.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>

#include "touchstone/adapters/mesh_files/soup.hpp"
#include "touchstone/adapters/mesh_files/weld.hpp"
#include "touchstone/contact_core/fit/stl_file.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace mesh_files {

void ReadTask::fail(const std::string& reason) const { throw InputError(file + ": " + reason); }

void ReadTask::fail_triangle(std::size_t triangle, const std::string& reason) const {
  fail("triangle " + std::to_string(triangle) + ": " + reason);
}

void ReadTask::require_room(std::size_t index) const {
  if (index >= most_triangles) fail("more than " + std::to_string(most_triangles) + " triangles");
}

namespace {

enum class Format : std::uint8_t { stl, obj, ply, dae };

/// A size that was stated is met within this factor: above what judging by eye is off, below what a wrong
/// unit makes of it (inches 25.4 and 39.4, millimetres 1000).
constexpr double kSizeFactor = 20.0;

Format format_of(const std::filesystem::path& file, const ReadTask& task) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  if (extension == ".stl") return Format::stl;
  if (extension == ".obj") return Format::obj;
  if (extension == ".ply") return Format::ply;
  if (extension == ".dae") return Format::dae;
  task.fail("a mesh is read from .stl, .obj, .ply or .dae, not '" + extension + "'");
}

std::string read_bytes(const std::filesystem::path& file, const ReadTask& task) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) task.fail("there is no such file");
  if (!std::filesystem::is_regular_file(file, error)) task.fail("is no file");
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) task.fail("cannot be read");
  constexpr std::uintmax_t kMostBytes = std::uintmax_t{8} << 30U;
  if (size > kMostBytes) task.fail("is larger than 8 GiB");
  std::string bytes(size, '\0');
  std::ifstream stream(file, std::ios::binary);
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size))) task.fail("cannot be read");
  if (bytes.starts_with("version https://git-lfs"))
    task.fail("is a pointer of Git LFS: fetch the file itself");
  return bytes;
}

/// Before memory is taken for what the header says. What is no binary file parse_stl() judges.
void require_room_for_binary_stl(std::string_view bytes, const ReadTask& task) {
  const std::optional<std::size_t> count = binary_stl_triangles(bytes);
  if (count && *count > 0) task.require_room(*count - 1);
}

Soup read_soup(const std::filesystem::path& file, Format format, UpAxis up, const ReadTask& task) {
  const std::string bytes = read_bytes(file, task);
  if (format == Format::dae) return read_dae(file, bytes, up == UpAxis::stated, task);
  if (format == Format::ply) return read_ply(bytes, task);
  if (format == Format::obj) return read_obj(bytes, task);
  require_room_for_binary_stl(bytes, task);
  TriangleMesh mesh = parse_stl(bytes, 1.0, task.file);
  if (!mesh.triangles.empty()) task.require_room(mesh.triangles.size() - 1);
  return {std::move(mesh.vertices), std::move(mesh.triangles)};
}

/// Turns the axis that is up to z by a cyclic exchange, which is a rotation and rounds nothing.
Vector3 turned_up(const Vector3& v, UpAxis up) {
  if (up == UpAxis::x) return {v.y(), v.z(), v.x()};
  if (up == UpAxis::y) return {v.z(), v.x(), v.y()};
  return v;
}

double volume_of(const TriangleMesh& mesh, const Vector3& about) {
  double six = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vector3 a = mesh.vertices[t[0]] - about, b = mesh.vertices[t[1]] - about,
                  c = mesh.vertices[t[2]] - about;
    six += dot(a, cross(b, c));
  }
  return six / 6.0;
}

void require_size(const MeshReport& report, double expected, const ReadTask& task) {
  if (!(expected > 0.0) || !std::isfinite(expected)) task.fail("the expected size is no length > 0");
  const double ratio = report.size() / expected;
  if (ratio <= kSizeFactor && ratio >= 1.0 / kSizeFactor) return;
  task.fail("it is " + figure(report.size()) + " m across where about " + figure(expected) +
            " m was expected, " + figure(ratio) + " times that: is the unit right?");
}

void finish(const Soup& soup, const MeshFileOptions& options, const ReadTask& task, LoadedMesh& loaded) {
  const double scale = soup.states_unit ? 1.0 : *options.metres_per_unit;
  MeshReport& report = loaded.report;
  for (Vector3& v : loaded.mesh.vertices) v = turned_up(v, options.up) * scale;
  const Vector3 low = turned_up(report.low, options.up) * scale;
  report.high = turned_up(report.high, options.up) * scale;
  report.low = low;
  if (!is_finite(report.low) || !is_finite(report.high) || !std::isfinite(report.size()))
    task.fail("its coordinates are too large: up to " + figure(norm_inf(report.high)));
  report.rounding = soup.relative_rounding * std::max(norm_inf(report.low), norm_inf(report.high));
  report.volume = report.is_closed() ? volume_of(loaded.mesh, 0.5 * (report.low + report.high)) : 0.0;
  if (report.shells > options.most_shells)
    task.fail(std::to_string(report.shells) + " shells, more than " + std::to_string(options.most_shells) +
              ": no part, or its triangles share no vertices");
  if (options.expected_size) require_size(report, *options.expected_size, task);
}

}  // namespace
}  // namespace mesh_files

LoadedMesh load_mesh(const std::filesystem::path& file, const MeshFileOptions& options) {
  using namespace mesh_files;
  const ReadTask task{file.string(), options.most_triangles, &options.progress};
  const Format format = format_of(file, task);
  if (options.metres_per_unit && !(*options.metres_per_unit > 0.0 && std::isfinite(*options.metres_per_unit)))
    task.fail("the unit is no length > 0");
  if (format != Format::dae && !options.metres_per_unit)
    task.fail("states no unit of length: say which (metres_per_unit)");
  if (format != Format::dae && options.up == UpAxis::stated)
    task.fail("states no up axis: say which, or take it as written");
  Soup soup = read_soup(file, format, options.up, task);
  task.advance(1.0);
  LoadedMesh loaded = weld(soup, task);
  finish(soup, options, task, loaded);
  return loaded;
}

std::string to_string(const MeshReport& report) {
  std::string out = std::to_string(report.triangles_read) + " triangles, " + std::to_string(report.shells) +
                    (report.shells == 1 ? " shell, " : " shells, ") + figure(report.size()) + " m across";
  const auto add = [&](std::size_t count, const char* what, std::size_t first) {
    if (count > 0)
      out += "; " + std::to_string(count) + " " + what + ", the first at triangle " + std::to_string(first);
  };
  add(report.zero_area, "without an area left out", report.first_zero_area);
  add(report.triangles_turned.size(), "turned so that the surface faces one way",
      report.triangles_turned.empty() ? 0 : report.triangles_turned.front());
  add(report.open_edges, "open edges", report.first_open);
  add(report.crowded_edges, "edges of more than two triangles", report.first_crowded);
  add(report.turned_edges, "edges between triangles that face opposite ways", report.first_turned);
  if (report.is_manifold() && report.is_oriented() && report.volume < 0.0) out += "; inside out";
  return out;
}

std::optional<UpAxis> up_axis_of(std::string_view text) {
  for (const UpAxis up : {UpAxis::as_written, UpAxis::stated, UpAxis::x, UpAxis::y, UpAxis::z})
    if (text == to_string(up)) return up;
  return std::nullopt;
}

const char* to_string(UpAxis up) {
  switch (up) {
    case UpAxis::as_written:
      return "as-written";
    case UpAxis::stated:
      return "stated";
    case UpAxis::x:
      return "x";
    case UpAxis::y:
      return "y";
    case UpAxis::z:
      return "z";
  }
  return "";
}

}  // namespace touchstone

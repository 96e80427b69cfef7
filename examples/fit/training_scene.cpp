#include "touchstone/examples/fit/training_scene.hpp"

#include <fmt/format.h>

#include <optional>

#include "touchstone/examples/fit/cover_scene.hpp"
#include "touchstone/examples/program/files/json.hpp"

namespace touchstone::fitting {
namespace {

constexpr double kSeconds = 10.0;  // to the mesh's middle

std::string row(const Vector3& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); }

std::string flight_text(const FitRun& run, const Approach& approach) {
  const Vector3 aside(approach.velocity.y(), approach.velocity.z(), approach.velocity.x());
  return fmt::format(
      "# A block comes against the cover of {}, backs off, and goes aside.\nname: {}\nscene: {{file: {}}}\n"
      "duration: {}\nhands:\n  - object: block\n    rates:\n      - {{time: 0, velocity: {}}}\n"
      "      - {{time: {}, velocity: {}}}\n      - {{time: {}, velocity: {}}}\n",
      run.certificate.mesh_file, program::Json("To " + run.name).dump(),
      program::Json(run.name + ".scene.yaml").dump(), 1.5 * approach.duration, row(approach.velocity),
      approach.duration, row(-approach.velocity), 1.25 * approach.duration, row(aside));
}

/// The list by which the station shows the mesh; nothing where its path cannot stand in a text.
std::optional<std::string> mesh_list(const FitRun& run, const std::filesystem::path& mesh,
                                     const std::filesystem::path& output) {
  const std::string path = std::filesystem::proximate(mesh, output).generic_string();
  program::Json item = {{"object", run.name}, {"mesh", path}, {"metres_per_unit", run.certificate.scale}};
  if (run.certificate.up != UpAxis::as_written) item["up"] = to_string(run.certificate.up);
  const std::string text = program::one_line(program::Json::array({item}));
  // Bytes that are no UTF-8 were replaced there.
  if (program::Json::parse(text)[0]["mesh"] != path) return std::nullopt;
  return text + "\n";
}

}  // namespace

Approach approach_to(const TriangleMesh& mesh) {
  Bounds bounds;
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t i : t) bounds.add(mesh.vertices[i]);
  const Vector3 size = bounds.high - bounds.low;
  int along = 0;
  for (int i = 1; i < 3; ++i)
    if (size[i] < size[along]) along = i;
  Approach out;
  double most = -1.0;
  for (const auto& t : mesh.triangles) {
    const Vector3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double shown = cross(b - a, c - a)[along];
    if (shown > most) most = shown, out.from = (a + b + c) / 3.0;
  }
  out.side = 0.1 * (size.sum() - size.maxCoeff() - size.minCoeff());
  const double middle = 0.5 * (bounds.low[along] + bounds.high[along]);
  const double distance = 0.5 * size[along] + 0.5 * out.side + 0.25 * bounds.diagonal();
  out.from[along] = middle + distance;
  out.velocity = Vector3::Zero();
  out.velocity[along] = -distance / kSeconds;
  out.duration = kSeconds;
  return out;
}

std::vector<program::ReportFile> training_files(const FitRun& run, const std::filesystem::path& mesh,
                                                const std::filesystem::path& output) {
  const Approach approach = approach_to(run.mesh);
  const std::string scene =
      scene_text(run.fit, run.name, fmt::format("A block comes against {}", run.certificate.mesh_file),
                 1.5 * approach.duration) +
      fmt::format(
          "  - name: block\n    pose: {{position: {}}}\n    hexahedra:\n      - {{name: block, box: {{size: "
          "[{}, {}, {}]}}}}\n    motion: {{segments: [{{duration: {}, velocity: {}}}]}}\n",
          row(approach.from), approach.side, approach.side, approach.side, approach.duration,
          row(approach.velocity));
  std::vector<program::ReportFile> files = {{run.name + ".scene.yaml", scene},
                                            {run.name + ".flight.yaml", flight_text(run, approach)}};
  if (auto list = mesh_list(run, mesh, output)) files.push_back({run.name + ".flight.meshes.json", *list});
  return files;
}

}  // namespace touchstone::fitting

#include "touchstone/examples/compare_backends/fitted/fitted_command.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/fitted/fitted_page.hpp"
#include "touchstone/examples/fit/fit_run.hpp"
#include "touchstone/examples/program/files/report_files.hpp"
#include "touchstone/examples/program/options/shell_text.hpp"
#include "touchstone/examples/program/terminal/program.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

using fitting::Certificate;
using fitting::FitRequest;
using fitting::FitRun;

struct FittedOptions {
  std::vector<std::string> meshes, over = {"8%", "4%", "2%", "1%"}, covers, backends;
  std::string unit, probe = "5%", range, output = "fitted";
  std::size_t poses = 300;
  std::uint64_t seed = 1;
  int repetitions = 5, tries = FitRequest().tries;
};

bool parse(int argc, const char* const* argv, FittedOptions& options) {
  CLI::App app{
      "Cost against total error, geometry's and backend's: covers of meshes within several errors, each "
      "proven, and the clearances that every backend gives on them around contact."};
  app.name("compare_backends fitted");
  app.add_option("MESH", options.meshes, "STL, OBJ, PLY or DAE files")->required();
  app.add_option("--unit", options.unit, "Unit of the files: m, cm, mm, um, in, ft, or metres a unit");
  app.add_option("--over", options.over, "Errors to fit within: 2mm, or 2% of the diagonal")
      ->capture_default_str();
  app.add_option("--covers", options.covers,
                 "Certificates of covers of the mesh instead, as touchstone_fit writes them; proven anew");
  app.add_option("--backend", options.backends, "Backends to ask (default: all in this process)");
  // Poses are made from the seed.
  app.add_option("--probe", options.probe, "Side of the cube that is put near the mesh")
      ->capture_default_str();
  app.add_option(
      "--range", options.range,
      "Clearances of the mesh are up to this, more than the finest cover's error (default: twice the "
      "coarsest cover's error, at least 5% of the diagonal)");
  app.add_option("--poses", options.poses, "Poses of the cube")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  app.add_option("--seed", options.seed, "Of the poses")->capture_default_str();
  app.add_option("--repetitions", options.repetitions, "Timed runs over all poses, of which the least counts")
      ->capture_default_str()
      ->check(CLI::Range(0, 1000));
  app.add_option("--tries", options.tries, "As of touchstone_fit")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  app.add_option("--out,--output", options.output, "Folder of the page and the plots")->capture_default_str();
  return parse_command_line(app, argc - 1, argv + 1);
}

FittedCover cover_of(const Certificate& certificate) {
  std::vector<PlacedHexahedron> solids;
  for (const auto& vertices : certificate.claim.hexahedra) {
    const std::string name = fmt::format("h{}", solids.size());
    solids.push_back({name, Hexahedron::from_vertices(vertices, WarpPolicy::within_tolerance, name), Pose()});
  }
  return {certificate.claim.excess, HexahedronTree(std::move(solids), "cover")};
}

FittedCover fitted(const std::filesystem::path& mesh, const std::string& over, const FittedOptions& options,
                   ProgressLine& progress) {
  FitRequest request;
  request.over = parse_length(over, "--over");
  request.tries = options.tries;
  if (!options.unit.empty()) request.input.metres_per_unit = parse_unit(options.unit);
  const FitRun run = fitting::run_fit(mesh, request, progress);
  if (!run.verdict.is_proven) reject(mesh.string(), "not proven: " + run.verdict.reason);
  return cover_of(run.certificate);
}

// The mesh as its covers see it: certificates state its unit and axes.
fitting::MeshInput input_of(const FittedOptions& options) {
  fitting::MeshInput input;
  if (!options.unit.empty()) input.metres_per_unit = parse_unit(options.unit);
  if (options.covers.empty()) return input;
  const Certificate first = fitting::read_certificate(options.covers.front());
  input.metres_per_unit = first.scale;
  input.up = first.up;
  for (const std::string& path : options.covers) {
    const Certificate certificate = fitting::read_certificate(path);
    if (certificate.scale != first.scale || certificate.up != first.up)
      reject(path, "is of another unit or axis than " + options.covers.front());
  }
  return input;
}

std::vector<FittedCover> covers_of(const std::filesystem::path& mesh, const FittedOptions& options,
                                   ProgressLine& progress) {
  std::vector<FittedCover> covers;
  if (options.covers.empty())
    for (const std::string& over : options.over) covers.push_back(fitted(mesh, over, options, progress));
  for (const std::string& path : options.covers) {
    progress.step("prove " + path);
    const Certificate certificate = fitting::read_certificate(path);
    const CoverVerdict verdict = fitting::check_certificate(certificate, mesh);
    if (!verdict.is_proven) reject(path, "refused: " + verdict.reason);
    covers.push_back(cover_of(certificate));
  }
  std::stable_sort(covers.begin(), covers.end(),
                   [](const FittedCover& a, const FittedCover& b) { return a.error > b.error; });
  return covers;
}

constexpr double kLeastRange = 0.05;  // of the diagonal, unless another is asked for

/// Poses are clear of the finest cover by less than the range without its error: refused before covers are
/// fitted or proven.
void check_range(const FittedOptions& options, double diagonal) {
  if (options.range.empty()) return;
  double finest = kInfinity;
  if (options.covers.empty())
    for (const std::string& over : options.over)
      finest = std::min(finest, parse_length(over, "--over").metres(diagonal));
  for (const std::string& path : options.covers)
    finest = std::min(finest, fitting::read_certificate(path).claim.excess);
  if (!(parse_length(options.range, "--range").metres(diagonal) > finest))
    reject("--range", fmt::format("is '{}', and the finest cover's error may be {:.6g} m: no pose of the "
                                  "probe is known to be within it",
                                  options.range, finest));
}

FittedMesh measure(const std::filesystem::path& path, const FittedOptions& options,
                   const BackendRegistry& registry, std::span<const std::string> backends,
                   ProgressLine& progress) {
  const TriangleMesh mesh = weld(fitting::read_mesh(path, input_of(options)).mesh);
  FittedMesh result;
  result.name = path.filename().string();
  result.triangles = mesh.triangles.size();
  result.diagonal = MeshDistance(mesh).bounds().diagonal();
  result.side = parse_length(options.probe, "--probe").metres(result.diagonal);
  check_range(options, result.diagonal);
  const std::vector<FittedCover> covers = covers_of(path, options, progress);
  result.range = options.range.empty() ? std::max(2.0 * covers.front().error, kLeastRange * result.diagonal)
                                       : parse_length(options.range, "--range").metres(result.diagonal);
  progress.step("poses of " + result.name);
  const ClearancePoses poses =
      make_poses(mesh, covers.back(), {result.side, result.range, options.poses, options.seed});
  result.poses = poses.poses.size();
  progress.step("clearances of " + result.name);
  result.errors = measure_total_errors(covers, poses, registry, backends, options.repetitions,
                                       [&](double done) { progress.share(done); });
  return result;
}

std::string command_of(int argc, const char* const* argv) {
  std::string command = "compare_backends";
  for (int i = 1; i < argc; ++i) command += " " + shell_word(argv[i]);
  return command;
}

}  // namespace

int run_fitted(int argc, const char* const* argv, const BackendRegistry& registry) {
  FittedOptions options;
  if (!parse(argc, argv, options)) return 0;
  if (!options.covers.empty() && options.meshes.size() != 1)
    reject("--covers", "are of one mesh, and there are " + std::to_string(options.meshes.size()));
  std::vector<std::string> backends = options.backends;
  if (backends.empty())
    for (const auto& entry : registry.narrowphases()) backends.push_back(entry.name);
  for (const std::string& backend : backends) static_cast<void>(registry.narrowphase(backend));
  static_cast<void>(registry.narrowphase("exact"));
  // A folder that cannot be written to is refused before the first fit.
  std::vector<std::string> names = {"fitted.md"};
  for (std::size_t i = 0; i < options.meshes.size(); ++i) names.push_back(fitted_plot_name(i));
  check_report_folder(options.output, names);
  // Each mesh is shown as soon as it is measured; one that fails does not end the others.
  std::vector<FittedMesh> meshes;
  std::vector<ReportFile> files;
  std::vector<std::string> failed;
  for (const std::string& path : options.meshes) {
    ProgressLine progress;
    try {
      meshes.push_back(measure(path, options, registry, backends, progress));
    } catch (const InputError& error) {
      if (options.meshes.size() == 1) throw;
      progress.finish();
      failed.push_back(fmt::format("{}: {}", std::filesystem::path(path).filename().string(), error.what()));
      print_now(fmt::format("not measured: {}\n", failed.back()));
      continue;
    }
    progress.finish();
    print_now(fitted_text(meshes.back()));
    std::string plot = fitted_plot(meshes.back());
    if (!plot.empty()) files.emplace_back(fitted_plot_name(meshes.size() - 1), std::move(plot));
  }
  if (meshes.empty()) return 1;
  files.emplace_back("fitted.md", fitted_page(meshes, command_of(argc, argv), failed));
  const std::filesystem::path folder = place_report(options.output, files, failed.empty());
  print_now(fmt::format("\npage and plots: {}\n", folder.string()));
  for (const std::string& reason : failed) print_now(fmt::format("not measured: {}\n", reason));
  return failed.empty() ? 0 : 1;
}

}  // namespace touchstone::comparison

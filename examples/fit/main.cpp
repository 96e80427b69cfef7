#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <set>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/fit/fit_run.hpp"
#ifdef TOUCHSTONE_HAS_SCENE_FILES
#include "touchstone/adapters/scene_files/scene_file.hpp"
#include "touchstone/examples/fit/serves.hpp"
#endif
#include "touchstone/examples/program/options/shell_text.hpp"
#include "touchstone/examples/program/terminal/machine.hpp"
#include "touchstone/examples/program/terminal/program.hpp"

namespace {

using namespace touchstone;
using namespace touchstone::fitting;

struct Options {
  std::string input, over, keep_open, up = "as-written", size, check, serves, tolerance, margin, object,
                                      output = "fit", command = "touchstone_fit";
  std::vector<std::string> unit, regions, levels;
  std::size_t count = 0, samples = 0;
  int repairs = FitOptions().repairs;
  int tries = fitting::FitRequest().tries;
  double minutes = 10.0;
  bool page = false, training = false, uniform = false;
};

/// Options of the mesh's file, and of how its numbers are read.
void add_mesh(CLI::App& app, Options& options) {
  app.add_option("mesh", options.input, "An STL, OBJ, PLY or DAE file, or a folder of them")->required();
  app.add_option(
         "--unit", options.unit,
         "Unit of the file: m, cm, mm, um, in, ft, or metres a unit; only DAE files say it. Of one mesh of a "
         "folder, by its name: part=in")
      ->allow_extra_args(false);
  app.add_option(
         "--up", options.up,
         "Axis of the file that points up and becomes z: x, y, z, stated (by a DAE file), or as-written")
      ->capture_default_str();
  app.add_option("--size", options.size,
                 "About how large a mesh is, such as 2m: one that is 20 times larger or smaller is refused");
}

void add_serves(CLI::App& app, Options& options) {
  auto* const serves = app.add_option("--serves", options.serves,
                                      "A scene with objects of the meshes' names, which stand or move: looks "
                                      "for the coarsest covers with which "
                                      "clearances are the meshes' to --tolerance, also where something is "
                                      "stopped");
  app.add_option("--tolerance", options.tolerance, "Of --serves: 1mm")->needs(serves);
  app.add_option("--margin", options.margin,
                 "Of --serves: other motions that stay this near count, and clearances up to it (default: 10 "
                 "times the tolerance)")
      ->needs(serves);
  app.add_option("--object", options.object, "Of --serves: the object's name, where it is not the mesh's")
      ->needs(serves);
  app.add_option("--minutes", options.minutes,
                 "Of --serves: the search ends after about this, with the best so far; a proof is not cut")
      ->capture_default_str()
      ->check(CLI::Range(0.001, 1e6))
      ->needs(serves);
  app.add_flag(
         "--uniform", options.uniform,
         "Of --serves: measures the tolerance everywhere as well, which may take long, and writes a page "
         "with both")
      ->needs(serves);
}

/// Options that would be ignored are refused.
void exclude_ignored(CLI::App& app) {
  // A check fits nothing, so options of the fit exclude it.
  for (const char* fits : {"--over", "--count", "--region", "--keep-open", "--samples", "--repairs",
                           "--tries", "--serves", "--levels"})
    app.get_option("--check")->excludes(app.get_option(fits));
  // A search for covers that serve sets the errors itself, and writes scenes and certificates alone.
  for (const char* ignored : {"--over", "--levels", "--samples", "--page", "--training"})
    app.get_option("--serves")->excludes(app.get_option(ignored));
}

bool parse(int argc, char** argv, Options& options) {
  CLI::App app{
      "Covers a mesh by few hexahedra: their union holds every triangle, and the inside of closed shells, "
      "and no point of it is farther outside than --over. Writes a scene file with the cover and a "
      "certificate, which is proven before it is written: coverage in exact arithmetic, the error by branch "
      "and bound. Open shells are covered as sheets."};
  add_mesh(app, options);
  // Errors bound the cover, for all of it or by region.
  app.add_option("--over", options.over,
                 "Largest error, outwards: 2mm, 0.5cm, 0.02m, 1in, or 2% of the diagonal");
  app.add_option("--count", options.count,
                 "At most so many hexahedra, with the least error; --over is where to begin")
      ->check(CLI::Range(1, 1000000));
  app.add_option(
      "--region", options.regions,
      "NAME=LENGTH:x,y,z:x,y,z: a box with a smaller error of its own, such as a bore to keep open; corners "
      "in the file's units");
  app.add_option("--keep-open", options.keep_open,
                 "Largest error in round bores, which are found: 0.9mm keeps them open to that");
  app.add_option(
         "--levels", options.levels,
         "Errors of coarser levels for worlds, ascending: 20mm,100mm; each level holds the one before, "
         "and is proven too")
      ->delimiter(',');
  // Samples, repairs and tries trade time for trust and fewer hexahedra.
  app.add_option("--samples", options.samples, "Random points of surface and inside to look for in the cover")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{10'000'000'000}));
  app.add_option("--repairs", options.repairs, "How hard to look for fewer: places that are covered anew")
      ->capture_default_str()
      ->check(CLI::Range(0, 1000000));
  app.add_option("--tries", options.tries,
                 "Searches that start anew, of which the fewest hexahedra count; fewer where one costs much")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  app.add_flag(
      "--training", options.training,
      "Writes of each mesh a scene with a block that comes against it, and a script that training_run flies");
  add_serves(app, options);
  app.add_flag(
      "--page", options.page,
      "Writes a page to look at, with the excess as colours and hexahedra against error, and a glTF model");
  app.add_option("--check", options.check, "Checks this certificate against the mesh, and writes nothing");
  exclude_ignored(app);
  for (int i = 1; i < argc; ++i) options.command += " " + program::shell_word(argv[i]);
  app.add_option("--out,--output", options.output, "Folder of scenes, certificates and the table")
      ->capture_default_str();
  return program::parse_command_line(app, argc, argv);
}

std::vector<std::filesystem::path> meshes_at(const std::filesystem::path& input) {
  if (!std::filesystem::is_directory(input)) return {input};
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(input)) {
    if (entry.is_regular_file() && is_mesh_file(entry.path())) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  if (files.empty()) reject(input.string(), "no STL, OBJ, PLY or DAE file in this folder");
  return files;
}

/// The unit that is stated for this mesh, else the one for all.
std::optional<double> unit_of(const std::vector<std::string>& units, const std::filesystem::path& mesh) {
  std::optional<double> all, own;
  for (const std::string& text : units) {
    const std::size_t equals = text.rfind('=');
    if (equals == std::string::npos)
      all = parse_unit(text);
    else if (text.substr(0, equals) == mesh.stem().string())
      own = parse_unit(text.substr(equals + 1));
  }
  return own ? own : all;
}

int check(const Options& options) {
  const Certificate certificate = read_certificate(options.check);
  const std::optional<double> unit = unit_of(options.unit, options.input);
  if (unit && *unit != certificate.scale)
    reject("--unit",
           fmt::format("is {} m; the certificate is of {} m a unit of the file", *unit, certificate.scale));
  const CoverVerdict verdict = check_certificate(certificate, options.input);
  if (!verdict.is_proven) {
    program::print_now(fmt::format("refused: {}\n", verdict.reason));
    return 1;
  }
  program::print_now(fmt::format(
      "proven: {} triangles in one hexahedron each, {} in several; {} outer pieces beside no inside; error "
      "bounded over {} tetrahedra\n",
      verdict.in_one_hexahedron, verdict.cut, verdict.outer_pieces, verdict.tetrahedra));
  program::print_now(claims_text(certificate));
  return 0;
}

double length_of(const std::string& text, const std::string& option) {
  const Length length = parse_length(text, option);
  if (length.is_share) reject(option, "'" + text + "' is a share, not a length");
  return length.value;
}

FitRequest request_of(const Options& options) {
  if (options.over.empty() && options.count == 0 && options.serves.empty())
    reject("--over", "is missing, and --count");
  FitRequest request;
  request.over = parse_length(options.over.empty() ? "5%" : options.over, "--over");
  if (options.count > 0) request.count = options.count;
  for (const std::string& region : options.regions) request.regions.push_back(parse_region(region));
  if (!options.keep_open.empty()) request.keep_open = parse_length(options.keep_open, "--keep-open");
  if (request.keep_open && options.serves.empty() && request.keep_open->is_share == request.over.is_share &&
      request.keep_open->value > request.over.value)
    reject("--keep-open", "is '" + options.keep_open + "', more than --over, which bores keep anyway");
  for (const std::string& level : options.levels) request.levels.push_back(parse_length(level, "--levels"));
  request.input.up = parse_up(options.up);
  if (!options.size.empty()) request.input.expected_size = length_of(options.size, "--size");
  request.page = options.page;
  request.training = options.training;
  request.output = options.output;
  request.repairs = options.repairs;
  request.tries = options.tries;
  request.samples = options.samples;
  return request;
}

/// A name that no mesh has is a slip, and so is a second unit of the same.
void check_units(const std::vector<std::string>& units, const std::vector<std::filesystem::path>& meshes) {
  std::set<std::string> seen;
  for (const std::string& text : units) {
    const std::size_t equals = text.rfind('=');
    const std::string name = equals == std::string::npos ? "" : text.substr(0, equals);
    if (!seen.insert(name).second) reject("--unit", "'" + text + "' comes after another for the same");
    if (equals == std::string::npos) continue;
    if (std::none_of(meshes.begin(), meshes.end(),
                     [&](const auto& mesh) { return mesh.stem().string() == name; }))
      reject("--unit", "'" + text + "': there is no mesh '" + name + "'");
  }
}

#ifdef TOUCHSTONE_HAS_SCENE_FILES
/// Of a folder, those that the scene has an object of the name of.
std::vector<ServedMesh> served_meshes(const Options& options,
                                      const std::vector<std::filesystem::path>& meshes,
                                      const MeshInput& input, const Scene& scene) {
  if (!options.object.empty() && meshes.size() != 1) reject("--object", "is of one mesh, not of a folder");
  std::vector<ServedMesh> served;
  for (const std::filesystem::path& mesh : meshes) {
    const std::string object = options.object.empty() ? cover_name(mesh) : options.object;
    if (meshes.size() != 1 && find_object(scene, object) == kNoObject) {
      program::print_now(fmt::format("{}: scene '{}' has no such object\n", object, scene.name));
      continue;
    }
    served.push_back({mesh, input, object});
    served.back().input.metres_per_unit = unit_of(options.unit, mesh);
  }
  if (served.empty()) reject("--serves", "scene '" + scene.name + "' has no object of any mesh's name");
  return served;
}
#endif

int serve([[maybe_unused]] const Options& options, [[maybe_unused]] const FitRequest& fit,
          [[maybe_unused]] const std::vector<std::filesystem::path>& meshes) {
#ifndef TOUCHSTONE_HAS_SCENE_FILES
  reject("--serves", "this build does not read scenes (Debian: libyaml-cpp-dev)");
#else
  if (options.tolerance.empty()) reject("--tolerance", "is missing");
  ServesRequest request;
  request.scene = load_scene(options.serves);
  request.meshes = served_meshes(options, meshes, fit.input, request.scene);
  std::vector<std::filesystem::path> served;
  for (const ServedMesh& mesh : request.meshes) served.push_back(mesh.file);
  check_names(served);
  // Clearances count up to a margin about the moving objects.
  request.tolerance = length_of(options.tolerance, "--tolerance");
  request.margin = options.margin.empty() ? 10.0 * request.tolerance : length_of(options.margin, "--margin");
  request.with_uniform = options.uniform;
  request.seconds = 60.0 * options.minutes;
  // A folder that cannot be written to is refused before the search.
  std::vector<std::string> names;
  for (const std::filesystem::path& mesh : served)
    for (const std::string& extension : cover_extensions({})) names.push_back(cover_name(mesh) + extension);
  if (options.uniform) names.emplace_back("served.md");
  program::check_report_folder(options.output, names);
  program::ProgressLine progress;
  const ServesResult result = find_coarsest(fit, request, progress, [&](const ServesRow& row) {
    progress.finish();
    program::print_now(row_text(row));
  });
  progress.finish();
  const std::string text = serves_text(result, request) + comparison_text(result, request);
  program::print_now("\n" + text);
  // Where none is within the tolerance the best so far is written, as a partial report.
  if (!result.best) return 1;
  const ServesRow& best = result.rows[*result.best];
  std::vector<program::ReportFile> files;
  for (const FitRun& run : best.runs)
    for (program::ReportFile& file : cover_files(run)) files.push_back(std::move(file));
  if (options.uniform)
    files.emplace_back("served.md", program::page_head("Covers fitted to a task", options.command) + "```\n" +
                                        text + "```\n");
  const std::filesystem::path folder = program::place_report(options.output, files, best.serves, true);
  program::print_now(fmt::format("scenes and certificates: {}\n", folder.string()));
  return best.serves ? 0 : 1;
#endif
}

int run(int argc, char** argv) {
  Options options;
  if (!parse(argc, argv, options)) return 0;
  if (!options.check.empty()) return check(options);
  FitRequest request = request_of(options);
  // Names and units are checked before the first fit.
  const std::vector<std::filesystem::path> meshes = meshes_at(options.input);
  check_units(options.unit, meshes);
  if (!options.serves.empty()) return serve(options, request, meshes);
  check_names(meshes);
  // So is the folder, as a fit may take hours.
  std::vector<std::string> names{"fit.csv"};
  for (const auto& mesh : meshes)
    for (const std::string& extension : cover_extensions(request))
      names.push_back(cover_name(mesh) + extension);
  program::check_report_folder(options.output, names);
  std::vector<FitRun> runs;
  std::vector<program::ReportFile> report;
  bool is_proven = true;
  // A mesh that fails does not end the others.
  for (const auto& mesh : meshes) {
    program::ProgressLine progress;
    request.input.metres_per_unit = unit_of(options.unit, mesh);
    try {
      runs.push_back(run_fit(mesh, request, progress));
    } catch (const InputError& error) {
      if (meshes.size() == 1) throw;
      progress.finish();
      program::print_now(fmt::format("not proven: {}\n", error.what()));  // the others are not lost
      is_proven = false;
      continue;
    }
    progress.finish();
    FitRun& last = runs.back();
    last.mesh = {};  // seen to
    if (!last.note.empty()) program::print_now(fmt::format("{}: {}\n", last.name, last.note));
    program::print_now(fmt::format("{}: {} hexahedra, error {:.4g} mm, {}\n", last.name,
                                   last.fit.hexahedra.size(), 1e3 * last.fit.excess,
                                   last.verdict.is_proven ? "proven" : "refused: " + last.verdict.reason));
    for (std::size_t i = 0; i < last.levels.size(); ++i)
      program::print_now(fmt::format("  level {}: {} hexahedra, error {:.4g} mm\n", i + 1,
                                     last.levels[i].tree->solids().size(), 1e3 * last.levels[i].excess));
    is_proven = is_proven && last.verdict.is_proven;
    if (!last.verdict.is_proven) continue;  // nothing that is not proven is written
    for (program::ReportFile& file : cover_files(last)) report.push_back(std::move(file));
  }
  // Scenes, certificates and the table are placed at once.
  if (runs.empty()) return 1;
  report.emplace_back("fit.csv", table_csv(runs));
  const std::filesystem::path folder = program::place_report(options.output, report, is_proven, true);
  program::print_now(fmt::format("\n{}\nscenes and certificates: {}\n", table_text(runs), folder.string()));
  return is_proven ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  return touchstone::program::run_program("touchstone_fit", [&] { return run(argc, argv); });
}

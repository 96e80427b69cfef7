#include "touchstone/examples/fit/fit_run.hpp"

#include <fmt/format.h>

#include <ctime>
#include <map>

#include "touchstone/contact_core/fit/round_parts.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/fit/cover_scene.hpp"
#include "touchstone/examples/fit/fit_page.hpp"
#include "touchstone/examples/fit/samples.hpp"
#include "touchstone/examples/fit/training_scene.hpp"
#include "touchstone/examples/program/files/json.hpp"
#include "touchstone/examples/program/files/sha256.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::fitting {
namespace {

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

Vector3 parse_corner(const std::string& text, const std::string& whole) {
  Vector3 p;
  char end = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &p.x(), &p.y(), &p.z(), &end) != 3 ||
      !is_finite(p))  // NOLINT
    reject("--region", "'" + whole + "': '" + text + "' is no corner such as 1,2.5,3");
  return p;
}

FitOptions options_for(const FitRequest& request, double scale, double diagonal,
                       program::ProgressLine& progress) {
  FitOptions options;
  options.over = request.over.metres(diagonal);
  options.repairs = request.repairs;
  options.tries = request.tries;
  for (const RegionRequest& region : request.regions)
    options.regions.push_back(
        {region.name, {scale * region.low, scale * region.high}, region.over.metres(diagonal)});
  options.progress = [&progress, on_progress = request.on_progress, stage = std::string()](
                         std::string_view now, double share) mutable {
    if (on_progress) on_progress();
    if (now != stage) progress.step(stage = now);
    progress.share(share);
  };
  return options;
}

void add_pictures(const MeshDistance& solid, const FitRequest& request, program::ProgressLine& progress,
                  FitRun& run) {
  const std::vector<CurvePoint> curve = fit_curve(run, request, progress);
  progress.step("draw");
  const ExcessSurface surface = excess_surface(solid, run.fit);
  run.more.emplace_back(run.name + ".html", fit_page(run, solid, surface, curve));
  run.more.emplace_back(run.name + ".gltf", fit_gltf(run, solid, surface));
}

// A region about each bore that is wider than what it is kept open to.
void keep_bores_open(const MeshDistance& mesh, double over, FitOptions& options) {
  for (const RoundPart& part : find_round_parts(mesh))
    if (part.is_bore && part.radius > over)
      options.regions.push_back({fmt::format("bore {}", options.regions.size()), part.bounds(), over});
}

/// Coarser levels of the cover, each with a certificate of its own. The first that is not proven is the
/// run's verdict.
void add_levels(const MeshDistance& solid, const FitRequest& request, program::ProgressLine& progress,
                FitRun& run) {
  std::vector<double> overs;
  for (const Length& over : request.levels) overs.push_back(over.metres(run.diagonal));
  progress.step("levels");
  run.levels = coarser_levels(make_tree(run.fit, run.name), solid, overs);
  for (const CoarserLevel& level : run.levels) {
    Certificate certificate = run.certificate;
    certificate.claim = {};
    certificate.claim.excess = level.excess;
    for (const PlacedHexahedron& placed : level.tree->solids())
      certificate.claim.hexahedra.push_back(placed.solid.vertices());
    run.level_certificates.push_back(std::move(certificate));
    if (!run.verdict.is_proven) continue;
    CoverVerdict verdict = check_cover(run.mesh, run.level_certificates.back().claim);
    if (verdict.is_proven) continue;
    run.verdict.is_proven = false;
    run.verdict.reason = fmt::format("level {}: {}", run.level_certificates.size(), verdict.reason);
  }
}

/// A level is coarser than the cover. With a count the cover's error is not known before.
void check_levels(const FitRequest& request, double diagonal) {
  if (request.levels.empty() || request.count) return;
  const double first = request.levels.front().metres(diagonal), over = request.over.metres(diagonal);
  if (!(first > over))
    reject("--levels",
           fmt::format("the first is {:.6g} m, which is not more than --over, {:.6g} m", first, over));
}

std::string level_certificate_extension(std::size_t level) {
  return fmt::format(".level{}.certificate.json", level + 1);
}

std::string percent(double share) { return fmt::format("{:.3f}", 100.0 * share); }

}  // namespace

RegionRequest parse_region(const std::string& text) {
  const std::size_t equals = text.find('='), first = text.find(':', equals),
                    second = text.find(':', first + 1);
  if (equals == std::string::npos || equals == 0 || first == std::string::npos || second == std::string::npos)
    reject("--region", "'" + text + "' is not NAME=LENGTH:x,y,z:x,y,z");
  const Length over = parse_length(text.substr(equals + 1, first - equals - 1), "--region");
  const Vector3 a = parse_corner(text.substr(first + 1, second - first - 1), text);
  const Vector3 b = parse_corner(text.substr(second + 1), text);
  return {text.substr(0, equals), over, a.cwiseMin(b), a.cwiseMax(b)};
}

std::string cover_name(const std::filesystem::path& mesh) {
  using program::Json;
  return Json::parse(program::one_line(Json(mesh.stem().string())));
}

void check_names(const std::vector<std::filesystem::path>& meshes) {
  std::map<std::string, std::string> files;
  for (const std::filesystem::path& mesh : meshes) {
    const auto [other, is_new] = files.try_emplace(cover_name(mesh), mesh.filename().string());
    if (!is_new)
      reject(mesh.parent_path().string(), other->second + " and " + mesh.filename().string() +
                                              " would both become " + other->first + ".yaml; rename one");
  }
}

FitRun run_fit(const std::filesystem::path& mesh, const FitRequest& request,
               program::ProgressLine& progress) {
  // The certificate hashes the file's bytes, not the triangles read.
  progress.step("read");
  ReadMesh read = read_mesh(mesh, request.input);
  const std::string bytes = program::read_file(mesh.string(), "the mesh");
  FitRun run;
  run.mesh = std::move(read.mesh);
  run.note = std::move(read.note);
  const TriangleMesh& triangles = run.mesh;
  progress.step("join");
  const MeshDistance solid(weld(triangles));
  // Open shells get no inside, which the report must state.
  run.name = cover_name(mesh);
  run.triangles = triangles.triangles.size();
  run.shells = solid.shells().count();
  for (const std::uint8_t is_closed : solid.shells().is_closed) run.closed_shells += is_closed;
  run.open_edges = solid.shells().open_edges;
  run.diagonal = solid.bounds().diagonal();
  if (!(run.diagonal > 0.0)) reject(mesh.string(), "all vertices are at one place");
  // Bores that stay open are regions with a smaller error.
  FitOptions options = options_for(request, read.metres_per_unit, run.diagonal, progress);
  if (request.keep_open) keep_bores_open(solid, request.keep_open->metres(run.diagonal), options);
  run.over = options.over;
  check_levels(request, run.diagonal);
  // Processor time counts, since other programs may run beside.
  const double start = processor_seconds();
  run.fit =
      request.count ? fit_count(solid, *request.count, options, &run.over) : fit_hexahedra(solid, options);
  const double fitted = processor_seconds();
  run.fit_seconds = fitted - start;
  // The proof checks the certificate's claim, and takes nothing from the fit.
  run.certificate = {mesh.filename().string(), program::sha256(bytes), read.metres_per_unit, request.input.up,
                     claim_of(run.fit, options)};
  progress.step("prove");
  run.verdict = check_cover(triangles, run.certificate.claim);
  if (!request.levels.empty()) add_levels(solid, request, progress, run);
  run.proof_seconds = processor_seconds() - fitted;
  // Samples, pages and training scenes cost time, and are made on request.
  if (request.samples > 0) {
    progress.step("sample");
    const SampleCount count = count_uncovered(solid, run.fit, request.samples);
    run.samples = count.asked;
    run.uncovered = count.uncovered;
  }
  if (request.page) add_pictures(solid, request, progress, run);
  if (request.training)
    for (program::ReportFile& file : training_files(run, mesh, request.output))
      run.more.push_back(std::move(file));
  return run;
}

std::vector<std::string> cover_extensions(const FitRequest& request) {
  std::vector<std::string> all{".yaml", ".certificate.json"};
  for (std::size_t level = 0; level < request.levels.size(); ++level)
    all.push_back(level_certificate_extension(level));
  if (request.page) all.insert(all.end(), {".html", ".gltf"});
  if (request.training) all.insert(all.end(), {".scene.yaml", ".flight.yaml", ".flight.meshes.json"});
  return all;
}

std::vector<program::ReportFile> cover_files(const FitRun& run) {
  const std::string description =
      fmt::format("{} hexahedra cover {} ({} triangles); no point of them is farther outside than {:.6g} m",
                  run.fit.hexahedra.size(), run.certificate.mesh_file, run.triangles, run.fit.excess);
  std::vector<program::ReportFile> files = {
      {run.name + ".yaml", scene_text(run.fit, run.name, description, 1.0, run.levels)},
      {run.name + ".certificate.json", certificate_text(run.certificate)}};
  for (std::size_t level = 0; level < run.level_certificates.size(); ++level)
    files.emplace_back(run.name + level_certificate_extension(level),
                       certificate_text(run.level_certificates[level]));
  files.insert(files.end(), run.more.begin(), run.more.end());
  return files;
}

std::string table_text(const std::vector<FitRun>& runs) {
  program::TextTable table({"mesh", "triangles", "shells", "open edges", "asked %", "hexahedra", "error %",
                            "error [mm]", "fit [s]", "proof", "[s]", "uncovered", "of"});
  for (const FitRun& run : runs)
    table.add({run.name, program::format_count(run.triangles), std::to_string(run.shells),
               std::to_string(run.open_edges), percent(run.over / run.diagonal),
               std::to_string(run.fit.hexahedra.size()), percent(run.fit.excess / run.diagonal),
               fmt::format("{:.4g}", 1e3 * run.fit.excess), fmt::format("{:.1f}", run.fit_seconds),
               run.verdict.is_proven ? "proven" : "REFUSED", fmt::format("{:.1f}", run.proof_seconds),
               run.samples > 0 ? program::format_count(run.uncovered) : "-",
               run.samples > 0 ? program::format_count(run.samples) : "-"});
  return table.str();
}

std::string table_csv(const std::vector<FitRun>& runs) {
  std::string text =
      "mesh,triangles,shells,closed_shells,open_edges,diagonal_m,asked_m,hexahedra,error_m,fit_s,proven,"
      "proof_s,samples,uncovered\n";
  for (const FitRun& run : runs)
    text += fmt::format("{},{},{},{},{},{},{},{},{},{:.2f},{},{:.2f},{},{}\n", run.name, run.triangles,
                        run.shells, run.closed_shells, run.open_edges, run.diagonal, run.over,
                        run.fit.hexahedra.size(), run.fit.excess, run.fit_seconds,
                        run.verdict.is_proven ? 1 : 0, run.proof_seconds, run.samples, run.uncovered);
  return text;
}

}  // namespace touchstone::fitting

#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/fit/fit_run.hpp"
#include "touchstone/examples/program/terminal/program.hpp"
#include "touchstone/tests/fit/table/decomposers.hpp"
#include "touchstone/tests/fit/table/results_page.hpp"

// Fits every mesh of a folder, proves and judges each cover, and sets it beside other decompositions: a page.

namespace {

using namespace touchstone;
using namespace touchstone::test;

struct Options {
  std::string folder, results;
  std::vector<std::string> over{"2%", "1%"}, unit;
  std::size_t samples = 10'000'000;
  std::uint64_t seed = 1;
  bool has_peers = true, is_fitted_to_peers = true;
  DecomposerSetting decomposers;
};

bool parse(int argc, char** argv, Options& options) {
  CLI::App app{
      "Fits the meshes of a folder, judges the covers by Bullet, and sets V-HACD and CoACD beside them."};
  app.add_option("folder", options.folder, "Of STL, OBJ, PLY or DAE files")->required();
  app.add_option("--unit", options.unit, "As of touchstone_fit")->allow_extra_args(false);
  app.add_option("--over", options.over, "Errors, each a share of the diagonal")->capture_default_str();
  app.add_option("--samples", options.samples, "Points that the judge looks for, of each mesh and error")
      ->capture_default_str();
  app.add_option("--seed", options.seed, "Of these points")->capture_default_str();
  app.add_option("--results", options.results, "Markdown page to write; without it to the standard output");
  app.add_option("--python", options.decomposers.python,
                 "A Python with the packages vhacdx and coacd, or without")
      ->capture_default_str();
  app.add_option("--longest", options.decomposers.longest, "For a mesh by one of these [s]")
      ->capture_default_str();
  app.add_flag("!--no-peers", options.has_peers, "Without V-HACD and CoACD");
  app.add_flag("!--no-fit-to-peers", options.is_fitted_to_peers, "Without covers within their excess");
  return program::parse_command_line(app, argc, argv);
}

double unit_of(const Options& options, const std::string& name) {
  std::optional<double> all, own;
  for (const std::string& text : options.unit) {
    const std::size_t equals = text.rfind('=');
    if (equals == std::string::npos)
      all = program::parse_unit(text);
    else if (text.substr(0, equals) == name)
      own = program::parse_unit(text.substr(equals + 1));
  }
  if (!own && !all) reject("--unit", "is missing, of " + name);
  return own ? *own : *all;
}

std::vector<ConvexPiece> pieces_of(const Fit& fit) {
  std::vector<ConvexPiece> pieces;
  for (const FittedHexahedron& each : fit.hexahedra)
    pieces.push_back({{each.vertices.begin(), each.vertices.end()}, {}});
  return pieces;
}

/// One mesh of the folder.
struct Part {
  std::filesystem::path file;
  std::string name;
  fitting::MeshInput input;
  TriangleMesh mesh;
  double diagonal = 0.0;
};

Part read_part(const Options& options, const std::filesystem::path& file) {
  Part part{file, fitting::cover_name(file), {}, {}, 0.0};
  part.input.metres_per_unit = unit_of(options, part.name);
  part.mesh = fitting::read_mesh(file, part.input).mesh;
  Bounds bounds;
  for (const auto& t : part.mesh.triangles)
    for (const std::uint32_t i : t) bounds.add(part.mesh.vertices[i]);
  part.diagonal = bounds.diagonal();
  return part;
}

fitting::FitRun fit_within(const Part& part, double share, program::ProgressLine& progress) {
  fitting::FitRequest request;
  request.over = {share, true};
  request.input = part.input;
  return fitting::run_fit(part.file, request, progress);
}

FitRow fit_row(const Options& options, const Part& part, const CoverJudge& judge, double share,
               program::ProgressLine& progress) {
  FitRow row{part.name, share, part.mesh.triangles.size(), 0, 0.0, 0.0, 0.0, {}, {}};
  try {
    const fitting::FitRun run = fit_within(part, share, progress);
    row.hexahedra = run.fit.hexahedra.size();
    row.error = run.fit.excess / run.diagonal;
    row.fit_seconds = run.fit_seconds;
    row.proof_seconds = run.proof_seconds;
    if (!run.verdict.is_proven) row.refused = "refused: " + run.verdict.reason;
    progress.step("judge");
    row.judged = judge.judge(pieces_of(run.fit), options.samples, options.seed, CoverJudge::kRounding,
                             [&](double done) { progress.share(done); });
  } catch (const InputError& error) {
    row.refused = error.what();
  }
  return row;
}

PeerRow peer_row(const Options& options, const Part& part, const CoverJudge& judge, const std::string& method,
                 const std::filesystem::path& scratch, program::ProgressLine& progress) {
  constexpr double kResolution = 1e-3, kLeastFit = 0.01;  // shares of the diagonal
  // Its hulls, their excess, and the samples that they leave uncovered.
  PeerRow row;
  row.mesh = part.name;
  row.method = method;
  progress.step(method);
  const Decomposition found = decompose(options.decomposers, method, part.mesh, scratch);
  row.failure = found.failure;
  if (!row.failure.empty()) return row;
  row.hulls = found.hulls.size();
  row.triangles = count_triangles(found.hulls);
  row.seconds = found.seconds;
  const MeshDistance distance(weld(part.mesh));
  progress.step("excess");
  row.excess = bound_hulls_excess(distance, found.hulls, kResolution * part.diagonal) / part.diagonal;
  progress.step("judge");
  row.judged = judge.judge(found.hulls, options.samples / 10, options.seed);
  row.judged_far = judge.judge(found.hulls, options.samples / 10, options.seed, kFar);
  // Ours within the same excess.
  if (!options.is_fitted_to_peers || row.excess < kLeastFit) return row;
  try {
    const fitting::FitRun run = fit_within(part, row.excess, progress);
    if (run.verdict.is_proven) row.hexahedra = run.fit.hexahedra.size();
  } catch (const InputError&) {  // none was found: said by its absence
  }
  return row;
}

std::string command_text(int argc, char** argv, const Options& options) {
  std::string text = "fit_table FOLDER";
  for (int i = 1; i < argc; ++i)
    if (argv[i] == std::string("--unit") && i + 1 < argc) text += std::string(" --unit ") + argv[i + 1];
  for (const std::string& over : options.over) text += " --over " + over;
  return text + fmt::format(" --samples {} --seed {}", options.samples, options.seed);
}

std::vector<double> shares_of(const Options& options) {
  std::vector<double> shares;
  for (const std::string& over : options.over) {
    const program::Length length = program::parse_length(over, "--over");
    if (!length.is_share) reject("--over", "'" + over + "' is no share of the diagonal");
    shares.push_back(length.value);
  }
  return shares;
}

std::vector<std::filesystem::path> files_of(const Options& options) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(options.folder))
    if (entry.is_regular_file() && fitting::is_mesh_file(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  if (files.empty()) reject(options.folder, "no STL, OBJ, PLY or DAE file in this folder");
  for (const auto& file : files) unit_of(options, fitting::cover_name(file));  // before hours of work
  return files;
}

/// Those that are installed; the page says of each whether it is.
std::vector<std::string> find_methods(const Options& options, FitTable& table) {
  std::vector<std::string> methods;
  if (!options.has_peers) return methods;
  for (const auto& [method, what] :
       {std::pair<std::string, std::string>{"vhacd", "V-HACD (Python package vhacdx)"},
        {"coacd", "CoACD (Python package coacd)"}}) {
    const FoundDecomposer found = find_decomposer(options.decomposers, method);
    const bool is_there = found.missing.empty();
    table.peers.push_back(what + (is_there ? " " + found.version : ": " + found.missing + ", left out"));
    if (is_there) methods.push_back(method);
  }
  return methods;
}

int run(int argc, char** argv) {
  Options options;
  if (!parse(argc, argv, options)) return 0;
  const std::vector<double> shares = shares_of(options);
  const std::vector<std::filesystem::path> files = files_of(options);
  FitTable table;
  table.command = command_text(argc, argv, options);
  table.samples = options.samples;
  const std::vector<std::string> methods = find_methods(options, table);
  const std::filesystem::path scratch =
      std::filesystem::temp_directory_path() / fmt::format("fit_table_{}", ::getpid());
  std::filesystem::create_directories(scratch);
  for (const auto& file : files) {
    program::ProgressLine progress;
    const Part part = read_part(options, file);
    const CoverJudge judge(part.mesh);
    for (const double share : shares) {
      table.rows.push_back(fit_row(options, part, judge, share, progress));
      progress.finish();
      program::print_now(row_text(table.rows.back()));
    }
    for (const std::string& method : methods) {
      table.peer_rows.push_back(peer_row(options, part, judge, method, scratch, progress));
      progress.finish();
      program::print_now(row_text(table.peer_rows.back()));
    }
    // After each mesh: what is known stays.
    if (!options.results.empty()) std::ofstream(options.results) << results_page(table);
  }
  std::filesystem::remove_all(scratch);
  if (options.results.empty()) program::print_now(results_page(table));
  return count_uncovered(table) == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  return touchstone::program::run_program("fit_table", [&] { return run(argc, argv); });
}

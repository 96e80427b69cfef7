#include <fmt/format.h>

#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/fit/fit_run.hpp"
#include "touchstone/examples/program/program.hpp"

namespace {

using namespace touchstone;
using namespace touchstone::fitting;

struct Options {
  std::string input, over, unit, check, output = "fit";
  std::vector<std::string> regions;
  std::size_t count = 0, samples = 0;
  int repairs = FitOptions().repairs;
};

bool parse(int argc, char** argv, Options& options) {
  CLI::App app{
      "Covers a mesh by few hexahedra: their union holds every triangle, and the inside of closed shells, "
      "and no "
      "point of it is farther outside than --over. Writes a scene file with the cover and a certificate, "
      "which is "
      "proven before it is written: coverage in exact arithmetic, the error by branch and bound. Open shells "
      "are "
      "covered as sheets."};
  app.add_option("mesh", options.input, "An STL file, or a folder of them")->required();
  app.add_option("--unit", options.unit,
                 "Unit of the file: m, cm, mm, um, in, ft, or metres a unit; files do not say");
  app.add_option("--over", options.over,
                 "Largest error, outwards: 2mm, 0.5cm, 0.02m, 1in, or 2% of the diagonal");
  app.add_option("--count", options.count,
                 "At most so many hexahedra, with the least error; --over is where to begin");
  app.add_option(
      "--region", options.regions,
      "NAME=LENGTH:x,y,z:x,y,z: a box with a smaller error of its own, such as a bore to keep open; corners "
      "in the file's units");
  app.add_option("--samples", options.samples,
                 "Random points of surface and inside to look for in the cover");
  app.add_option("--repairs", options.repairs, "How hard to look for fewer: places that are covered anew")
      ->capture_default_str()
      ->check(CLI::Range(0, 1000000));
  app.add_option("--check", options.check, "Checks this certificate against the mesh, and writes nothing");
  app.add_option("--out,--output", options.output, "Folder of scenes, certificates and the table")
      ->capture_default_str();
  return comparison::parse_command_line(app, argc, argv);
}

std::vector<std::filesystem::path> meshes_at(const std::filesystem::path& input) {
  if (!std::filesystem::is_directory(input)) return {input};
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(input)) {
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    if (entry.is_regular_file() && extension == ".stl") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  if (files.empty()) reject(input.string(), "no STL file in this folder");
  return files;
}

int check(const Options& options) {
  const Certificate certificate = read_certificate(options.check);
  if (!options.unit.empty() && parse_unit(options.unit) != certificate.scale)
    reject("--unit", fmt::format("'{}' is {} m; the certificate is of {} m a unit of the file", options.unit,
                                 parse_unit(options.unit), certificate.scale));
  const CoverVerdict verdict = check_certificate(certificate, options.input);
  if (!verdict.is_proven) {
    comparison::print_now(fmt::format("refused: {}\n", verdict.reason));
    return 1;
  }
  comparison::print_now(fmt::format(
      "proven: {} triangles in one hexahedron each, {} in several; {} outer pieces beside no inside; error "
      "bounded over {} tetrahedra\n",
      verdict.in_one_hexahedron, verdict.cut, verdict.outer_pieces, verdict.tetrahedra));
  comparison::print_now(claims_text(certificate));
  return 0;
}

FitRequest request_of(const Options& options) {
  if (options.unit.empty()) reject("--unit", "is missing: an STL file does not say its unit");
  if (options.over.empty() && options.count == 0) reject("--over", "is missing, and --count");
  FitRequest request;
  request.over = parse_length(options.over.empty() ? "5%" : options.over, "--over");
  if (options.count > 0) request.count = options.count;
  for (const std::string& region : options.regions) request.regions.push_back(parse_region(region));
  request.scale = parse_unit(options.unit);
  request.repairs = options.repairs;
  request.samples = options.samples;
  return request;
}

int run(int argc, char** argv) {
  Options options;
  if (!parse(argc, argv, options)) return 0;
  if (!options.check.empty()) return check(options);
  const FitRequest request = request_of(options);
  const std::vector<std::filesystem::path> meshes = meshes_at(options.input);
  check_names(meshes);
  std::vector<std::string> names{"fit.csv"};
  for (const auto& mesh : meshes)
    for (const char* extension : {".yaml", ".certificate.json"})
      names.push_back(cover_name(mesh) + extension);
  comparison::check_report_folder(options.output, names);
  std::vector<FitRun> runs;
  std::vector<comparison::ReportFile> report;
  bool is_proven = true;
  for (const auto& mesh : meshes) {
    comparison::ProgressLine progress;
    try {
      runs.push_back(run_fit(mesh, request, progress));
    } catch (const InputError& error) {
      if (meshes.size() == 1) throw;
      progress.finish();
      comparison::print_now(fmt::format("not proven: {}\n", error.what()));  // the others are not lost
      is_proven = false;
      continue;
    }
    progress.finish();
    const FitRun& last = runs.back();
    comparison::print_now(fmt::format("{}: {} hexahedra, error {:.4g} mm, {}\n", last.name,
                                      last.fit.hexahedra.size(), 1e3 * last.fit.excess,
                                      last.verdict.is_proven ? "proven" : "refused: " + last.verdict.reason));
    is_proven = is_proven && last.verdict.is_proven;
    if (!last.verdict.is_proven) continue;  // nothing that is not proven is written
    for (comparison::ReportFile& file : cover_files(last)) report.push_back(std::move(file));
  }
  if (runs.empty()) return 1;
  report.emplace_back("fit.csv", table_csv(runs));
  const std::filesystem::path folder = comparison::place_report(options.output, report, is_proven, true);
  comparison::print_now(
      fmt::format("\n{}\nscenes and certificates: {}\n", table_text(runs), folder.string()));
  return is_proven ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  return touchstone::comparison::run_program("touchstone_fit", [&] { return run(argc, argv); });
}

#include <fmt/format.h>

#include "touchstone/examples/measures/all_backends.hpp"
#include "touchstone/examples/program/choices.hpp"
#include "touchstone/examples/program/program.hpp"
#include "touchstone/examples/program/report_files.hpp"
#include "touchstone/examples/training_run/options.hpp"
#include "touchstone/examples/training_run/run.hpp"

namespace {

using namespace touchstone;
using namespace touchstone::training;
using comparison::ProgressLine;

void print_list(const Options& options, const BackendRegistry& registry) {
  fmt::print("scripts\n");
  for (const std::filesystem::path& file : find_scripts(options))
    fmt::print("  {:26}  {}\n", file.stem().string(), load_script(file).name);
  fmt::print("backends\n{}", comparison::backend_list(registry));
  fmt::print("outputs\n{}", outputs_text());
}

std::vector<comparison::ReportFile> report_files(const std::vector<ScriptResult>& results) {
  std::vector<comparison::ReportFile> files = {{"results.json", results_json(results)},
                                               {"results.csv", results_csv(results)}};
  for (const ScriptResult& result : results) {
    const std::string plot = separation_plot(result);
    if (!plot.empty()) files.emplace_back("plots/" + result.file + ".svg", plot);
  }
  return files;
}

int run(int argc, char** argv) {
  const std::optional<Options> options = parse_options(argc, argv, TOUCHSTONE_SCRIPTS);
  if (!options) return 0;
  BackendRegistry registry;
  comparison::register_all_backends(registry);
  if (options->list) {
    print_list(*options, registry);
    return 0;
  }
  const std::vector<std::string> backends = comparison::choose_backends(options->backends, registry);
  const std::vector<std::filesystem::path> scripts = find_scripts(*options);
  comparison::check_report_folder(options->output);
  prepare_outputs(options->outputs);
  fmt::print(
      "stopped s: first stop; clear m: exact separation there; deep mm: deepest shown; on way: and between "
      "frames;\n"
      "merged: frames shown in contact; shown!: wrongly so or untold; told!: told of none there was;\n"
      "blocked!: wrongly blocked of those blocked; us: control and check of a frame;\n"
      "cpu: the worst by the thread's own clock\n");
  const auto results = comparison::run_each(
      scripts,
      [&](const auto& script, ProgressLine& progress) {
        return run_script(script, *options, registry, backends, progress);
      },
      terminal_text);
  fmt::print("{}", summary_text(results));
  comparison::write_report_folder(options->output, report_files(results));
  fmt::print("\nresults, plots: {}\n", options->output);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return touchstone::comparison::run_program("training_run", [&] { return run(argc, argv); });
}

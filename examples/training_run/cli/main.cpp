#include <fmt/format.h>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/examples/program/options/bundled_folder.hpp"
#include "touchstone/examples/program/options/choices.hpp"
#include "touchstone/examples/program/terminal/program.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"
#include "touchstone/examples/training_run/cli/options.hpp"
#include "touchstone/examples/training_run/cli/run.hpp"
#include "touchstone/examples/training_run/results/live_report.hpp"

namespace {

using namespace touchstone;
using namespace touchstone::training;
using program::ProgressLine;

void print_list(const Options& options, const BackendRegistry& registry) {
  fmt::print("scripts\n");
  for (const std::filesystem::path& file : find_scripts(options))
    fmt::print("  {:26}  {}\n", file.stem().string(), load_setting(file, options)->script().name);
  fmt::print("backends\n{}", program::backend_list(registry));
  fmt::print("outputs\n{}", outputs_text());
}

int run(int argc, char** argv) {
  const std::optional<Options> options =
      parse_options(argc, argv, program::bundled_folder(TOUCHSTONE_EXAMPLES, "training_run/scripts"));
  if (!options) return 0;
  BackendRegistry registry;
  register_all_backends(registry);
  if (options->list) {
    print_list(*options, registry);
    return 0;
  }
  // Wrong names are found before a report is begun.
  const std::vector<std::string> backends = program::choose_backends(options->backends, registry);
  const std::vector<std::filesystem::path> scripts = find_scripts(*options);
  LiveReport report(options->output, program::stems(scripts));
  for (const std::filesystem::path& script : scripts)
    load_setting(script, *options, [&](const std::string& account) {  // before any of them is flown
      program::print_now(program::wrapped(account));
    });
  // So are outputs that cannot be made.
  std::vector<std::string> flights;
  for (const std::string& script : program::stems(scripts))
    for (std::string& name : flight_names(script, backends)) flights.push_back(std::move(name));
  prepare_outputs(options->outputs, flights);
  program::print_now(
      "stopped s: first stop; clear m: exact separation there; deep mm: deepest shown; between: and between "
      "frames;\n"
      "merged: frames shown in contact; missed: of those, wrongly or not reported; phantom: contact "
      "reported, none there;\n"
      "false stops: wrongly stopped of frames with a mover stopped; us: control and check of a frame;\n"
      "cpu: the worst by the thread's own clock; alloc: in all frames (figure 2 lists anew what is in "
      "range)\n");
  // Methods are reported one by one, so that an interrupt loses none of them.
  const auto run_one = [&](const std::filesystem::path& script, ProgressLine& progress) {
    return run_script(script, *options, registry, backends, progress,
                      [&](const ScriptResult& so_far) { report.see_method(so_far); });
  };
  program::run_each(scripts, run_one, [&](ScriptResult result) {
    const std::string text = program::wrapped(terminal_text(result));
    report.see_script(std::move(result));
    return text;
  });
  report.finish();
  program::print_now(program::wrapped(summary_text(report.results())) +
                     "\nresults, plots: " + options->output + "\n");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return touchstone::program::run_program("training_run", [&] { return run(argc, argv); });
}

#include <fmt/format.h>

#include "touchstone/adapters/scene_files/dynamics_file.hpp"
#include "touchstone/examples/dynamics_run/live_report.hpp"
#include "touchstone/examples/dynamics_run/run.hpp"
#include "touchstone/examples/measures/all_backends.hpp"
#include "touchstone/examples/program/bundled_folder.hpp"
#include "touchstone/examples/program/choices.hpp"
#include "touchstone/examples/program/program.hpp"

namespace {

using namespace touchstone;
using namespace touchstone::dynamics;
using comparison::ProgressLine;

std::string chosen_reference(const Options& options, const BackendRegistry& registry) {
  if (!options.reference.empty()) return registry.narrowphase(options.reference).name;
  for (const auto& entry : registry.narrowphases())
    if (entry.name == "exact") return entry.name;
  return "native";
}

void print_list(const Options& options, const BackendRegistry& registry) {
  fmt::print("scenes\n");
  for (const std::filesystem::path& file : find_scenes(options))
    fmt::print("  {:26}  {}\n", file.stem().string(), load_dynamic_scene(file).scene.name);
  fmt::print("backends\n{}", comparison::backend_list(registry));
}

int run(int argc, char** argv) {
  std::optional<Options> options =
      parse_options(argc, argv, comparison::bundled_folder(TOUCHSTONE_EXAMPLES, "dynamics_run/scenes"));
  if (!options) return 0;
  BackendRegistry registry;
  comparison::register_all_backends(registry);
  if (options->list) {
    print_list(*options, registry);
    return 0;
  }
  const std::vector<std::string> backends = comparison::choose_backends(options->backends, registry);
  options->reference = chosen_reference(*options, registry);
  const std::vector<std::filesystem::path> scenes = find_scenes(*options);
  LiveReport report(options->output, comparison::stems(scenes), backends);
  for (const std::filesystem::path& scene : scenes) load_scene(scene, *options);  // before any of them is run
  comparison::print_now(legend_text(options->reference));
  const auto run_one = [&](const std::filesystem::path& scene, ProgressLine& progress) {
    return run_scene(scene, *options, registry, backends, progress,
                     [&](const SceneResult& so_far) { report.see_run(so_far); });
  };
  comparison::run_each(scenes, run_one, [&](SceneResult result) {
    const std::string text = terminal_text(result);
    report.see_scene(std::move(result));
    return text;
  });
  report.finish();
  comparison::print_now(report.verdict() + fmt::format("\nresults, series, plots: {}\n", options->output));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return touchstone::comparison::run_program("dynamics_run", [&] { return run(argc, argv); });
}

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/guarded_run/run.hpp"
#include "touchstone/examples/program/files/report_files.hpp"
#include "touchstone/examples/program/options/bundled_folder.hpp"
#include "touchstone/examples/program/options/choices.hpp"
#include "touchstone/examples/program/terminal/program.hpp"
#include "touchstone/examples/robot_files/robot_files.hpp"

namespace {

using namespace touchstone;
using namespace touchstone::guarded;

struct Options {
  std::vector<std::string> scenes, contacts{"native"}, settings;
  std::string output = "guarded";
  std::filesystem::path folder;
  robot_files::RobotChoices robots;
  bool list = false;
};

bool parse(int argc, char** argv, Options& options) {
  CLI::App app{
      "Runs scenes with dynamics and a guard in one loop: hand controller, torque-limited joints and contact "
      "forces, proof and motion modification, output; what is shown never merges."};
  app.add_option("--scene", options.scenes, "Names or files (default: all bundled ones; --list names them)");
  app.add_option("--contacts", options.contacts, "Narrowphases behind the dynamics' contacts, or all")
      ->capture_default_str();
  app.add_option("--set", options.settings, "Scene parameters, NAME=VALUE");
  app.add_option("--out,--output", options.output, "Folder of results, series and plots")
      ->capture_default_str();
  std::string folder;
  app.add_option("--scenes", folder, "Folder with the scenes");
  app.add_flag("--list", options.list, "List scenes and narrowphases");
  robot_files::add_robot_options(app, options.robots);
  if (!program::parse_command_line(app, argc, argv)) return false;
  if (!options.robots.files.empty())
    throw InputError("--robot: robots come with a scene that has a guard, as the model of an arm");
  options.folder = folder.empty() ? program::bundled_folder(TOUCHSTONE_EXAMPLES, "guarded_run/scenes")
                                  : std::filesystem::path(folder);
  return true;
}

int run(int argc, char** argv) {
  Options options;
  if (!parse(argc, argv, options)) return 0;
  BackendRegistry registry;
  register_all_backends(registry);
  const ArmModels models = robot_files::arm_models(
      options.robots, [](const std::string& account) { program::print_now(account); });
  // A list needs scenes and backends alone.
  const std::vector<std::filesystem::path> files =
      program::choose_files({options.folder, "--scenes", "there is no such scene"}, options.scenes);
  if (options.list) {
    for (const std::filesystem::path& file : files)
      fmt::print("  {:26}  {}\n", file.stem().string(),
                 load_guarded_scene(file, {}, models).scene.scene.name);
    fmt::print("{}", program::backend_list(registry));
    return 0;
  }
  const std::vector<std::string> contacts = program::choose_backends(options.contacts, registry);
  // Parameters are those of all scenes.
  SceneParameters parameters;
  for (const std::string& text : options.settings) {
    const program::SceneSetting setting = program::parse_setting(text, false);
    parameters[setting.name] = setting.value;
  }
  std::vector<program::ReportFile> report;
  program::print_now(legend_text());
  // Each scene is run over the contacts of every backend that is chosen.
  for (const std::filesystem::path& file : files) {
    const GuardedScene scene = load_guarded_scene(file, parameters, models);
    const std::string name = file.stem().string();
    std::vector<GuardedRun> runs;
    program::ProgressLine progress;
    for (const std::string& each : contacts) runs.push_back(run_scene(scene, registry, each, progress));
    progress.finish();
    program::print_now(terminal_text(name, scene, runs));
    report.emplace_back(name + ".csv", results_csv(name, runs));
    for (const GuardedRun& each : runs)
      if (each.not_run.empty()) report.emplace_back(name + "_" + each.contacts + ".csv", series_csv(each));
    if (std::string svg = plot(scene, runs); !svg.empty()) report.emplace_back(name + ".svg", std::move(svg));
  }
  // No file that came in between is written over.
  const std::filesystem::path folder = program::place_report(options.output, report, true);
  program::print_now(fmt::format("\nresults, series, plots: {}\n", folder.string()));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return touchstone::program::run_program("guarded_run", [&] { return run(argc, argv); });
}

#include "touchstone/examples/dynamics_run/options.hpp"

#include <CLI/CLI.hpp>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/options/choices.hpp"
#include "touchstone/examples/program/terminal/program.hpp"

namespace touchstone::dynamics {
std::optional<Options> parse_options(int argc, const char* const* argv, const std::filesystem::path& scenes) {
  Options options;
  options.folder = scenes;
  CLI::App app{
      "Runs scenes with dynamics in every engine and over the contacts of every backend, compares drift of "
      "momentum and energy, penetration, final poses and time per step, and names what to build on."};
  // Scenes, engines and backends are chosen by name.
  app.add_option("--scene", options.scenes,
                 "Scene numbers (8 9), names or files (default: all bundled ones; --list names them)");
  app.add_option(
         "--engine", options.engines,
         "Engines: own (over each --backend), ENGINE with its own check, ENGINE:CHECK with one of ours "
         "inside (bullet:exact), or all (default: own; --list names them)")
      ->delimiter(',');
  app.add_option(
      "--backend", options.backends,
      "Narrowphases of the own engine, and with --engine all of every other (default: all; the others "
      "their own and native; --list names them)");
  app.add_option("--reference", options.reference,
                 "What final poses are compared with (default: exact, or native where that is not built)");
  std::vector<std::string> settings;
  app.add_option("--set", settings,
                 "Scene parameters, NAME=VALUE; what the scene is known to come to is not judged then");
  // Samples, repetitions and limits decide how runs are measured and judged.
  app.add_option("--every", options.every, "Record the start, every n-th step and the last")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  app.add_option("--repetitions", options.repetitions,
                 "Runs of each scene and backend: a step's time is that of its fastest")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option(
         "--deadline", options.deadline,
         "What a step may take, for its 99.9th percentile [s] (default: the scene's step, which keeps up "
         "with the clock)")
      ->check(CLI::PositiveNumber);
  app.add_option("--out,--output", options.output, "Folder of results, series and plots")
      ->capture_default_str();
  app.add_option(
         "--error", options.error,
         "What every figure may be off by, in its unit; of energy and drifts the share (default: what "
         "the scenes allow)")
      ->check(CLI::PositiveNumber);
  std::string folder;
  app.add_option("--scenes", folder, "Folder with the scenes");
  options.robots.sphere_facets = 8;  // of the engines, ours alone takes rounded solids
  robot_files::add_robot_options(app, options.robots);
  app.add_flag("--list", options.list, "List scenes and backends");
  if (!program::parse_command_line(app, argc, argv)) return std::nullopt;
  // Defaults that depend on other options are set after parsing.
  for (const std::string& setting : settings)
    options.settings.push_back(program::parse_setting(setting, false));
  if (options.output.empty()) throw InputError("--out: names no folder");
  if (!folder.empty()) options.folder = folder;
  if (options.engines.empty()) options.engines = {"own"};
  if (options.backends.empty()) options.backends = {"all"};
  return options;
}

std::vector<std::filesystem::path> find_scenes(const Options& options) {
  std::vector<std::filesystem::path> files;
  if (options.robots.files.empty() || !options.scenes.empty())
    files = program::choose_files({options.folder, "--scenes", "there is no such scene"}, options.scenes);
  files.insert(files.end(), options.robots.files.begin(), options.robots.files.end());
  return files;
}

}  // namespace touchstone::dynamics

#include "touchstone/examples/compare_backends/options.hpp"

#include <cmath>
#include <filesystem>
#include <map>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/program.hpp"
#include "touchstone/examples/program/shell_text.hpp"

namespace touchstone::comparison {
namespace {

const std::map<std::string, QueryKind> kQueries = {
    {"overlap", QueryKind::overlap}, {"distance", QueryKind::distance}, {"manifold", QueryKind::manifold}};

/// Cases of the user's own decide alone, unless families are named too.
void choose_families(Options& options) {
  const std::vector<std::string> all = {"all"}, none = {"none"};
  const bool has_own = !options.pairs_file.empty() || !options.scenes.empty();
  if (options.families.empty() && has_own) {
    options.families = none;
    options.no_broadphase = true;
  }
  options.no_families = options.families == none;
  if (options.no_families || options.families == all) options.families.clear();
}

}  // namespace

void add_query_option(CLI::App& app, std::string& query) {
  query = "distance";
  app.add_option("--query", query, "The query of --max-error")
      ->check(CLI::IsMember({"overlap", "distance", "manifold"}))
      ->capture_default_str();
}

double checked_max_error(double max_error) {
  if (!std::isfinite(max_error) || max_error < 0)
    throw InputError("--max-error: must be finite and not negative");
  return max_error;
}

QueryKind query_named(const std::string& name) {
  const auto found = kQueries.find(name);
  if (found == kQueries.end()) throw InputError("unknown query '" + name + "'");
  return found->second;
}

std::optional<Options> parse_options(int argc, const char* const* argv) {
  Options options;
  options.command_line = shell_word(std::filesystem::path(argv[0]).filename().string());
  for (int i = 1; i < argc; ++i) options.command_line += " " + shell_word(argv[i]);
  std::string query;
  double max_error = 0;
  std::size_t count = 0;

  CLI::App app{
      "Every contact detection backend on the same pairs and scenes: speed against error.\n"
      "compare_backends diff OLD.json NEW.json: what changed between two runs.\n"
      "compare_backends decide RESULTS.json --max-error M ...: the verdict of a run for other allowed "
      "errors."};
  app.add_option("--backend", options.backends, "Backends to compare (default: all; --list names them)");
  app.add_option(
      "--families", options.families,
      "Pair families, 'all' or 'none' (default: all; none where --pairs, --capture or --scene brings "
      "cases of your own, which then decide alone)");
  auto* count_option = app.add_option("--count", count, "Pairs a family (default 20000, 500 with --quick)")
                           ->check(CLI::Range(1, 10000000));
  app.add_option("--seed", options.seed, "Seed of the pair families")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--scene", options.scenes, "Scene files (YAML)");
  std::vector<std::string> settings;
  app.add_option("--set", settings,
                 "Scene parameters: NAME=VALUE (every scene that has it) or SCENE:NAME=VALUE, SCENE the "
                 "file's name without .yaml");
  auto* pairs_option = app.add_option("--pairs", options.pairs_file, "Your own cases (JSON)");
  std::string capture_file;
  app.add_option("--capture", capture_file, "The same of an engine's own check, with its answers")
      ->excludes(pairs_option);
  app.add_option("--dynamics", options.dynamics_file,
                 "results.json of dynamics_run, for the page's section on dynamics drift");
  auto* error_option = app.add_option("--max-error", max_error,
                                      "Name the fastest backend whose worst case stays inside this [m]");
  add_query_option(app, query);
  app.add_option("--case", options.case_id,
                 "Replay one case: family:index, a pair file's id, or scene:frame:pair");
  app.add_option("--output", options.output, "Folder of the report")->capture_default_str();
  app.add_option("--repetitions", options.repetitions, "Passes over each timed row")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--threads", options.threads, "For the exact answers; timing always runs on one")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  app.add_flag("--no-broadphase", options.no_broadphase,
               "Leave the broadphases out (so too where cases of your own decide alone)");
  app.add_flag("--quick", options.quick,
               "Few pairs, two repetitions, 100 frames a scene, 1k boxes in the broadphases");
  app.add_flag("--list", options.list, "List backends, broadphases and families");
  if (!parse_command_line(app, argc, argv)) return std::nullopt;
  if (*count_option) options.count = count;
  if (*error_option) options.max_error = checked_max_error(max_error);
  for (const std::string& setting : settings) options.scene_settings.push_back(parse_setting(setting, true));
  if (!settings.empty() && options.scenes.empty())
    throw InputError("--set: there is no --scene to set it in");
  if (app.count("--case") > 0 && options.case_id.empty()) throw InputError("--case: names no case");
  if (options.output.empty()) throw InputError("--output: names no folder");
  options.query = query_named(query);
  if (app.count("--capture") > 0) {
    if (capture_file.empty()) throw InputError("--capture: names no file");
    options.pairs_file = capture_file;
    options.is_capture = true;
  }
  choose_families(options);
  if (options.no_families && options.scenes.empty() && options.pairs_file.empty() && options.no_broadphase)
    throw InputError(
        "--families none: and no --scene, no --pairs and no broadphases: there is nothing to compare");
  if (options.quick && app.count("--repetitions") == 0) options.repetitions = 2;
  return options;
}

}  // namespace touchstone::comparison

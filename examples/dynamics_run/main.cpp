#include <fmt/format.h>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/adapters/all/all_engines.hpp"
#include "touchstone/examples/dynamics_run/live_report.hpp"
#include "touchstone/examples/dynamics_run/run.hpp"
#include "touchstone/examples/dynamics_run/simulate.hpp"
#include "touchstone/examples/program/options/bundled_folder.hpp"
#include "touchstone/examples/program/options/choices.hpp"
#include "touchstone/examples/program/terminal/program.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace {

using namespace touchstone;
using namespace touchstone::dynamics;
using program::ProgressLine;

std::string chosen_reference(const Options& options, const BackendRegistry& registry) {
  if (!options.reference.empty()) return registry.narrowphase(options.reference).name;
  for (const auto& entry : registry.narrowphases())
    if (entry.name == "exact") return entry.name;
  return "native";
}

/// With which of its checks an engine has a feature: "yes", "-", "ours" for all but its own, or those that
/// do.
std::string word_for(const physics::EngineRegistry::Entry& entry, physics::EngineFeature feature) {
  std::vector<std::string> with;
  for (const std::string& check : entry.checks)
    if (entry.features(check).has(feature)) with.push_back(check);
  if (with.empty()) return "-";
  if (with.size() == entry.checks.size()) return "yes";
  const bool is_ours = with.size() + 1 == entry.checks.size() && with[0] != physics::kOwnCheck;
  return is_ours ? "ours" : fmt::format("{}", fmt::join(with, ","));
}

/// A row a feature, a column an engine.
void print_features(const physics::EngineRegistry& engines) {
  fmt::print(
      "what a scene may ask of engines ('-': refused as unsupported; or the checks with which)\n  {:40}", "");
  for (const auto& entry : engines.engines()) fmt::print("  {:10}", entry.name);
  for (int i = 0; i < physics::kEngineFeatures; ++i) {
    const auto feature = static_cast<physics::EngineFeature>(i);
    fmt::print("\n  {:40}", to_string(feature));
    for (const auto& entry : engines.engines()) fmt::print("  {:10}", word_for(entry, feature));
  }
  fmt::print("\n  {:40}", "steps after a snapshot is restored");
  for (const auto& entry : engines.engines()) fmt::print("  {:10}", to_string(entry.after_restore));
  fmt::print("\n");
}

void print_engine(const physics::EngineRegistry::Entry& entry) {
  fmt::print("  {:26}  {}; checks: {}", entry.name, entry.description, fmt::join(entry.checks, " "));
  for (const auto& refused : entry.refused_checks)
    fmt::print("; unsupported: {} ({})", refused.name, refused.reason);
  fmt::print("\n");
}

void print_list(const Options& options, const BackendRegistry& registry,
                const physics::EngineRegistry& engines) {
  fmt::print("scenes\n");
  for (const std::filesystem::path& file : find_scenes(options))
    fmt::print("  {:26}  {}\n", file.stem().string(), load_scene(file, options).scene.name);
  fmt::print("backends\n{}engines\n", program::backend_list(registry));
  for (const auto& entry : engines.engines()) print_engine(entry);
  for (const auto& missing : engines.missing())
    fmt::print("  {:26}  missing: {}\n", missing.name, missing.reason);
  print_features(engines);
}

/// In the order asked for, each once; `own` over each of the backends.
std::vector<physics::EngineChoice> choose_engines(const Options& options,
                                                  const physics::EngineRegistry& engines,
                                                  const std::vector<std::string>& backends) {
  std::vector<physics::EngineChoice> choices;
  const auto add = [&](const physics::EngineChoice& choice) {
    engines.engine(choice);
    const auto is_same = [&](const physics::EngineChoice& each) {
      return run_name(each) == run_name(choice);
    };
    if (std::none_of(choices.begin(), choices.end(), is_same)) choices.push_back(choice);
  };
  // All narrowphases in every engine would be some forty runs a scene.
  const bool any_named = options.backends != std::vector<std::string>{"all"};
  const auto is_asked = [&](const std::string& check) {
    if (check == physics::kOwnCheck) return true;
    return any_named ? std::find(backends.begin(), backends.end(), check) != backends.end()
                     : check == "native";
  };
  const auto add_own = [&] {
    for (const std::string& backend : backends) add({"own", backend});
  };
  for (const std::string& word : options.engines) {
    if (word == "own" || word == "all") add_own();
    if (word == "all")
      for (const auto& entry : engines.engines())
        for (const std::string& check : entry.checks)
          if (entry.name != "own" && is_asked(check)) add({entry.name, check});
    if (word != "own" && word != "all") add(physics::parse_engine_choice(word));
  }
  return choices;
}

std::vector<std::string> run_names(const std::vector<physics::EngineChoice>& choices) {
  std::vector<std::string> names;
  for (const physics::EngineChoice& choice : choices) names.push_back(run_name(choice));
  return names;
}

int run(int argc, char** argv) {
  std::optional<Options> options =
      parse_options(argc, argv, program::bundled_folder(TOUCHSTONE_EXAMPLES, "dynamics_run/scenes"));
  if (!options) return 0;
  // Engines take their checks from the same backends.
  BackendRegistry registry;
  register_all_backends(registry);
  physics::EngineRegistry engines;
  physics::register_all_engines(engines, registry);
  if (options->list) {
    print_list(*options, registry, engines);
    return 0;
  }
  // All names are resolved before the first run, so that a wrong one costs no time.
  const std::vector<physics::EngineChoice> choices =
      choose_engines(*options, engines, program::choose_backends(options->backends, registry));
  options->reference = chosen_reference(*options, registry);
  const std::vector<std::filesystem::path> scenes = find_scenes(*options);
  LiveReport report(options->output, program::stems(scenes), run_names(choices));
  for (const std::filesystem::path& scene : scenes)
    load_scene(scene, *options, [](const std::string& account) {  // before any of them is run
      program::print_now(program::wrapped(account));
    });
  // Runs are reported one by one, so that an interrupt loses none of them.
  program::print_now(legend_text(options->reference));
  const auto run_one = [&](const std::filesystem::path& scene, ProgressLine& progress) {
    return run_scene(scene, *options, engines, choices, progress,
                     [&](const SceneResult& so_far) { report.see_run(so_far); });
  };
  program::run_each(scenes, run_one, [&](SceneResult result) {
    const std::string text = program::wrapped(terminal_text(result));
    report.see_scene(std::move(result));
    return text;
  });
  report.finish();
  program::print_now(program::wrapped(report.verdict()) +
                     fmt::format("\nresults, series, plots: {}\n", options->output));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return touchstone::program::run_program("dynamics_run", [&] { return run(argc, argv); });
}

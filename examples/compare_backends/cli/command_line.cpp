#include "touchstone/examples/compare_backends/cli/command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/options/shell_text.hpp"
#include "touchstone/examples/program/terminal/program.hpp"

namespace touchstone::comparison {
namespace {

/// Cases of the user's own decide alone, unless families are named too.
void choose_families(Options& options) {
  const std::vector<std::string> all = {"all"}, none = {"none"};
  const bool has_own = !options.pairs_file.empty() || !options.scenes.empty() || !options.corpus.empty();
  if (options.families.empty() && has_own) {
    options.families = none;
    options.no_broadphase = true;
  }
  options.no_families = options.families == none;
  if (options.no_families || options.families == all) options.families.clear();
}

double checked_max_error(double max_error) {
  if (!std::isfinite(max_error) || max_error < 0)
    throw InputError("--max-error: must be finite and not negative");
  return max_error;
}

}  // namespace

void ChoiceOptions::add_to(CLI::App& app) {
  // The query and the allowed error.
  app.add_option("--query", query, "The query that is chosen for")
      ->check(CLI::IsMember({"overlap", "distance", "manifold"}))
      ->capture_default_str();
  app.add_option(
      "--max-error", max_errors,
      "Name the fastest backend whose answers cost at most this [m]; exact for two digits, else to "
      "the safe side");
  app.add_option("--share", choice.share, "Share of the pairs that may be beyond --max-error (default 0)");
  // The pairs that count.
  app.add_option("--of", sets, "Decide from these sets alone: families, scenes, 'pairs' (default: all)");
  app.add_option("--classes", classes,
                 "Decide from pairs of these exact classes: apart, touching, deep (default: all). Deep: by "
                 "more than 1 % of the larger solid's size")
      ->check(CLI::IsMember({"apart", "touching", "deep"}));
  app.add_flag("--contacts-only", contacts_only, "Short for --classes touching deep");
  app.add_option("--apart-up-to", choice.apart_up_to,
                 "Of pairs that are apart, those up to this [m]; taken as the next power of ten from 1e-6 to "
                 "100 (default: all)");
  app.add_option("--within", choice.within,
                 "Pairs whose coordinates are up to this [m]; taken as the next power of ten from 1 to 1e7 "
                 "(default: all)");
  // The parts of an answer that count.
  app.add_flag("--without-normals", without_normals, "Normals are not asked for");
  app.add_flag("--without-points", without_points, "Neither are closest points or contact points");
  app.add_option("--min-coverage", choice.min_coverage,
                 "Manifolds: a contact whose points cover less of the true patch counts as beyond; taken as "
                 "the next of 0.25, 0.5, 0.75, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999");
  // Time and allocations.
  app.add_option("--deadline", choice.deadline,
                 "A call's time at the 99.9th percentile, at most [s]: a pair a call, in scenes a frame");
  app.add_flag("--no-allocations", choice.no_allocations, "A backend that allocates in steady state is out");
}

std::vector<Choice> ChoiceOptions::choices() const {
  Choice base = choice;
  base.query = query_named(query);
  base.sets = sets;
  // Classes are all chosen where none is named.
  if (contacts_only && !classes.empty())
    throw InputError("--contacts-only: is short for --classes touching deep; give one of the two");
  const auto has = [&](const char* name) {
    return classes.empty() || std::find(classes.begin(), classes.end(), name) != classes.end();
  };
  base.apart = has("apart") && !contacts_only;
  base.touching = has("touching");
  base.deep = has("deep");
  base.normals = !without_normals;
  base.points = !without_points;
  // Figures must be within what the run's counts tell apart.
  if (!(base.share >= 0) || !(base.share < 1)) throw InputError("--share: must be from 0 to below 1");
  if (!(base.apart_up_to > 0)) throw InputError("--apart-up-to: must be above 0");
  if (!(base.within > 0)) throw InputError("--within: must be above 0");
  if (!(base.min_coverage >= 0) || base.min_coverage > kCoverageBins.back())
    throw InputError("--min-coverage: must be from 0 to 0.999, which is as far as coverage is told apart");
  if (base.min_coverage > 0 && base.query != QueryKind::manifold)
    throw InputError("--min-coverage: is of --query manifold");
  if (!(base.deadline > 0)) throw InputError("--deadline: must be above 0");
  // Each largest error is a choice of its own.
  std::vector<Choice> all;
  for (const double max_error : max_errors) {
    base.max_error = checked_max_error(max_error);
    all.push_back(base);
  }
  if (max_errors.empty()) all.push_back(base);
  return all;
}

namespace {

/// Options that are not an Options' own yet.
struct RawOptions {
  std::size_t count = 0;
  std::vector<std::string> settings;
  std::string capture_file;
  std::string shard;
  ChoiceOptions choice;
};

void add_options(CLI::App& app, Options& options, RawOptions& raw) {
  // Backends: those of the build, plug-ins, engines.
  app.add_option("--backend", options.backends, "Backends to compare (default: all; --list names them)");
  app.add_option(
      "--plugin", options.plugins,
      "Shared libraries with a backend each (touchstone_plugin.h), asked in a process of their own");
  app.add_option("--engine", options.engines,
                 "Commands of engines that read pairs and write answers, split at blanks "
                 "(adapters/process_engine/README.md)");
  app.add_option(
         "--engine-limit", options.engine_limit,
         "Seconds for which an engine may be silent before it counts as hanging, five times that when it "
         "starts (default: a command 2, a plug-in 60)")
      ->check(CLI::Range(0.1, 86400.0));
  // Cases: families, scenes, files.
  app.add_option("--families", options.families,
                 "Pair families, 'all' or 'none' (default: all; none where --pairs, --capture, --corpus or "
                 "--scene brings cases of your own, which then decide alone)");
  app.add_option("--count", raw.count, "Pairs a family (default 20000, 500 with --quick)")
      ->check(CLI::Range(1, 10000000));
  app.add_option("--seed", options.seed, "Seed of the pair families")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--scene", options.scenes, "Scene files (YAML)");
  app.add_option("--set", raw.settings,
                 "Scene parameters: NAME=VALUE (every scene that has it) or SCENE:NAME=VALUE, SCENE the "
                 "file's name without .yaml");
  auto* pairs_option = app.add_option("--pairs", options.pairs_file, "Your own cases (JSON)");
  app.add_option("--capture", raw.capture_file, "The same of an engine's own check, with its answers")
      ->excludes(pairs_option);
  app.add_option("--corpus", options.corpus,
                 "Folder of a corpus (touchstone_bench corpus): its sets, held against its hashes and truth");
  app.add_option("--dynamics", options.dynamics_file,
                 "results.json of dynamics_run, for the page's section on dynamics drift");
  // The choice: query, error, pairs.
  raw.choice.add_to(app);
  // One case, or a part of all.
  app.add_option("--case", options.case_id,
                 "Replay one case: family:index, a pair file's id, or scene:frame:pair");
  app.add_option(
      "--shard", raw.shard,
      "3/8: the third of 8 parts of the pairs alone, into a file in --output; compare_backends merge "
      "makes one report of all of them");
  // The report, and how long the run takes.
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
}

Shard parse_shard(const std::string& text) {
  Shard shard;
  char slash = 0, rest = 0;
  std::istringstream in(text);
  // Signs are taken by the stream: -1 would come out large.
  const bool is_shard = text.find_first_not_of("0123456789/") == std::string::npos &&
                        in >> shard.k >> slash >> shard.n && slash == '/' && !(in >> rest);
  if (!is_shard || shard.k < 1 || shard.k > shard.n || shard.n > kMostShards)
    throw InputError("--shard: '" + text + "' is no shard, 3/8 is the third of 8 (of at most " +
                     std::to_string(kMostShards) + ")");
  return shard;
}

/// The words without those of the two options that parts of one run may differ in.
std::vector<std::string> shared_arguments(int argc, const char* const* argv) {
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--shard" || word == "--output")
      ++i;
    else if (!word.starts_with("--shard=") && !word.starts_with("--output="))
      words.push_back(word);
  }
  return words;
}

/// Takes over what was parsed as text. @throws InputError naming the options that do not go together.
void settle(const CLI::App& app, const RawOptions& raw, Options& options) {
  if (app.count("--count") > 0) options.count = raw.count;
  // One run is decided for one choice.
  if (raw.choice.max_errors.size() > 1)
    throw InputError("--max-error: one for a run; `compare_backends decide` takes more of a finished one");
  options.choice = raw.choice.choices().front();
  if (!raw.choice.max_errors.empty()) options.max_error = options.choice.max_error;
  // Scene parameters need a scene to be set in.
  for (const std::string& setting : raw.settings)
    options.scene_settings.push_back(parse_setting(setting, true));
  if (!raw.settings.empty() && options.scenes.empty())
    throw InputError("--set: there is no --scene to set it in");
  // Options that are given must name something.
  if (app.count("--case") > 0 && options.case_id.empty()) throw InputError("--case: names no case");
  if (app.count("--corpus") > 0 && options.corpus.empty()) throw InputError("--corpus: names no folder");
  if (options.output.empty()) throw InputError("--output: names no folder");
  if (app.count("--capture") > 0) {
    if (raw.capture_file.empty()) throw InputError("--capture: names no file");
    options.pairs_file = raw.capture_file;
    options.is_capture = true;
  }
  // Something must be left to compare, in sets with unique names.
  choose_families(options);
  if (!options.corpus.empty() && !options.no_families)
    throw InputError("--corpus: brings its own sets; --families draws others of the same names");
  if (options.no_families && options.scenes.empty() && options.pairs_file.empty() && options.corpus.empty() &&
      options.no_broadphase)
    throw InputError(
        "--families none: and no --scene, no --pairs and no broadphases: there is nothing to compare");
  if (app.count("--shard") > 0) {
    options.shard = parse_shard(raw.shard);
    if (!options.case_id.empty()) throw InputError("--shard: has no part of --case, which is one case");
    if (options.no_families && options.pairs_file.empty() && options.corpus.empty())
      throw InputError("--shard: there are no pairs to cut; scenes are measured whole, by the merge");
  }
  if (options.quick && app.count("--repetitions") == 0) options.repetitions = 2;
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv) {
  Options options;
  options.command_line = shell_word(std::filesystem::path(argv[0]).filename().string());
  for (int i = 1; i < argc; ++i) options.command_line += " " + shell_word(argv[i]);
  CLI::App app{
      "Every contact detection backend on the same pairs and scenes: speed against error.\n"
      "compare_backends diff OLD.json NEW.json: what changed between two runs.\n"
      "compare_backends decide RESULTS.json --max-error M ...: the verdict of a run for other choices.\n"
      "compare_backends merge SHARD... --output DIR: the report of a run that was cut by --shard.\n"
      "compare_backends fitted MESH... --unit mm --over 4% 2% 1%: geometry's error and the backend's "
      "together."};
  RawOptions raw;
  add_options(app, options, raw);
  if (!parse_command_line(app, argc, argv)) return std::nullopt;
  settle(app, raw, options);
  options.shared_arguments = shared_arguments(argc, argv);
  return options;
}

}  // namespace touchstone::comparison

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <string_view>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/cli/backends.hpp"
#include "touchstone/examples/compare_backends/cli/command_line.hpp"
#include "touchstone/examples/compare_backends/cli/decide_again.hpp"
#include "touchstone/examples/compare_backends/cli/plugins.hpp"
#include "touchstone/examples/compare_backends/cli/terminal.hpp"
#include "touchstone/examples/compare_backends/diff/diff.hpp"
#include "touchstone/examples/compare_backends/figures/figure_files.hpp"
#ifdef TOUCHSTONE_HAS_FITS
#include "touchstone/examples/compare_backends/fitted/fitted_command.hpp"
#endif
#include "touchstone/examples/compare_backends/page/html_report.hpp"
#include "touchstone/examples/compare_backends/results/answers_writer.hpp"
#include "touchstone/examples/compare_backends/results/json_writer.hpp"
#include "touchstone/examples/compare_backends/results/least_that_serves_page.hpp"
#include "touchstone/examples/compare_backends/results/tables_page.hpp"
#include "touchstone/examples/compare_backends/run/comparison.hpp"
#include "touchstone/examples/compare_backends/run/replay.hpp"
#include "touchstone/examples/compare_backends/run/shards/shard_file.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"
#include "touchstone/examples/program/files/report_run.hpp"
#include "touchstone/examples/program/terminal/program.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace {

using namespace touchstone;
using namespace touchstone::comparison;

void print_list(const Options& options, const Backends& backends) {
  std::string list = "backends\n";
  const auto add = [&](std::string_view name, std::string_view text) {
    list += fmt::format("  {:18}  {}\n", name, text);
  };
  for (const auto& [name, description] : chosen_backends(options, backends)) add(name, description);
  for (const Gap& gap : backends.gaps) add(gap.what, gap.why);
  list += "broadphases\n";
  for (const auto& entry : backends.registry.broadphases()) add(entry.name, entry.description);
  list += "families\n";
  for (const PairFamily& family : pair_families()) add(family.name, family.description);
  print_now(wrapped(list));
}

std::vector<ReportFile> report_files(const Report& report) {
  std::vector<ReportFile> files = {{"results.json", results_json(report)},
                                   {"results.csv", results_csv(report)}};
  files.emplace_back("report.html", html_report(report));
  if (std::string page = least_that_serves_page(report); !page.empty())
    files.emplace_back("least_that_serves.md", std::move(page));
  for (ReportFile& figure : figure_files(report)) files.push_back(std::move(figure));
  if (report.pair_file) {
    files.emplace_back("answers.json", answers_json(*report.pair_file));
    files.emplace_back("answers.csv", answers_csv(*report.pair_file));
  }
  return files;
}

// Every file that a run may write.
std::vector<std::string> report_names(const Options& options, const Backends& backends) {
  std::vector<std::string> sets, names = {"results.json", "results.csv", "report.html"}, backend_names;
  if (!options.no_families)
    for (const PairFamily& family : pair_families()) sets.emplace_back(family.name);
  if (!options.corpus.empty())
    for (const CorpusSet& set : load_corpus(options.corpus).sets) sets.push_back(set.name);
  if (!options.pairs_file.empty()) {
    sets.emplace_back("pairs");
    names.insert(names.end(), {"answers.json", "answers.csv"});
  }
  if (!options.scenes.empty()) names.emplace_back("least_that_serves.md");
  for (const auto& [name, description] : chosen_backends(options, backends)) backend_names.push_back(name);
  const std::vector<std::filesystem::path> scenes(options.scenes.begin(), options.scenes.end());
  for (std::string& figure : figure_names(sets, backend_names, stems(scenes)))
    names.push_back(std::move(figure));
  return names;
}

/// Measures, and writes the report; of what shards measured the rest.
int report_run(const Options& options, const Backends& backends, const ShardAnswers* shards) {
  const auto oracle = make_exact_oracle();
  ReportRun files(options.output, report_names(options, backends));
  ProgressLine progress;
  Shown shown;
  const auto on_part = [&](const Report& so_far) {
    files.put(report_files(so_far));
    progress.finish();
    print_now(wrapped(new_tables(so_far, shown)));
  };
  const Report report = run_comparison(options, backends, oracle.get(), progress, on_part, shards);
  files.finish(report_files(report));
  print_now(fmt::format("{}\nreport: {}\n", wrapped(terminal_report(report, shown)), options.output));
  // A choice that nothing decides is an error, which must not cost the report.
  if (!report.verdicts.empty() && report.verdicts.front().is_empty())
    throw InputError(sentence(report.verdicts.front()));
  return 0;
}

Backends backends_for(const Options& options) {
  const std::filesystem::path program = std::filesystem::canonical("/proc/self/exe");
  Backends backends = build_backends(program);
  std::optional<std::chrono::milliseconds> limit;
  if (options.engine_limit)
    limit = std::chrono::duration_cast<std::chrono::milliseconds>(
        std::chrono::duration<double>(*options.engine_limit));
  add_plugins(backends, program, options.plugins, limit.value_or(kWorkerTimeLimit));
  add_engines(backends, options.engines, limit);
  return backends;
}

int run_merge(int argc, const char* const* argv) {
  CLI::App app{"The report of a run whose pairs were cut by --shard. What is not cut is measured now."};
  app.name("compare_backends merge");
  std::vector<std::string> files;
  std::string output = "report";
  app.add_option("SHARD", files, "Files of all shards, in any order")->required();
  app.add_option("--output", output, "Folder of the report")->capture_default_str();
  if (!parse_command_line(app, argc - 1, argv + 1)) return 0;
  // The run is that of the shards' command line, with another folder for its report.
  const ShardAnswers shards(files);
  std::vector<std::string> words = shards.arguments();
  words.insert(words.begin(), argv[0]);
  words.insert(words.end(), {"--output", output});
  std::vector<const char*> run_argv;
  for (const std::string& word : words) run_argv.push_back(word.c_str());
  const std::optional<Options> options = parse_options(static_cast<int>(run_argv.size()), run_argv.data());
  return options ? report_run(*options, backends_for(*options), &shards) : 0;
}

int run_on_covers([[maybe_unused]] int argc, [[maybe_unused]] const char* const* argv) {
#ifdef TOUCHSTONE_HAS_FITS
  BackendRegistry registry;
  register_all_backends(registry);
  return run_fitted(argc, argv, registry);
#else
  throw InputError(
      "fitted: this build fits no meshes (it needs GMP with C++ support, and TOUCHSTONE_WITH_GLTF)");
#endif
}

int run(int argc, char** argv) {
  // Subcommands have options of their own.
  if (argc > 1 && argv[1] == std::string_view("diff")) return run_diff(argc, argv);
  if (argc > 1 && argv[1] == std::string_view("decide")) return run_decide(argc, argv);
  if (argc > 1 && argv[1] == std::string_view("tables")) return run_tables(argc, argv);
  if (argc > 1 && argv[1] == std::string_view("merge")) return run_merge(argc, argv);
  if (argc > 1 && argv[1] == std::string_view("fitted")) return run_on_covers(argc, argv);
  const std::optional<Options> options = parse_options(argc, argv);
  if (!options) return 0;
  const Backends backends = backends_for(*options);
  if (options->list) {
    print_list(*options, backends);
    return 0;
  }
  if (options->shard) {
    ProgressLine progress;
    print_now(run_shard(*options, backends, make_exact_oracle().get(), progress).string() + "\n");
    return 0;
  }
  if (options->case_id.empty()) return report_run(*options, backends, nullptr);
  fmt::print("{}", replay_case(*options, backends, make_exact_oracle().get()));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return touchstone::program::run_program("compare_backends", [&] { return run(argc, argv); });
}

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <set>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/bench/corpus/corpus_writer.hpp"
#include "touchstone/examples/bench/site/case_pages.hpp"
#include "touchstone/examples/bench/site/index_page.hpp"
#include "touchstone/examples/program/files/report_run.hpp"
#include "touchstone/examples/program/options/bundled_folder.hpp"
#include "touchstone/examples/program/terminal/program.hpp"

namespace {

using namespace touchstone;
using namespace touchstone::comparison;

constexpr const char* kFrozen = "touchstone-bench-1.2.json";

/// Both kinds of folders are reports of this program: one must not take the other's files for stale ones.
void refuse_folder(const std::string& output, const char* name, const char* why) {
  if (std::filesystem::exists(std::filesystem::path(output) / name))
    throw InputError(output + ": " + why + "; name another folder");
}

int run_corpus(const std::string& output, const std::string& manifest, int threads, bool freeze) {
  const CorpusPlan plan = load_plan(manifest.empty() ? bundled_folder(TOUCHSTONE_EXAMPLES, "bench") / kFrozen
                                                     : std::filesystem::path(manifest));
  refuse_folder(output, "index.html", "holds a site");
  ReportRun files(output, corpus_names(plan));
  ProgressLine progress;
  const auto oracle = make_exact_oracle();
  auto written =
      corpus_files(plan, *oracle, threads, freeze, [&](const std::string& set) { progress.step(set); });
  progress.finish();
  files.finish(std::move(written));
  print_now(fmt::format("{} {}: {} sets in {}\n", plan.name, plan.version, plan.sets.size(), output));
  return 0;
}

std::string raw_name(const std::string& file) {
  return "raw/" + std::filesystem::path(file).filename().string();
}

int run_site(const std::string& output, const std::string& folder, const std::vector<std::string>& results) {
  refuse_folder(output, kCorpusManifest, "holds a corpus");
  std::set<std::string> raw;
  for (const std::string& file : results)
    if (!raw.insert(raw_name(file)).second)
      throw InputError("site: " + file + ": another results file has that name");
  const Corpus corpus = load_corpus(folder);
  const BenchResults all = read_bench_results(results, corpus);
  const std::vector<Entry> newest = all.newest();
  std::vector<std::string> names = case_names(newest, corpus);
  names.insert(names.end(), raw.begin(), raw.end());
  names.emplace_back("index.html");
  ReportRun files(output, names);
  std::vector<ReportFile> site = case_files(newest, corpus, *make_exact_oracle());
  for (const std::string& file : results) site.emplace_back(raw_name(file), read_file(file, "site"));
  site.emplace_back("index.html", index_page(all, corpus));
  files.finish(std::move(site));
  print_now(fmt::format("site: {}/index.html, {} files of results\n", output, results.size()));
  return 0;
}

int run(int argc, char** argv) {
  CLI::App app{"The reference benchmark: its corpus, and a site from any number of results."};
  app.require_subcommand(1);
  std::string output, manifest, folder;
  std::vector<std::string> results;
  int threads = 2;
  bool freeze = false;
  CLI::App* corpus = app.add_subcommand("corpus", "Write the corpus: pairs, truth, hashes");
  corpus->add_option("FOLDER", output, "Where to")->required();
  corpus->add_option("--manifest", manifest, "Another manifest than the bundled one");
  corpus->add_option("--threads", threads, "For the exact answers")->check(CLI::Range(1, 256));
  corpus->add_flag("--freeze", freeze, "A new version: write hashes in place of holding them against");
  CLI::App* site = app.add_subcommand("site", "Build the site");
  site->add_option("FOLDER", output, "Where to")->required();
  site->add_option("RESULTS.json", results, "results.json of compare_backends --corpus")->required();
  site->add_option("--corpus", folder, "The corpus that they were measured on")->required();
  if (!parse_command_line(app, argc, argv)) return 0;
  return corpus->parsed() ? run_corpus(output, manifest, threads, freeze) : run_site(output, folder, results);
}

}  // namespace

int main(int argc, char** argv) {
  return touchstone::program::run_program("touchstone_bench", [&] { return run(argc, argv); });
}

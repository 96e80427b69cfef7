#include <fmt/format.h>

#include <csignal>
#include <iostream>

#include "contact_core/input_error.hpp"
#include "examples/compare_backends/backends.hpp"
#include "examples/compare_backends/comparison.hpp"
#include "examples/compare_backends/json_writer.hpp"
#include "examples/compare_backends/pair_families.hpp"
#include "examples/compare_backends/report_files.hpp"
#include "examples/compare_backends/terminal.hpp"

namespace {

using namespace touchstone;
using namespace touchstone::comparison;

constexpr int kBadInput = 2;
constexpr int kInterrupted = 130;

void on_signal(int) { ProgressLine::interrupted = true; }

void print_list(const BackendRegistry& registry, const std::vector<Gap>& gaps) {
  fmt::print("backends\n");
  for (const auto& entry : registry.narrowphases())
    fmt::print("  {:18}  {}\n", entry.name, entry.description);
  for (const Gap& gap : gaps) fmt::print("  {:18}  {}\n", gap.what, gap.why);
  fmt::print("broadphases\n");
  for (const auto& entry : registry.broadphases()) fmt::print("  {:18}  {}\n", entry.name, entry.description);
  fmt::print("families\n");
  for (const PairFamily& family : pair_families())
    fmt::print("  {:18}  {}\n", family.name, family.description);
}

std::vector<ReportFile> report_files(const Report& report) {
  return {{"results.json", results_json(report)}, {"results.csv", results_csv(report)}};
}

int run(int argc, char** argv) {
  const std::optional<Options> options = parse_options(argc, argv);
  if (!options) return 0;
  BackendRegistry registry;
  std::vector<Gap> gaps;
  register_backends(registry, gaps);
  if (options->list) {
    print_list(registry, gaps);
    return 0;
  }
  check_report_folder(options->output);
  const auto oracle = make_exact_oracle();
  ProgressLine progress;
  const Report report = run_comparison(*options, registry, oracle.get(), gaps, progress);
  write_report_folder(options->output, report_files(report));
  fmt::print("{}\nreport: {}\n", terminal_report(report), options->output);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  try {
    return run(argc, argv);
  } catch (const Interrupted& interrupted) {
    std::cerr << "compare_backends: " << interrupted.what() << "\n";
    return kInterrupted;
  } catch (const InputError& error) {
    std::cerr << "compare_backends: " << error.what() << "\n";
    return kBadInput;
  } catch (const std::exception& error) {
    std::cerr << "compare_backends: " << error.what() << "\n";
    return 1;
  }
}

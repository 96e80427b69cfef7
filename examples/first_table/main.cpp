#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/measures/accuracy/accuracy.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"
#include "touchstone/examples/measures/runs/backend_run.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

// A first look at what compare_backends measures, while that is still being built: our checks and two engines
// on a few hundred pairs of each family, a table a family as it is measured. No report is written.

namespace {

using namespace touchstone;
using namespace touchstone::measures;
using namespace touchstone::program;

constexpr std::uint64_t kSeed = 1;        // the pairs that compare_backends --quick has
constexpr std::size_t kPairs = 500;       // too
constexpr double kSecondsOfARow = 0.005;  // a slow row's repetition is cut to about this
constexpr int kRepetitions = 3;           // of each row, in turns

// One narrowphase of each part; an engine's second one waits for the whole comparison.
std::vector<const BackendRegistry::NarrowphaseEntry*> shown_narrowphases(const BackendRegistry& registry) {
  std::vector<const BackendRegistry::NarrowphaseEntry*> shown;
  for (const auto& entry : registry.narrowphases())
    if (entry.name != "bullet_gjk") shown.push_back(&entry);
  return shown;
}

std::string worst(const Judgement& judgement, Measure measure) {
  return format_error(judgement.errors[static_cast<std::size_t>(measure)].over_scale.worst);
}

std::vector<std::string> row_of(const BackendAnswers& answers, const Judgement* judgement) {
  std::vector<std::string> row = {answers.name};
  for (const QueryKind kind : kQueryKinds) {
    const std::optional<Timing>& single = answers.queries[index_of(kind)].single;
    row.push_back(format_ns(single ? single->median_ns : kNaN));
    if (judgement == nullptr) continue;
    const Wrongness& wrong = judgement->wrongness[index_of(kind)];
    row.push_back(format_count(wrong.missed + wrong.phantom));
    row.push_back(format_count(wrong.undecided + wrong.failed + wrong.missing + wrong.unsupported));
  }
  if (judgement == nullptr) return row;
  row.push_back(worst(*judgement, Measure::distance));
  row.push_back(worst(*judgement, Measure::depth));
  return row;
}

std::string table_of(const PairSet& set, const std::vector<const BackendRegistry::NarrowphaseEntry*>& shown,
                     const Oracle* oracle) {
  MeasureOptions measure;
  measure.seed = kSeed;
  measure.perturb = false;
  measure.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  measure.repetitions = kRepetitions;
  measure.slow_seconds = kSecondsOfARow;
  // The heading, of more columns where the truth is known.
  std::vector<PairTruth> truth;
  if (oracle != nullptr) truth = compute_truth(set, *oracle, measure.threads);
  std::vector<std::string> header = {"ns a pair", "overlap", "distance", "manifold"};
  if (oracle != nullptr)
    header = {"ns a pair", "overlap",  "wrong", "open", "distance",     "wrong",
              "open",      "manifold", "wrong", "open", "dist error/S", "depth error/S"};
  TextTable table(header);
  // A row a backend.
  for (BackendAnswers& answers : run_backends(shown, set, measure)) {
    if (oracle == nullptr) {
      table.add(row_of(answers, nullptr));
      continue;
    }
    take_worse_answers(set, truth, *oracle, answers, measure.threads);
    const Judgement judgement = judge(set, truth, *oracle, answers, measure.threads);
    table.add(row_of(answers, &judgement));
  }
  return table.str();
}

void run(const std::vector<std::string>& families) {
  BackendRegistry registry;
  register_all_backends(registry);
  const auto oracle = make_exact_oracle();
  for (const std::string& name : families) make_pair_family(name, kSeed, 0);  // unknown ones before any runs
  if (oracle != nullptr)
    fmt::print(
        "wrong: the wrong class; open: undecided, failed, without a value or not answered by that backend\n"
        "error/S: the worst error of distance and depth over max(size, largest |coordinate|)\n");
  for (const std::string& name : families) {
    const PairSet set = make_pair_family(name, kSeed, kPairs);
    fmt::print("\n{}{}", wrapped(fmt::format("{}: {}; {} pairs\n", name, set.description, kPairs)),
               table_of(set, shown_narrowphases(registry), oracle.get()));
    if (std::fflush(stdout) != 0) throw std::runtime_error("standard output cannot be written");
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> families(argv + 1, argv + argc);
  const std::string first = families.empty() ? "" : families[0];
  try {
    if (first == "--help" || first == "-h") {
      fmt::print(
          "first_table [FAMILY ...]: times and wrong answers of a few backends on few pairs of each "
          "family\n");
    } else if (first == "--version") {
      fmt::print("first_table " TOUCHSTONE_VERSION "\n");
    } else {
      if (families.empty())
        for (const PairFamily& family : pair_families()) families.emplace_back(family.name);
      run(families);
    }
    if (std::fflush(stdout) != 0) throw std::runtime_error("standard output cannot be written");
  } catch (const std::exception& error) {
    fmt::print(stderr, "first_table: {}\n", error.what());
    return 2;
  }
  return 0;
}

#include "examples/compare_backends/comparison.hpp"

#include <algorithm>
#include <cmath>

#include "contact_core/input_error.hpp"
#include "examples/compare_backends/pair_families.hpp"

namespace touchstone::comparison {
namespace {

BackendResult sum_up_backend(const BackendAnswers& answers) {
  BackendResult result;
  result.name = answers.name;
  result.description = answers.description;
  result.capabilities = answers.capabilities;
  result.frame = answers.frame_by_query;
  result.failure = answers.failure;
  for (const QueryKind kind : kQueryKinds) {
    const QueryAnswers& query = answers.queries[index_of(kind)];
    result.rows[index_of(kind)] = {query.single, query.batch, query.raw, query.allocations};
  }
  return result;
}

MeasureOptions measure_options(const Options& options) {
  MeasureOptions measure;
  measure.seed = options.seed;
  measure.threads = options.threads;
  measure.repetitions = options.repetitions;
  return measure;
}

class Session {
 public:
  Session(const Options& options, const BackendRegistry& registry, const Oracle* oracle,
          ProgressLine& progress)
      : options_(options), registry_(registry), oracle_(oracle), progress_(progress) {}

  void run_families(Report& report) {
    std::vector<std::string> names = options_.families;
    if (names.empty() && !options_.no_families) {
      for (const PairFamily& family : pair_families()) names.emplace_back(family.name);
    }
    for (const std::string& name : names) {
      const PairSet set = make_pair_family(name, options_.seed, options_.pair_count());
      report.sets.push_back(run_set(set));
    }
  }

  SetResult run_set(const PairSet& set) {
    const Progress share = [this](double done) { progress_.share(done); };
    std::vector<PairTruth> truth;
    if (oracle_ != nullptr) {
      progress_.step(set.name + ": exact answers");
      truth = compute_truth(set, *oracle_, options_.threads, share);
    }
    progress_.step(set.name + ": backends");
    const auto backends = chosen_backends(options_, registry_);
    const auto answers = run_backends(backends, set, measure_options(options_), share);
    progress_.step(set.name + ": errors");
    return sum_up(set, truth, oracle_, answers, options_.threads, share);
  }

  void run_broadphase_sizes(Report& report) {
    BroadphaseOptions broadphase;
    broadphase.seed = options_.seed;
    broadphase.threads = options_.threads;
    if (options_.quick) broadphase.sizes = {1000};
    progress_.step("broadphases");
    report.broadphases = run_broadphases(registry_.broadphases(), broadphase, oracle_,
                                         [this](double done) { progress_.share(done); });
  }

 private:
  const Options& options_;
  const BackendRegistry& registry_;
  const Oracle* oracle_;
  ProgressLine& progress_;
};

}  // namespace

std::vector<const BackendRegistry::NarrowphaseEntry*> chosen_backends(const Options& options,
                                                                      const BackendRegistry& registry) {
  std::vector<const BackendRegistry::NarrowphaseEntry*> chosen;
  if (options.backends.empty()) {
    for (const auto& entry : registry.narrowphases()) chosen.push_back(&entry);
  }
  for (const std::string& name : options.backends) chosen.push_back(&registry.narrowphase(name));
  return chosen;
}

SetResult sum_up(const PairSet& set, std::span<const PairTruth> truth, const Oracle* oracle,
                 std::span<const BackendAnswers> answers, int threads, const Progress& progress) {
  SetResult result;
  result.name = set.name;
  result.description = set.description;
  result.cases = set.cases();
  result.ids = set.ids;
  for (const PairTruth& each : truth) {
    result.contacts += each.contact();
    result.touching += each.pair_class == PairClass::touching;
  }
  for (std::size_t b = 0; b < answers.size(); ++b) {
    result.backends.push_back(sum_up_backend(answers[b]));
    if (oracle == nullptr) continue;
    const auto part = [&](double done) {
      if (progress) progress((static_cast<double>(b) + done) / static_cast<double>(answers.size()));
    };
    result.backends.back().judgement = judge(set, truth, *oracle, answers[b], threads, part);
    result.backends.back().judged = true;
  }
  return result;
}

Report run_comparison(const Options& options, const BackendRegistry& registry, const Oracle* oracle,
                      std::vector<Gap> gaps, ProgressLine& progress) {
  Report report;
  report.machine = describe_machine();
  report.options = options;
  report.gaps = std::move(gaps);
  report.has_truth = oracle != nullptr;
  for (const auto* entry : chosen_backends(options, registry)) {
    report.backends.emplace_back(entry->name, entry->description);
  }
  Session session(options, registry, oracle, progress);
  session.run_families(report);
  if (!options.no_broadphase) session.run_broadphase_sizes(report);
  if (report.has_truth && !report.sets.empty() && options.max_error) {
    for (const QueryKind kind : kQueryKinds)
      report.verdicts.push_back(decide(report.sets, kind, *options.max_error));
  }
  progress.finish();
  return report;
}

}  // namespace touchstone::comparison

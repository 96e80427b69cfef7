#include "touchstone/examples/measures/runs/thread_run.hpp"

#include <chrono>
#include <thread>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/measures/common/parallel.hpp"

namespace touchstone::measures {
namespace {

using Clock = std::chrono::steady_clock;

// One backend, ready to be asked.
class Asked {
 public:
  Asked(const BackendRegistry::NarrowphaseEntry& entry, const PairSet& set)
      : name(entry.name), narrowphase_(entry.make()), set_(set) {
    const Capabilities& can = narrowphase_->capabilities();
    if (!can.distance && !can.penetration) query = QueryKind::overlap;
    if (!can.thread_safe) gap = "declares itself not thread safe";
    try {
      narrowphase_->build(set.solids);
    } catch (const InputError& error) {
      gap = error.what();
    }
    status_.resize(set.pairs.size());
    geometry_.resize(set.pairs.size());
  }

  // [ns a pair]
  double pass(int threads, std::size_t batch) {
    const auto begin = Clock::now();
    parallel_chunks(set_.pairs.size(), batch, threads, [&](std::size_t first, std::size_t end) {
      const std::size_t count = end - first;
      const auto workspace = narrowphase_->make_workspace();
      narrowphase_->evaluate(
          {std::span(set_.pairs).subspan(first, count), set_.poses, {.kind = query}},
          {std::span(status_).subspan(first, count), std::span(geometry_).subspan(first, count), {}},
          *workspace);
    });
    return std::chrono::duration<double, std::nano>(Clock::now() - begin).count() /
           static_cast<double>(set_.pairs.size());
  }

  std::string name, gap;
  QueryKind query = QueryKind::distance;

 private:
  std::unique_ptr<Narrowphase> narrowphase_;
  const PairSet& set_;
  std::vector<PairStatus> status_;
  std::vector<PairGeometry> geometry_;
};

}  // namespace

std::vector<int> thread_counts() {
  std::vector<int> counts = {1, 2};
  const int most = static_cast<int>(std::thread::hardware_concurrency());
  for (int count = 4; count <= most; count *= 2) counts.push_back(count);
  return counts;
}

std::vector<ThreadResult> run_threads(std::span<const BackendRegistry::NarrowphaseEntry* const> backends,
                                      const PairSet& set, const ThreadOptions& options) {
  std::vector<ThreadResult> results;
  // A backend is built once, for all numbers of threads.
  std::vector<Asked> asked;
  asked.reserve(backends.size());
  for (const auto* entry : backends) asked.emplace_back(*entry, set);
  std::vector<std::vector<double>> times(asked.size() * options.threads.size());
  // Each pass goes over all rows, so that what slows the machine slows all alike.
  for (int pass = 0; pass <= options.passes; ++pass) {
    for (std::size_t t = 0; t < times.size(); ++t) {
      Asked& backend = asked[t / options.threads.size()];
      if (!backend.gap.empty()) continue;
      const double ns = backend.pass(options.threads[t % options.threads.size()], options.batch);
      if (pass > 0) times[t].push_back(ns);  // the first one warms up
    }
  }
  // A backend that was not asked keeps its reason.
  for (std::size_t t = 0; t < times.size(); ++t) {
    const Asked& backend = asked[t / options.threads.size()];
    ThreadResult result;
    result.backend = backend.name;
    result.query = backend.query;
    result.threads = options.threads[t % options.threads.size()];
    result.pairs = set.pairs.size();
    result.gap = backend.gap;
    if (backend.gap.empty()) result.pass = summarise_blocks(times[t], times[t].size());
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace touchstone::measures

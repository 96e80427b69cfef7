#include <benchmark/benchmark.h>

#include <algorithm>
#include <random>
#include <string>

#include "contact_core/registry.hpp"
#include "examples/measures/pair_families.hpp"
#ifdef TOUCHSTONE_BENCHMARK_BULLET
#include "adapters/bullet/bullet.hpp"
#endif
#ifdef TOUCHSTONE_BENCHMARK_ODE
#include "adapters/ode/ode.hpp"
#endif

// A query over a shuffled pair family, whose data do not fit the first caches: one pair a call, as a batch, and
// the engines' raw calls. The counter "pair" is the time of a pair.

namespace touchstone {
namespace {

constexpr std::size_t kPairs = 4096;

struct Workload {
  comparison::PairSet set;
  std::vector<SolidPair> pairs;
  std::vector<PairStatus> status;
  std::vector<PairGeometry> geometry;
  std::vector<ContactPoint> points;

  explicit Workload(const std::string& family) : set(comparison::make_pair_family(family, 1, kPairs)) {
    pairs = set.pairs;
    std::mt19937_64 random(1);
    for (std::size_t i = pairs.size() - 1; i > 0; --i) std::swap(pairs[i], pairs[random() % (i + 1)]);
    status.resize(pairs.size());
    geometry.resize(pairs.size());
    points.resize(pairs.size() * kMaxManifoldPoints);
  }
};

BackendRegistry& registry() {
  static BackendRegistry* all = [] {
    auto* out = new BackendRegistry;
    register_core(*out);
#ifdef TOUCHSTONE_BENCHMARK_BULLET
    register_bullet(*out);
#endif
#ifdef TOUCHSTONE_BENCHMARK_ODE
    register_ode(*out);
#endif
    return out;
  }();
  return *all;
}

void per_pair(benchmark::State& state) {
  state.counters["pair"] = benchmark::Counter(static_cast<double>(kPairs),
                                              benchmark::Counter::kIsIterationInvariantRate |
                                                  benchmark::Counter::kInvert);
}

void run_query(benchmark::State& state, const std::string& backend, const std::string& family, QueryKind kind,
               bool batch) {
  Workload work(family);
  const auto narrowphase = registry().narrowphase(backend).make();
  narrowphase->build(work.set.solids);
  const auto workspace = narrowphase->make_workspace();
  Query query;
  query.kind = kind;
  NarrowphaseOutput output{work.status, work.geometry, work.points};
  const std::size_t step = batch ? work.pairs.size() : 1;
  for (auto _ : state) {
    for (std::size_t i = 0; i < work.pairs.size(); i += step) {
      narrowphase->evaluate({std::span(work.pairs).subspan(i, step), work.set.poses, query}, output, *workspace);
      benchmark::ClobberMemory();
    }
  }
  per_pair(state);
}

void run_raw(benchmark::State& state, const std::string& backend, const std::string& family, QueryKind kind) {
  Workload work(family);
  const auto raw = registry().narrowphase(backend).make_raw();
  raw->build(work.set.solids);
  raw->set_poses(work.set.poses);
  if (!raw->supports(kind)) return state.SkipWithError("unsupported");
  for (auto _ : state) benchmark::DoNotOptimize(raw->run(work.pairs, kind));
  per_pair(state);
}

void add_rows() {
  for (const auto& [kind, family] :
       {std::pair{QueryKind::overlap, "random"}, {QueryKind::overlap, "sheared"}, {QueryKind::overlap, "tapered"},
        {QueryKind::distance, "random"}, {QueryKind::distance, "sheared"}, {QueryKind::distance, "tapered"},
        {QueryKind::distance, "near_parallel"}, {QueryKind::manifold, "random"}, {QueryKind::manifold, "resting"},
        {QueryKind::manifold, "tapered"}}) {
    const std::string name = std::string(to_string(kind)) + "/" + family + "/";
    const std::string family_name = family;
    benchmark::RegisterBenchmark((name + "native").c_str(), [=, kind = kind](benchmark::State& state) {
      run_query(state, "native", family_name, kind, false);
    });
    benchmark::RegisterBenchmark((name + "native_batch").c_str(), [=, kind = kind](benchmark::State& state) {
      run_query(state, "native", family_name, kind, true);
    });
    for (const auto& entry : registry().narrowphases()) {
      if (!entry.make_raw) continue;
      benchmark::RegisterBenchmark((name + entry.name + "_raw").c_str(),
                                   [=, kind = kind, backend = entry.name](benchmark::State& state) {
                                     run_raw(state, backend, family_name, kind);
                                   });
    }
  }
}

}  // namespace
}  // namespace touchstone

int main(int argc, char** argv) {
  touchstone::add_rows();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

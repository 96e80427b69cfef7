#include <benchmark/benchmark.h>

#include <algorithm>
#include <random>
#include <string>
#include <string_view>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"

// A query over a shuffled pair family, whose data do not fit the first caches: one pair a call, as a batch,
// and the engines' raw calls. The counter "pair" is the time of a pair.

namespace touchstone {
namespace {

constexpr std::size_t kPairs = 4096;

BackendRegistry& registry() {
  static BackendRegistry* all = [] {
    auto* out = new BackendRegistry;
    register_all_backends(*out);
    return out;
  }();
  return *all;
}

/// A family's name with one of these endings stands for those of its pairs that overlap, or are apart.
constexpr std::string_view kOverlapping = ":overlapping";
constexpr std::string_view kApart = ":apart";

/// The first kPairs, or as many as there are.
std::vector<SolidPair> pairs_with(PairStatus wanted, const measures::PairSet& set) {
  const auto native = registry().narrowphase("native").make();
  native->build(set.solids);
  std::vector<PairStatus> status(set.pairs.size());
  const auto workspace = native->make_workspace();
  native->evaluate({set.pairs, set.poses, Query{QueryKind::overlap}}, {status, {}, {}}, *workspace);
  std::vector<SolidPair> out;
  for (std::size_t i = 0; i < set.pairs.size() && out.size() < kPairs; ++i)
    if (status[i] == wanted) out.push_back(set.pairs[i]);
  return out;
}

struct Workload {
  measures::PairSet set;
  std::vector<SolidPair> pairs;
  std::vector<PairStatus> status;
  std::vector<PairGeometry> geometry;
  std::vector<ContactPoint> points;

  explicit Workload(std::string_view family) {
    const bool overlapping = family.ends_with(kOverlapping), apart = family.ends_with(kApart);
    if (overlapping) family.remove_suffix(kOverlapping.size());
    if (apart) family.remove_suffix(kApart.size());
    set = measures::make_pair_family(family, 1, overlapping || apart ? 4 * kPairs : kPairs);
    pairs = set.pairs;
    if (overlapping) pairs = pairs_with(PairStatus::overlapping, set);
    if (apart) pairs = pairs_with(PairStatus::separated, set);
    std::mt19937_64 random(1);
    for (std::size_t i = pairs.size() - 1; i > 0; --i) std::swap(pairs[i], pairs[random() % (i + 1)]);
    status.resize(pairs.size());
    geometry.resize(pairs.size());
    points.resize(pairs.size() * kMaxManifoldPoints);
  }
};

void per_pair(benchmark::State& state, const Workload& work) {
  state.counters["pair"] =
      benchmark::Counter(static_cast<double>(work.pairs.size()),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
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
      narrowphase->evaluate({std::span(work.pairs).subspan(i, step), work.set.poses, query}, output,
                            *workspace);
      benchmark::ClobberMemory();
    }
  }
  per_pair(state, work);
}

void run_raw(benchmark::State& state, const std::string& backend, const std::string& family, QueryKind kind) {
  Workload work(family);
  const auto raw = registry().narrowphase(backend).make_raw();
  raw->build(work.set.solids);
  raw->set_poses(work.set.poses);
  if (!raw->supports(kind)) return state.SkipWithError("unsupported");
  for (auto _ : state) benchmark::DoNotOptimize(raw->run(work.pairs, kind));
  per_pair(state, work);
}

void add_rows() {
  // Each query with the families that take different ways through the code.
  for (const auto& [kind, family] : {std::pair{QueryKind::overlap, "random"},
                                     {QueryKind::overlap, "sheared"},
                                     {QueryKind::overlap, "tapered"},
                                     {QueryKind::distance, "random"},
                                     {QueryKind::distance, "sheared"},
                                     {QueryKind::distance, "tapered"},
                                     {QueryKind::distance, "near_parallel"},
                                     {QueryKind::distance, "random:overlapping"},
                                     {QueryKind::distance, "containment:overlapping"},
                                     {QueryKind::distance, "slabs_needles:overlapping"},
                                     {QueryKind::distance, "resting:overlapping"},
                                     {QueryKind::distance, "sheared:overlapping"},
                                     {QueryKind::distance, "tapered:overlapping"},
                                     {QueryKind::distance, "near_parallel:overlapping"},
                                     {QueryKind::distance, "random:apart"},
                                     {QueryKind::distance, "near_1e-3:apart"},
                                     {QueryKind::distance, "near_1e-7:apart"},
                                     {QueryKind::distance, "slabs_needles:apart"},
                                     {QueryKind::distance, "far:apart"},
                                     {QueryKind::distance, "sheared:apart"},
                                     {QueryKind::distance, "tapered:apart"},
                                     {QueryKind::distance, "near_parallel:apart"},
                                     {QueryKind::manifold, "random"},
                                     {QueryKind::manifold, "resting"},
                                     {QueryKind::manifold, "tapered"}}) {
    // A pair a call, a batch, and the engines' raw calls.
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

#include "touchstone/tests/benchmarks/pairs/cost_timing.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <numeric>

#include "touchstone/contact_core/native/solids/pair_batch.hpp"
#include "touchstone/contact_core/native/solids/solid_set.hpp"
#include "touchstone/examples/measures/common/random.hpp"
#include "touchstone/tests/benchmarks/pairs/cost_table_families.hpp"

namespace touchstone {
namespace {

using measures::PairSet;

constexpr std::uint64_t kSeed = 20261123;
constexpr std::size_t kHotPairs = 256, kColdPairs = 16384, kBatch = 256;
constexpr int kHotRounds = 24, kColdRounds = 3;
/// Reads of the clock that find what one costs; some of them are interrupted.
constexpr int kClockReads = 10000;

double now_ns() {
  return static_cast<double>(std::chrono::steady_clock::now().time_since_epoch() /
                             std::chrono::nanoseconds(1));
}

double clock_cost() {
  std::vector<double> costs(kClockReads);
  for (double& cost : costs) {
    const double start = now_ns();
    cost = now_ns() - start;
  }
  std::nth_element(costs.begin(), costs.begin() + kClockReads / 2, costs.end());
  return costs[kClockReads / 2];
}

Costs summarise(std::vector<double> costs) {
  std::sort(costs.begin(), costs.end());
  const std::size_t n = costs.size();
  return {std::accumulate(costs.begin(), costs.end(), 0.0) / static_cast<double>(n), costs[n / 2],
          costs[n * 99 / 100], costs.back()};
}

using RunPairs = std::function<void(std::span<const SolidPair>)>;

/// The least time of each step of pairs, per pair.
Costs time_pairs(std::span<const SolidPair> pairs, std::size_t step, int rounds, const RunPairs& run) {
  static const double kClock = clock_cost();
  std::vector<double> least(pairs.size() / step, INFINITY);
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < least.size(); ++i) {
      const double start = now_ns();
      run(pairs.subspan(i * step, step));
      const double cost = std::max(now_ns() - start - kClock, 0.0);
      least[i] = std::min(least[i], cost / static_cast<double>(step));
    }
  }
  return summarise(std::move(least));
}

/// A family's pairs, and room for answers.
struct Workload {
  PairSet set;
  std::vector<PairStatus> status;
  std::vector<PairGeometry> geometry;
  std::vector<ContactPoint> points;

  Workload(std::string_view family, std::size_t count)
      : set(make_cost_table_family(family, kSeed, count)),
        status(count),
        geometry(count),
        points(count * kMaxManifoldPoints) {}

  void shuffle() {
    measures::Random random(kSeed);
    measures::shuffle(set.pairs, random);
  }
};

Costs time_checked(const BackendRegistry& registry, const CostRow& row, Workload& work, int rounds) {
  const auto narrowphase = registry.make_narrowphase(row.backend);
  narrowphase->build(work.set.solids);
  const auto workspace = narrowphase->make_workspace();
  Query query;
  query.kind = row.kind;
  if (row.contacts_only) query.max_separation = 0.0;
  const NarrowphaseOutput output{work.status, work.geometry, work.points};
  return time_pairs(work.set.pairs, row.is_batch ? kBatch : 1, rounds, [&](std::span<const SolidPair> pairs) {
    narrowphase->evaluate({pairs, work.set.poses, query}, output, *workspace);
  });
}

Costs time_raw(const BackendRegistry& registry, const CostRow& row, Workload& work, int rounds) {
  const auto raw = registry.narrowphase(row.backend).make_raw();
  raw->build(work.set.solids);
  raw->set_poses(work.set.poses);
  volatile std::size_t contacts = 0;
  return time_pairs(work.set.pairs, 1, rounds, [&](std::span<const SolidPair> pairs) {
    contacts = contacts + raw->run(pairs, row.kind);
  });
}

std::vector<PairStatus> classes(const BackendRegistry& registry, const std::string& backend,
                                const Workload& work) {
  const auto narrowphase = registry.make_narrowphase(backend);
  narrowphase->build(work.set.solids);
  const auto workspace = narrowphase->make_workspace();
  std::vector<PairStatus> status(work.set.pairs.size());
  Query query;
  query.kind = QueryKind::overlap;
  narrowphase->evaluate({work.set.pairs, work.set.poses, query}, {status, {}, {}}, *workspace);
  return status;
}

/// Adds up a number of each cache line.
template <class Record>
double sum_of_lines(const Record& record) {
  const auto* const numbers = reinterpret_cast<const double*>(&record);
  double sum = 0.0;
  for (std::size_t i = 0; i < sizeof(Record) / sizeof(double); i += 64 / sizeof(double)) sum += numbers[i];
  return sum;
}

double time_reading(const Workload& work, int rounds) {
  const native::SolidSet set = native::make_solid_set(work.set.solids);
  volatile double total = 0.0;
  const auto run = [&](std::span<const SolidPair> pairs) {
    constexpr std::size_t kSolidsAhead = 16, kAhead = 8;
    double sum = 0.0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (i + kSolidsAhead < pairs.size())
        for (const SolidIndex solid : {pairs[i + kSolidsAhead].a, pairs[i + kSolidsAhead].b})
          native::prefetch(set.solids[solid]), native::prefetch(work.set.poses[solid]);
      if (i + kAhead < pairs.size())
        for (const SolidIndex solid : {pairs[i + kAhead].a, pairs[i + kAhead].b})
          native::prefetch(set.vertices[solid]), native::prefetch(*set.solids[solid].plain);
      for (const SolidIndex solid : {pairs[i].a, pairs[i].b})
        sum += (sum_of_lines(work.set.poses[solid]) + sum_of_lines(set.vertices[solid])) +
               sum_of_lines(set.solids[solid].plain->normals);
    }
    total = total + sum;
  };
  return time_pairs(work.set.pairs, kBatch, rounds, run).mean;
}

bool has_narrowphase(const BackendRegistry& registry, std::string_view name) {
  return std::any_of(registry.narrowphases().begin(), registry.narrowphases().end(),
                     [&](const auto& entry) { return entry.name == name; });
}

int count_wrong(const BackendRegistry& registry, const CostRow& row, const Workload& work) {
  if (!has_narrowphase(registry, "exact")) return -1;
  const std::vector<PairStatus> truth = classes(registry, "exact", work);
  const std::vector<PairStatus> given = classes(registry, row.backend, work);
  int wrong = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) wrong += truth[i] != given[i] ? 1 : 0;
  return wrong;
}

}  // namespace

RowCosts measure_row(const BackendRegistry& registry, const CostRow& row) {
  const bool is_raw = static_cast<bool>(registry.narrowphase(row.backend).make_raw);
  const auto time = is_raw ? time_raw : time_checked;
  Workload hot(row.family, kHotPairs), cold(row.family, kColdPairs);
  hot.shuffle();
  RowCosts out{};
  out.hot = time(registry, row, hot, kHotRounds);
  out.streamed = time(registry, row, cold, kColdRounds);
  cold.shuffle();
  out.cold = time(registry, row, cold, kColdRounds);
  out.wrong = count_wrong(registry, row, hot);
  return out;
}

ReadingCosts measure_reading(std::string_view family) {
  Workload hot(family, kHotPairs), cold(family, kColdPairs);
  hot.shuffle(), cold.shuffle();
  return {time_reading(hot, kHotRounds), time_reading(cold, kColdRounds)};
}

std::vector<std::string> raw_peers(const BackendRegistry& registry, QueryKind kind) {
  std::vector<std::string> out;
  for (const auto& entry : registry.narrowphases())
    if (entry.make_raw && entry.make_raw()->supports(kind)) out.push_back(entry.name);
  return out;
}

}  // namespace touchstone

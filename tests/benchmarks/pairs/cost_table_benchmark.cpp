#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/measures/common/random.hpp"
#include "touchstone/tests/benchmarks/pairs/cost_table_families.hpp"

// The cost of a pair, by family, query and backend, in one process: the table of the contact costs.
//
//   cost_table_benchmark [FAMILY or QUERY or BACKEND or lone or batch]...
//
// Each argument keeps the rows that have it as one of their names. Hot: 256 pairs in turn. Cold: 16 384 pairs
// in shuffled order, whose data do not fit the caches. Each pair is timed alone, less what the clock takes,
// and stands with the least of its repetitions, so that other work on the machine counts little; the
// median, 99th percentile and worst are over pairs [ns]. Of batches there is a mean only. Peers run their
// raw calls. "wrong": pairs of the hot set with another class than exact arithmetic has.

namespace touchstone {
namespace {

using comparison::PairSet;

constexpr std::uint64_t kSeed = 20261123;
constexpr std::size_t kHotPairs = 256, kColdPairs = 16384;
constexpr int kHotRounds = 24, kColdRounds = 3;
/// Of reading a clock; one in so many reads is interrupted.
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

struct Costs {
  double mean, median, p99, worst;
};

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

/// A family's pairs in shuffled order, and room for answers.
struct Workload {
  PairSet set;
  std::vector<PairStatus> status;
  std::vector<PairGeometry> geometry;
  std::vector<ContactPoint> points;

  Workload(std::string_view family, std::size_t count)
      : set(make_cost_table_family(family, kSeed, count)),
        status(count),
        geometry(count),
        points(count * kMaxManifoldPoints) {
    comparison::Random random(kSeed);
    comparison::shuffle(set.pairs, random);
  }
};

struct Row {
  std::string family;
  QueryKind kind;
  std::string backend;
  bool is_batch;
};

Costs time_checked(const BackendRegistry& registry, const Row& row, Workload& work, int rounds) {
  const auto narrowphase = registry.make_narrowphase(row.backend);
  narrowphase->build(work.set.solids);
  const auto workspace = narrowphase->make_workspace();
  Query query;
  query.kind = row.kind;
  const NarrowphaseOutput output{work.status, work.geometry, work.points};
  return time_pairs(work.set.pairs, row.is_batch ? work.set.pairs.size() : 1, rounds,
                    [&](std::span<const SolidPair> pairs) {
                      narrowphase->evaluate({pairs, work.set.poses, query}, output, *workspace);
                    });
}

Costs time_raw(const BackendRegistry& registry, const Row& row, Workload& work, int rounds) {
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

bool has_narrowphase(const BackendRegistry& registry, std::string_view name) {
  return std::any_of(registry.narrowphases().begin(), registry.narrowphases().end(),
                     [&](const auto& entry) { return entry.name == name; });
}

/// "-": there is no exact arithmetic in this build. A backend's own margins count as wrong, too.
std::string count_wrong(const BackendRegistry& registry, const Row& row, const Workload& work) {
  if (!has_narrowphase(registry, "exact")) return "-";
  const std::vector<PairStatus> truth = classes(registry, "exact", work);
  const std::vector<PairStatus> given = classes(registry, row.backend, work);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) wrong += truth[i] != given[i] ? 1 : 0;
  return std::to_string(wrong);
}

void print_costs(const Costs& costs, bool is_batch) {
  if (is_batch)
    std::printf(" %8.0f %8s %8s %8s", costs.mean, "", "", "");
  else
    std::printf(" %8.0f %8.0f %8.0f %8.0f", costs.mean, costs.median, costs.p99, costs.worst);
}

void print_row(const BackendRegistry& registry, const Row& row) {
  const bool is_raw = static_cast<bool>(registry.narrowphase(row.backend).make_raw);
  const auto time = is_raw ? time_raw : time_checked;
  Workload hot(row.family, kHotPairs), cold(row.family, kColdPairs);
  const Costs hot_costs = time(registry, row, hot, kHotRounds);
  const Costs cold_costs = time(registry, row, cold, kColdRounds);
  std::printf("%-16s %-9s %-12s %-6s", row.family.c_str(), std::string(to_string(row.kind)).c_str(),
              row.backend.c_str(), row.is_batch ? "batch" : "lone");
  print_costs(hot_costs, row.is_batch);
  print_costs(cold_costs, row.is_batch);
  std::printf(" %6s\n", count_wrong(registry, row, hot).c_str());
  std::fflush(stdout);
}

std::vector<Row> all_rows(const BackendRegistry& registry) {
  std::vector<Row> rows;
  for (const std::string_view family : cost_table_families()) {
    for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold}) {
      for (const bool is_batch : {false, true})
        rows.push_back({std::string(family), kind, "native", is_batch});
      for (const auto& entry : registry.narrowphases())
        if (entry.make_raw && entry.make_raw()->supports(kind))
          rows.push_back({std::string(family), kind, entry.name, false});
    }
  }
  return rows;
}

/// Whether every argument names the row's family, query, backend or mode. Names of one sort are alternatives.
bool is_wanted(const Row& row, const std::vector<std::string>& arguments) {
  const std::array<std::string, 4> names = {row.family, std::string(to_string(row.kind)), row.backend,
                                            row.is_batch ? "batch" : "lone"};
  const auto sort_of = [](const std::string& name) {
    if (name == "lone" || name == "batch") return 3;
    if (name == "overlap" || name == "distance" || name == "manifold") return 1;
    const auto families = cost_table_families();
    return std::find(families.begin(), families.end(), name) != families.end() ? 0 : 2;
  };
  std::array<bool, 4> is_asked{}, is_met{};
  for (const std::string& argument : arguments) {
    const int sort = sort_of(argument);
    is_asked[sort] = true;
    is_met[sort] = is_met[sort] || names[sort] == argument;
  }
  for (int sort = 0; sort < 4; ++sort)
    if (is_asked[sort] && !is_met[sort]) return false;
  return true;
}

}  // namespace
}  // namespace touchstone

int main(int argc, char** argv) {
  using namespace touchstone;
  BackendRegistry registry;
  register_all_backends(registry);
  for (const auto& entry : registry.narrowphases())
    std::printf("# %s: %s\n", entry.name.c_str(), entry.description.c_str());
  std::printf("# %-14s %-9s %-12s %-6s %35s %35s\n", "", "", "", "", "hot [ns]", "cold [ns]");
  std::printf("%-16s %-9s %-12s %-6s", "family", "query", "backend", "calls");
  for (int i = 0; i < 2; ++i) std::printf(" %8s %8s %8s %8s", "mean", "median", "99%", "worst");
  std::printf(" %6s\n", "wrong");
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  for (const Row& row : all_rows(registry))
    if (is_wanted(row, arguments)) print_row(registry, row);
}

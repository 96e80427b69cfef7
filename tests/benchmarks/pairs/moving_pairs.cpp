#include "touchstone/tests/benchmarks/pairs/moving_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/examples/measures/common/random.hpp"
#include "touchstone/tests/benchmarks/pairs/cost_table_families.hpp"

namespace touchstone {
namespace {

constexpr std::uint64_t kSeed = 20261127;
constexpr std::size_t kPairs = 4096;
constexpr int kFrames = 48, kTurn = 8;  // frames until all turn back

}  // namespace

MovingCost measure_moving_pairs(const BackendRegistry& registry, std::string_view family, double step) {
  // Pairs that move a little in each frame, to and fro.
  measures::PairSet set = make_cost_table_family(family, kSeed, kPairs);
  measures::Random random(kSeed);
  std::vector<Vector3> steps;
  for (std::size_t i = 0; i < set.poses.size(); ++i)
    steps.push_back(step * measures::random_direction(random));

  // The same batch without a cache and with one.
  const auto narrowphase = registry.make_narrowphase("native");
  narrowphase->build(set.solids);
  const auto workspace = narrowphase->make_workspace();
  std::vector<PairStatus> status(kPairs);
  std::vector<PairCacheEntry> cache(kPairs);
  Query query;
  query.kind = QueryKind::overlap;
  const auto time = [&](std::span<PairCacheEntry> entries) {
    const double start = processor_us();
    narrowphase->evaluate({set.pairs, set.poses, query, entries}, {status, {}, {}}, *workspace);
    return 1e3 * (processor_us() - start) / static_cast<double>(kPairs);
  };

  // The least time of all frames.
  MovingCost out{INFINITY, INFINITY};
  for (int frame = 0; frame < kFrames; ++frame) {
    const double sign = frame / kTurn % 2 == 0 ? 1.0 : -1.0;
    for (std::size_t i = 0; i < set.poses.size(); ++i) set.poses[i].p += sign * steps[i];
    const double without = time({}), with = time(cache);
    if (frame == 0) continue;  // the cache is empty yet
    out.without_cache = std::min(out.without_cache, without);
    out.with_cache = std::min(out.with_cache, with);
  }
  return out;
}

}  // namespace touchstone

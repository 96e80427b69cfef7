#include "touchstone/tests/proof/hash/result_hash.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <thread>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/tests/proof/checks/result_bits.hpp"
#include "touchstone/tests/proof/pairs/families.hpp"

namespace touchstone::proof {
namespace {

/// Pairs built together, so that memory does not grow with the count.
constexpr std::size_t kBlock = 4096;

constexpr double kWhole = kInfinity;

/// Asked of every pair, manifolds of the whole clip. The third cuts off pairs apart by more than a tenth of a
/// metre.
constexpr std::array<Query, 5> kQueries = {{
    {.kind = QueryKind::overlap},
    {.kind = QueryKind::distance},
    {.kind = QueryKind::distance, .max_separation = 0.1},
    {.kind = QueryKind::manifold, .max_points = 8, .max_point_separation = kWhole},
    {.kind = QueryKind::manifold, .max_points = 4, .max_point_separation = kWhole},
}};

template <typename Body>
void on_threads(int threads, std::size_t count, std::size_t chunk, const Body& body) {
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t begin; (begin = next.fetch_add(chunk)) < count;)
      body(begin, std::min(begin + chunk, count));
  };
  std::vector<std::jthread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(work);
  work();
}

struct Block {
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;
};

Block make_block(std::size_t family, std::uint64_t seed, std::size_t first, std::size_t count) {
  Block block;
  for (std::size_t i = 0; i < count; ++i) {
    PosedSolids pair = make_pair(family, seed, first + i);
    const auto solid = static_cast<SolidIndex>(block.solids.size());
    block.solids.push_back(std::move(pair.a));
    block.solids.push_back(std::move(pair.b));
    block.poses.push_back(pair.X_WA);
    block.poses.push_back(pair.X_WB);
    block.pairs.push_back({solid, solid + 1});
  }
  return block;
}

/// Answers to one query of a batch, put into each pair's own hash.
void hash_batch(const Narrowphase& narrowphase, const Block& block, const Query& query, bool with_cache,
                std::size_t begin, std::span<Fnv1a> hashes) {
  const std::size_t count = hashes.size(), slots = static_cast<std::size_t>(query.max_points);
  const bool overlap = query.kind == QueryKind::overlap;
  std::vector<PairStatus> status(count);
  std::vector<PairGeometry> geometry(overlap ? 0 : count);
  std::vector<ContactPoint> points(query.kind == QueryKind::manifold ? count * slots : 0);
  std::vector<PairCacheEntry> cache(with_cache ? count : 0);
  const auto workspace = narrowphase.make_workspace();
  for (int pass = with_cache ? 0 : 1; pass < 2; ++pass) {
    narrowphase.evaluate({std::span(block.pairs).subspan(begin, count), block.poses, query, cache},
                         {status, geometry, points}, *workspace);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const auto put = [&](std::uint64_t word) { hashes[i].put(word); };
    if (overlap) {
      put(static_cast<std::uint64_t>(status[i]));
    } else {
      const auto own =
          points.empty() ? std::span<const ContactPoint>{} : std::span(points).subspan(i * slots, slots);
      for_each_word(status[i], geometry[i], own, put);
    }
  }
}

std::uint64_t family_hash(std::size_t family, const HashOptions& options,
                          const std::function<std::unique_ptr<Narrowphase>()>& make) {
  Fnv1a all;
  for (std::size_t first = 0; first < options.count; first += kBlock) {
    const std::size_t count = std::min(kBlock, options.count - first);
    const Block block = make_block(family, options.seed, first, count);
    const auto narrowphase = make();
    narrowphase->build(block.solids);
    std::vector<Fnv1a> hashes(count);
    on_threads(options.threads, count, options.batch, [&](std::size_t begin, std::size_t end) {
      const auto own = std::span(hashes).subspan(begin, end - begin);
      for (const Query& query : kQueries) hash_batch(*narrowphase, block, query, options.cache, begin, own);
    });
    for (const Fnv1a& hash : hashes) all.put(hash.value());
  }
  return all.value();
}

}  // namespace

std::vector<FamilyHash> result_hashes(const HashOptions& options,
                                      const std::function<std::unique_ptr<Narrowphase>()>& make) {
  std::vector<FamilyHash> hashes;
  for (std::size_t family = 0; family < families().size(); ++family)
    hashes.push_back({families()[family].name, family_hash(family, options, make)});
  return hashes;
}

std::uint64_t total_hash(const std::vector<FamilyHash>& hashes) {
  Fnv1a total;
  for (const FamilyHash& each : hashes) total.put(each.hash);
  return total.value();
}

}  // namespace touchstone::proof

#include "touchstone/tests/proof/hash/result_hash.hpp"

#include <gtest/gtest.h>

#include <bit>

#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/proof/checks/lying_narrowphase.hpp"
#include "touchstone/tests/proof/pairs/families.hpp"

namespace touchstone::proof {
namespace {

std::uint64_t hash(const HashOptions& options) { return total_hash(result_hashes(options, make_native)); }

TEST(ResultHash, BatchSizesThreadsAndACacheDoNotShow) {
  const HashOptions reference{.count = 100, .threads = 1, .batch = 1};
  const std::uint64_t expected = hash(reference);
  for (const std::size_t batch : {2u, 7u, 33u, 4096u}) {
    for (const int threads : {1, 3}) {
      for (const bool cache : {false, true}) {
        HashOptions options = reference;
        options.batch = batch, options.threads = threads, options.cache = cache;
        EXPECT_EQ(hash(options), expected)
            << "batch " << batch << ", threads " << threads << ", cache " << cache;
      }
    }
  }
}

TEST(ResultHash, OneBitOfAnyAnswerShows) {
  // Lies of one bit or one status.
  const HashOptions options{.count = 10};
  const std::uint64_t expected = hash(options);
  const auto flipped = [](double& value) {
    value = std::bit_cast<double>(std::bit_cast<std::uint64_t>(value) ^ 1u);
  };
  const std::vector<LyingNarrowphase::Lie> lies = {[&](const auto&, const auto& output) {
                                                     if (!output.geometry.empty())
                                                       flipped(output.geometry[3].separation);
                                                   },
                                                   [&](const auto&, const auto& output) {
                                                     if (!output.geometry.empty())
                                                       flipped(output.geometry[9].n_AB_W.y());
                                                   },
                                                   [&](const auto&, const auto& output) {
                                                     if (!output.points.empty())
                                                       flipped(output.points[0].p_B_W.z());
                                                   },
                                                   [&](const auto&, const auto& output) {
                                                     if (!output.points.empty())
                                                       output.points[0].feature_id ^= 1u;
                                                   },
                                                   [&](const auto& input, const auto& output) {
                                                     if (input.query.kind == QueryKind::overlap)
                                                       output.status[5] = PairStatus::undecided;
                                                   }};
  // Each shows, and so does another seed.
  for (const auto& lie : lies)
    EXPECT_NE(total_hash(result_hashes(options, [&] { return std::make_unique<LyingNarrowphase>(lie); })),
              expected);
  HashOptions other = options;
  other.seed = 2;
  EXPECT_NE(hash(other), expected);
}

TEST(ResultHash, EveryFamilyHasItsOwn) {
  const auto hashes = result_hashes({.count = 5}, make_native);
  ASSERT_EQ(hashes.size(), families().size());
  for (std::size_t i = 0; i < hashes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(hashes[i].hash, hashes[j].hash);
}

}  // namespace
}  // namespace touchstone::proof

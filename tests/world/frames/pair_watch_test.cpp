#include "touchstone/contact_core/world/pairs/pair_watch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/tests/support/random.hpp"

namespace touchstone {
namespace {

TEST(PairWatch, HoldsWhatWasAddedAndNotRemoved) {
  Random random(3);
  PairWatch watch;
  watch.set_solids(20);
  std::map<std::pair<SolidIndex, SolidIndex>, std::uint32_t> expected;
  for (int i = 0; i < 5000; ++i) {
    SolidIndex a = random.below(20), b = random.below(20);
    if (a == b) continue;
    if (a > b) std::swap(a, b);
    const std::uint32_t found = watch.find({a, b});
    const auto known = expected.find({a, b});
    ASSERT_EQ(found, known == expected.end() ? kNoIndex : known->second);
    if (known == expected.end()) {
      expected[{a, b}] = watch.add({a, b, kNoLinkPair, 1.0 * a});
    } else {
      watch.remove(found);
      EXPECT_FALSE(watch.is_used(found));
      EXPECT_GT(watch[found].clear_until, 1e300);
      expected.erase(known);
    }
    ASSERT_EQ(watch.count(), expected.size());
  }
  for (SolidIndex solid = 0; solid < 20; ++solid) {
    std::vector<std::uint32_t> found, wanted;
    watch.for_each_of(solid, [&](std::uint32_t index) { found.push_back(index); });
    for (const auto& [pair, index] : expected)
      if (pair.first == solid || pair.second == solid) wanted.push_back(index);
    std::sort(found.begin(), found.end()), std::sort(wanted.begin(), wanted.end());
    EXPECT_EQ(found, wanted);
  }
  EXPECT_LE(watch.size(), 190u);  // indices are used again
}

TEST(PairWatch, PairsOfASolidMayBeRemovedWhileTheyAreVisited) {
  PairWatch watch;
  watch.set_solids(10);
  for (SolidIndex other = 1; other < 10; ++other) watch.add({0, other, kNoLinkPair, kNotKnown});
  watch.add({3, 4, kNoLinkPair, kNotKnown});
  watch.for_each_of(0, [&](std::uint32_t index) { watch.remove(index); });
  EXPECT_EQ(watch.count(), 1u);
  EXPECT_NE(watch.find({3, 4}), kNoIndex);
}

}  // namespace
}  // namespace touchstone

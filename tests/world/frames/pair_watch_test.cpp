#include "touchstone/contact_core/world/pairs/pair_watch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/tests/support/random.hpp"

namespace touchstone {
namespace {

TEST(PairWatch, HoldsWhatWasAddedAndNotRemoved) {
  // Pairs are added and removed at random, here and in a map.
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
  // Each solid's pairs are those of the map.
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

// Pairs of 6 solids with what rests, of 4 pairs of links and of two movers come, go, travel and get new room;
// what rests moves at times.
TEST(PairWatch, FindsPairsOfArmsThatWentFurtherThanTheyAreClear) {
  constexpr std::uint32_t kMoving = 6, kLinkPairs = 4;
  Random random(5);
  PairWatch watch;
  watch.set_solids(60);
  std::set<std::uint32_t> group;  // of those that are here
  std::vector<double> gone(60, 0.0);
  std::set<SolidIndex> moving;  // of those of no arm
  std::size_t looks = 0, here = 0;
  const auto gone_of = [&](const WatchedPair& pair) {
    ++looks;
    return pair.link_pair != kNoLinkPair ? gone[pair.a] : gone[pair.a] + gone[pair.b];
  };
  for (int frame = 0; frame < 6000; ++frame) {
    const SolidIndex a = random.below(kMoving + kLinkPairs + 1), b = 20 + random.below(40);
    const std::uint32_t link_pair = a < kMoving || a == kMoving + kLinkPairs ? kNoLinkPair : a - kMoving;
    if (const std::uint32_t index = watch.find({a, b}); index != kNoIndex)
      watch.remove(index), group.erase(index);
    else
      group.insert(watch.add_of_arm({a, b, link_pair, kNotKnown},
                                    a < kMoving && !moving.contains(b) ? a : kNoIndex, gone[b]));
    // All of the arm travels, and so do those that move, which come to rest in the second third of the time.
    for (SolidIndex i = 0; i < 20; ++i) gone[i] += 0.01 * random.below(100) / 100.0;
    for (const SolidIndex solid : moving) gone[solid] += 0.3 * random.below(100) / 100.0;
    if (frame % 30 == 29) {
      const bool rests = frame / 2000 == 1;
      const SolidIndex solid = rests && !moving.empty() ? *moving.begin() : 20 + random.below(40);
      if (moving.erase(solid) != 0)
        watch.note_rests(solid, gone[solid]);
      else if (!rests)
        moving.insert(solid), watch.note_moves(solid);
    }
    const auto raise = [&](std::uint32_t index) {
      watch[index].clear_until = gone_of(watch[index]) + 1.0 + random.below(100) / 100.0;
    };
    // Every second frame raises what it visits at once, the others afterwards.
    const std::size_t before = looks;
    std::set<std::uint32_t> visited;
    watch.for_each_of_arms_beyond(gone_of, [&](std::uint32_t index) {
      EXPECT_TRUE(visited.insert(index).second);
      if (frame % 2 == 1) raise(index);
    });
    if (moving.empty() && frame >= 2000) here += group.size();
    const std::size_t now = looks;
    for (const std::uint32_t index : group) {
      if (gone_of(watch[index]) <= watch[index].clear_until) continue;
      EXPECT_TRUE(visited.contains(index));
      raise(index);
    }
    for (const std::uint32_t index : visited) EXPECT_TRUE(group.contains(index));
    looks = moving.empty() && frame >= 2000 ? now : before;
  }
  EXPECT_GT(here, 10000u);
  EXPECT_LT(6 * looks, here);  // what moved once rests again
  watch.clear();
  watch.for_each_of_arms_beyond([](const WatchedPair&) { return kInfinity; },
                                [](std::uint32_t) { ADD_FAILURE() << "none is left"; });
}

TEST(PairWatch, FindsAllPairsOfAnArmThatWentNoNumber) {
  PairWatch watch;
  watch.set_solids(4);
  for (SolidIndex other = 1; other < 4; ++other) watch.add_of_arm({0, other, kNoLinkPair, 1.0}, 0);
  std::size_t visits = 0;
  const auto visit = [&](std::uint32_t) { ++visits; };
  watch.for_each_of_arms_beyond([](const WatchedPair&) { return 0.5; }, visit);
  EXPECT_EQ(visits, 0u);
  watch.for_each_of_arms_beyond([](const WatchedPair&) { return std::numeric_limits<double>::quiet_NaN(); },
                                visit);
  EXPECT_EQ(visits, 3u);
}

TEST(PairWatch, ShortensHowLongPairsAreClear) {
  PairWatch watch;
  watch.set_solids(3);
  const std::uint32_t gone = watch.add({1, 2, kNoLinkPair, kNotKnown});
  const std::uint32_t index = watch.add_of_arm({0, 1, kNoLinkPair, 1.0}, 0, 0.25);
  watch.remove(gone);
  const auto went = [](const WatchedPair&) { return 0.75; };
  std::size_t visits = 0;
  watch.for_each_of_arms_beyond(went, [&](std::uint32_t) { ++visits; });
  EXPECT_EQ(visits, 0u);
  watch.shorten_clearances(0.5);
  EXPECT_LE(watch[index].clear_until, 0.5);
  EXPECT_GT(watch[index].clear_until, 0.5 - 1e-14);
  EXPECT_EQ(watch[gone].clear_until, kInfinity);
  watch.for_each_of_arms_beyond(went, [&](std::uint32_t) { ++visits; });
  EXPECT_EQ(visits, 1u);
}

}  // namespace
}  // namespace touchstone

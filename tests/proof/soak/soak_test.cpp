#include "touchstone/tests/proof/soak/soak.hpp"

#include <gtest/gtest.h>

#include <iostream>

namespace touchstone {
namespace {

// A slice of what `soak` runs whole.
TEST(SoakThread, EveryInvariantHoldsAndTheRecordReplays) {
  Soak run;
  run.frames = 4000;
  const SoakFigures flown = soak(run);
  EXPECT_EQ(flown.violation, "");
  EXPECT_EQ(flown.frames, run.frames);
  EXPECT_GT(flown.refused, 0u);
  EXPECT_GT(flown.refused_set_up, 0u);
  EXPECT_GT(flown.blocked, 0u);
  EXPECT_GT(flown.slid, 0u);
  EXPECT_GT(flown.latched, 0u);
  EXPECT_GT(flown.removed, 0u);
  EXPECT_GT(flown.exempted, 0u);
  EXPECT_GT(flown.selections, 0u);
  EXPECT_GT(flown.refused_selections, 0u);
  EXPECT_GT(flown.pairs_checked, run.frames / 4);
  std::cout << describe(flown);
  run.replay = &flown.record;
  const SoakFigures again = soak(run);
  EXPECT_EQ(again.violation, "");
  EXPECT_EQ(again.pose_hash, flown.pose_hash);
}

}  // namespace
}  // namespace touchstone

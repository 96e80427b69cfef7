#include "touchstone/tests/world/progress/motion_progress.hpp"

#include <gtest/gtest.h>

#include <iostream>

namespace touchstone {
namespace {

// A slice of what `motion_progress` runs whole, from other seeds than those that the slides were made with.
struct Slice {
  std::string scene;
  int trials = 2, looks = 6;
  double most_frozen = 0.01;
};

ProgressFigures measured(const Slice& slice, double rate) {
  ProgressRun run;
  run.scene = slice.scene, run.rate = rate;
  run.trials = slice.trials, run.looks = slice.looks;
  run.seed = 1000;
  const ProgressFigures figures = measure_progress(run);
  print_progress(std::cout, figures);
  return figures;
}

class Progress : public ::testing::TestWithParam<double> {};

void expect_progress(const Slice& slice, double rate) {
  const ProgressFigures f = measured(slice, rate);
  EXPECT_GT(f.blocked, 0u) << slice.scene;
  EXPECT_LE(f.frozen_share(), slice.most_frozen) << slice.scene;
  EXPECT_EQ(f.stuck, 0u) << slice.scene;
  EXPECT_EQ(f.merged, 0u) << slice.scene;
}

TEST_P(Progress, ArmsGoOnAlongWhatTheyMeet) {
  print_progress_heading(std::cout);
  for (const char* scene : {"flat", "edge", "corner", "post", "bore"}) expect_progress({scene}, GetParam());
}

TEST_P(Progress, ArmsAmongBlocks) { expect_progress({"blocks", 3, 4}, GetParam()); }

TEST_P(Progress, ArmsThatEndAndAreHeldByTheirTools) {
  // As many that one frame of them is less than a hundredth.
  for (const char* scene : {"arms", "held_arms"}) expect_progress({scene, 20, 6}, GetParam());
}

TEST_P(Progress, DrawersComeOutAndPegsGoIn) {
  for (const char* scene : {"drawer", "drawers", "hand_drawers", "pegs"})
    expect_progress({scene, 3}, GetParam());
}

TEST_P(Progress, WhatFitsCloselyGoesOn) {
  for (const char* scene : {"two_links", "fit_bore", "pegs_large", "pegs_small", "file_drawers", "payload"})
    expect_progress({scene, 2, 3}, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Rates, Progress, ::testing::Values(10.0, 50.0), [](const auto& test) {
  return std::to_string(static_cast<int>(test.param)) + "Hz";
});

// In one frame of each, sub-steps gain less than a thousandth of what is left but as much as the ones before:
// the next ones lead round an edge.
TEST(ProgressOfHeldArms, PoorSubStepsThatGainSteadilyGoOn) {
  for (const std::uint64_t seed : {515032u, 990143u}) {
    ProgressRun run;
    run.scene = "held_arms", run.rate = 10.0, run.seed = seed;
    const ProgressFigures f = measure_progress(run);
    EXPECT_EQ(f.looked_at, f.blocked);
    EXPECT_GT(f.open, 0u) << seed;
    EXPECT_EQ(f.frozen, 0u) << seed;
  }
}

// It turns round a corner of its shell, by more with each sub-step, though each one's plan says that it is
// near its end.
TEST(ProgressOfDrawers, PlansThatEndDoNotEndTheWayRoundACorner) {
  ProgressRun run;
  run.scene = "drawers", run.rate = 10.0, run.seed = 882027, run.looks = 2;
  const ProgressFigures f = measure_progress(run);
  EXPECT_GT(f.blocked, 20u);
  EXPECT_GT(f.open, 0u);
  EXPECT_EQ(f.stuck, 0u);
  EXPECT_EQ(f.merged, 0u);
}

TEST(ProgressAtAKilohertz, ArmsGoOnAlongWhatTheyMeet) {
  for (const char* scene : {"edge", "corner"}) expect_progress({scene, 1, 4}, 1000.0);
}

// At 1 kHz the commanded paths themselves stay clear.
TEST(ProgressOfAdvance, ATurnAboutTheEdgeThatItRestsOnIsNotHeld) {
  for (const double rate : {10.0, 50.0}) expect_progress({"advance", 6, 4, 0.05}, rate);
}

}  // namespace
}  // namespace touchstone

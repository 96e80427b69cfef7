#include "touchstone/examples/compare_backends/run/selection_gain.hpp"

#include <gtest/gtest.h>

namespace touchstone::comparison {
namespace {

TEST(SelectionGain, WhatIsSwitchedOffIsNeitherLookedAtNorPaidFor) {
  SelectionOptions options;
  options.objects = 300;
  options.frames = 6;
  options.repetitions = 3;
  const std::vector<SelectionRow> rows = run_selection(options);
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[1].switched_off, 150u);
  EXPECT_EQ(rows[2].switched_off, 270u);
  for (std::size_t i = 1; i < rows.size(); ++i)
    EXPECT_LT(rows[i].candidate_pairs, rows[i - 1].candidate_pairs);
  EXPECT_EQ(rows[3].candidate_pairs, 0);
  EXPECT_LT(rows[3].frame.minimum_ns, rows[0].frame.minimum_ns);
}

}  // namespace
}  // namespace touchstone::comparison

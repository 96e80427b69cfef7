#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "touchstone/examples/compare_backends/diff/mann_whitney.hpp"
#include "touchstone/examples/compare_backends/judge/upper_bound.hpp"
#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/common/quantiles.hpp"

namespace touchstone::comparison {
namespace {

// P(X <= found) term by term, each from scratch.
double binomial_at_most(int found, int cases, double share) {
  double sum = 0;
  for (int k = 0; k <= found; ++k) {
    double choose = 1;
    for (int i = 0; i < k; ++i) choose *= static_cast<double>(cases - i) / (i + 1);
    sum += choose * std::pow(share, k) * std::pow(1 - share, cases - k);
  }
  return sum;
}

TEST(UpperBound, NoneOfManyIsThreeOverTheCount) {
  EXPECT_NEAR(upper_bound_95(0, 20000), 1.4977e-4, 1e-8);
  EXPECT_NEAR(upper_bound_95(0, 1), 0.95, 1e-12);
  EXPECT_EQ(upper_bound_95(0, 0), 1.0);
  EXPECT_EQ(upper_bound_95(7, 7), 1.0);
}

TEST(UpperBound, AtItSoFewTurnUpInFivePercentOfTheSamples) {
  for (const int cases : {2, 10, 100, 500}) {
    for (const int found : {0, 1, cases / 3, cases - 1}) {
      const double bound = upper_bound_95(static_cast<std::size_t>(found), static_cast<std::size_t>(cases));
      EXPECT_NEAR(binomial_at_most(found, cases, bound), 0.05, 1e-9) << found << " of " << cases;
      EXPECT_GT(bound, static_cast<double>(found) / cases);
    }
  }
}

TEST(UpperBound, GrowsWithWhatWasFoundAlsoOfMany) {
  double last = 0;
  for (const std::size_t found : {0, 1, 100, 5000, 19000, 19999}) {
    const double bound = upper_bound_95(found, 20000);
    EXPECT_GT(bound, last);
    EXPECT_LT(bound, 1.0);
    last = bound;
  }
}

TEST(Blocks, TheMedianOfTwoIsBetweenThemAndFewHaveNo99Percent) {
  std::array<double, 2> two = {10, 30};
  const Timing timing = summarise_blocks(two);
  EXPECT_EQ(timing.median_ns, 20);
  EXPECT_EQ(timing.minimum_ns, 10);
  EXPECT_TRUE(std::isnan(shown_p99(timing)));
  std::array<double, 100> many;
  for (int i = 0; i < 100; ++i) many[static_cast<std::size_t>(i)] = i + 1;
  EXPECT_EQ(shown_p99(summarise_blocks(many)), 99);
  EXPECT_TRUE(std::isnan(shown_p99(summarise_blocks(std::span(many).first(99)))));
}

TEST(MannWhitney, SmallSamplesByHand) {
  const std::array<double, 3> low = {1, 2, 3}, high = {4, 5, 6};
  EXPECT_DOUBLE_EQ(mann_whitney_p(low, high), 2.0 / 20);  // 2 of the 20 ways to choose three ranks
  EXPECT_DOUBLE_EQ(mann_whitney_p(high, low), 2.0 / 20);
  EXPECT_DOUBLE_EQ(mann_whitney_p(low, low), 1.0);
  const std::array<double, 2> x = {1, 3}, y = {2, 4};
  EXPECT_DOUBLE_EQ(mann_whitney_p(x, y), 4.0 / 6);  // sums 3 4 5 5 6 7, 4 is as far as 3 4 6 7
  const std::array<double, 2> tied = {1, 1}, other = {1, 2};
  EXPECT_DOUBLE_EQ(mann_whitney_p(tied, other), 1.0);  // ranks 2 2 2 4: sums 4 and 6, both as far from 5
}

TEST(MannWhitney, NineAgainstNineApartIsTwoOfAllWays) {
  std::array<double, 9> x, y;
  for (int i = 0; i < 9; ++i) x[static_cast<std::size_t>(i)] = i, y[static_cast<std::size_t>(i)] = 100 + i;
  EXPECT_DOUBLE_EQ(mann_whitney_p(x, y), 2.0 / 48620);
}

TEST(MannWhitney, OnlyWhatIsUnlikelyAmongManyIsResolved) {
  const std::array<double, 4> p = {0.001, 0.9, 0.03, 0.02};
  EXPECT_EQ(resolved(p, 0.05), (std::vector<bool>{true, false, true, true}));  // 0.03 <= 3/4 * 0.05
  const std::array<double, 3> chance = {0.04, 0.5, 0.9};
  EXPECT_EQ(resolved(chance, 0.05), (std::vector<bool>{false, false, false}));
}

}  // namespace
}  // namespace touchstone::comparison

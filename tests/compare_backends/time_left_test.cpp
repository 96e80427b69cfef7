#include "touchstone/examples/program/terminal/time_left.hpp"

#include <gtest/gtest.h>

#include "touchstone/examples/compare_backends/names.hpp"

namespace touchstone::comparison {
namespace {

TEST(TimeLeft, SaysNothingBeforeAPartIsDoneAndAfterTheLast) {
  TimeLeft left({{"family", 100}, {"family", 100}});
  EXPECT_FALSE(left.estimate(5.0));
  left.finish_part(10.0);
  EXPECT_TRUE(left.estimate(5.0));
  left.finish_part(10.0);
  EXPECT_FALSE(left.estimate(0.0));
  left.finish_part(10.0);  // one more than there are
  EXPECT_EQ(left.finished(), 2u);
  EXPECT_FALSE(TimeLeft().estimate(1.0));
}

TEST(TimeLeft, GoesByThePaceOfTheSameKindAndElseByThatOfAll) {
  TimeLeft left({{"family", 100}, {"family", 300}, {"scene", 50}, {"scene", 200}});
  left.finish_part(10.0);
  // 0.1 s a case: 30 s of the second family, 4 s of them gone, and scenes as fast as families.
  EXPECT_DOUBLE_EQ(*left.estimate(4.0), 26.0 + 5.0 + 20.0);
  EXPECT_DOUBLE_EQ(*left.estimate(100.0), 0.0 + 5.0 + 20.0);  // it takes longer than was thought
  left.finish_part(50.0);
  EXPECT_DOUBLE_EQ(*left.estimate(0.0), 0.15 * 250.0);
  left.finish_part(1.0);  // scenes: 0.02 s a case
  EXPECT_DOUBLE_EQ(*left.estimate(1.0), 3.0);
}

TEST(TimeLeft, IsToldAsRoughlyAsItIsKnown) {
  EXPECT_EQ(about(0.0), "about 0 s");
  EXPECT_EQ(about(11.0), "about 20 s");
  EXPECT_EQ(about(89.0), "about 90 s");
  EXPECT_EQ(about(91.0), "about 2 min");
  EXPECT_EQ(about(3601.0), "about 61 min");
}

}  // namespace
}  // namespace touchstone::comparison

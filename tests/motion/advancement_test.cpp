#include <gtest/gtest.h>

#include <vector>

#include "touchstone/contact_core/motion/advancement.hpp"

namespace touchstone {
namespace {

TEST(Advancement, GoesFromLookToLookUntilOneAnswers) {
  std::vector<double> seen;
  double s = 0.0;
  const AdvanceEnd end = advance(s, 100, [&](double at) -> std::optional<double> {
    seen.push_back(at);
    return at < 0.75 ? std::optional(at + 0.25) : std::nullopt;
  });
  EXPECT_EQ(end, AdvanceEnd::answered);
  EXPECT_EQ(seen, (std::vector{0.0, 0.25, 0.5, 0.75}));
  EXPECT_EQ(s, 0.75);
}

TEST(Advancement, StopsWhereItMayLookNoMore) {
  int looks = 0;
  double s = 0.0;
  const auto halfway = [&](double at) -> std::optional<double> {
    ++looks;
    return 0.5 * (at + 1.0);
  };
  EXPECT_EQ(advance(s, 4, halfway), AdvanceEnd::looks_spent);
  EXPECT_EQ(looks, 4);
  EXPECT_EQ(s, 0.875);  // the last look's: nothing beyond is known
}

TEST(Advancement, StopsWhereALookLetsNothingOn) {
  int looks = 0;
  double s = 0.5;
  const auto stay = [&](double at) -> std::optional<double> {
    ++looks;
    return at;
  };
  EXPECT_EQ(advance(s, 100, stay), AdvanceEnd::looks_spent);
  EXPECT_EQ(looks, 1);
  EXPECT_EQ(s, 0.5);
}

}  // namespace
}  // namespace touchstone

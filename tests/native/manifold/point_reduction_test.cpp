#include "touchstone/contact_core/native/manifold/point_reduction.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "touchstone/tests/native/native_fixture.hpp"

namespace touchstone::native {
namespace {

/// Corners on an ellipse, at random.
FlatPolygon random_polygon(Random& random, int count) {
  std::array<double, FlatPolygon::kMost> angle{};
  for (int i = 0; i < count; ++i) angle[i] = random.uniform(0, 2 * std::acos(-1.0));
  std::sort(angle.begin(), angle.begin() + count);
  const double flat = random.uniform(0.01, 1);
  FlatPolygon out;
  out.count = count;
  for (int i = 0; i < count; ++i) out.x[i] = 3 + std::cos(angle[i]), out.y[i] = flat * std::sin(angle[i]) - 2;
  return out;
}

double worth(const FlatPolygon& p, const Choice& chosen, int wanted) {
  const auto x = [&](int i) { return p.x[chosen[i]] - p.x[chosen[0]]; };
  const auto y = [&](int i) { return p.y[chosen[i]] - p.y[chosen[0]]; };
  if (wanted == 2) return x(1) * x(1) + y(1) * y(1);
  double area = 0.0;
  for (int i = 1; i + 1 < wanted; ++i) area += 0.5 * (x(i) * y(i + 1) - y(i) * x(i + 1));
  return area;
}

double best_of_all(const FlatPolygon& p, int wanted, int must) {
  double best = 0.0;
  for (unsigned mask = 0; mask < 1u << p.count; ++mask) {
    if (std::popcount(mask) != wanted || (must >= 0 && !(mask >> must & 1u))) continue;
    Choice chosen{};
    int count = 0;
    for (int i = 0; i < p.count; ++i)
      if (mask >> i & 1u) chosen[count++] = i;
    best = std::max(best, worth(p, chosen, wanted));
  }
  return best;
}

TEST(LargestChoice, IsTheBestOfAllChoices) {
  Random random(31);
  for (int i = 0; i < 400; ++i) {
    const int count = 3 + random.below(8);
    const FlatPolygon polygon = random_polygon(random, count);
    for (int wanted = 1; wanted <= std::min(count, 8); ++wanted) {
      const int must = random.below(count + 1) - 1;
      Choice chosen{};
      choose_largest_polygon(polygon, wanted, must, chosen);
      ASSERT_TRUE(std::is_sorted(chosen.begin(), chosen.begin() + wanted));
      ASSERT_EQ(std::adjacent_find(chosen.begin(), chosen.begin() + wanted), chosen.begin() + wanted);
      ASSERT_LT(chosen[wanted - 1], count);
      if (must >= 0) {
        ASSERT_NE(std::find(chosen.begin(), chosen.begin() + wanted, must), chosen.begin() + wanted);
      }
      const double best = best_of_all(polygon, wanted, must);
      ASSERT_GE(worth(polygon, chosen, wanted), best * (1 - 1e-8)) << wanted << " of " << count;
    }
  }
}

TEST(LargestChoice, HoldsTheStatedShareOfTheArea) {
  Random random(32);
  double least_four = 1.0, least_three = 1.0, least_free_three = 1.0;
  for (int i = 0; i < 3000; ++i) {
    const int count = 5 + random.below(8);
    const FlatPolygon polygon = random_polygon(random, count);
    Choice all{}, chosen{};
    for (int k = 0; k < count; ++k) all[k] = k;
    const double whole = worth(polygon, all, count);
    const int must = random.below(count);
    choose_largest_polygon(polygon, 4, must, chosen);
    least_four = std::min(least_four, worth(polygon, chosen, 4) / whole);
    choose_largest_polygon(polygon, 3, must, chosen);
    least_three = std::min(least_three, worth(polygon, chosen, 3) / whole);
    choose_largest_polygon(polygon, 3, -1, chosen);
    least_free_three = std::min(least_free_three, worth(polygon, chosen, 3) / whole);
  }
  EXPECT_GE(least_four, 0.5);
  EXPECT_GE(least_three, 0.25);
  EXPECT_GE(least_free_three, 3 * std::sqrt(3.0) / (4 * std::acos(-1.0)));
}

// A regular octagon: all squares are equal to rounding, the one with the first corner is taken.
TEST(LargestChoice, TiesGoToTheFirst) {
  FlatPolygon octagon;
  octagon.count = 8;
  for (int i = 0; i < 8; ++i)
    octagon.x[i] = std::cos(i * std::acos(-1.0) / 4), octagon.y[i] = std::sin(i * std::acos(-1.0) / 4);
  Choice chosen{};
  choose_largest_polygon(octagon, 4, -1, chosen);
  EXPECT_EQ(std::vector<int>(chosen.begin(), chosen.begin() + 4), (std::vector<int>{0, 2, 4, 6}));
  choose_largest_polygon(octagon, 4, 3, chosen);
  EXPECT_EQ(std::vector<int>(chosen.begin(), chosen.begin() + 4), (std::vector<int>{1, 3, 5, 7}));
}

}  // namespace
}  // namespace touchstone::native

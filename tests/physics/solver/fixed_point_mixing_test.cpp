// Anderson's mixing of fixed points.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "touchstone/physics/solver/fixed_point_mixing.hpp"

namespace touchstone::physics {
namespace {

/// F(x) = fixed + A (x - fixed), A diagonal.
struct Map {
  std::vector<double> fixed, A;

  std::vector<double> operator()(const std::vector<double>& x) const {
    std::vector<double> out(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) out[i] = fixed[i] + A[i] * (x[i] - fixed[i]);
    return out;
  }
  double miss(const std::vector<double>& x) const {
    double most = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) most = std::max(most, std::abs(x[i] - fixed[i]));
    return most;
  }
};

void mix_rounds(const Map& map, int rounds, FixedPointMixing& mixing, std::vector<double>& x) {
  for (int i = 0; i < rounds; ++i) {
    std::vector<double> next = map(x);
    mixing.mix(x, next);
    x = next;
  }
}

TEST(FixedPointMixing, FindsPointsThatTwoModesLeadAwayFrom) {
  const Map map{{1.0, -2.0, 3.0}, {-3.0, 2.5, 0.0}};
  FixedPointMixing mixing;
  mixing.reserve(3);
  std::vector<double> x(3, 0.0);
  mix_rounds(map, 2, mixing, x);
  EXPECT_GT(map.miss(x), 1.0);
  mix_rounds(map, 2, mixing, x);
  EXPECT_LT(map.miss(x), 1e-12);
}

TEST(FixedPointMixing, TakesOneOfDifferencesThatAreParallel) {
  // One mode alone: its second difference says nothing new.
  const Map map{{1.0, 1.0}, {-4.0, -4.0}};
  FixedPointMixing mixing;
  std::vector<double> x(2, 0.0);
  mix_rounds(map, 6, mixing, x);
  EXPECT_LT(map.miss(x), 1e-12);
}

TEST(FixedPointMixing, ForgetsWhatWasMixedAsItIsRestarted) {
  const Map map{{1.0, -2.0}, {-3.0, 2.5}};
  FixedPointMixing mixing;
  std::vector<double> x(2, 5.0);
  mix_rounds(map, 2, mixing, x);
  mixing.restart();
  // The first result of all is taken as it is.
  std::vector<double> next = map(x);
  mixing.mix(x, next);
  EXPECT_EQ(next, map(x));
}

}  // namespace
}  // namespace touchstone::physics

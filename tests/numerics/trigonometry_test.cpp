#include "touchstone/contact_core/geometry/trigonometry.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

// Truth: the C library's functions of long double, good to some 2^-63 (x86) or 2^-112.

namespace touchstone {
namespace {

static_assert(std::numeric_limits<long double>::digits >= 64);

/// In units in the last place of the truth as a double.
double error_in_ulps(double got, long double truth) {
  const int exponent = std::max(std::ilogb(static_cast<double>(truth)), -1022);
  return static_cast<double>(std::abs(static_cast<long double>(got) - truth) /
                             std::scalbn(1.0L, exponent - 52));
}

struct WorstErrors {
  double sine = 0.0, cosine = 0.0;

  void take(double angle) {
    const SineCosine got = sine_cosine(angle);
    sine = std::max(sine, error_in_ulps(got.sine, std::sin(static_cast<long double>(angle))));
    cosine = std::max(cosine, error_in_ulps(got.cosine, std::cos(static_cast<long double>(angle))));
    ASSERT_EQ(got.sine, touchstone::sine(angle));
    ASSERT_EQ(got.cosine, touchstone::cosine(angle));
  }
};

double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

/// Every mantissa, sign and exponent in the range as likely.
double any_double(std::mt19937_64& random, int low, int high) {
  const int exponent = low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
  const double value = std::scalbn(1.0 + uniform(random), exponent);
  return random() & 1 ? value : -value;
}

TEST(Trigonometry, SineAndCosineAreWithinTheStatedErrorForAnglesOfUsualSize) {
  std::mt19937_64 random(1);
  for (const double largest : {0.7853981633974483, 4.0, 100.0, 1e4, 0x1p20}) {
    WorstErrors worst;
    for (int i = 0; i < 200000; ++i) worst.take(largest * (2.0 * uniform(random) - 1.0));
    std::printf("up to %g rad: sine %.3f ulp, cosine %.3f ulp\n", largest, worst.sine, worst.cosine);
    EXPECT_LT(std::max(worst.sine, worst.cosine), 0.8);
  }
}

TEST(Trigonometry, SineAndCosineAreWithinTheStatedErrorForEveryFiniteAngle) {
  std::mt19937_64 random(2);
  WorstErrors worst;
  for (int i = 0; i < 400000; ++i) worst.take(any_double(random, -60, 1023));
  std::printf("all magnitudes: sine %.3f ulp, cosine %.3f ulp\n", worst.sine, worst.cosine);
  EXPECT_LT(std::max(worst.sine, worst.cosine), 0.8);
  // Every power of two and its neighbours, to the largest double.
  for (int exponent = -1074; exponent <= 1023; ++exponent) {
    const double power = std::scalbn(1.0, exponent);
    for (const double angle : {power, std::nextafter(power, 0.0), -power, 1.75 * power}) worst.take(angle);
  }
  worst.take(std::numeric_limits<double>::max());
  EXPECT_LT(std::max(worst.sine, worst.cosine), 0.8);
}

TEST(Trigonometry, MultiplesOfAQuarterTurnKeepAllDigitsOfTheirSmallRest) {
  WorstErrors worst;
  for (int k = 1; k < 200000; ++k) {
    const double angle = k * 1.5707963267948966;
    for (const double near : {angle, std::nextafter(angle, 0.0), std::nextafter(angle, 1e300)})
      worst.take(near);
  }
  // The double nearest to a multiple of pi/2 of all (Muller, Elementary Functions, table 11.1), and where the
  // two reductions meet.
  for (const double angle : {0x1.6ac5b262ca1ffp+849, 0x1p20, std::nextafter(0x1p20, 0.0)}) worst.take(angle);
  EXPECT_LT(std::max(worst.sine, worst.cosine), 0.8);
}

TEST(Trigonometry, OddAndEvenToTheBitAndSpecialAnglesAreExact) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 100000; ++i) {
    const double angle = any_double(random, -40, 60);
    const SineCosine there = sine_cosine(angle), back = sine_cosine(-angle);
    ASSERT_EQ(there.sine, -back.sine);
    ASSERT_EQ(there.cosine, back.cosine);
  }
  EXPECT_TRUE(std::signbit(sine(-0.0)));
  EXPECT_EQ(cosine(0.0), 1.0);
  EXPECT_EQ(sine(5e-324), 5e-324);
  EXPECT_EQ(sine(1.5707963267948966), 1.0);
  EXPECT_NEAR(sine(0.5235987755982988), 0.5, 0x1p-53);
  for (const double none : {kInfinity, -kInfinity, kNaN}) {
    EXPECT_TRUE(std::isnan(sine(none)));
    EXPECT_TRUE(std::isnan(cosine(none)));
  }
}

TEST(Trigonometry, ArcTangentIsWithinTheStatedErrorInEveryDirectionAndScale) {
  std::mt19937_64 random(4);
  for (const int scale : {1, 12, 1000}) {
    double worst = 0.0;
    for (int i = 0; i < 400000; ++i) {
      const double y = any_double(random, -scale, scale), x = any_double(random, -scale, scale);
      const long double truth = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
      if (std::abs(truth) < 0x1p-1000L) continue;
      worst = std::max(worst, error_in_ulps(arc_tangent(y, x), truth));
    }
    std::printf("exponents to %d: %.3f ulp\n", scale, worst);
    EXPECT_LT(worst, 1.5);
  }
}

TEST(Trigonometry, ArcTangentHasTheStandardsZerosAndInfinities) {
  const double infinity = kInfinity;
  const double values[] = {0.0, -0.0, 1.0, -1.0, infinity, -infinity, 5e-324, -5e-324, 1.7e308, -1.7e308};
  for (const double y : values)
    for (const double x : values) {
      const double got = arc_tangent(y, x), expected = std::atan2(y, x);
      EXPECT_EQ(std::bit_cast<std::uint64_t>(got), std::bit_cast<std::uint64_t>(expected)) << y << " " << x;
    }
  EXPECT_TRUE(std::isnan(arc_tangent(std::nan(""), 1.0)));
  EXPECT_TRUE(std::isnan(arc_tangent(0.0, std::nan(""))));
}

}  // namespace
}  // namespace touchstone

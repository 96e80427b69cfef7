#include "touchstone/contact_core/geometry/trigonometry.hpp"

#include <array>
#include <bit>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <utility>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/fixed_integer.hpp"

// An angle is brought to within pi/4 of a multiple n of pi/2 (reduce()), where polynomials serve.
//
// Reduction: Cody and Waite 1980. pi/2 = P1 + P2 + P3, the first two of 33 bits, so that n P1 and n P2 are
// exact for |n| < 2^20, and so is x - n P1 (a multiple of 2^-53 below 1). What is left has an error below
// 2^-100. Where more than 30 bits cancel, and for larger angles, Payne and Hanek 1983: the product of x's
// 53 bits with those 256 bits of 2/pi that reach the fraction of a quadrant, in integers. No double is nearer
// than 2^-62 to a multiple of pi/2 (Muller, Elementary Functions, 11.3), so that at least 2^-64 of what is
// left is right.
//
// Polynomials: least largest error by Remez's exchange with the first coefficient rounded beforehand;
// |r| <= pi/4: sine 2^-57.8 (relative), cosine 2^-64 (absolute); |t| <= 7/16: arc tangent 2^-57.6 (relative).
// How they are summed so that almost only the last operation rounds: Ng, fdlibm 5.3 (Sun Microsystems 1993).

namespace touchstone {
namespace {

static_assert(FLT_EVAL_METHOD == 0, "sums and products must round to double");

using numerics::Uint128;

constexpr double kQuarterPi = 0x1.921fb54442d18p-1;
constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1;
constexpr double kP1 = 0x1.921fb544p+0, kP2 = 0x1.0b4611a6p-34, kP3 = 0x1.3198a2e037073p-69;
constexpr double kLargestFast = 0x1p20;    // n < 2^20
constexpr double kSmallestFast = 0x1p-30;  // of what is left

/// 2/pi after its binary point, behind 64 zeros.
constexpr std::array<std::uint64_t, 22> kBitsOfTwoOverPi = {
    0x0000000000000000, 0xa2f9836e4e441529, 0xfc2757d1f534ddc0, 0xdb6295993c439041, 0xfe5163abdebbc561,
    0xb7246e3a424dd2e0, 0x06492eea09d1921c, 0xfe1deb1cb129a73e, 0xe88235f52ebb4484, 0xe99c7026b45f7e41,
    0x3991d639835339f4, 0x9c845f8bbdf9283b, 0x1ff897ffde05980f, 0xef2f118b5a0a6d1f, 0x6d367ecf27cb09b7,
    0x4f463f669e5fea2d, 0x7527bac7ebe5f17b, 0x3d0739f78a5292ea, 0x6bfb5fb11f8d5d08, 0x56033046fc7b6bab,
    0xf0cfbc209af4361d, 0xa9e391615ee61b08};
/// pi/2 times 2^127.
constexpr std::uint64_t kHalfPiHigh = 0xc90fdaa22168c234, kHalfPiLow = 0xc4c6628b80dc1cd1;

/// An angle less n quarter turns, as the sum of two doubles; n modulo 4.
struct Reduced {
  double high;
  double low;
  unsigned quadrant;
};

using Words = std::array<std::uint64_t, 4>;  // the most significant first

/// (a b) / 2^128, rounded down, off by less than 3.
Uint128 high_product(Uint128 a, std::uint64_t b_high, std::uint64_t b_low) {
  const auto a_high = static_cast<std::uint64_t>(a >> 64), a_low = static_cast<std::uint64_t>(a);
  const Uint128 cross_1 = (static_cast<Uint128>(a_high) * b_low) >> 64;
  const Uint128 cross_2 = (static_cast<Uint128>(a_low) * b_high) >> 64;
  return static_cast<Uint128>(a_high) * b_high + cross_1 + cross_2;
}

/// m 2^exponent 2/pi modulo 4, in units of 2^-254.
Words quadrants(std::uint64_t m, int exponent) {
  // Bits of weight 2^-i with exponent - i >= 2 give multiples of 4.
  const unsigned first = static_cast<unsigned>(exponent + 62);
  const std::size_t word = first / 64;
  const int shift = static_cast<int>(first % 64);
  Words product{};
  Uint128 carry = 0;
  for (std::size_t i = 4; i-- > 0;) {
    const Uint128 two =
        static_cast<Uint128>(kBitsOfTwoOverPi[word + i]) << 64 | kBitsOfTwoOverPi[word + i + 1];
    carry += static_cast<Uint128>(static_cast<std::uint64_t>(two << shift >> 64)) * m;
    product[i] = static_cast<std::uint64_t>(carry);
    carry >>= 64;
  }
  return product;
}

/// Two's complement.
void negate(Words& words) {
  bool carry = true;
  for (std::size_t i = 4; i-- > 0;) {
    words[i] = ~words[i] + (carry ? 1 : 0);
    carry = carry && words[i] == 0;
  }
}

void shift_left(Words& words, int count) {  // below 64
  if (count == 0) return;
  for (std::size_t i = 0; i < 4; ++i)
    words[i] = words[i] << count | (i < 3 ? words[i + 1] >> (64 - count) : 0);
}

/// Any |x| >= pi/4, finite.
Reduced reduce_exactly(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(std::abs(x));
  const std::uint64_t m = (bits & 0xfffffffffffff) | 0x10000000000000;
  Words fraction = quadrants(m, static_cast<int>(bits >> 52) - 1075);
  auto quadrant = static_cast<unsigned>(fraction[0] >> 62);
  shift_left(fraction, 2);
  double sign = x < 0.0 ? -1.0 : 1.0;
  const bool beyond_half = fraction[0] >> 63 != 0;
  if (beyond_half) negate(fraction);
  if (beyond_half) ++quadrant, sign = -sign;
  int exponent = -127;
  for (; fraction[0] == 0; exponent -= 64) fraction = {fraction[1], fraction[2], fraction[3], 0};
  const int zeros = std::countl_zero(fraction[0]);
  shift_left(fraction, zeros);
  const Uint128 top = static_cast<Uint128>(fraction[0]) << 64 | fraction[1];
  const Uint128 angle = high_product(top, kHalfPiHigh, kHalfPiLow);  // 126 or 127 bits and one
  const double most = static_cast<double>(static_cast<std::uint64_t>(angle >> 75));
  const double rest = static_cast<double>(static_cast<std::uint64_t>(angle >> 22) & 0x1fffffffffffff);
  const double unit = sign * std::ldexp(1.0, exponent - zeros);
  const double a = most * (unit * 0x1p75), b = rest * (unit * 0x1p22);
  const double high = a + b;
  return {high, (a - high) + b, x < 0.0 ? 0u - quadrant : quadrant};
}

Reduced reduce(double x) {
  if (std::abs(x) <= kQuarterPi) return {x, 0.0, 0};
  if (!(std::abs(x) < kLargestFast)) {
    if (!std::isfinite(x)) return {kNaN, 0.0, 0};
    return reduce_exactly(x);
  }
  const double n = (x * kTwoOverPi + 0x1.8p52) - 0x1.8p52;  // the nearest whole number
  const double first = x - n * kP1, second = n * kP2;
  const double sum = first - second;  // and what its rounding left (Knuth's two-sum)
  const double part = sum - first;
  const double left = (first - (sum - part)) - (second + part);
  const double rest = left - n * kP3;
  const double high = sum + rest;
  if (std::abs(high) < kSmallestFast) return reduce_exactly(x);
  return {high, (sum - high) + rest, static_cast<unsigned>(static_cast<int>(n))};
}

double polynomial_sine(double r, double low) {
  constexpr std::array<double, 6> S = {-0x1.5555555555549p-3, 0x1.111111110f884p-7,   -0x1.a01a019c101a4p-13,
                                       0x1.71de357543c85p-19, -0x1.ae5e63d6fea26p-26, 0x1.5d923d00f99b5p-33};
  const double z = r * r, cube = z * r;
  const double p = (S[1] + z * (S[2] + z * S[3])) + (z * (z * z)) * (S[4] + z * S[5]);
  return r - ((z * (0.5 * low - cube * p) - low) - cube * S[0]);
}

double polynomial_cosine(double r, double low) {
  constexpr std::array<double, 6> C = {0x1.555555555554bp-5,  -0x1.6c16c16c15003p-10,
                                       0x1.a01a019c8b28ap-16, -0x1.27e4f7ed0047ap-22,
                                       0x1.1ee9d792216a1p-29, -0x1.8fa3c1f5e0a85p-37};
  const double z = r * r, square = z * z;
  const double p = z * (C[0] + z * (C[1] + z * C[2])) + (square * square) * (C[3] + z * (C[4] + z * C[5]));
  const double half = 0.5 * z, w = 1.0 - half;
  return w + (((1.0 - w) - half) + (z * p - r * low));
}

/// (t - arc tangent of t) / t.
double missing_share(double t) {
  constexpr std::array<double, 11> A = {0x1.555555555550bp-2,  -0x1.999999998e7fap-3, 0x1.2492491ff3f46p-3,
                                        -0x1.c71c6fdb68455p-4, 0x1.745cdbad2d22dp-4,  -0x1.3b0f20f1575c5p-4,
                                        0x1.10d607cda631cp-4,  -0x1.ddde0268deed3p-5, 0x1.97a1e6c92fdd7p-5,
                                        -0x1.2b1ae9bbd58c8p-5, 0x1.0a852cce3f50fp-6};
  const double z = t * t, w = z * z, u = w * w;
  const double even = (A[0] + w * A[2]) + u * ((A[4] + w * A[6]) + u * (A[8] + w * A[10]));
  const double odd = (A[1] + w * A[3]) + u * ((A[5] + w * A[7]) + u * A[9]);
  return z * even + w * odd;
}

/// Of small / large. @pre 0 <= small <= large, large > 0, neither so large or small that half of one or the
/// sum of both is inexact beyond its rounding.
double arc_tangent_within_octant(double small, double large) {
  if (small < 0.4375 * large) {
    const double t = small / large;
    return t - t * missing_share(t);
  }
  // arctan(a) = arctan(c) + arctan((a - c) / (1 + a c)), c = 1/2 or 1; the differences are exact.
  const bool by_half = small < 0.6875 * large;
  const double base = by_half ? 0x1.dac670561bb4fp-2 : kQuarterPi;
  const double base_low = by_half ? 0x1.a2b7f222f65e2p-56 : 0x1.1a62633145c07p-55;
  const double t =
      by_half ? (small - 0.5 * large) / (large + 0.5 * small) : (small - large) / (large + small);
  return base + (t - (t * missing_share(t) - base_low));
}

}  // namespace

SineCosine sine_cosine(double angle) noexcept {
  const Reduced r = reduce(angle);
  double s = polynomial_sine(r.high, r.low), c = polynomial_cosine(r.high, r.low);
  if (r.quadrant & 1) {
    std::swap(s, c);
    c = -c;
  }
  if (r.quadrant & 2) s = -s, c = -c;
  return {s, c};
}

double sine(double angle) noexcept {
  const Reduced r = reduce(angle);
  const double s = r.quadrant & 1 ? polynomial_cosine(r.high, r.low) : polynomial_sine(r.high, r.low);
  return r.quadrant & 2 ? -s : s;
}

double cosine(double angle) noexcept {
  const Reduced r = reduce(angle);
  const double c = r.quadrant & 1 ? -polynomial_sine(r.high, r.low) : polynomial_cosine(r.high, r.low);
  return r.quadrant & 2 ? -c : c;
}

double arc_tangent(double y, double x) noexcept {
  constexpr double kHalfPi = 2.0 * kQuarterPi, kHalfPiRest = 0x1.1a62633145c07p-54;
  double across = std::abs(x), up = std::abs(y);
  if (std::isnan(across) || std::isnan(up)) return kNaN;
  if (std::isinf(across) || std::isinf(up)) {
    across = std::isinf(across) ? 1.0 : 0.0;
    up = std::isinf(up) ? 1.0 : 0.0;
  }
  const double larger = across < up ? up : across;
  if (larger > 0x1p1000) across *= 0x1p-60, up *= 0x1p-60;
  if (larger < 0x1p-900) across *= 0x1p120, up *= 0x1p120;
  const bool steep = up > across;
  double angle = 0.0;
  if (larger > 0.0)
    angle = steep ? arc_tangent_within_octant(across, up) : arc_tangent_within_octant(up, across);
  const bool behind = std::signbit(x);
  if (steep)
    angle = behind ? kHalfPi + (angle + kHalfPiRest) : kHalfPi - (angle - kHalfPiRest);
  else if (behind)
    angle = 2.0 * kHalfPi - (angle - 2.0 * kHalfPiRest);
  return std::copysign(angle, y);
}

}  // namespace touchstone

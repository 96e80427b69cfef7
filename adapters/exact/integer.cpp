#include <algorithm>
#include <cmath>
#include <limits>

#include "touchstone/adapters/exact/integer_vector.hpp"

namespace touchstone::exact {
namespace {

constexpr long kNoExponent = std::numeric_limits<long>::max();

// Exponent of the lowest bit a double's 53-bit mantissa can have.
long lowest_exponent(double value) {
  if (value == 0.0) return kNoExponent;
  int exponent = 0;
  std::frexp(value, &exponent);
  return exponent - 53L;
}

long lowest_exponent(const WorldVertices& v) {
  long lowest = kNoExponent;
  for (const auto* axis : {&v.x, &v.y, &v.z}) {
    for (const double value : *axis) lowest = std::min(lowest, lowest_exponent(value));
  }
  return lowest;
}

Integer on_grid(double value, long grid) {
  if (value == 0.0) return 0;
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);
  Integer result = static_cast<long>(std::ldexp(mantissa, 53));
  result <<= static_cast<mp_bitcnt_t>(exponent - 53L - grid);
  return result;
}

IntegerVector on_grid(const Vector3& v, long grid) {
  return {on_grid(v.x(), grid), on_grid(v.y(), grid), on_grid(v.z(), grid)};
}

long bit_length(const Integer& value) { return static_cast<long>(mpz_sizeinbase(value.get_mpz_t(), 2)); }

// (magnitude + something in (0, 1) when there is a remainder) * 2^exponent; magnitude has more than 55 bits.
double round_magnitude(const Integer& magnitude, bool remainder, long exponent) {
  const long length = bit_length(magnitude);
  const long drop = std::max(length - 53, -1074 - exponent);  // subnormals keep fewer bits
  if (drop > length) return 0.0;
  const auto bits = static_cast<mp_bitcnt_t>(drop);
  Integer kept = magnitude >> bits;
  if (mpz_tstbit(magnitude.get_mpz_t(), bits - 1) != 0) {
    const bool above_half = remainder || mpz_scan1(magnitude.get_mpz_t(), 0) < bits - 1;
    if (above_half || mpz_odd_p(kept.get_mpz_t())) ++kept;
  }
  return std::ldexp(kept.get_d(), static_cast<int>(std::clamp(exponent + drop, -4000L, 4000L)));
}

}  // namespace

IntegerPair to_integers(const WorldVertices& a, const WorldVertices& b, double radius_a, double radius_b) {
  const long lowest = std::min(
      {lowest_exponent(a), lowest_exponent(b), lowest_exponent(radius_a), lowest_exponent(radius_b)});
  IntegerPair pair;
  pair.exponent = lowest == kNoExponent ? 0 : lowest;
  pair.radius = on_grid(radius_a, pair.exponent) + on_grid(radius_b, pair.exponent);
  pair.origin = on_grid(a.vertex(0), pair.exponent);
  for (int i = 0; i < 8; ++i) {
    pair.a[i] = on_grid(a.vertex(i), pair.exponent) - pair.origin;
    pair.b[i] = on_grid(b.vertex(i), pair.exponent) - pair.origin;
  }
  return pair;
}

long to_integers(const Vector3& v, IntegerVector& out) {
  const long lowest = std::min({lowest_exponent(v.x()), lowest_exponent(v.y()), lowest_exponent(v.z())});
  const long grid = lowest == kNoExponent ? 0 : lowest;
  out = on_grid(v, grid);
  return grid;
}

double round_ratio(const Integer& numerator, const Integer& denominator, long exponent) {
  if (numerator == 0) return 0.0;
  const long shift = std::max(0L, 66 + bit_length(denominator) - bit_length(numerator));
  Integer quotient = abs(numerator), remainder;
  quotient <<= static_cast<mp_bitcnt_t>(shift);
  mpz_tdiv_qr(quotient.get_mpz_t(), remainder.get_mpz_t(), quotient.get_mpz_t(), denominator.get_mpz_t());
  const double magnitude = round_magnitude(quotient, remainder != 0, exponent - shift);
  return numerator < 0 ? -magnitude : magnitude;
}

double round_root(int sign, const Integer& numerator, const Integer& denominator, long exponent) {
  if (sign == 0 || numerator == 0) return 0.0;
  const long shift = std::max(0L, (134 + bit_length(denominator) - bit_length(numerator)) / 2);
  Integer quotient = numerator, remainder;
  quotient <<= static_cast<mp_bitcnt_t>(2 * shift);
  mpz_tdiv_qr(quotient.get_mpz_t(), remainder.get_mpz_t(), quotient.get_mpz_t(), denominator.get_mpz_t());
  bool inexact = remainder != 0;
  Integer root;
  mpz_sqrtrem(root.get_mpz_t(), remainder.get_mpz_t(), quotient.get_mpz_t());
  inexact = inexact || remainder != 0;
  const double magnitude = round_magnitude(root, inexact, exponent - shift);
  return sign < 0 ? -magnitude : magnitude;
}

double round_root_less(int sign, const Integer& numerator, const Integer& denominator, const Integer& radius,
                       long exponent) {
  // The root to more and more bits behind the point, until the difference has enough of them.
  for (mp_bitcnt_t bits = 64;; bits *= 2) {
    Integer quotient = numerator << (2 * bits), remainder, root;
    mpz_tdiv_qr(quotient.get_mpz_t(), remainder.get_mpz_t(), quotient.get_mpz_t(), denominator.get_mpz_t());
    bool inexact = remainder != 0;
    mpz_sqrtrem(root.get_mpz_t(), remainder.get_mpz_t(), quotient.get_mpz_t());
    inexact = inexact || remainder != 0;
    // The true root is in (root, root + 1) where inexact.
    Integer magnitude = (radius << bits) - (sign < 0 ? Integer(-root) : root);
    if (inexact && bit_length(magnitude) < 70) continue;
    const bool negative = magnitude > 0;
    // radius - root is above the true value: the next integer towards 0 and something.
    if (negative && sign >= 0 && inexact) --magnitude;
    magnitude = abs(magnitude);
    const long shift = std::max(0L, 70 - bit_length(magnitude));
    magnitude <<= static_cast<mp_bitcnt_t>(shift);
    const double rounded = round_magnitude(magnitude, inexact, exponent - static_cast<long>(bits) - shift);
    return negative ? -rounded : rounded;
  }
}

Vector<double> approximate(const IntegerVector& v) {
  long ex = 0, ey = 0, ez = 0;
  const double x = mpz_get_d_2exp(&ex, v.x.get_mpz_t());
  const double y = mpz_get_d_2exp(&ey, v.y.get_mpz_t());
  const double z = mpz_get_d_2exp(&ez, v.z.get_mpz_t());
  long top = std::numeric_limits<long>::min();
  if (x != 0.0) top = std::max(top, ex);
  if (y != 0.0) top = std::max(top, ey);
  if (z != 0.0) top = std::max(top, ez);
  const auto scale = [top](double value, long exponent) {
    return value == 0.0 ? 0.0 : std::ldexp(value, static_cast<int>(std::max(exponent - top, -4000L)));
  };
  return {scale(x, ex), scale(y, ey), scale(z, ez)};
}

}  // namespace touchstone::exact

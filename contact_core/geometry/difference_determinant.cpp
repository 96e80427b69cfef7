#include "touchstone/contact_core/geometry/difference_determinant.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "touchstone/contact_core/geometry/big_integer.hpp"

// How a sign is decided, cheapest first:
//  1. doubles with an error bound (below);
//  2. the same with exponents kept apart, where the first over- or underflowed;
//  3. integers: multiplying an axis by a power of two leaves the sign alone, so the coordinates of each axis
//     are made integers on that axis's own lowest bit. When highest and lowest bit of every axis are at most
//     125 bits apart, the determinant is formed in 192 bits (differences below 2^61) or 384 bits; otherwise
//     in BigInteger. DirectionSigns forms u x v once, and of each point p_i at most once the height (u x v) .
//     (p_i - p_0), of the same bits as a determinant: det[u v p_j - p_i] has the sign of a difference of two.
// Floating-point expansions (Shewchuk 1997) would take the place of 3 for ordinary exponents, but not for all
// doubles; the integers do, and need no second path.
//
// Error bound of 1. Let u = 2^-53. A difference of doubles is exact times (1 + d), |d| <= u, whatever its
// magnitude (sums do not underflow). A term of the determinant is a product of three differences (3
// roundings), two products (2) and at most three additions (3): 8 roundings, so the computed sum is within
// ((1 + u)^8 - 1) * permanent of the exact one, permanent = the sum of the six terms' magnitudes, and the
// computed permanent is low by at most the same factor. 9 u covers both, 16 u = 2^-49 is used, so the
// rounding of the bound itself is covered too. Underflow adds at most 2^-1075 to a product: 2 * 2^-1075 to
// each minor, that times |a_k| to a term, and 3 * 2^-1075 for the last products; the permanent may be low by
// as much. 2^-1000 (1 + |a_x| + |a_y| + |a_z|) covers it amply (a normal number: denormal constants would be
// slow). Overflow anywhere makes the permanent infinite or NaN: monotonicity of rounding keeps every
// intermediate value of the determinant at most its counterpart in the permanent.

namespace touchstone::numerics {
namespace {

// Widths of 3. A finite double is an integer below 2^2098 times 2^-1074, so 2098 bits hold any coordinate on
// an axis's unit, 2099 a difference (33 limbs), 2 * 2099 + 1 a 2x2 minor (66 limbs), and 3 * 2099 + 3 bits =
// 6300 a determinant (99 limbs). product() may touch one limb more than the value needs.
constexpr int kDifferenceLimbs = 34;
constexpr int kMinorLimbs = 69;
constexpr int kDeterminantLimbs = 104;
using DifferenceInteger = BigInteger<kDifferenceLimbs>;
using MinorInteger = BigInteger<kMinorLimbs>;
using DeterminantInteger = BigInteger<kDeterminantLimbs>;
using BigVector = std::array<DifferenceInteger, 3>;

constexpr int kFittingBits = 125;

struct Parts {
  int sign;
  std::uint64_t mantissa;  // odd, or 0
  int exponent;            // of the mantissa's least significant bit

  int top() const { return exponent + static_cast<int>(std::bit_width(mantissa)); }
};

Parts parts_of(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  const int biased = static_cast<int>(bits >> 52 & 0x7ff);
  std::uint64_t mantissa = bits & 0xfffffffffffffULL;
  if (biased != 0) mantissa |= 1ULL << 52;
  if (mantissa == 0) return {0, 0, 0};
  const int zeros = std::countr_zero(mantissa);
  return {bits >> 63 ? -1 : 1, mantissa >> zeros, (biased != 0 ? biased - 1075 : -1074) + zeros};
}

DifferenceInteger big_integer_of(double value, int unit_exponent) {
  const Parts parts = parts_of(value);
  DifferenceInteger out;
  assign_shifted(out, parts.sign, parts.mantissa, parts.mantissa == 0 ? 0 : parts.exponent - unit_exponent);
  return out;
}

MinorInteger minor(const DifferenceInteger& a, const DifferenceInteger& b, const DifferenceInteger& c,
                   const DifferenceInteger& d) {
  return difference(product<kMinorLimbs>(a, b), product<kMinorLimbs>(c, d));
}

/// A double whose exponent cannot overflow: fraction * 2^exponent, 1/2 <= |fraction| < 1 or zero.
struct WideExponent {
  double fraction;
  int exponent;
};

/// q - p, rounded once. Halves are used where the difference overflows: what halving may round is below
/// 2^-1074, beside a result above 2^1023.
WideExponent wide_difference(double q, double p) {
  WideExponent out{q - p, 0};
  const bool overflows = !std::isfinite(out.fraction);
  if (overflows) out.fraction = q / 2.0 - p / 2.0;
  out.fraction = std::frexp(out.fraction, &out.exponent);
  out.exponent += overflows;
  return out;
}

using ScaledVector = std::array<WideExponent, 3>;

/// Sign of det[a b c]: -1, 0 or +1 when certain, otherwise kUncertain. The six terms are scaled by the
/// largest one's exponent: none overflows, what underflows is below 2^-1074 beside a permanent of at least
/// 1/8. Roundings: 3 (differences), 2 (products), 5 (sums); 16 u of the permanent covers them as above.
constexpr int kUncertain = 2;

int wide_filtered_sign(const ScaledVector& a, const ScaledVector& b, const ScaledVector& c) {
  std::array<WideExponent, 6> terms;
  int largest = std::numeric_limits<int>::min();
  for (int k = 0; k < 6; ++k) {
    const int axis = k % 3, step = k < 3 ? 1 : 2;
    const WideExponent &f = a[axis], &g = b[(axis + step) % 3], &h = c[(axis + 2 * step) % 3];
    terms[k] = {(k < 3 ? 1.0 : -1.0) * f.fraction * g.fraction * h.fraction,
                f.exponent + g.exponent + h.exponent};
    if (terms[k].fraction != 0.0) largest = std::max(largest, terms[k].exponent);
  }
  double sum = 0.0, permanent = 0.0;
  for (const WideExponent& term : terms) {
    if (term.fraction == 0.0) continue;
    const double value = std::scalbn(term.fraction, term.exponent - largest);
    sum += value;
    permanent += std::abs(value);
  }
  if (permanent == 0.0) return 0;  // every term has a factor that is exactly zero
  return std::abs(sum) > 0x1p-49 * permanent ? (sum > 0.0 ? 1 : -1) : kUncertain;
}

/// Divides each axis by the highest power of two that all three components share: the sign stays.
void strip_common_zeros(IntegerVector& a, IntegerVector& b, IntegerVector& c) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto low = static_cast<std::uint64_t>(a[axis] | b[axis] | c[axis]);
    const int zeros = low != 0 ? std::countr_zero(low) : 63;
    a[axis] >>= zeros, b[axis] >>= zeros, c[axis] >>= zeros;
  }
}

}  // namespace

int DifferenceDeterminant::wide_filter(Difference u, Difference v, Difference w,
                                       const FilteredDeterminant& det) const noexcept {
  // Coincident points need no arithmetic.
  if (is_zero(u) || is_zero(v) || is_zero(w)) return 0;
  const bool ordinary = det.absolute_error < det.relative_error && det.relative_error < 0x1p1000;
  if (ordinary) return kUncertain;
  const auto scaled = [&](Difference d) {
    const Vector3 &p = points_[d.p], &q = points_[d.q];
    return ScaledVector{wide_difference(q.x(), p.x()), wide_difference(q.y(), p.y()),
                        wide_difference(q.z(), p.z())};
  };
  return wide_filtered_sign(scaled(u), scaled(v), scaled(w));
}

int DifferenceDeterminant::unfiltered_sign(Difference u, Difference v, Difference w,
                                           const FilteredDeterminant& det) noexcept {
  const int sign = wide_filter(u, v, w, det);
  return sign != kUncertain ? sign : exact_sign(u, v, w);
}

void DifferenceDeterminant::prepare_integers() noexcept {
  integers_ready_ = integers_fit_ = true;
  // Each axis's unit, and whether all coordinates fit on it.
  std::array<std::array<Parts, 3>, kMaxPoints> parts;
  for (int axis = 0; axis < 3; ++axis) {
    int lowest = std::numeric_limits<int>::max(), top = std::numeric_limits<int>::min();
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Parts& c = parts[i][axis] = parts_of(points_[i](axis));
      if (c.mantissa == 0) continue;
      lowest = std::min(lowest, c.exponent);
      top = std::max(top, c.top());
    }
    const bool all_zero = top < lowest;
    unit_exponent_[axis] = all_zero ? 0 : lowest;
    integers_fit_ = integers_fit_ && (all_zero || top - lowest <= kFittingBits);
  }
  if (!integers_fit_) return;
  // The coordinates in these units.
  for (std::size_t i = 0; i < points_.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const Parts& c = parts[i][axis];
      integers_[i][axis] =
          c.mantissa == 0 ? 0
                          : c.sign * (static_cast<Int128>(c.mantissa) << (c.exponent - unit_exponent_[axis]));
    }
  }
  take_differences();
}

void DifferenceDeterminant::take_differences() noexcept {
  const IntegerVector first = integers_[0];
  std::array<std::uint64_t, 3> low_bits{};
  for (std::size_t i = 0; i < points_.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      integers_[i][axis] -= first[axis];
      low_bits[axis] |= static_cast<std::uint64_t>(integers_[i][axis]);
    }
  }
  // Dividing an axis by a power of two leaves the sign alone.
  are_narrow_ = true;
  for (int axis = 0; axis < 3; ++axis) {
    const int zeros = low_bits[axis] != 0 ? std::countr_zero(low_bits[axis]) : 63;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Int128 c = integers_[i][axis] >>= zeros;
      are_narrow_ = are_narrow_ && is_narrow(2 * c);
    }
  }
}

IntegerVector DifferenceDeterminant::integer_difference(Difference u) const {
  const IntegerVector &p = integers_[u.p], &q = integers_[u.q];
  return {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
}

int DifferenceDeterminant::exact_sign(Difference u, Difference v, Difference w) noexcept {
  if (!integers_ready_) prepare_integers();
  if (!integers_fit_) return exact_sign_any_span(u, v, w);
  IntegerVector a = integer_difference(u), b = integer_difference(v), c = integer_difference(w);
  if (!(is_narrow(a) && is_narrow(b) && is_narrow(c))) strip_common_zeros(a, b, c);
  return is_narrow(a) && is_narrow(b) && is_narrow(c) ? narrow_determinant_sign(a, b, c)
                                                      : wide_determinant_sign(a, b, c);
}

int DirectionSigns::unfiltered_sign(Difference w, const FilteredDeterminant& det) noexcept {
  if (is_ready_ && determinant_.integers_fit_) return compare<6>(height(w.q), height(w.p));
  const int sign = determinant_.wide_filter(u_, v_, w, det);
  if (sign != kUncertain) return sign;
  if (!is_ready_) prepare_direction();
  if (!determinant_.integers_fit_) return determinant_.exact_sign_any_span(u_, v_, w);
  return compare<6>(height(w.q), height(w.p));
}

void DirectionSigns::prepare_direction() noexcept {
  is_ready_ = true;
  if (!determinant_.integers_ready_) determinant_.prepare_integers();
  if (!determinant_.integers_fit_) return;
  const IntegerVector u = determinant_.integer_difference(u_), v = determinant_.integer_difference(v_);
  if (determinant_.are_narrow_)
    narrow_ = narrow_cross(u, v);
  else
    wide_ = wide_cross(u, v);
}

const DirectionSigns::Height& DirectionSigns::height(int point) noexcept {
  Height& out = heights_[point];
  if ((known_ >> point & 1) != 0) return out;
  known_ |= 1u << point;
  const IntegerVector& from_first = determinant_.integers_[point];
  if (!determinant_.are_narrow_) return out = wide_dot(from_first, wide_);
  const Int192 narrow = narrow_dot(from_first, narrow_);
  const std::uint64_t sign = narrow.high < 0 ? ~std::uint64_t{0} : 0;
  return out = {narrow.low,
                static_cast<std::uint64_t>(narrow.high),
                static_cast<std::uint64_t>(narrow.high >> 64),
                sign,
                sign,
                sign};
}

int DifferenceDeterminant::exact_sign_any_span(Difference u, Difference v, Difference w) const noexcept {
  const auto big = [&](Difference d) {
    BigVector out;
    for (int axis = 0; axis < 3; ++axis)
      out[axis] = difference(big_integer_of(points_[d.q](axis), unit_exponent_[axis]),
                             big_integer_of(points_[d.p](axis), unit_exponent_[axis]));
    return out;
  };
  const BigVector a = big(u), b = big(v), c = big(w);
  DeterminantInteger det;
  for (int axis = 0; axis < 3; ++axis) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    if (a[axis].sign == 0) continue;
    det = sum(det, product<kDeterminantLimbs>(a[axis], minor(b[next], c[last], b[last], c[next])));
  }
  return det.sign;
}

int DifferenceDeterminant::cross_sign(Difference u, Difference v, int axis) noexcept {
  const int next = (axis + 1) % 3, last = (axis + 2) % 3;
  const Vector3 f = rounded(u), g = rounded(v);
  const double positive = f(next) * g(last), negative = f(last) * g(next);
  // 4 roundings (two differences, a product, the subtraction): 8 u covers them as above; underflow 2 *
  // 2^-1075.
  const double error = 0x1p-50 * (std::abs(positive) + std::abs(negative)) + 0x1p-1000;
  const double value = positive - negative;
  if (std::abs(value) > error) return value > 0.0 ? 1 : -1;

  if (!integers_ready_) prepare_integers();
  if (integers_fit_) {
    const IntegerVector a = integer_difference(u), b = integer_difference(v);
    if (are_narrow_) return sign_of(a[next] * b[last] - a[last] * b[next]);
    return sign_of<4>(wide_minor(a[next], a[last], b[next], b[last]));
  }
  const auto component = [&](Difference d, int k) {
    return difference(big_integer_of(points_[d.q](k), unit_exponent_[k]),
                      big_integer_of(points_[d.p](k), unit_exponent_[k]));
  };
  return minor(component(u, next), component(v, last), component(u, last), component(v, next)).sign;
}

}  // namespace touchstone::numerics

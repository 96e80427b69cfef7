#include "contact_core/numerics/difference_determinant.hpp"

#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "contact_core/numerics/big_integer.hpp"

namespace touchstone::numerics {
namespace {

// Widths. A finite double is an integer below 2^2098 times 2^-1074, so 2098 bits hold any coordinate on a
// common exponent, 2099 a difference (33 limbs), 2 * 2099 + 1 a 2x2 minor (66 limbs), and 3 * 2099 + 3 bits =
// 6300 a determinant (99 limbs). product() may touch one limb more than the value needs.
constexpr int kDifferenceLimbs = 34;
constexpr int kMinorLimbs = 69;
constexpr int kDeterminantLimbs = 104;
using DifferenceInteger = BigInteger<kDifferenceLimbs>;
using MinorInteger = BigInteger<kMinorLimbs>;
using DeterminantInteger = BigInteger<kDeterminantLimbs>;

struct Parts {
  int sign;
  std::uint64_t mantissa;
  int exponent;  // of the mantissa's least significant bit
};

Parts parts_of(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  const int biased = static_cast<int>(bits >> 52 & 0x7ff);
  std::uint64_t mantissa = bits & 0xfffffffffffffULL;
  if (biased != 0) mantissa |= 1ULL << 52;
  return {bits >> 63 ? -1 : 1, mantissa, biased != 0 ? biased - 1075 : -1074};
}

DifferenceInteger integer_of(double value, int lowest_exponent) {
  const Parts parts = parts_of(value);
  DifferenceInteger out;
  if (parts.mantissa == 0) {  // has no lowest bit: nor has a set of nothing but zeros
    assign_shifted(out, parts.sign, 0, 0);
    return out;
  }
  // Trailing zero bits may lie below the common exponent, which is that of the lowest bit set in any
  // coordinate.
  const int shift = parts.exponent - lowest_exponent;
  if (shift < 0)
    assign_shifted(out, parts.sign, parts.mantissa >> -shift, 0);
  else
    assign_shifted(out, parts.sign, parts.mantissa, shift);
  return out;
}

int sign_of(double value) { return value > 0.0 ? 1 : value < 0.0 ? -1 : 0; }

MinorInteger minor(const DifferenceInteger& a, const DifferenceInteger& b, const DifferenceInteger& c,
                   const DifferenceInteger& d) {
  return difference(product<kMinorLimbs>(a, b), product<kMinorLimbs>(c, d));
}

}  // namespace

// Filter. Let u = 2^-53. Every computed difference is exact times (1 + d), |d| <= u; a term of the
// determinant is a product of three differences (3 roundings), two products (2) and at most three additions
// (3): 8 roundings, so the computed sum is within ((1 + u)^8 - 1) * permanent of the exact one; the computed
// permanent is low by at most the same factor. 16 u covers both. Underflow, in the products or in scaling
// (coordinates are at most 1, so factors are at most 2), adds at most 2^-1074 per rounding, magnified by at
// most 4: below 2^-1000 in all.
double determinant_error(double permanent) { return 0x1p-49 * permanent + 0x1p-1000; }

DifferenceDeterminant::DifferenceDeterminant(std::span<const Vector3> points)
    : count_(static_cast<int>(points.size())) {
  double largest = 0.0;
  for (int i = 0; i < count_; ++i) {
    points_[i] = points[i];
    for (int axis = 0; axis < 3; ++axis) largest = std::max(largest, std::abs(points[i](axis)));
  }
  // Powers of two. Ordinary magnitudes need none: squares and cubes of 2^+-64 are far from over- or
  // underflow, and the error bound's 2^-1000 is far below any determinant the filter could certify there.
  if (largest == 0.0 || (largest > 0x1p-64 && largest <= 1.0)) {
    scaled_ = points_;
    return;
  }
  const int exponent = -(std::ilogb(largest) + 1);
  const double factor_low = std::scalbn(1.0, exponent / 2),
               factor_high = std::scalbn(1.0, exponent - exponent / 2);
  for (int i = 0; i < count_; ++i) scaled_[i] = points_[i] * factor_low * factor_high;
}

void DifferenceDeterminant::prepare_exponent() {
  lowest_exponent_ = std::numeric_limits<int>::max();
  for (int i = 0; i < count_; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const Parts parts = parts_of(points_[i](axis));
      if (parts.mantissa != 0)
        lowest_exponent_ = std::min(lowest_exponent_, parts.exponent + std::countr_zero(parts.mantissa));
    }
  }
  exponent_known_ = true;
}

int DifferenceDeterminant::sign(Difference u, Difference v, Difference w) {
  const Vector3 a = scaled_[u.q] - scaled_[u.p], b = scaled_[v.q] - scaled_[v.p],
                c = scaled_[w.q] - scaled_[w.p];
  const double xp = b.y() * c.z(), xn = b.z() * c.y();
  const double yp = b.z() * c.x(), yn = b.x() * c.z();
  const double zp = b.x() * c.y(), zn = b.y() * c.x();
  const double det = (a.x() * (xp - xn) + a.y() * (yp - yn)) + a.z() * (zp - zn);
  const double permanent =
      (std::abs(a.x()) * (std::abs(xp) + std::abs(xn)) + std::abs(a.y()) * (std::abs(yp) + std::abs(yn))) +
      std::abs(a.z()) * (std::abs(zp) + std::abs(zn));
  if (std::abs(det) > determinant_error(permanent)) return sign_of(det);
  return exact_sign(u, v, w);
}

struct DifferenceDeterminant::Integers {
  std::array<DifferenceInteger, 3> component;

  Integers(const DifferenceDeterminant& of, Difference u) {
    for (int axis = 0; axis < 3; ++axis)
      component[axis] = difference(integer_of(of.points_[u.q](axis), of.lowest_exponent_),
                                   integer_of(of.points_[u.p](axis), of.lowest_exponent_));
  }
};

int DifferenceDeterminant::exact_sign(Difference u, Difference v, Difference w) {
  // A zero column needs no arithmetic: common where edges are parallel to an axis or vertices coincide.
  if (is_zero(u) || is_zero(v) || is_zero(w)) return 0;
  if (!exponent_known_) prepare_exponent();
  const Integers a(*this, u), b(*this, v), c(*this, w);
  DeterminantInteger det;
  for (int axis = 0; axis < 3; ++axis) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    if (a.component[axis].sign == 0) continue;
    det =
        sum(det, product<kDeterminantLimbs>(a.component[axis], minor(b.component[next], c.component[last],
                                                                     b.component[last], c.component[next])));
  }
  return det.sign;
}

int DifferenceDeterminant::cross_sign(Difference u, Difference v, int axis) {
  if (!exponent_known_) prepare_exponent();
  const Integers a(*this, u), b(*this, v);
  const int next = (axis + 1) % 3, last = (axis + 2) % 3;
  return minor(a.component[next], b.component[last], a.component[last], b.component[next]).sign;
}

int DifferenceDeterminant::component_sign(Difference u, int axis) const {
  const double p = points_[u.p](axis), q = points_[u.q](axis);
  return q > p ? 1 : q < p ? -1 : 0;
}

bool DifferenceDeterminant::is_zero(Difference u) const { return points_[u.p] == points_[u.q]; }

}  // namespace touchstone::numerics

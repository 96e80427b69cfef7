#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "touchstone/contact_core/geometry/fixed_integer.hpp"

// Signed integers of a fixed capacity, on the stack: what decides a sign when a floating-point filter cannot.
// Only the limbs in use are touched, so ordinary inputs (a few limbs) stay cheap whatever the capacity.

namespace touchstone::numerics {

template <int Capacity>
struct BigInteger {
  int sign = 0;                              ///< -1, 0, +1
  int size = 0;                              ///< limbs in use; 0 for zero, otherwise limb[size - 1] != 0
  std::array<std::uint64_t, Capacity> limb;  ///< magnitude, least significant first

  BigInteger() {}  // limbs stay unset: zeroing them would cost more than most additions
  BigInteger(const BigInteger& other) : sign(other.sign), size(other.size) {
    std::copy_n(other.limb.begin(), size, limb.begin());
  }
  BigInteger& operator=(const BigInteger& other) {
    sign = other.sign;
    size = other.size;
    std::copy_n(other.limb.begin(), size, limb.begin());
    return *this;
  }
};

/// sign * mantissa * 2^shift.
template <int Capacity>
void assign_shifted(BigInteger<Capacity>& out, int sign, std::uint64_t mantissa, int shift) {
  out.sign = mantissa == 0 ? 0 : sign;
  out.size = 0;
  if (mantissa == 0) return;
  const int whole = shift / 64;
  const int part = shift % 64;
  for (int i = 0; i < whole; ++i) out.limb[i] = 0;
  out.limb[whole] = mantissa << part;
  out.size = whole + 1;
  if (part != 0 && mantissa >> (64 - part) != 0) out.limb[out.size++] = mantissa >> (64 - part);
}

template <int N, int M>
int compare_magnitude(const BigInteger<N>& a, const BigInteger<M>& b) {
  if (a.size != b.size) return a.size < b.size ? -1 : 1;
  for (int i = a.size; i-- > 0;)
    if (a.limb[i] != b.limb[i]) return a.limb[i] < b.limb[i] ? -1 : 1;
  return 0;
}

template <int N>
void add_magnitude(const BigInteger<N>& a, const BigInteger<N>& b, BigInteger<N>& out) {
  const BigInteger<N>& large = a.size >= b.size ? a : b;
  const BigInteger<N>& small = a.size >= b.size ? b : a;
  Uint128 carry = 0;
  for (int i = 0; i < large.size; ++i) {
    carry += large.limb[i];
    if (i < small.size) carry += small.limb[i];
    out.limb[i] = static_cast<std::uint64_t>(carry);
    carry >>= 64;
  }
  out.size = large.size;
  if (carry != 0) out.limb[out.size++] = static_cast<std::uint64_t>(carry);
}

/// @pre |a| > |b|
template <int N>
void subtract_magnitude(const BigInteger<N>& a, const BigInteger<N>& b, BigInteger<N>& out) {
  std::uint64_t borrow = 0;
  for (int i = 0; i < a.size; ++i) {
    const Uint128 taken = static_cast<Uint128>(i < b.size ? b.limb[i] : 0) + borrow;
    borrow = a.limb[i] < taken ? 1 : 0;
    out.limb[i] = a.limb[i] - static_cast<std::uint64_t>(taken);
  }
  out.size = a.size;
  while (out.size > 0 && out.limb[out.size - 1] == 0) --out.size;
}

/// a + sign_of_b * b. @pre Capacity holds one bit more than the larger of the two.
template <int N>
BigInteger<N> sum(const BigInteger<N>& a, const BigInteger<N>& b, int sign_of_b = 1) {
  BigInteger<N> out;
  const int b_sign = b.sign * sign_of_b;
  if (a.sign == 0 || b_sign == 0) {
    out = a.sign == 0 ? b : a;
    out.sign = a.sign == 0 ? b_sign : a.sign;
  } else if (a.sign == b_sign) {
    add_magnitude(a, b, out);
    out.sign = a.sign;
  } else {
    const int order = compare_magnitude(a, b);
    if (order > 0) {
      subtract_magnitude(a, b, out);
      out.sign = a.sign;
    } else if (order < 0) {
      subtract_magnitude(b, a, out);
      out.sign = b_sign;
    }
  }
  return out;
}

template <int N>
BigInteger<N> difference(const BigInteger<N>& a, const BigInteger<N>& b) {
  return sum(a, b, -1);
}

template <int Out, int N, int M>
BigInteger<Out> product(const BigInteger<N>& a, const BigInteger<M>& b) {
  BigInteger<Out> out;
  out.sign = a.sign * b.sign;
  if (out.sign == 0) return out;
  out.size = a.size + b.size;
  std::fill_n(out.limb.begin(), out.size, 0);
  for (int i = 0; i < a.size; ++i) {
    Uint128 carry = 0;
    for (int j = 0; j < b.size; ++j) {
      carry += static_cast<Uint128>(a.limb[i]) * b.limb[j] + out.limb[i + j];
      out.limb[i + j] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    out.limb[i + b.size] = static_cast<std::uint64_t>(carry);
  }
  while (out.limb[out.size - 1] == 0) --out.size;
  return out;
}

}  // namespace touchstone::numerics

#pragma once

#include <array>
#include <cstdint>

// Signs of 3x3 determinants of machine integers, without overflow: what decides most of the cases that a
// floating-point filter cannot.

namespace touchstone::numerics {

__extension__ typedef __int128 Int128;
__extension__ typedef unsigned __int128 Uint128;

inline int sign_of(Int128 value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

/// Columns of a determinant, or vectors, of integer components.
using IntegerVector = std::array<Int128, 3>;

/// True if |value| < 2^61.
inline bool is_narrow(Int128 value) { return value >> 61 == 0 || value >> 61 == -1; }

inline bool is_narrow(const IntegerVector& v) {
  return is_narrow(v[0]) && is_narrow(v[1]) && is_narrow(v[2]);
}

/// b x c. @pre is_narrow() both: products are below 2^122, so components below 2^123.
inline IntegerVector narrow_cross(const IntegerVector& b, const IntegerVector& c) {
  IntegerVector out;
  for (int axis = 0; axis < 3; ++axis) {
    const int next = axis == 2 ? 0 : axis + 1, last = axis == 0 ? 2 : axis - 1;
    const auto product = [](Int128 x, Int128 y) {
      return static_cast<Int128>(static_cast<std::int64_t>(x)) * static_cast<std::int64_t>(y);
    };
    out[axis] = product(b[next], c[last]) - product(b[last], c[next]);
  }
  return out;
}

/// high * 2^64 + low.
struct Int192 {
  Int128 high;
  std::uint64_t low;
};

/// a . n. @pre is_narrow(a), components m of n below 2^123.
/// With m = high * 2^64 + low, 0 <= low < 2^64, the sum of a * low is below 3 * 2^125 and that of a * high
/// below 3 * 2^120: both fit.
inline Int192 narrow_dot(const IntegerVector& a, const IntegerVector& n) {
  Int128 high = 0, low = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto component = static_cast<std::int64_t>(a[axis]);
    high += static_cast<Int128>(component) * static_cast<std::int64_t>(n[axis] >> 64);
    low += static_cast<Int128>(component) * static_cast<std::uint64_t>(n[axis]);
  }
  return {high + (low >> 64), static_cast<std::uint64_t>(low)};
}

/// Sign of det[a b c]. @pre is_narrow() all.
inline int narrow_determinant_sign(const IntegerVector& a, const IntegerVector& b, const IntegerVector& c) {
  const Int192 det = narrow_dot(a, narrow_cross(b, c));
  return det.high != 0 ? sign_of(det.high) : det.low != 0 ? 1 : 0;
}

/// A two's complement integer of N 64-bit limbs, least significant first.
template <int N>
using Limbs = std::array<std::uint64_t, N>;

template <int N>
bool is_negative(const Limbs<N>& a) {
  return a[N - 1] >> 63 != 0;
}

/// sum += a, or -= a.
template <int N>
void accumulate(Limbs<N>& sum, const Limbs<N>& a, bool subtract) {
  const std::uint64_t flip = subtract ? ~std::uint64_t{0} : 0;
  Uint128 carry = subtract ? 1 : 0;
  for (int i = 0; i < N; ++i) {
    carry += static_cast<Uint128>(sum[i]) + (a[i] ^ flip);
    sum[i] = static_cast<std::uint64_t>(carry);
    carry >>= 64;
  }
}

template <int N, int M>
Limbs<N + M> unsigned_product(const Limbs<N>& a, const Limbs<M>& b) {
  Limbs<N + M> out{};
  for (int i = 0; i < N; ++i) {
    Uint128 carry = 0;
    for (int j = 0; j < M; ++j) {
      carry += static_cast<Uint128>(a[i]) * b[j] + out[i + j];
      out[i + j] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    out[i + M] = static_cast<std::uint64_t>(carry);
  }
  return out;
}

inline Limbs<2> magnitude(Int128 value) {
  const Uint128 m = value < 0 ? -static_cast<Uint128>(value) : static_cast<Uint128>(value);
  return {static_cast<std::uint64_t>(m), static_cast<std::uint64_t>(m >> 64)};
}

/// a d - b c. @pre magnitudes below 2^126: the result is below 2^253.
inline Limbs<4> wide_minor(Int128 a, Int128 b, Int128 c, Int128 d) {
  Limbs<4> out{};
  accumulate<4>(out, unsigned_product<2, 2>(magnitude(a), magnitude(d)), (a < 0) != (d < 0));
  accumulate<4>(out, unsigned_product<2, 2>(magnitude(b), magnitude(c)), (b < 0) == (c < 0));
  return out;
}

template <int N>
int sign_of(const Limbs<N>& value) {
  if (is_negative<N>(value)) return -1;
  for (const std::uint64_t limb : value)
    if (limb != 0) return 1;
  return 0;
}

/// Sign of a - b.
template <int N>
int compare(const Limbs<N>& a, const Limbs<N>& b) {
  const auto a_top = static_cast<std::int64_t>(a[N - 1]), b_top = static_cast<std::int64_t>(b[N - 1]);
  if (a_top != b_top) return a_top > b_top ? 1 : -1;
  for (int i = N - 2; i >= 0; --i)
    if (a[i] != b[i]) return a[i] > b[i] ? 1 : -1;
  return 0;
}

/// A vector of integers below 2^253, as magnitudes and signs.
struct WideVector {
  std::array<Limbs<4>, 3> magnitude;
  std::array<bool, 3> negative;
};

/// b x c. @pre magnitudes below 2^126.
inline WideVector wide_cross(const IntegerVector& b, const IntegerVector& c) {
  WideVector out{};
  for (int axis = 0; axis < 3; ++axis) {
    const int next = axis == 2 ? 0 : axis + 1, last = axis == 0 ? 2 : axis - 1;
    const Limbs<4> minor = wide_minor(b[next], b[last], c[next], c[last]);
    out.negative[axis] = is_negative<4>(minor);
    accumulate<4>(out.magnitude[axis], minor, out.negative[axis]);
  }
  return out;
}

/// a . n. @pre magnitudes of a below 2^126: the sum is below 3 * 2^379, and 384 bits hold it.
inline Limbs<6> wide_dot(const IntegerVector& a, const WideVector& n) {
  Limbs<6> out{};
  for (int axis = 0; axis < 3; ++axis)
    accumulate<6>(out, unsigned_product<4, 2>(n.magnitude[axis], magnitude(a[axis])),
                  n.negative[axis] != (a[axis] < 0));
  return out;
}

/// Sign of det[a b c]. @pre magnitudes below 2^126.
inline int wide_determinant_sign(const IntegerVector& a, const IntegerVector& b, const IntegerVector& c) {
  return sign_of<6>(wide_dot(a, wide_cross(b, c)));
}

}  // namespace touchstone::numerics

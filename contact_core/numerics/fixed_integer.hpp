#pragma once

#include <array>
#include <cstdint>

#include "contact_core/numerics/big_integer.hpp"

// Signed integers of a fixed, small number of limbs: determinants of coordinates that span at most 125 bits,
// where BigInteger's bookkeeping would cost several times the arithmetic.

namespace touchstone::numerics {

__extension__ typedef __int128 Int128;

/// Two's complement, least significant limb first.
template <int N>
struct FixedInteger {
  std::array<std::uint64_t, N> limb{};

  bool is_negative() const { return limb[N - 1] >> 63 != 0; }
  int sign() const {
    if (is_negative()) return -1;
    std::uint64_t any = 0;
    for (std::uint64_t l : limb) any |= l;
    return any != 0 ? 1 : 0;
  }
};

template <int N>
FixedInteger<N> add(const FixedInteger<N>& a, const FixedInteger<N>& b, bool negate_b = false) {
  FixedInteger<N> out;
  const std::uint64_t flip = negate_b ? ~std::uint64_t{0} : 0;
  Uint128 carry = negate_b ? 1 : 0;
  for (int i = 0; i < N; ++i) {
    carry += a.limb[i];
    carry += b.limb[i] ^ flip;
    out.limb[i] = static_cast<std::uint64_t>(carry);
    carry >>= 64;
  }
  return out;
}

inline FixedInteger<2> fixed(Int128 value) {
  const auto bits = static_cast<Uint128>(value);
  return {{static_cast<std::uint64_t>(bits), static_cast<std::uint64_t>(bits >> 64)}};
}

/// Never overflows: |a| <= 2^(64 N - 1), |b| <= 2^(64 M - 1).
template <int N, int M>
FixedInteger<N + M> product(const FixedInteger<N>& a, const FixedInteger<M>& b) {
  const FixedInteger<N> p = a.is_negative() ? add(FixedInteger<N>{}, a, true) : a;
  const FixedInteger<M> q = b.is_negative() ? add(FixedInteger<M>{}, b, true) : b;
  FixedInteger<N + M> out;
  for (int i = 0; i < N; ++i) {
    std::uint64_t carry = 0;
    for (int j = 0; j < M; ++j) {
      const Uint128 t = static_cast<Uint128>(p.limb[i]) * q.limb[j] + out.limb[i + j] + carry;
      out.limb[i + j] = static_cast<std::uint64_t>(t);
      carry = static_cast<std::uint64_t>(t >> 64);
    }
    out.limb[i + M] = carry;
  }
  return a.is_negative() != b.is_negative() ? add(FixedInteger<N + M>{}, out, true) : out;
}

}  // namespace touchstone::numerics

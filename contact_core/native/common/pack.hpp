#pragma once

#include <cstddef>
#include <cstdint>
#if defined(__SSE2__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

// Vectors of doubles through the compiler's vector types: two lanes, and functions of any number of lanes.
// TOUCHSTONE_ISA names the namespace: code compiled for one instruction set must not be linked into another.
// kernels_<isa>.cpp defines it (simd/pack.hpp adds wider packs), common/lanes.hpp defines it as `baseline`.
// For the same reason nothing here or in the kernels uses Eigen or the standard library.

#define TOUCHSTONE_INLINE [[gnu::always_inline]] inline

namespace touchstone::native::TOUCHSTONE_ISA {

typedef double Double2 __attribute__((vector_size(16)));
typedef long long Mask2 __attribute__((vector_size(16)));  // a comparison's: all bits of a lane, or none

template <class Pack>
struct Traits;
template <>
struct Traits<Double2> {
  using Mask = Mask2;
  static constexpr int lanes = 2;
};
template <class Pack>
using MaskOf = typename Traits<Pack>::Mask;

/// x - 0 is x, the zero's sign included (0 + x is not, for -0), and compilers know it.
template <class Pack>
TOUCHSTONE_INLINE Pack all(double value) {
  return value - Pack{};
}

template <class Pack>
TOUCHSTONE_INLINE Pack load(const double* from) {
  Pack out;
  __builtin_memcpy(&out, from, sizeof out);
  return out;
}

template <class Pack>
TOUCHSTONE_INLINE void store(const Pack& from, double* to) {
  __builtin_memcpy(to, &from, sizeof from);
}

template <class Pack>
TOUCHSTONE_INLINE Pack magnitude(Pack p) {
  using Mask = MaskOf<Pack>;
  return (Pack)((Mask)p & (Mask{} + 0x7fff'ffff'ffff'ffffLL));  // all(-0.0) is +0.0
}

/// The second where they are equal or one is no number, as the machine's minimum and maximum have it.
template <class Pack>
TOUCHSTONE_INLINE Pack least(Pack p, Pack q) {
  return p < q ? p : q;
}
template <class Pack>
TOUCHSTONE_INLINE Pack greatest(Pack p, Pack q) {
  return p > q ? p : q;
}

/// Bit i: lane i is set.
TOUCHSTONE_INLINE unsigned bits(Mask2 mask) {
#if defined(__SSE2__)
  return static_cast<unsigned>(_mm_movemask_pd((__m128d)mask));
#else
  return static_cast<unsigned>(mask[0] & 1) | static_cast<unsigned>(mask[1] & 2);
#endif
}

TOUCHSTONE_INLINE Double2 square_root(Double2 p) {
#if defined(__SSE2__)
  return (Double2)_mm_sqrt_pd((__m128d)p);
#elif defined(__aarch64__)
  return (Double2)vsqrtq_f64((float64x2_t)p);
#else
  return Double2{__builtin_sqrt(p[0]), __builtin_sqrt(p[1])};
#endif
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

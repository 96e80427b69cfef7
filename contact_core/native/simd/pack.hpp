#pragma once

#include "touchstone/contact_core/native/common/pack.hpp"

// Packs of four and eight lanes, and vectors of packs. Included by kernels_<isa>.cpp only.

namespace touchstone::native::TOUCHSTONE_ISA {

typedef double Double4 __attribute__((vector_size(32)));
typedef double Double8 __attribute__((vector_size(64)));
typedef long long Mask4 __attribute__((vector_size(32)));
typedef long long Mask8 __attribute__((vector_size(64)));

/// u: the largest relative error of one rounding.
constexpr double kU = 0x1p-53;

template <>
struct Traits<Double4> {
  using Mask = Mask4;
  static constexpr int lanes = 4;
};
template <>
struct Traits<Double8> {
  using Mask = Mask8;
  static constexpr int lanes = 8;
};

template <class Pack>
TOUCHSTONE_INLINE Pack select(MaskOf<Pack> where, Pack then, Pack otherwise) {
  return where ? then : otherwise;
}

TOUCHSTONE_INLINE unsigned bits(Mask4 mask) {
#if defined(__AVX2__)
  return static_cast<unsigned>(_mm256_movemask_pd((__m256d)mask));
#else
  return bits(__builtin_shufflevector(mask, mask, 0, 1)) | bits(__builtin_shufflevector(mask, mask, 2, 3))
                                                               << 2;
#endif
}

TOUCHSTONE_INLINE unsigned bits(Mask8 mask) {
#if defined(__AVX512DQ__)
  return _mm512_movepi64_mask((__m512i)mask);
#else
  return bits(__builtin_shufflevector(mask, mask, 0, 1, 2, 3)) |
         bits(__builtin_shufflevector(mask, mask, 4, 5, 6, 7)) << 4;
#endif
}

TOUCHSTONE_INLINE Double4 square_root(Double4 p) {
#if defined(__AVX2__)
  return (Double4)_mm256_sqrt_pd((__m256d)p);
#else
  const Double2 low = square_root(__builtin_shufflevector(p, p, 0, 1));
  const Double2 high = square_root(__builtin_shufflevector(p, p, 2, 3));
  return __builtin_shufflevector(low, high, 0, 1, 2, 3);
#endif
}

TOUCHSTONE_INLINE Double8 square_root(Double8 p) {
#if defined(__AVX512F__)
  return (Double8)_mm512_maskz_sqrt_pd(0xff, (__m512d)p);  // the plain form warns in g++ 12
#else
  const Double4 low = square_root(__builtin_shufflevector(p, p, 0, 1, 2, 3));
  const Double4 high = square_root(__builtin_shufflevector(p, p, 4, 5, 6, 7));
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#endif
}

// ---- Gather: lane l of out[k] is from[l][k].

TOUCHSTONE_INLINE void transpose(const double* const (&from)[2], Double2 (&out)[4]) {
  for (int half = 0; half < 2; ++half) {
    const Double2 p = load<Double2>(from[0] + 2 * half), q = load<Double2>(from[1] + 2 * half);
    out[2 * half] = __builtin_shufflevector(p, q, 0, 2);
    out[2 * half + 1] = __builtin_shufflevector(p, q, 1, 3);
  }
}

TOUCHSTONE_INLINE void transpose(const double* const (&from)[4], Double4 (&out)[4]) {
  const Double4 p = load<Double4>(from[0]), q = load<Double4>(from[1]), r = load<Double4>(from[2]),
                s = load<Double4>(from[3]);
  const Double4 pq_even = __builtin_shufflevector(p, q, 0, 4, 2, 6);
  const Double4 pq_odd = __builtin_shufflevector(p, q, 1, 5, 3, 7);
  const Double4 rs_even = __builtin_shufflevector(r, s, 0, 4, 2, 6);
  const Double4 rs_odd = __builtin_shufflevector(r, s, 1, 5, 3, 7);
  out[0] = __builtin_shufflevector(pq_even, rs_even, 0, 1, 4, 5);
  out[1] = __builtin_shufflevector(pq_odd, rs_odd, 0, 1, 4, 5);
  out[2] = __builtin_shufflevector(pq_even, rs_even, 2, 3, 6, 7);
  out[3] = __builtin_shufflevector(pq_odd, rs_odd, 2, 3, 6, 7);
}

TOUCHSTONE_INLINE void transpose(const double* const (&from)[8], Double8 (&out)[4]) {
  const double* const low_from[4] = {from[0], from[1], from[2], from[3]};
  const double* const high_from[4] = {from[4], from[5], from[6], from[7]};
  Double4 low[4], high[4];
  transpose(low_from, low);
  transpose(high_from, high);
  for (int k = 0; k < 4; ++k) out[k] = __builtin_shufflevector(low[k], high[k], 0, 1, 2, 3, 4, 5, 6, 7);
}

/// `count` doubles, a multiple of four, of each lane's record.
template <class Pack, int count>
TOUCHSTONE_INLINE void gather(const double* const (&from)[Traits<Pack>::lanes], Pack (&out)[count]) {
  static_assert(count % 4 == 0);
  for (int first = 0; first < count; first += 4) {
    const double* part[Traits<Pack>::lanes];
    for (int l = 0; l < Traits<Pack>::lanes; ++l) part[l] = from[l] + first;
    Pack four[4];
    transpose(part, four);
    for (int k = 0; k < 4; ++k) out[first + k] = four[k];
  }
}

// ---- Scatter: out[l][k] is lane l of in[k].

TOUCHSTONE_INLINE void scatter(const Double2 (&in)[4], double* const (&out)[2]) {
  for (int half = 0; half < 2; ++half) {
    const Double2 p = in[2 * half], q = in[2 * half + 1];
    store(__builtin_shufflevector(p, q, 0, 2), out[0] + 2 * half);
    store(__builtin_shufflevector(p, q, 1, 3), out[1] + 2 * half);
  }
}

TOUCHSTONE_INLINE void scatter(const Double4 (&in)[4], double* const (&out)[4]) {
  const Double4 xy_even = __builtin_shufflevector(in[0], in[1], 0, 4, 2, 6);
  const Double4 xy_odd = __builtin_shufflevector(in[0], in[1], 1, 5, 3, 7);
  const Double4 zw_even = __builtin_shufflevector(in[2], in[3], 0, 4, 2, 6);
  const Double4 zw_odd = __builtin_shufflevector(in[2], in[3], 1, 5, 3, 7);
  store(__builtin_shufflevector(xy_even, zw_even, 0, 1, 4, 5), out[0]);
  store(__builtin_shufflevector(xy_odd, zw_odd, 0, 1, 4, 5), out[1]);
  store(__builtin_shufflevector(xy_even, zw_even, 2, 3, 6, 7), out[2]);
  store(__builtin_shufflevector(xy_odd, zw_odd, 2, 3, 6, 7), out[3]);
}

TOUCHSTONE_INLINE void scatter(const Double8 (&in)[4], double* const (&out)[8]) {
  Double4 low[4], high[4];
  for (int k = 0; k < 4; ++k) {
    low[k] = __builtin_shufflevector(in[k], in[k], 0, 1, 2, 3);
    high[k] = __builtin_shufflevector(in[k], in[k], 4, 5, 6, 7);
  }
  double* const low_out[4] = {out[0], out[1], out[2], out[3]};
  double* const high_out[4] = {out[4], out[5], out[6], out[7]};
  scatter(low, low_out);
  scatter(high, high_out);
}

// ---- Vectors of packs

template <class Pack>
struct Vector3Of {
  Pack x, y, z;
};

template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> operator-(const Vector3Of<Pack>& p, const Vector3Of<Pack>& q) {
  return {p.x - q.x, p.y - q.y, p.z - q.z};
}
template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> operator+(const Vector3Of<Pack>& p, const Vector3Of<Pack>& q) {
  return {p.x + q.x, p.y + q.y, p.z + q.z};
}
template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> operator*(const Pack& s, const Vector3Of<Pack>& p) {
  return {s * p.x, s * p.y, s * p.z};
}
template <class Pack>
TOUCHSTONE_INLINE Pack dot(const Vector3Of<Pack>& p, const Vector3Of<Pack>& q) {
  return (p.x * q.x + p.y * q.y) + p.z * q.z;
}
template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> cross(const Vector3Of<Pack>& p, const Vector3Of<Pack>& q) {
  return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
}
template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> select(MaskOf<Pack> where, const Vector3Of<Pack>& then,
                                         const Vector3Of<Pack>& otherwise) {
  return {select(where, then.x, otherwise.x), select(where, then.y, otherwise.y),
          select(where, then.z, otherwise.z)};
}
/// The 1-norm and the largest magnitude.
template <class Pack>
TOUCHSTONE_INLINE Pack sum(const Vector3Of<Pack>& p) {
  return (magnitude(p.x) + magnitude(p.y)) + magnitude(p.z);
}
template <class Pack>
TOUCHSTONE_INLINE Pack largest(const Vector3Of<Pack>& p) {
  return greatest(greatest(magnitude(p.x), magnitude(p.y)), magnitude(p.z));
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

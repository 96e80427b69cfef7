#pragma once

#include "touchstone/contact_core/native/simd/pack.hpp"

// Products of doubles without their rounding, in lanes: by fused multiplication where the instruction set has
// it, else by splitting (Dekker 1971). Both find the same bits below 2^996, where splitting overflows: what
// rounding took from a product is a double where the product is at least kLeastProduct, and counts as 0
// below.

namespace touchstone::native::TOUCHSTONE_ISA {

/// high + low; see double_double.hpp, also for the steps below.
template <class Pack>
struct Wide {
  Pack high, low;
};

template <class Pack>
TOUCHSTONE_INLINE Wide<Pack> exact_sum(Pack x, Pack y) {
  const Pack sum = x + y;
  const Pack y_part = sum - x;
  return {sum, (x - (sum - y_part)) + (y - y_part)};
}

/// The last bit of x y is 2^-105 of it at least: of products from here on no double is too small for it.
constexpr double kLeastProduct = 0x1p-960;

/// x y - product, product = x y rounded.
#if defined(__FMA__)
TOUCHSTONE_INLINE Double2 product_error(Double2 x, Double2 y, Double2 product) {
  return (Double2)_mm_fmsub_pd((__m128d)x, (__m128d)y, (__m128d)product);
}
TOUCHSTONE_INLINE Double4 product_error(Double4 x, Double4 y, Double4 product) {
  return (Double4)_mm256_fmsub_pd((__m256d)x, (__m256d)y, (__m256d)product);
}
#if defined(__AVX512F__)
TOUCHSTONE_INLINE Double8 product_error(Double8 x, Double8 y, Double8 product) {
  return (Double8)_mm512_fmsub_pd((__m512d)x, (__m512d)y, (__m512d)product);
}
#endif
#else
template <class Pack>
TOUCHSTONE_INLINE Pack product_error(Pack x, Pack y, Pack product) {
  const Pack splitter = all<Pack>(0x1p27 + 1.0);
  const Pack tx = splitter * x, ty = splitter * y;
  const Pack xh = tx - (tx - x), yh = ty - (ty - y);
  const Pack xl = x - xh, yl = y - yh;
  return ((xh * yh - product) + xh * yl + xl * yh) + xl * yl;
}
#endif

/// x y exactly, where at least kLeastProduct.
template <class Pack>
TOUCHSTONE_INLINE Wide<Pack> exact_product(Pack x, Pack y) {
  const Pack product = x * y;
  const MaskOf<Pack> counts = magnitude(product) >= all<Pack>(kLeastProduct);
  return {product, (Pack)(counts & (MaskOf<Pack>)product_error(x, y, product))};
}

/// To 8 u^2 |x y|: 2 u^2 of it by each product with a low part and their sum, 3 u^2 by adding that to the
/// product's own error, u^2 by the low parts' product, left out. Low parts are u of high ones at most.
template <class Pack>
TOUCHSTONE_INLINE Wide<Pack> operator*(const Wide<Pack>& x, const Wide<Pack>& y) {
  const Wide<Pack> product = exact_product(x.high, y.high);
  return exact_sum(product.high, product.low + (x.high * y.low + x.low * y.high));
}

/// To 4 u^2 |x y|: u^2 by the low part's product, 2 u^2 by adding that to the high one's error.
template <class Pack>
TOUCHSTONE_INLINE Wide<Pack> operator*(const Wide<Pack>& x, Pack y) {
  const Wide<Pack> product = exact_product(x.high, y);
  return exact_sum(product.high, product.low + x.low * y);
}

/// To 3 u^2 (|x| + |y|): u^2 by the low parts' sum, 2 u^2 by adding that to the error of the high ones'.
template <class Pack>
TOUCHSTONE_INLINE Wide<Pack> operator+(const Wide<Pack>& x, const Wide<Pack>& y) {
  const Wide<Pack> sum = exact_sum(x.high, y.high);
  return exact_sum(sum.high, sum.low + (x.low + y.low));
}

template <class Pack>
TOUCHSTONE_INLINE Wide<Pack> operator-(const Wide<Pack>& x, const Wide<Pack>& y) {
  return x + Wide<Pack>{-y.high, -y.low};
}

template <class Pack>
struct WideVector {
  Wide<Pack> x, y, z;

  TOUCHSTONE_INLINE Vector3Of<Pack> high() const { return {x.high, y.high, z.high}; }
};

/// Exact.
template <class Pack>
TOUCHSTONE_INLINE WideVector<Pack> wide_difference(const Vector3Of<Pack>& p, const Vector3Of<Pack>& q) {
  return {exact_sum(p.x, -q.x), exact_sum(p.y, -q.y), exact_sum(p.z, -q.z)};
}

template <class Pack>
TOUCHSTONE_INLINE WideVector<Pack> cross(const WideVector<Pack>& p, const WideVector<Pack>& q) {
  return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
}

template <class Pack>
TOUCHSTONE_INLINE WideVector<Pack> operator+(const WideVector<Pack>& p, const WideVector<Pack>& q) {
  return {p.x + q.x, p.y + q.y, p.z + q.z};
}

template <class Pack>
TOUCHSTONE_INLINE WideVector<Pack> operator*(const WideVector<Pack>& p, Pack s) {
  return {p.x * s, p.y * s, p.z * s};
}

template <class Pack>
TOUCHSTONE_INLINE Wide<Pack> dot(const WideVector<Pack>& p, const WideVector<Pack>& q) {
  return (p.x * q.x + p.y * q.y) + p.z * q.z;
}

/// p x - q y to about one rounding, however much cancels.
template <class Pack>
TOUCHSTONE_INLINE Pack difference_of_products(Pack p, Pack x, Pack q, Pack y) {
  const Wide<Pack> px = exact_product(p, x), qy = exact_product(q, y);
  const Wide<Pack> difference = exact_sum(px.high, -qy.high);
  return difference.high + (difference.low + (px.low - qy.low));
}

/// Right to 2 u of each component, however small the angle.
template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> accurate_cross(const Vector3Of<Pack>& p, const Vector3Of<Pack>& q) {
  return {difference_of_products(p.y, q.z, p.z, q.y), difference_of_products(p.z, q.x, p.x, q.z),
          difference_of_products(p.x, q.y, p.y, q.x)};
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

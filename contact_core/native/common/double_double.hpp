#pragma once

#include "touchstone/contact_core/geometry/vector.hpp"

// Unevaluated sums of two doubles, about 104 bits (Dekker 1971; Knuth's two-sum). No FMA, so the bits are the
// same everywhere. Range: magnitudes within about [2^-400, 2^400], which the native check's scaling
// guarantees.

namespace touchstone::native {

/// @tparam T double, or lanes of doubles.
template <class T>
struct DoubleDoubleOf {
  T high{};
  T low{};
};
using DoubleDouble = DoubleDoubleOf<double>;

template <class T>
inline DoubleDoubleOf<T> two_sum(T x, T y) {
  const T sum = x + y;
  const T y_part = sum - x;
  return {sum, (x - (sum - y_part)) + (y - y_part)};
}

template <class T>
inline DoubleDoubleOf<T> two_product(T x, T y) {
  constexpr double kSplitter = 0x1p27 + 1.0;
  const T tx = kSplitter * x, ty = kSplitter * y;
  const T xh = tx - (tx - x), yh = ty - (ty - y);
  const T xl = x - xh, yl = y - yh;
  const T product = x * y;
  return {product, ((xh * yh - product) + xh * yl + xl * yh) + xl * yl};
}

template <class T>
inline DoubleDoubleOf<T> operator+(DoubleDoubleOf<T> x, DoubleDoubleOf<T> y) {
  const DoubleDoubleOf<T> high = two_sum(x.high, y.high);
  const DoubleDoubleOf<T> low = two_sum(x.low, y.low);
  const DoubleDoubleOf<T> first = two_sum(high.high, high.low + low.high);
  return two_sum(first.high, first.low + low.low);
}

inline DoubleDouble operator-(DoubleDouble x) { return {-x.high, -x.low}; }
inline DoubleDouble operator-(DoubleDouble x, DoubleDouble y) { return x + (-y); }

template <class T>
inline DoubleDoubleOf<T> operator*(DoubleDoubleOf<T> x, DoubleDoubleOf<T> y) {
  DoubleDoubleOf<T> p = two_product(x.high, y.high);
  p.low += x.high * y.low + x.low * y.high;
  return two_sum(p.high, p.low);
}

inline DoubleDouble operator/(DoubleDouble x, DoubleDouble y) {
  const double first = x.high / y.high;
  const DoubleDouble rest = x - y * DoubleDouble{first, 0.0};
  const double second = rest.high / y.high;
  const DoubleDouble last = rest - y * DoubleDouble{second, 0.0};
  return two_sum(first, second) + DoubleDouble{last.high / y.high, 0.0};
}

using touchstone::cross;
using touchstone::dot;

/// p x - q y (difference of products) to about one rounding, however much cancels.
inline double difference_of_products(double p, double x, double q, double y) {
  return (two_product(p, x) - two_product(q, y)).high;
}

/// u x v with each component right to about one rounding.
inline Vector3 accurate_cross(const Vector3& u, const Vector3& v) {
  return {difference_of_products(u.y(), v.z(), u.z(), v.y()),
          difference_of_products(u.z(), v.x(), u.x(), v.z()),
          difference_of_products(u.x(), v.y(), u.y(), v.x())};
}

struct DoubleDouble3 {
  DoubleDouble x, y, z;

  Vector3 rounded() const { return {x.high, y.high, z.high}; }
};

/// Exact but for the sum's second rounding.
inline DoubleDouble3 difference(const Vector3& p, const Vector3& q) {
  return {two_sum(p.x(), -q.x()), two_sum(p.y(), -q.y()), two_sum(p.z(), -q.z())};
}

inline DoubleDouble3 operator+(const DoubleDouble3& p, const DoubleDouble3& q) {
  return {p.x + q.x, p.y + q.y, p.z + q.z};
}
inline DoubleDouble3 operator-(const DoubleDouble3& p, const DoubleDouble3& q) {
  return {p.x - q.x, p.y - q.y, p.z - q.z};
}
inline DoubleDouble3 operator*(DoubleDouble s, const DoubleDouble3& p) { return {s * p.x, s * p.y, s * p.z}; }
inline DoubleDouble dot(const DoubleDouble3& p, const DoubleDouble3& q) {
  return (p.x * q.x + p.y * q.y) + p.z * q.z;
}
inline DoubleDouble3 cross(const DoubleDouble3& p, const DoubleDouble3& q) {
  return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
}

}  // namespace touchstone::native

#pragma once

#include "touchstone/contact_core/native/simd/pack.hpp"

// Products of doubles without their rounding (Dekker 1971), in lanes.

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

/// x y exactly.
template <class Pack>
TOUCHSTONE_INLINE Wide<Pack> exact_product(Pack x, Pack y) {
  const Pack splitter = all<Pack>(0x1p27 + 1.0);
  const Pack tx = splitter * x, ty = splitter * y;
  const Pack xh = tx - (tx - x), yh = ty - (ty - y);
  const Pack xl = x - xh, yl = y - yh;
  const Pack product = x * y;
  return {product, ((xh * yh - product) + xh * yl + xl * yh) + xl * yl};
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

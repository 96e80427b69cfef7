#pragma once

#include "touchstone/contact_core/native/simd/exact_products.hpp"

// Vertices in the frame of a plane, eight in lanes; bounds stand in flush_hulls.cpp.

namespace touchstone::native::TOUCHSTONE_ISA {

template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> all_of(const double* v) {
  return {all<Pack>(v[0]), all<Pack>(v[1]), all<Pack>(v[2])};
}

/// n . d, right to its last bit however small (the dot product in twice the precision of Ogita, Rump and
/// Oishi 2005).
template <class Pack>
TOUCHSTONE_INLINE Pack accurate_height(const Vector3Of<Pack>& n, const WideVector<Pack>& d) {
  const Wide<Pack> x = exact_product(d.x.high, n.x), y = exact_product(d.y.high, n.y),
                   z = exact_product(d.z.high, n.z);
  const Wide<Pack> xy = exact_sum(x.high, y.high), xyz = exact_sum(xy.high, z.high);
  const Pack of_differences = (d.x.low * n.x + d.y.low * n.y) + d.z.low * n.z;
  const Pack of_products = (x.low + y.low) + z.low;
  return xyz.high + (((xy.low + xyz.low) + of_products) + of_differences);
}

/// @param reach becomes at least each vertex's |p - p_W|_1.
template <class Pack>
TOUCHSTONE_INLINE void put_into_frame(const VertexRecord& v_W, const PlaneFrame& plane, Pack& reach,
                                      VertexRecord& out) {
  const Vector3Of<Pack> x = all_of<Pack>(plane.x), y = all_of<Pack>(plane.y), n = all_of<Pack>(plane.n),
                        p_W = all_of<Pack>(plane.p_W);
  for (int i = 0; i < 8; i += Traits<Pack>::lanes) {
    const Vector3Of<Pack> v = {load<Pack>(v_W.x + i), load<Pack>(v_W.y + i), load<Pack>(v_W.z + i)};
    const WideVector<Pack> d = wide_difference(v, p_W);
    const Vector3Of<Pack> high = d.high();
    store(dot(x, high), out.x + i), store(dot(y, high), out.y + i);
    store(accurate_height(n, d), out.z + i);
    reach = greatest(reach, sum(high));
  }
}

template <class Pack>
TOUCHSTONE_INLINE double put_into_frame_inline(const VertexRecord& a_W, const VertexRecord& b_W,
                                               const PlaneFrame& plane, VertexRecord& a, VertexRecord& b) {
  Pack reach{};
  put_into_frame<Pack>(a_W, plane, reach, a);
  put_into_frame<Pack>(b_W, plane, reach, b);
  double out = reach[0];
  for (int l = 1; l < Traits<Pack>::lanes; ++l) out = reach[l] > out ? reach[l] : out;
  return out;
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

#pragma once

#include <bit>

#include "touchstone/contact_core/native/common/hull_pair.hpp"

#define TOUCHSTONE_ISA baseline
#include "touchstone/contact_core/native/common/pack.hpp"
#undef TOUCHSTONE_ISA

// Eight vertices against one axis, two lanes at a time, which every x86-64 and arm64 has. Lanes never mix, so
// the bits are those of scalar code.

namespace touchstone::native {

using baseline::all;
using baseline::bits;
using baseline::Double2;
using baseline::greatest;
using baseline::least;
using baseline::magnitude;
using baseline::store;

inline Double2 load(const double* p) { return baseline::load<Double2>(p); }

/// One coordinate of eight vertices, or axis . vertex.
struct Lanes {
  Double2 d[4];
};

inline Lanes dots(const WorldVertices& v, const Vector3& axis) {
  const Double2 x = all<Double2>(axis.x()), y = all<Double2>(axis.y()), z = all<Double2>(axis.z());
  Lanes out;
  for (int i = 0; i < 4; ++i)
    out.d[i] = (x * load(&v.x[2 * i]) + y * load(&v.y[2 * i])) + z * load(&v.z[2 * i]);
  return out;
}

inline double low_of(const Lanes& p) {
  const Double2 m = least(least(p.d[0], p.d[1]), least(p.d[2], p.d[3]));
  return m[0] < m[1] ? m[0] : m[1];
}

inline double high_of(const Lanes& p) {
  const Double2 m = greatest(greatest(p.d[0], p.d[1]), greatest(p.d[2], p.d[3]));
  return m[0] > m[1] ? m[0] : m[1];
}

/// The lowest index that holds `value`, one of the eight. Without a branch, whose outcome no predictor can
/// guess.
inline int first_equal(const Lanes& lanes, double value) {
  const Double2 wanted = all<Double2>(value);
  unsigned mask = 0x80;
  for (int i = 0; i < 4; ++i) mask |= bits(lanes.d[i] == wanted) << (2 * i);
  return std::countr_zero(mask);
}

}  // namespace touchstone::native

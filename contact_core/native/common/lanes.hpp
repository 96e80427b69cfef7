#pragma once

#include <bit>

#include "touchstone/contact_core/native/common/hull_pair.hpp"

// Eight vertices against one axis, two lanes at a time: what every x86-64 and arm64 has. Lanes never mix, so
// the bits are those of scalar code.

namespace touchstone::native {

typedef double Double2 __attribute__((vector_size(16)));

/// One coordinate of eight vertices, or axis . vertex.
struct Lanes {
  Double2 d[4];
};

inline Double2 load(const double* p) { return Double2{p[0], p[1]}; }

inline Lanes dots(const WorldVertices& v, const Vector3& axis) {
  const Double2 x = {axis.x(), axis.x()}, y = {axis.y(), axis.y()}, z = {axis.z(), axis.z()};
  Lanes out;
  for (int i = 0; i < 4; ++i)
    out.d[i] = (x * load(&v.x[2 * i]) + y * load(&v.y[2 * i])) + z * load(&v.z[2 * i]);
  return out;
}

inline Double2 least(Double2 p, Double2 q) { return p < q ? p : q; }
inline Double2 greatest(Double2 p, Double2 q) { return p > q ? p : q; }

inline double low_of(const Lanes& p) {
  const Double2 m = least(least(p.d[0], p.d[1]), least(p.d[2], p.d[3]));
  return m[0] < m[1] ? m[0] : m[1];
}

inline double high_of(const Lanes& p) {
  const Double2 m = greatest(greatest(p.d[0], p.d[1]), greatest(p.d[2], p.d[3]));
  return m[0] > m[1] ? m[0] : m[1];
}

/// The lowest index that holds `value`, one of the eight. Without branches where the machine can: which
/// vertex it is, no predictor can guess.
inline int first_equal(const Lanes& lanes, double value) {
#ifdef __SSE2__
  const Double2 wanted = {value, value};
  unsigned mask = 0x80;
  for (int i = 0; i < 4; ++i)
    mask |= static_cast<unsigned>(__builtin_ia32_movmskpd((Double2)(lanes.d[i] == wanted))) << (2 * i);
  return std::countr_zero(mask);
#else
  for (int i = 0; i < 7; ++i)
    if (lanes.d[i / 2][i % 2] == value) return i;
  return 7;
#endif
}

}  // namespace touchstone::native

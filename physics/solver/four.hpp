#pragma once

#include <algorithm>

#include "touchstone/contact_core/geometry/vector.hpp"
#include "touchstone/physics/solver/contact_laws.hpp"

#define TOUCHSTONE_ISA baseline
#include "touchstone/contact_core/native/common/pack.hpp"
#undef TOUCHSTONE_ISA

// Four doubles side by side, in the instructions that every x86-64 and arm64 has. Lanes mix in
// sum_of() alone, which has one order: bits are the same everywhere.

namespace touchstone::physics {

struct Four {
  native::baseline::Double2 low, high;
};
/// All bits of a lane, or none.
struct FourMask {
  native::baseline::Mask2 low, high;
};

TOUCHSTONE_INLINE Four in_all(double value) {
  const native::baseline::Double2 both = native::baseline::all<native::baseline::Double2>(value);
  return {both, both};
}
TOUCHSTONE_INLINE Four four_at(const double* from) {
  using native::baseline::Double2;
  return {native::baseline::load<Double2>(from), native::baseline::load<Double2>(from + 2)};
}
TOUCHSTONE_INLINE void put(const Four& p, double* to) {
  native::baseline::store(p.low, to), native::baseline::store(p.high, to + 2);
}

TOUCHSTONE_INLINE Four operator+(const Four& p, const Four& q) { return {p.low + q.low, p.high + q.high}; }
TOUCHSTONE_INLINE Four operator-(const Four& p, const Four& q) { return {p.low - q.low, p.high - q.high}; }
TOUCHSTONE_INLINE Four operator*(const Four& p, const Four& q) { return {p.low * q.low, p.high * q.high}; }
TOUCHSTONE_INLINE Four operator/(const Four& p, const Four& q) { return {p.low / q.low, p.high / q.high}; }
TOUCHSTONE_INLINE Four operator-(const Four& p) { return {-p.low, -p.high}; }
TOUCHSTONE_INLINE Four& operator+=(Four& p, const Four& q) { return p = p + q; }
TOUCHSTONE_INLINE Four& operator-=(Four& p, const Four& q) { return p = p - q; }

TOUCHSTONE_INLINE FourMask operator<(const Four& p, const Four& q) {
  return {p.low < q.low, p.high < q.high};
}
TOUCHSTONE_INLINE FourMask operator<=(const Four& p, const Four& q) {
  return {p.low <= q.low, p.high <= q.high};
}
TOUCHSTONE_INLINE FourMask operator!=(const Four& p, const Four& q) {
  return {p.low != q.low, p.high != q.high};
}
TOUCHSTONE_INLINE FourMask operator&(const FourMask& p, const FourMask& q) {
  return {p.low & q.low, p.high & q.high};
}
TOUCHSTONE_INLINE FourMask operator|(const FourMask& p, const FourMask& q) {
  return {p.low | q.low, p.high | q.high};
}
TOUCHSTONE_INLINE bool is_any(const FourMask& mask) {
  return (native::baseline::bits(mask.low) | native::baseline::bits(mask.high)) != 0;
}
TOUCHSTONE_INLINE Four select(const FourMask& where, const Four& then, const Four& otherwise) {
  return {where.low ? then.low : otherwise.low, where.high ? then.high : otherwise.high};
}

TOUCHSTONE_INLINE Four magnitude(const Four& p) {
  return {native::baseline::magnitude(p.low), native::baseline::magnitude(p.high)};
}
TOUCHSTONE_INLINE Four square_root(const Four& p) {
  return {native::baseline::square_root(p.low), native::baseline::square_root(p.high)};
}
/// worse_of() by lane.
TOUCHSTONE_INLINE Four worse_of(const Four& p, const Four& q) { return select((q <= p) | (p != p), p, q); }

TOUCHSTONE_INLINE double sum_of(const Four& p) {
  const native::baseline::Double2 sum = p.low + p.high;
  return sum[0] + sum[1];
}

/// worse_of() and the largest of all lanes.
TOUCHSTONE_INLINE double worst_of(const Four& p) {
  return worse_of(worse_of(p.low[0], p.low[1]), worse_of(p.high[0], p.high[1]));
}
TOUCHSTONE_INLINE double largest_of(const Four& p) {
  return std::max(std::max(p.low[0], p.low[1]), std::max(p.high[0], p.high[1]));
}

/// Vectors side by side.
struct FourVectors {
  Four x, y, z;
};

TOUCHSTONE_INLINE FourVectors vectors_at(const double (*from)[4]) {
  return {four_at(from[0]), four_at(from[1]), four_at(from[2])};
}
/// One vector in all lanes.
TOUCHSTONE_INLINE FourVectors vector_in_all(const double* from) {
  return {in_all(from[0]), in_all(from[1]), in_all(from[2])};
}
TOUCHSTONE_INLINE FourVectors operator+(const FourVectors& u, const FourVectors& v) {
  return {u.x + v.x, u.y + v.y, u.z + v.z};
}
TOUCHSTONE_INLINE FourVectors operator-(const FourVectors& u, const FourVectors& v) {
  return {u.x - v.x, u.y - v.y, u.z - v.z};
}
TOUCHSTONE_INLINE FourVectors operator*(const Four& s, const FourVectors& v) {
  return {s * v.x, s * v.y, s * v.z};
}
TOUCHSTONE_INLINE Four dot(const FourVectors& u, const FourVectors& v) {
  return (u.x * v.x + u.y * v.y) + u.z * v.z;
}
TOUCHSTONE_INLINE FourVectors cross(const FourVectors& u, const FourVectors& v) {
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

/// A v.
TOUCHSTONE_INLINE FourVectors rotated(const Matrix3& A, const FourVectors& v) {
  const auto row = [&](int r) {
    return (in_all(A(r, 0)) * v.x + in_all(A(r, 1)) * v.y) + in_all(A(r, 2)) * v.z;
  };
  return {row(0), row(1), row(2)};
}

}  // namespace touchstone::physics

#pragma once

// Private to adapters/exact: vectors over double or over integers of any length, with the same formulas for
// both.

#include <gmpxx.h>

#include <array>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone::exact {

using Integer = mpz_class;

template <class Scalar>
struct Vector {
  Scalar x, y, z;

  friend bool operator==(const Vector&, const Vector&) = default;
};
using IntegerVector = Vector<Integer>;

template <class S>
Vector<S> operator-(const Vector<S>& u, const Vector<S>& v) {
  return {u.x - v.x, u.y - v.y, u.z - v.z};
}

template <class S>
Vector<S> operator+(const Vector<S>& u, const Vector<S>& v) {
  return {u.x + v.x, u.y + v.y, u.z + v.z};
}

template <class S>
Vector<S> operator-(const Vector<S>& u) {
  return {-u.x, -u.y, -u.z};
}

template <class S>
Vector<S> scaled(const Vector<S>& u, const S& s) {
  return {u.x * s, u.y * s, u.z * s};
}

template <class S>
S dot(const Vector<S>& u, const Vector<S>& v) {
  return u.x * v.x + u.y * v.y + u.z * v.z;
}

template <class S>
Vector<S> cross(const Vector<S>& u, const Vector<S>& v) {
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

template <class S>
bool is_zero(const Vector<S>& u) {
  return u.x == 0 && u.y == 0 && u.z == 0;
}

/// Both solids on one integer grid: a coordinate [m] is (vertex + origin) * 2^exponent. The origin is a
/// vertex of A.
struct IntegerPair {
  std::array<IntegerVector, 8> a, b;
  IntegerVector origin;
  long exponent;
};

IntegerPair to_integers(const WorldVertices& a, const WorldVertices& b);

/// v = out * 2^returned exponent, exactly.
long to_integers(const Vector3& v, IntegerVector& out);

/// The double nearest to numerator / denominator * 2^exponent, ties to even; denominator > 0.
double round_ratio(const Integer& numerator, const Integer& denominator, long exponent);

/// The double nearest to sign * sqrt(numerator / denominator) * 2^exponent; numerator >= 0, denominator > 0.
double round_root(int sign, const Integer& numerator, const Integer& denominator, long exponent);

/// v scaled by some power of two so that its largest component is in [1/2, 1); relative error below 2^-52 a
/// component.
Vector<double> approximate(const IntegerVector& v);

}  // namespace touchstone::exact

#pragma once

// Private to adapters/exact: pairs of solids as integers of any length.

#include <gmpxx.h>

#include <array>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/numerics/closest_point.hpp"
#include "touchstone/contact_core/numerics/scalar_vector.hpp"

namespace touchstone::exact {

using Integer = mpz_class;

using numerics::ClosestSimplex;
using numerics::cross;
using numerics::dot;
using numerics::find_closest_point;
using numerics::is_zero;
using numerics::scaled;
using numerics::support;
using numerics::Vector;
using numerics::operator+;
using numerics::operator-;
using IntegerVector = Vector<Integer>;

/// Both solids on one integer grid: a coordinate [m] is (vertex + origin) * 2^exponent. The origin is a
/// vertex of A.
struct IntegerPair {
  std::array<IntegerVector, 8> a, b;
  IntegerVector origin;
  Integer radius;  ///< the sum of both, on the same grid
  long exponent;
};

IntegerPair to_integers(const WorldVertices& a, const WorldVertices& b, double radius_a = 0.0,
                        double radius_b = 0.0);

/// v = out * 2^returned exponent, exactly.
long to_integers(const Vector3& v, IntegerVector& out);

/// The double nearest to numerator / denominator * 2^exponent, ties to even; denominator > 0.
double round_ratio(const Integer& numerator, const Integer& denominator, long exponent);

/// The double nearest to sign * sqrt(numerator / denominator) * 2^exponent; numerator >= 0, denominator > 0.
double round_root(int sign, const Integer& numerator, const Integer& denominator, long exponent);

/// The double nearest to (sign * sqrt(numerator / denominator) - radius) * 2^exponent, for a difference that
/// is not 0; numerator, radius >= 0, denominator > 0.
double round_root_less(int sign, const Integer& numerator, const Integer& denominator, const Integer& radius,
                       long exponent);

/// v scaled by some power of two so that its largest component is in [1/2, 1); relative error below 2^-52 a
/// component.
Vector<double> approximate(const IntegerVector& v);

}  // namespace touchstone::exact

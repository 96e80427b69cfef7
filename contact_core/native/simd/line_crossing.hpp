#pragma once

#include "touchstone/contact_core/native/simd/pack.hpp"

namespace touchstone::native::TOUCHSTONE_ISA {

template <class Real>
struct LineCrossing {
  Real x, y;
};

/// Where two lines cross seen along n: p + x a and q + y b, w = q - p. One pair's, or pairs in lanes.
template <class Real>
TOUCHSTONE_INLINE LineCrossing<Real> cross_lines(const Vector3Of<Real>& w, const Vector3Of<Real>& a,
                                                 const Vector3Of<Real>& b, const Vector3Of<Real>& n) {
  const Vector3Of<Real> b_n = cross(b, n), a_n = cross(a, n);
  const Real determinant = dot(a, b_n);
  return {dot(w, b_n) / determinant, dot(w, a_n) / determinant};
}

}  // namespace touchstone::native::TOUCHSTONE_ISA

#pragma once

#include "touchstone/contact_core/geometry/pose.hpp"

// Products of 3x3 matrices in one stated order of operations: Eigen's own products and reductions change
// their order with the instruction set.

namespace touchstone::physics {

/// u v^T.
inline Matrix3 outer(const Vector3& u, const Vector3& v) {
  Matrix3 out;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) out(i, j) = u[i] * v[j];
  return out;
}

/// The matrix of v: skew(u) v = u x v.
inline Matrix3 skew(const Vector3& u) {
  Matrix3 out;
  out << 0.0, -u.z(), u.y(), u.z(), 0.0, -u.x(), -u.y(), u.x(), 0.0;
  return out;
}

inline Matrix3 product(const Matrix3& A, const Matrix3& B) {
  Matrix3 out;
  for (int j = 0; j < 3; ++j) out.col(j) = rotate(A, B.col(j));
  return out;
}

/// A^T v.
inline Vector3 rotate_back(const Matrix3& A, const Vector3& v) {
  return {dot(A.col(0), v), dot(A.col(1), v), dot(A.col(2), v)};
}

/// R I R^T, symmetric to the bit for symmetric I.
inline Matrix3 turned(const Matrix3& R, const Matrix3& I) {
  const Matrix3 RI = product(R, I);
  Matrix3 out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) out(i, j) = out(j, i) = dot(RI.row(i).transpose(), R.row(j).transpose());
  return out;
}

/// The inverse by cofactors. @pre A is symmetric and regular.
inline Matrix3 symmetric_inverse(const Matrix3& A) {
  Matrix3 cofactors;
  cofactors.col(0) = cross(A.col(1), A.col(2));
  cofactors.col(1) = cross(A.col(2), A.col(0));
  cofactors.col(2) = cross(A.col(0), A.col(1));
  const double determinant = dot(A.col(0), cofactors.col(0));
  Matrix3 out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) out(i, j) = out(j, i) = cofactors(i, j) / determinant;
  return out;
}

inline bool is_finite(const Matrix3& A) {
  return touchstone::is_finite(A.col(0)) && touchstone::is_finite(A.col(1)) &&
         touchstone::is_finite(A.col(2));
}

}  // namespace touchstone::physics

#pragma once

#include "touchstone/contact_core/geometry/pose.hpp"

/// @file
/// Products of 3x3 matrices in one stated order of operations. Eigen's own products and reductions change
/// their order with the instruction set that it was compiled for, so that none stands where bits of a pose or
/// of a velocity depend on it; what it does entry by entry (sums, products with a number) is the same
/// everywhere.

namespace touchstone {

/// u v^T.
inline Matrix3 outer(const Vector3& u, const Vector3& v) {
  Matrix3 out;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) out(i, j) = u[i] * v[j];
  return out;
}

/// The matrix of u: skew(u) v = u x v.
inline Matrix3 skew(const Vector3& u) {
  Matrix3 out;
  out << 0.0, -u.z(), u.y(), u.z(), 0.0, -u.x(), -u.y(), u.x(), 0.0;
  return out;
}

/// A B, column by column as rotate().
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

/// True where no entry is infinite or NaN.
inline bool is_finite(const Matrix3& A) {
  return is_finite(Vector3(A.col(0))) && is_finite(Vector3(A.col(1))) && is_finite(Vector3(A.col(2)));
}

/// The eigenvalues of a symmetric matrix, the smallest first; off by a few eps of the largest magnitude
/// (Jacobi's rotations).
Vector3 symmetric_eigenvalues(const Matrix3& A);

/// Rotation by `angle` [rad], right-handed, about a unit axis (Rodrigues); off by less than 18 u (Frobenius,
/// u = 2^-53) and twice the axis' own error.
Matrix3 rotation_about(const Vector3& axis, double angle) noexcept;

}  // namespace touchstone

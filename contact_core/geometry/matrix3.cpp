#include "touchstone/contact_core/geometry/matrix3.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/trigonometry.hpp"

namespace touchstone {
namespace {

/// A' = J^T A J with the rotation J in the plane of axes i and j that makes A'(i, j) zero (Golub and Van
/// Loan, Matrix Computations, 8.5.2).
void rotate_to_zero(Matrix3& A, int i, int j) {
  if (A(i, j) == 0.0) return;
  const double ratio = (A(j, j) - A(i, i)) / (2.0 * A(i, j));
  const double t = std::copysign(1.0, ratio) / (std::abs(ratio) + std::sqrt(1.0 + ratio * ratio));
  const double c = 1.0 / std::sqrt(1.0 + t * t), s = t * c;
  const double change = t * A(i, j);
  A(i, i) -= change;
  A(j, j) += change;
  A(i, j) = A(j, i) = 0.0;
  const int k = 3 - i - j;
  const double ki = A(k, i), kj = A(k, j);
  A(k, i) = A(i, k) = c * ki - s * kj;
  A(k, j) = A(j, k) = s * ki + c * kj;
}

}  // namespace

Vector3 symmetric_eigenvalues(const Matrix3& A) {
  Matrix3 D = A;
  // Converges quadratically: four sweeps leave nothing, the others find zeros.
  for (int sweep = 0; sweep < 6; ++sweep) {
    rotate_to_zero(D, 0, 1);
    rotate_to_zero(D, 0, 2);
    rotate_to_zero(D, 1, 2);
  }
  Vector3 values(D(0, 0), D(1, 1), D(2, 2));
  std::sort(values.data(), values.data() + 3);
  return values;
}

Matrix3 rotation_about(const Vector3& axis, double angle) noexcept {
  const auto [s, c] = sine_cosine(angle);
  // 1 - c, without its cancellation where the turn is small.
  const double versine = c > 0.5 ? s * s / (1.0 + c) : 1.0 - c;
  const Vector3& a = axis;
  const double xy = versine * a.x() * a.y(), xz = versine * a.x() * a.z(), yz = versine * a.y() * a.z();
  Matrix3 R;
  R << c + versine * a.x() * a.x(), xy - s * a.z(), xz + s * a.y(),  //
      xy + s * a.z(), c + versine * a.y() * a.y(), yz - s * a.x(),   //
      xz - s * a.y(), yz + s * a.x(), c + versine * a.z() * a.z();
  return R;
}

}  // namespace touchstone

#include "touchstone/contact_core/geometry/quaternion.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone {
namespace {

constexpr double kUlp = 0x1p-52;

double largest_entry(const Matrix3& A) { return A.cwiseAbs().maxCoeff(); }

Vector3 random_axis(std::mt19937_64& random) {
  const Vector3 v = random_vector(random, 0.1, 1.0);
  return v / norm(v);
}

/// Rodrigues' formula with all digits of long double.
Matrix3 true_rotation(const Vector3& axis, double angle) {
  const long double s = std::sin(static_cast<long double>(angle)), h = std::sin(0.5L * angle), v = 2 * h * h;
  Matrix3 R;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const long double sign = i == j ? 0 : (j - i + 3) % 3 == 1 ? -1 : 1;
      R(i, j) = static_cast<double>((i == j ? 1 - v : 0) + v * axis(i) * axis(j) +
                                    (i == j ? 0 : sign * s * axis(3 - i - j)));
    }
  return R;
}

TEST(Rotation, AboutAnAxisIsWithinTheStatedError) {
  std::mt19937_64 random(1);
  double worst = 0.0;
  for (int i = 0; i < 100000; ++i) {
    const Vector3 axis = random_axis(random);
    const double angle = i % 3 == 0 ? uniform(random, -1e-3, 1e-3) : uniform(random, -7.0, 7.0);
    const Matrix3 off = rotation_about(axis, angle) - true_rotation(axis, angle);
    double square = 0.0;
    for (int k = 0; k < 9; ++k) square += off.data()[k] * off.data()[k];
    worst = std::max(worst, std::sqrt(square));
  }
  std::printf("%.2f u\n", worst * 0x1p53);
  EXPECT_LT(worst, 18 * 0x1p-53);
}

TEST(Quaternion, MatrixThereAndBackAndItsTurn) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 20000; ++i) {
    const Vector3 turn = uniform(random, 0.0, 3.14) * random_axis(random);
    const Quaternion q = quaternion_of_turn(turn);
    const Matrix3 R = rotation_matrix(q);
    ASSERT_LT(largest_entry(R - rotation_about(turn / norm(turn), norm(turn))), 8 * kUlp);
    const AxisAngle found = axis_angle_of(quaternion_of(R));
    ASSERT_LT(norm(found.angle * found.axis - turn), 16 * kUlp);
    const AxisAngle other = axis_angle_of({-q.w, -q.v});
    ASSERT_LT(norm(other.angle * other.axis - turn), 16 * kUlp);
  }
  EXPECT_EQ(axis_angle_of({}).angle, 0.0);
  EXPECT_EQ(axis_angle_of({0.0, {0, 1, 0}}).angle, std::numbers::pi);
}

TEST(Quaternion, SlerpTurnsEvenlyTheShorterWay) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 20000; ++i) {
    const Matrix3 R = random_rotation(random);
    const Vector3 axis = random_axis(random);
    const double angle = i % 4 == 0 ? uniform(random, 0.0, 1e-7) : uniform(random, 0.0, 3.1);
    const double s = uniform(random, 0.0, 1.0);
    Quaternion to = quaternion_of(product(rotation_about(axis, angle), R));
    if (i % 2 == 1) to = {-to.w, -to.v};  // the same attitude
    const Matrix3 got = rotation_matrix(slerp(quaternion_of(R), to, s));
    ASSERT_LT(largest_entry(got - product(rotation_about(axis, s * angle), R)), 3e-14);
    ASSERT_LT(orthonormality_defect(got), 12 * kUlp);
  }
}

TEST(Quaternion, OfAHalfTurnAndOfRotationsNearOne) {
  for (const double away : {0.0, 1e-300, 1e-17, 1e-12, 1e-8}) {
    for (int k = 0; k < 3; ++k) {
      const Vector3 axis = Vector3::Unit(k);
      const Quaternion from, to = quaternion_of(rotation_about(axis, std::numbers::pi - away));
      const Matrix3 R = rotation_matrix(slerp(from, to, 0.5));
      EXPECT_NEAR(std::abs(R((k + 1) % 3, (k + 2) % 3)), 1.0, 1e-7) << away;
    }
  }
}

TEST(Matrix3, EigenvaluesOfSymmetricMatricesAreThoseOfEigen) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 20000; ++i) {
    const Matrix3 R = random_rotation(random);
    Vector3 values = random_vector(random, 2.0);
    if (i % 3 == 0) values[1] = values[0];
    if (i % 7 == 0) values[2] = 1e-9;
    const Matrix3 A = turned(R, values.asDiagonal());
    const Vector3 expected = Eigen::SelfAdjointEigenSolver<Matrix3>(A, Eigen::EigenvaluesOnly).eigenvalues();
    ASSERT_LT((symmetric_eigenvalues(A) - expected).cwiseAbs().maxCoeff(), 32 * kUlp);
  }
  EXPECT_EQ(symmetric_eigenvalues(Vector3(3, 1, 2).asDiagonal()), Vector3(1, 2, 3));
  EXPECT_EQ(symmetric_eigenvalues(Matrix3::Zero()), Vector3(0, 0, 0));
}

}  // namespace
}  // namespace touchstone

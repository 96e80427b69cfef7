#include "touchstone/contact_core/geometry/pose.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr double kPi = std::numbers::pi;

TEST(Quaternion, HalfTurnsAndQuarterTurnsAreWhatTheySay) {
  EXPECT_EQ(rotation_from_quaternion(1, 0, 0, 0), Matrix3::Identity());
  EXPECT_EQ(rotation_from_quaternion(0, 0, 0, 1), Matrix3(Vector3(-1, -1, 1).asDiagonal()));
  const double h = std::sqrt(0.5);
  const Matrix3 R = rotation_from_quaternion(h, 0, 0, h);  // +90 deg about z takes x to y
  EXPECT_LE((rotate(R, Vector3(1, 0, 0)) - Vector3(0, 1, 0)).cwiseAbs().maxCoeff(), 2 * kEps);
}

TEST(Quaternion, FollowsTheStatedFormulaToTheBit) {
  const double w = 0.3, x = -0.7, y = 0.2, z = 0.9;
  const double length = std::sqrt(((w * w + x * x) + y * y) + z * z);
  const double a = w / length, b = x / length, c = y / length, d = z / length;
  const Matrix3 R = rotation_from_quaternion(w, x, y, z);
  EXPECT_EQ(R(0, 0), ((a * a + b * b) - c * c) - d * d);
  EXPECT_EQ(R(1, 0), 2.0 * (b * c + a * d));
  EXPECT_EQ(R(2, 1), 2.0 * (c * d + a * b));
}

TEST(Quaternion, AnyScaleGivesARotation) {
  for (double scale : {1e-320, 1e-200, 1e-160, 1.0, 1e160, 1e200, 1e307}) {
    const Matrix3 R = rotation_from_quaternion(scale, 2 * scale, -scale, 3 * scale);
    EXPECT_LE(orthonormality_defect(R), 1e-15) << scale;
  }
  const Matrix3 R = rotation_from_quaternion(1, 2, -1, 3);
  EXPECT_EQ(rotation_from_quaternion(0x1p-700, 0x1p-699, -0x1p-700, 3 * 0x1p-700), R);
  EXPECT_EQ(rotation_from_quaternion(0x1p700, 0x1p701, -0x1p700, 3 * 0x1p700), R);
}

TEST(Quaternion, ZeroAndNotFiniteAreRefused) {
  EXPECT_THAT([] { rotation_from_quaternion(0, 0, 0, 0, "gripper"); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("gripper"), HasSubstr("zero"))));
  EXPECT_THAT([] { rotation_from_quaternion(1, NAN, 0, 0, "gripper"); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("gripper"), HasSubstr("not finite"))));
  EXPECT_THROW(rotation_from_quaternion(1, 0, INFINITY, 0), InputError);
}

TEST(PoseMatrix, BadMatricesAreRefusedWithTheFigure) {
  const auto make = [](const Matrix4& X) { return [X] { pose_from_matrix(X, "arm"); }; };
  Matrix4 X = Matrix4::Identity();
  X(0, 0) = -1;
  EXPECT_THAT(make(X),
              ThrowsMessage<InputError>(AllOf(HasSubstr("arm"), HasSubstr("reflection"), HasSubstr("-1"))));
  X = Matrix4::Identity() * 2;
  X(3, 3) = 1;
  EXPECT_THAT(make(X), ThrowsMessage<InputError>(AllOf(HasSubstr("arm"), HasSubstr("off orthonormal by 3"))));
  X = Matrix4::Identity();
  X(0, 1) = 1e-3;
  EXPECT_THAT(make(X), ThrowsMessage<InputError>(HasSubstr("0.001")));
  X = Matrix4::Identity();
  X(3, 0) = 1e-300;
  EXPECT_THAT(make(X), ThrowsMessage<InputError>(HasSubstr("last row")));
  for (double bad : {double(NAN), double(INFINITY)})
    for (int column : {0, 3}) {
      X = Matrix4::Identity();
      X(1, column) = bad;
      EXPECT_THAT(make(X), ThrowsMessage<InputError>(HasSubstr("not finite")));
    }
}

TEST(PoseMatrix, ToleranceIsOneMillionth) {
  Pose X;
  X.R(0, 1) = 0.9e-6;
  EXPECT_TRUE(is_valid_pose(X));
  X.R(0, 1) = 1.1e-6;
  EXPECT_FALSE(is_valid_pose(X));
}

TEST(PoseMatrix, GoesThereAndBackToTheBit) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const Pose X = random_pose(random, 1e3);
    const Pose back = pose_from_matrix(matrix_from_pose(X));
    EXPECT_EQ(back.R, X.R);
    EXPECT_EQ(back.p, X.p);
  }
}

TEST(PositionVector, AnglesTurnAboutFixedXThenYThenZ) {
  Vector6 v;
  v << 1, 2, 3, kPi / 2, 0, 0;
  Pose X = pose_from_position_vector(v);
  EXPECT_EQ(X.p, Vector3(1, 2, 3));
  EXPECT_LE((rotate(X.R, Vector3(0, 1, 0)) - Vector3(0, 0, 1)).cwiseAbs().maxCoeff(),
            kEps);  // roll takes y to z
  v << 0, 0, 0, 0, kPi / 2, 0;
  X = pose_from_position_vector(v);
  EXPECT_LE((rotate(X.R, Vector3(0, 0, 1)) - Vector3(1, 0, 0)).cwiseAbs().maxCoeff(),
            kEps);  // pitch takes z to x
  v << 0, 0, 0, kPi / 2, 0, kPi / 2;
  X = pose_from_position_vector(v);
  // Roll first: y goes to z and stays; yaw first would have taken y to -x.
  EXPECT_LE((rotate(X.R, Vector3(0, 1, 0)) - Vector3(0, 0, 1)).cwiseAbs().maxCoeff(), kEps);
}

TEST(PositionVector, RandomPosesGoThereAndBack) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 10000; ++i) {
    const Pose X = random_pose(random, 10);
    const Vector6 v = position_vector_from_pose(X);
    EXPECT_LE(std::abs(v(3)), kPi);
    EXPECT_LE(std::abs(v(4)), kPi / 2);
    EXPECT_LE(std::abs(v(5)), kPi);
    const Pose back = pose_from_position_vector(v);
    EXPECT_LE((back.R - X.R).cwiseAbs().maxCoeff(), 8 * kEps);
    EXPECT_EQ(back.p, X.p);
  }
}

TEST(PositionVector, GimbalLockPutsTheWholeTurnIntoYaw) {
  for (double pitch : {kPi / 2, -kPi / 2})
    for (double roll : {0.0, 0.4, -2.0})
      for (double yaw : {0.0, 1.0, -3.0}) {
        Vector6 v;
        v << 0, 0, 0, roll, pitch, yaw;
        const Pose X = pose_from_position_vector(v);
        const Vector6 found = position_vector_from_pose(X);
        EXPECT_EQ(found(3), 0.0);
        EXPECT_NEAR(found(4), pitch, 1e-12);
        const double turn = pitch > 0 ? yaw - roll : yaw + roll;
        EXPECT_NEAR(std::remainder(found(5) - turn, 2 * kPi), 0.0, 8 * kEps);
        EXPECT_LE((pose_from_position_vector(found).R - X.R).cwiseAbs().maxCoeff(), 1e-15);
      }
}

TEST(PositionVector, NearGimbalLockTheMatrixIsStillReproduced) {
  for (double off : {1e-15, 1e-13, 1e-12, 1e-11, 1e-8, 1e-4})
    for (double sign : {1.0, -1.0}) {
      Vector6 v;
      v << 0, 0, 0, 0.7, sign * (kPi / 2 - off), -0.3;
      const Pose X = pose_from_position_vector(v);
      const Pose back = pose_from_position_vector(position_vector_from_pose(X));
      // Below cos(pitch) = 1e-12 roll is dropped, which costs at most that much.
      EXPECT_LE((back.R - X.R).cwiseAbs().maxCoeff(), off <= 1e-12 ? 1.1e-12 : 8 * kEps) << off;
    }
}

// As above, with the rounding of a product in every entry: roll and yaw taken one by one were off by eps /
// cos(pitch).
TEST(PositionVector, NearGimbalLockRoundedMatricesAreStillReproduced) {
  std::mt19937_64 random(5);
  for (double off : {1e-11, 1e-9, 1e-6, 1e-3})
    for (int i = 0; i < 100; ++i) {
      Vector6 v;
      v << 0, 0, 0, 0.7, kPi / 2 - off, -0.3;
      const Pose other = random_pose(random, 0);
      const Pose X = compose(inverse(other), compose(other, pose_from_position_vector(v)));
      const Pose back = pose_from_position_vector(position_vector_from_pose(X));
      EXPECT_LE((back.R - X.R).cwiseAbs().maxCoeff(), 8 * kEps) << off;
    }
}

TEST(PositionVector, NotFiniteIsRefusedNamingTheComponent) {
  for (int i = 0; i < 6; ++i) {
    Vector6 v = Vector6::Zero();
    v(i) = NAN;
    EXPECT_THAT(
        [&] { pose_from_position_vector(v, "tool"); },
        ThrowsMessage<InputError>(AllOf(HasSubstr("tool"), HasSubstr("component " + std::to_string(i)))));
  }
}

TEST(ComposeAndInverse, AgreeWithTransformingPointsAndCancel) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 2000; ++i) {
    const Pose X_WA = random_pose(random, 5), X_AB = random_pose(random, 5);
    const Vector3 p_B = random_vector(random, 2);
    const Vector3 apart = transform(compose(X_WA, X_AB), p_B) - transform(X_WA, transform(X_AB, p_B));
    EXPECT_LE(apart.cwiseAbs().maxCoeff(), 100 * kEps);
    const Pose none = compose(inverse(X_WA), X_WA);
    EXPECT_LE((none.R - Matrix3::Identity()).cwiseAbs().maxCoeff(), 8 * kEps);
    EXPECT_LE(none.p.cwiseAbs().maxCoeff(), 100 * kEps);
  }
}

}  // namespace
}  // namespace touchstone

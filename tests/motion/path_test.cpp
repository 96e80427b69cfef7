#include "touchstone/contact_core/motion/path.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/contact_core/scene/motion.hpp"
#include "touchstone/tests/support/degree.hpp"

namespace touchstone {
namespace {

Pose posed(const Vector3& p, const Vector3& axis, double angle) {
  Pose X;
  X.p = p;
  X.R = rotation_about(axis / norm(axis), angle);
  return X;
}

TEST(RigidPath, EndsAreExact) {
  const Pose from = posed({1, 2, 3}, {1, 1, 0}, 0.3), to = posed({-1, 5, 0.1}, {0, 1, 2}, 2.5);
  const RigidPath path = RigidPath::between(from, to);
  EXPECT_EQ(path.pose_at(0.0).R, from.R);
  EXPECT_EQ(path.pose_at(1.0).R, to.R);
  EXPECT_EQ(path.pose_at(1.0).p, to.p);
}

TEST(RigidPath, GoesOnlyAsFarAsItsEndWithoutAJump) {
  const Pose from = posed({1, 2, 3}, {1, 1, 0}, 0.3), to = posed({-1, 5, 0.1}, {0, 1, 2}, 2.5);
  const RigidPath path = RigidPath::between(from, to);
  const Pose almost = path.pose_at(1.0 - 1e-12);
  EXPECT_LT((almost.R - to.R).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_LT((almost.p - to.p).cwiseAbs().maxCoeff(), 1e-11);
}

TEST(RigidPath, HalfTurnIsFollowedThroughAQuarter) {
  const RigidPath path = RigidPath::between(Pose{}, posed({0, 0, 0}, {0, 0, 1}, 180 * kDegree));
  const Matrix3 R = path.pose_at(0.5).R;
  EXPECT_NEAR(std::abs(R(1, 0)), 1.0, 1e-12);
}

TEST(RigidPath, TurnsFurtherThanOnceWhenToldByRates) {
  const RigidPath path = RigidPath::by(Pose{}, {0, 0, 0}, {0, 0, 720 * kDegree});
  EXPECT_NEAR(path.pose_at(0.125).R(1, 0), 1.0, 1e-12);  // a quarter turn
  EXPECT_NEAR(path.pose_at(0.5).R(0, 0), 1.0, 1e-12);    // once round
}

TEST(RigidPath, StateIsTheDerivativeAndTheCurvatureIsBounded) {
  const Pose from = posed({1, 2, 3}, {1, 1, 0}, 0.3), to = posed({-1, 5, 0.1}, {0, 1, 2}, 2.5);
  const RigidPath path = RigidPath::between(from, to);
  const Vector3 p_O(0.4, -0.7, 1.3);
  const Vector3 n = Vector3(0.6, 0.0, 0.8);
  const auto height = [&](double s) { return dot(n, transform(path.pose_at(s), p_O)); };
  const double h = 1e-4;
  for (double s = 0.1; s < 0.9; s += 0.1) {
    const BodyState state = path.at(0, s);
    const Vector3 offset = rotate(state.X_WO.R, p_O);
    const double slope = dot(n, state.velocity_W + cross(state.angular_velocity_W, offset));
    EXPECT_NEAR(slope, (height(s + h) - height(s - h)) / (2 * h), 1e-6);
    const double curvature = (height(s + h) - 2 * height(s) + height(s - h)) / (h * h);
    EXPECT_LE(std::abs(curvature), path.curvature_bound(0, state, transform(state.X_WO, p_O), n) + 1e-5);
  }
}

}  // namespace
}  // namespace touchstone

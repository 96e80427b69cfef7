#include "touchstone/contact_core/scene/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/scene/scene.hpp"

namespace touchstone {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(Motion, RestsWithoutAPath) {
  Pose X;
  X.p = {1, 2, 3};
  EXPECT_EQ(pose_at({}, X, 7.0).p, X.p);
}

TEST(Motion, MovesAlongSegmentsAndHoldsBetweenThem) {
  Motion motion;
  motion.segments.push_back({1.0, 2.0, {1, 0, 0}});
  motion.segments.push_back({5.0, 1.0, {0, 2, 0}});
  validate_motion(motion, "m");
  EXPECT_EQ(pose_at(motion, {}, 0.5).p, Vector3(0, 0, 0));
  EXPECT_EQ(pose_at(motion, {}, 2.0).p, Vector3(1, 0, 0));
  EXPECT_EQ(pose_at(motion, {}, 4.0).p, Vector3(2, 0, 0));
  EXPECT_EQ(pose_at(motion, {}, 5.5).p, Vector3(2, 1, 0));
  EXPECT_EQ(pose_at(motion, {}, 99.0).p, Vector3(2, 2, 0));
}

TEST(Motion, TurnsRightHandedAboutTheMovingPivot) {
  Motion motion;
  motion.segments.push_back({0.0, 2.0, {0, 0, 1}, Vector3::UnitZ(), kPi / 2, {1, 0, 0}});
  Pose X;
  X.p = {2, 0, 0};
  const Pose after = pose_at(motion, X, 1.0);
  EXPECT_NEAR(norm(after.p - Vector3(1, 1, 1)), 0.0, 1e-15);
  EXPECT_NEAR(norm(Vector3(after.R.col(0)) - Vector3::UnitY()), 0.0, 1e-15);
  EXPECT_TRUE(is_valid_pose(after));
}

TEST(Motion, InterpolatesKeysFromTheInitialPose) {
  Motion motion;
  Pose key;
  key.p = {4, 0, 0};
  key.R = rotation_about(Vector3::UnitX(), kPi / 2);
  motion.keys.push_back({2.0, key});
  const Pose half = pose_at(motion, {}, 1.0);
  EXPECT_EQ(half.p, Vector3(2, 0, 0));
  EXPECT_NEAR((half.R - rotation_about(Vector3::UnitX(), kPi / 4)).cwiseAbs().maxCoeff(), 0.0, 1e-15);
  EXPECT_EQ(pose_at(motion, {}, 2.0).R, key.R);
  EXPECT_EQ(pose_at(motion, {}, 9.0).p, key.p);
}

TEST(Motion, RefusesBadPaths) {
  const auto message = [](const Motion& motion) {
    try {
      validate_motion(motion, "object 'a'");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  Motion overlap;
  overlap.segments = {{0.0, 2.0, {1, 0, 0}}, {1.0, 1.0, {1, 0, 0}}};
  EXPECT_EQ(message(overlap), "object 'a': motion segment 1: starts before the one before it ends");
  Motion axis;
  axis.segments = {{0.0, 2.0, {1, 0, 0}, {0, 0, 2}, 1.0}};
  EXPECT_EQ(message(axis), "object 'a': motion segment 0: the axis is not a unit vector");
  Motion keys;
  keys.keys = {{1.0, {}}, {1.0, {}}};
  EXPECT_EQ(message(keys), "object 'a': motion key 1: not later than the one before it");
  keys.segments = overlap.segments;
  EXPECT_EQ(message(keys), "object 'a': a motion has segments or keys, not both");
  Motion infinite;
  infinite.segments = {{0.0, 2.0, {std::nan(""), 0, 0}}};
  EXPECT_EQ(message(infinite), "object 'a': motion segment 0: the velocity is not finite");
}

TEST(Scene, CountsTheFrameAtTheEndDespiteRounding) {
  Scene scene;
  scene.frame_rate = 10;
  scene.duration = 0.3;
  EXPECT_EQ(scene.frame_count(), 4u);
  scene.duration = 0.7;
  EXPECT_EQ(scene.frame_count(), 8u);
  scene.duration = 0.75;
  EXPECT_EQ(scene.frame_count(), 8u);
}

}  // namespace
}  // namespace touchstone

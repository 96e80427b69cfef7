#include "touchstone/adapters/cigi/coordinates.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/degree.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone {
namespace {

using namespace cigi;

constexpr double kAngleError = 5e-7;  ///< [rad] as stated at place()

Pose about(const Vector3& axis, double degrees, const Vector3& p = Vector3::Zero()) {
  const double half = degrees * kDegree / 2;
  return {rotation_from_quaternion(std::cos(half), std::sin(half) * axis.x(), std::sin(half) * axis.y(),
                                   std::sin(half) * axis.z()),
          p};
}

double turn_between(const Matrix3& A, const Matrix3& B) {
  // |A - B| in the Frobenius norm is 2 sqrt(2) sin(turn / 2).
  double sum = 0.0;
  for (int i = 0; i < 9; ++i) sum += (A(i) - B(i)) * (A(i) - B(i));
  return 2.0 * std::asin(std::min(1.0, std::sqrt(sum / 8.0)));
}

EntityControl placed(const Anchor& anchor, const Pose& X_WE) {
  EntityControl packet;
  place(anchor, X_WE, packet);
  return packet;
}

TEST(CigiCoordinates, PlacesOnEarthKnownInClosedForm) {
  const double b = 6378137.0 * (1.0 - 1.0 / 298.257223563);
  EXPECT_EQ(position_on_earth({0, 0, 10}).x(), 6378147.0);
  EXPECT_NEAR(position_on_earth({0, 90, 0}).y(), 6378137.0, 1e-9);
  EXPECT_NEAR(position_on_earth({90, 0, 5}).z(), b + 5, 2e-9);
  EXPECT_NEAR(position_on_earth({-90, 0, 5}).z(), -b - 5, 2e-9);
}

TEST(CigiCoordinates, EarthThereAndBack) {
  std::mt19937_64 random(1);
  double worst = 0.0;
  for (int i = 0; i < 200'000; ++i) {
    Geodetic place;
    place.latitude = i % 10 == 0 ? (i % 20 == 0 ? 90 : -90) : uniform(random, -90, 90);
    if (i % 10 == 1) place.latitude *= 1e-9;
    place.longitude = uniform(random, -180, 180);
    place.altitude = uniform(random, -1e4, 1e6);
    const Vector3 p = position_on_earth(place);
    const Geodetic back = geodetic_from(p);
    worst = std::max(worst, norm(position_on_earth(back) - p));
    ASSERT_NEAR(back.altitude, place.altitude, 5e-9);
  }
  EXPECT_LT(worst, 5e-9);
  RecordProperty("worst_error_m", std::to_string(worst));
  std::printf("worst error on Earth: %.3g m\n", worst);
}

TEST(CigiCoordinates, NorthEastDownIsARotationThatPointsThere) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 1000; ++i) {
    const Geodetic place{uniform(random, -89, 89), uniform(random, -179, 179), uniform(random, 0, 1e5)};
    const Matrix3 R = north_east_down(place);
    EXPECT_TRUE(is_valid_pose({R, Vector3::Zero()}));
    // Finite differences along each direction, 1 m.
    const double meridian = 1.0 / 6.36e6 / kDegree;
    Geodetic north = place, east = place, down = place;
    north.latitude += meridian, east.longitude += meridian, down.altitude -= 1.0;
    const Vector3 p = position_on_earth(place);
    const std::array<Vector3, 3> steps{position_on_earth(north) - p, position_on_earth(east) - p,
                                       position_on_earth(down) - p};
    for (int axis = 0; axis < 3; ++axis) EXPECT_LT(norm(steps[axis] / norm(steps[axis]) - R.col(axis)), 1e-5);
  }
}

// Each angle alone, by the standard's words: yaw turns the nose to the right, pitch lifts it, roll lowers the
// right wing.
TEST(CigiCoordinates, AnglesTurnAsTheStandardSays) {
  const Anchor anchor = AttachedTo{9, {}};
  const Vector3 nose(1, 0, 0), right(0, 1, 0);
  EntityControl packet;
  packet.yaw = 90.0F;
  EXPECT_NEAR(rotate(pose_from(anchor, packet).R, nose).y(), 1.0, 1e-15);  // to the right
  packet = {};
  packet.pitch = 30.0F;
  EXPECT_NEAR(rotate(pose_from(anchor, packet).R, nose).z(), -0.5, 1e-15);  // up is -z
  packet = {};
  packet.roll = 30.0F;
  EXPECT_NEAR(rotate(pose_from(anchor, packet).R, right).z(), 0.5, 1e-15);  // down is +z
  // In order: yaw first, then pitch about the turned axis.
  packet = {};
  packet.yaw = 90.0F, packet.pitch = 90.0F;
  EXPECT_NEAR(rotate(pose_from(anchor, packet).R, nose).z(), -1.0, 1e-15);
  EXPECT_NEAR(rotate(pose_from(anchor, packet).R, right).x(), -1.0, 1e-15);
}

TEST(CigiCoordinates, AttachedWithZUp) {
  // The world's z is up, its y to the left of the parent's nose.
  const Anchor anchor = AttachedTo{7, z_up()};
  EntityControl packet = placed(anchor, compose(about({0, 0, 1}, 30, {1, 2, 3}), z_up()));
  EXPECT_TRUE(packet.is_attached);
  EXPECT_EQ(packet.parent, 7);
  EXPECT_EQ(packet.position, (std::array<double, 3>{1, -2, -3}));
  // To the left seen from above: a yaw of -30, given as 330.
  EXPECT_FLOAT_EQ(packet.yaw, 330.0F);
  EXPECT_NEAR(packet.roll, 0, 1e-13);
  EXPECT_NEAR(packet.pitch, 0, 1e-13);
}

TEST(CigiCoordinates, AttachedThereAndBack) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 100'000; ++i) {
    const Anchor anchor = AttachedTo{1, random_pose(random, 100.0)};
    const Pose X_WE = random_pose(random, 20.0);
    const EntityControl packet = placed(anchor, X_WE);
    ASSERT_TRUE(packet.yaw >= 0 && packet.yaw < 360 && std::abs(packet.pitch) <= 90 &&
                std::abs(packet.roll) <= 180);
    const Pose back = pose_from(anchor, packet);
    // Coordinates below 300 m, some ten roundings of 2^-53 each on the way.
    ASSERT_LT(norm(back.p - X_WE.p), 300 * 20 * 0x1p-53);
    ASSERT_LT(turn_between(back.R, X_WE.R), kAngleError);
  }
}

TEST(CigiCoordinates, GimbalLockKeepsTheOrientation) {
  const Anchor anchor = AttachedTo{};
  for (const double pitch : {90.0, -90.0})
    for (double yaw = 0; yaw < 360; yaw += 7) {
      const Pose X_WE =
          compose(about({0, 0, 1}, yaw), compose(about({0, 1, 0}, pitch), about({1, 0, 0}, 40)));
      EXPECT_LT(turn_between(pose_from(anchor, placed(anchor, X_WE)).R, X_WE.R), kAngleError);
    }
}

TEST(CigiCoordinates, OnEarthThereAndBack) {
  std::mt19937_64 random(4);
  double worst = 0.0;
  for (int i = 0; i < 100'000; ++i) {
    OnEarth earth;
    earth.origin = {uniform(random, -90, 90), uniform(random, -180, 180), uniform(random, -100, 5e5)};
    earth.X_NW = i % 2 ? z_up() : random_pose(random, 10.0);
    const Pose X_WE = random_pose(random, 1000.0);
    const EntityControl packet = placed(earth, X_WE);
    ASSERT_FALSE(packet.is_attached);
    const Pose back = pose_from(earth, packet);
    worst = std::max(worst, norm(back.p - X_WE.p));
    ASSERT_LT(turn_between(back.R, X_WE.R), kAngleError);
  }
  EXPECT_LT(worst, 1e-8);
  std::printf("worst position there and back over Earth: %.3g m\n", worst);
}

TEST(CigiCoordinates, NorthOfTheOriginIsNorth) {
  OnEarth earth;
  earth.origin = {45, 10, 100};
  earth.X_NW = z_up();  // x north, y west, z up
  const EntityControl packet = placed(earth, compose({Matrix3::Identity(), {1000, 0, 0}}, z_up()));
  // 1 km on the meridian at 45 degrees: 1/111131.7 deg a metre (the meridian's radius there is 6367381.8 m).
  const double radius = 6378137.0 * (1 - 0.00669437999014) / std::pow(1 - 0.00669437999014 * 0.5, 1.5);
  EXPECT_NEAR(packet.position[0], 45 + 1000 / (radius + 100) / kDegree, 1e-8);
  EXPECT_NEAR(packet.position[1], 10, 1e-12);
  // The tangent plane leaves the ellipsoid: d^2 / 2R.
  EXPECT_NEAR(packet.position[2], 100 + 1e6 / (2 * radius), 1e-5);
  // Against the local horizon the nose is up by d/R.
  EXPECT_NEAR(packet.pitch, 1000 / radius / kDegree, 2e-6);
}

TEST(CigiCoordinates, RefusesWhatIsNoAnchor) {
  OnEarth earth;
  EXPECT_NO_THROW(validate(Anchor(earth)));
  earth.origin.latitude = 91;
  EXPECT_THROW(validate(Anchor(earth)), InputError);
  earth.origin.latitude = std::nan("");
  EXPECT_THROW(validate(Anchor(earth)), InputError);
  AttachedTo attached;
  attached.X_PW.R *= 2;
  EXPECT_THROW(validate(Anchor(attached)), InputError);
}

}  // namespace
}  // namespace touchstone

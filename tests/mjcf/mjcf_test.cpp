#include "touchstone/adapters/mjcf/mjcf.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone {
namespace {

using testing::HasSubstr;

std::filesystem::path write(const std::string& body) {
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) /
      (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".xml");
  std::ofstream(file) << "<mujoco model='arm'><compiler angle='radian' meshdir='" TOUCHSTONE_ROBOTS
                         "/mesh_arm/meshes'/><asset><mesh name='hand' file='hand.obj' "
                         "scale='0.001 0.001 0.001'/></asset>\n<worldbody>"
                      << body;
  return file;
}

Robot load(const std::string& worldbody) {
  return mjcf::load_robot(write(worldbody + "</worldbody></mujoco>"));
}

Vector3 middle(const Mechanism& arm, const std::vector<double>& q, std::uint32_t solid) {
  std::vector<Pose> X(arm.links().size());
  arm.link_poses({}, q, X);
  return transform(X[arm.link_of(solid)], arm.placed(solid).X_OS.p);
}

const std::string kBox = "<geom type='box' size='0.1 0.1 0.5' mass='3'/>";

TEST(Mjcf, BodiesTurnAboutTheirJointsAnchors) {
  // Turned by 90 degrees about z, the anchor 0.1 m along the body's y, which is the world's -x.
  const Robot robot = load(
      "<body name='a' pos='1 0 2' quat='0.7071067811865476 0 0 0.7071067811865476'>"
      "<joint name='j' axis='0 0 2' pos='0 0.1 0' range='-1 2' limited='true'/>" +
      kBox + "<body name='b' pos='0 0 1'><joint name='k' type='slide' axis='1 0 0'/>" + kBox +
      "</body></body>");
  const Mechanism arm(robot.mechanism);
  ASSERT_EQ(arm.value_count(), 2u);
  EXPECT_EQ(arm.links()[arm.base()].name, "world");
  EXPECT_LE(norm(middle(arm, {0, 0}, 0) - Vector3(1, 0, 2)), 1e-14);
  EXPECT_LE(norm(middle(arm, {0, 0}, 1) - Vector3(1, 0, 3)), 1e-14);
  EXPECT_LE(norm(middle(arm, {0, 0.5}, 1) - Vector3(1, 0.5, 3)), 1e-14);
  // The anchor is at (0.9, 0); half a turn takes x = 1 to 0.8.
  EXPECT_LE(norm(middle(arm, {std::acos(-1.0), 0}, 0) - Vector3(0.8, 0, 2)), 1e-14);
  EXPECT_EQ(arm.joints()[0].lower, -1.0);
  EXPECT_EQ(arm.joints()[1].upper, kInfinity);
  EXPECT_EQ(arm.links()[1].mass.mass, 3.0);
  EXPECT_LE(norm(arm.links()[1].mass.centre_L - Vector3(0, -0.1, 0)), 1e-15);
}

TEST(Mjcf, ABodyMayHaveSeveralJoints) {
  const Mechanism arm(
      load("<body name='a' pos='0 0 1'><joint name='x' type='slide' axis='1 0 0'/>"
           "<joint name='y' type='slide' axis='0 1 0'/><joint name='z' axis='0 0 1' pos='1 0 0'/>" +
           kBox + "</body>")
          .mechanism);
  ASSERT_EQ(arm.value_count(), 3u);
  EXPECT_LE(norm(middle(arm, {0.1, 0.2, 0}, 0) - Vector3(0.1, 0.2, 1)), 1e-15);
  EXPECT_LE(norm(middle(arm, {0.1, 0.2, std::acos(-1.0)}, 0) - Vector3(2.1, 0.2, 1)), 1e-14);
}

TEST(Mjcf, EveryShapeIsReadAndWhatCannotTouchIsNot) {
  const Robot robot = load(
      "<body name='a'><geom type='sphere' size='0.1'/><geom type='capsule' size='0.1 0.3'/>"
      "<geom type='cylinder' size='0.1 0.3'/><geom type='ellipsoid' size='0.1 0.2 0.3'/>" +
      kBox +
      "<geom name='mesh' type='mesh' mesh='hand'/>"
      "<geom type='sphere' size='9' contype='0' conaffinity='0'/></body>");
  EXPECT_EQ(robot.mechanism.links[1].solids.size(), 1u + 1u + 5u + 9u + 1u + 1u);
  ASSERT_EQ(robot.replaced.size(), 5u);
  EXPECT_EQ(robot.replaced[4].shape, "mesh");
  EXPECT_EQ(robot.replaced[4].triangles, 12u);
  // The mesh stands where its file has it, though MuJoCo keeps it about its centre of mass.
  const PlacedHexahedron& hand = robot.mechanism.links[1].solids.back();
  double low = 1e9, high = -1e9;
  for (const Vector3& v : hand.solid.vertices()) {
    low = std::min(low, transform(hand.X_OS, v).x());
    high = std::max(high, transform(hand.X_OS, v).x());
  }
  EXPECT_NEAR(low, 0.0, 1e-7);
  EXPECT_NEAR(high, 0.12, 1e-7);
}

TEST(Mjcf, ExcludedBodiesAndBitsBecomeExemptPairs) {
  const Mechanism arm(
      mjcf::load_robot(write("<body name='a'>" + kBox + "</body><body name='b' pos='3 0 0'>" + kBox +
                             "</body><body name='c' pos='6 0 0'>" +
                             "<geom type='box' size='1 1 1' contype='2' conaffinity='2'/></body>"
                             "</worldbody><contact><exclude body1='a' body2='b'/></contact>"
                             "</mujoco>"))
          .mechanism);
  EXPECT_TRUE(arm.is_exempt(0, 1));
  EXPECT_TRUE(arm.is_exempt(0, 2));
  EXPECT_TRUE(arm.is_exempt(1, 2));
}

std::string error(const std::string& worldbody) {
  return refusal_of([&] { load(worldbody); });
}

TEST(Mjcf, AFloorOfTheWorldIsLeftOutAndNoted) {
  const Robot robot =
      load("<geom name='floor' type='plane' size='1 1 1'/><body><joint axis='0 0 1'/>" + kBox + "</body>");
  EXPECT_TRUE(robot.mechanism.links[0].solids.empty());
  ASSERT_EQ(robot.notes.size(), 1u);
  EXPECT_THAT(robot.notes[0], HasSubstr("plane 'floor' of the world is left out"));
}

TEST(Mjcf, BadFilesAreRefused) {
  EXPECT_THAT(error("<body name='a'><freejoint/>" + kBox + "</body>"),
              HasSubstr("free joints are not supported"));
  EXPECT_THAT(error("<body name='a'><joint name='j' type='ball'/>" + kBox + "</body>"),
              HasSubstr("joint 'j' of body 'a': ball joints"));
  EXPECT_THAT(error("<geom name='hills' type='hfield' hfield='h'/>"), HasSubstr("BadFilesAreRefused.xml: "));
  EXPECT_THAT(error("<body><geom type='mesh' mesh='none'/></body>"), HasSubstr("none"));
  EXPECT_THAT(error("<body><geom type='box' size='1 nan 1'/></body>"), HasSubstr("BadFilesAreRefused.xml: "));
  EXPECT_THAT(error("<body><unknown/></body>"), HasSubstr("unknown"));
  EXPECT_THAT(error("<body>"), HasSubstr("BadFilesAreRefused.xml: "));
  try {
    mjcf::load_robot("not_there.xml");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("not_there.xml: cannot be read"));
  }
}

}  // namespace
}  // namespace touchstone

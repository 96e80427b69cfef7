#include "touchstone/adapters/robots/mesh_units.hpp"

#include <gmock/gmock.h>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using testing::HasSubstr;

/// Two links, joints 0.3 m and 0.4 m on, and a mesh of a given size on each.
Robot arm_with(double first, double second) {
  Robot robot;
  JointDescription lift, turn;
  turn.name = "turn", turn.parent = "base", turn.child = "upper", turn.X_PJ.p = {0, 0, 0.3};
  lift.name = "lift", lift.parent = "upper", lift.child = "lower", lift.X_PJ.p = {0.4, 0, 0};
  robot.mechanism.joints = {turn, lift};
  robot.replaced.push_back({"upper", "c", "mesh", "upper.stl", 12, 1, 0.0, first});
  robot.replaced.push_back({"lower", "c", "mesh", "lower.stl", 12, 1, 0.0, second});
  return robot;
}

std::string error_of(Robot robot, const RobotOptions& options = {}) {
  try {
    check_mesh_units("arm.urdf", options, robot);
  } catch (const InputError& error) {
    return error.what();
  }
  return robot.notes.empty() ? "accepted" : "noted: " + robot.notes[0];
}

TEST(MeshUnits, JointsReachAsFarAsTheLongestChain) {
  EXPECT_NEAR(joint_reach(arm_with(1, 1).mechanism), 0.7, 1e-15);
}

TEST(MeshUnits, MillimetresForMetresAreRefusedByName) {
  EXPECT_EQ(error_of(arm_with(0.5, 0.4)), "accepted");
  EXPECT_EQ(error_of(arm_with(0.5, 0.001)), "accepted");  // a screw
  EXPECT_EQ(error_of(arm_with(6, 0.4)), "accepted");
  EXPECT_THAT(error_of(arm_with(0.5, 60)),
              HasSubstr("link 'lower': mesh 'lower.stl' is 60 m across"));  // a hand
  EXPECT_THAT(error_of(arm_with(500, 400)),
              HasSubstr("arm.urdf: link 'upper': mesh 'upper.stl' is 500 m across, the largest of the robot, "
                        "while its joints reach 0.7 m: a factor of 714.286; are its units"));
  EXPECT_THAT(error_of(arm_with(0.0005, 0.0004)), HasSubstr("a factor of 1400; are its units"));
  EXPECT_THAT(error_of(arm_with(0.02, 0.01)), HasSubstr("noted: arm.urdf: link 'upper'"));  // inches
  EXPECT_THAT(error_of(arm_with(20, 16)), HasSubstr("noted: arm.urdf: link 'upper'"));
  RobotOptions any;
  any.any_mesh_size = true;
  EXPECT_THAT(error_of(arm_with(500, 400), any), HasSubstr("noted: "));
}

TEST(MeshUnits, WithoutDistancesNothingIsSaid) {
  Robot robot = arm_with(500, 400);
  for (JointDescription& joint : robot.mechanism.joints) joint.X_PJ.p = Vector3::Zero();
  EXPECT_EQ(error_of(robot), "accepted");
  robot = arm_with(0, 0);
  EXPECT_EQ(error_of(robot), "accepted");
}

}  // namespace
}  // namespace touchstone

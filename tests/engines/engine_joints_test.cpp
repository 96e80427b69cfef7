// Joints between bodies in every dynamics engine that has them: closed loops, motors, stops, joined and let
// go mid-run, within what each method may be off. An engine without them must refuse them by name.

#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/engines/engine_suite.hpp"

namespace touchstone {
namespace {

using namespace engine_tests;
using physics::BodyJointKind;
using physics::DynamicScene;
using physics::EngineFeature;
using physics::JointAddress;
using physics::JointDrive;
using physics::SceneAction;
using physics::SceneBodyJoint;

const Vector3 kZero = Vector3::Zero();
constexpr double kSide = 0.2;
constexpr JointAddress kJoint{JointAddress::kBodyJoint, 0};

class EngineJoints : public EngineSuite {
 protected:
  /// True where the engine has no joints between bodies, and then that it says so; or none like the scene's
  /// (MuJoCo's are balls, hinges and fixed ones without motors or stops).
  bool is_refused(const DynamicScene& scene) {
    if (can(EngineFeature::body_joints)) {
      if (GetParam().engine != "mujoco") return false;
      try {
        engines().make(GetParam(), scene);
      } catch (const InputError& error) {
        const std::string text = error.what();
        EXPECT_EQ(text.find("engine 'mujoco"), 0u) << text;
        EXPECT_NE(text.find("': unsupported: "), std::string::npos) << text;
        EXPECT_NE(text.find("(joint 'joint')"), std::string::npos) << text;
        return true;
      }
      return false;
    }
    try {
      engines().make(GetParam(), scene);
      ADD_FAILURE() << "a scene that it cannot do was taken";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("joints between bodies (joint 'joint')"), std::string::npos)
          << error.what();
    }
    return true;
  }
};

SceneBodyJoint joint_at(BodyJointKind kind, std::size_t parent, std::size_t child, const Vector3& p_W) {
  SceneBodyJoint joint;
  joint.name = "joint";
  joint.kind = kind;
  joint.parent = parent, joint.child = child;
  joint.p_W = p_W;
  return joint;
}

/// No gravity; two cubes with a gap of a side between their faces, joined in its middle.
DynamicScene two_cubes(BodyJointKind kind, double duration) {
  DynamicScene scene = empty_scene(duration);
  scene.gravity_W.setZero();
  const std::size_t a = add_box(scene, "a", {kSide, kSide, kSide}, {-kSide, 0, 0}, 1.0);
  const std::size_t b = add_box(scene, "b", {kSide, kSide, kSide}, {kSide, 0, 0}, 3.0);
  scene.joints.push_back(joint_at(kind, a, b, {0, 0, 0}));
  return scene;
}

/// Bullet's hinges have two stops or none; a second one that nobody asked for is no answer.
TEST_P(EngineJoints, AHingeWithOneStopIsTakenAsItIsOrRefused) {
  DynamicScene scene = two_cubes(BodyJointKind::hinge, 0.1);
  scene.joints[0].upper = 0.5;
  if (is_refused(scene)) return;
  try {
    engines().make(GetParam(), scene);
    EXPECT_NE(GetParam().engine, "bullet");
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("a stop on one side alone (joint 'joint')"), std::string::npos)
        << error.what();
  }
}

/// Of the point of an object that is at p_W at the start.
Vector3 point_of(const physics::DynamicsEngine& engine, std::size_t object, const Vector3& p_W) {
  const Pose& start = engine.scene().scene.objects[object].X_WO;
  return transform(engine.object_pose(object), transform(inverse(start), p_W));
}

TEST_P(EngineJoints, ABallHoldsItsPointAndMomenta) {
  DynamicScene scene = two_cubes(BodyJointKind::ball, 1.0);
  // About the ball: both its bodies have its velocity there.
  scene.bodies[0].w_W = {0, 0, 1};
  scene.bodies[0].v_W = {0, -kSide, 0};
  scene.bodies[1].w_W = {0, 0, -0.5};
  scene.bodies[1].v_W = {0, -0.5 * kSide, 0};
  if (is_refused(scene)) return;
  const auto start = engines().make(GetParam(), scene);
  const auto engine = run(GetParam(), scene);
  // Drift is drawn back by 0.2 a step: some v w h^2 are left.
  expect_error("ball apart [m]", norm(point_of(*engine, 0, kZero) - point_of(*engine, 1, kZero)), 1e-9, 1e-6);
  expect_error("momentum [N s]", norm(engine->linear_momentum() - start->linear_momentum()), 1e-12, 1e-9);
  expect_error("angular [N m s]", norm(engine->angular_momentum() - start->angular_momentum()), 1e-9, 1e-4);
}

TEST_P(EngineJoints, AFixedOneMakesOneBody) {
  DynamicScene scene = two_cubes(BodyJointKind::fixed, 1.0);
  scene.bodies[0].v_W = {0, 0.4, 0};  // a quarter of the mass: the two are brought to one motion at once
  if (is_refused(scene)) return;
  const auto engine = run(GetParam(), scene);
  const double share = 0.4 * 1.0 / 4.0;
  expect_error("mean speed [m/s]", norm(engine->linear_momentum() / 4.0 - Vector3(0, share, 0)), 1e-12, 1e-9);
  // Inertia about the centre of mass: both cubes' own and m r^2; the moment of momentum is 1 kg's.
  const double own = (1.0 + 3.0) * kSide * kSide / 6.0, steiner = 1.0 * 0.09 + 3.0 * 0.01;
  const double w = -0.3 * 0.4 / (own + steiner);
  expect_error("turns at [rad/s]", norm(*engine->angular_velocity(0) - Vector3(0, 0, w)), 1e-9, 1e-3);
  expect_error("as one [rad/s]", norm(*engine->angular_velocity(0) - *engine->angular_velocity(1)), 1e-9,
               1e-6);
}

TEST_P(EngineJoints, AHingeIsDrivenBetweenFreeBodies) {
  DynamicScene scene = two_cubes(BodyJointKind::hinge, 1.0);
  scene.joints[0].drive.drive = {JointDrive::Mode::rate, 0.0, 0.2, 5.0};
  if (is_refused(scene)) return;
  const auto engine = run(GetParam(), scene);
  expect_error("driven at [rad/s]", std::abs(engine->joint_rate(kJoint) - 0.2), 1e-9, 1e-6);
  expect_error("to [rad]", std::abs(engine->joint_value(kJoint) - 0.2), 1e-2, 1e-2);
  expect_error("nothing outside [N m s]", norm(engine->angular_momentum()), 1e-9, 1e-5);
  EXPECT_LT(engine->angular_velocity(0)->z(), 0.0);
  EXPECT_GT(engine->angular_velocity(1)->z(), 0.0);
}

TEST_P(EngineJoints, ATorqueActsBothWays) {
  DynamicScene scene = two_cubes(BodyJointKind::hinge, 0.5);
  scene.joints[0].drive.drive = {JointDrive::Mode::torque, 0.02, 0.0, 5.0};
  if (is_refused(scene)) return;
  const auto engine = run(GetParam(), scene);
  // About the hinge, where the bodies' centres stand a side away on either hand: the pair turns against each
  // other, and the common centre of mass stays.
  EXPECT_GT(engine->joint_rate(kJoint), 0.01);
  expect_error("hinge apart [m]", norm(point_of(*engine, 0, kZero) - point_of(*engine, 1, kZero)), 1e-9,
               1e-6);
  expect_error("nothing outside [N m s]", norm(engine->angular_momentum()), 1e-9, 1e-5);
  expect_error("nor [N s]", norm(engine->linear_momentum()), 1e-12, 1e-9);
  const auto own = run({"own", "native"}, scene);
  expect_error("turned, from ours [rad]", std::abs(engine->joint_value(kJoint) - own->joint_value(kJoint)),
               0.0, 1e-3 * own->joint_value(kJoint) + kStep * own->joint_rate(kJoint));
}

TEST_P(EngineJoints, ASliderMeetsItsStop) {
  DynamicScene scene = two_cubes(BodyJointKind::slider, 1.0);
  scene.joints[0].axis_W = {1, 0, 0};
  scene.joints[0].upper = 0.05;
  scene.bodies[1].v_W = {0.2, 0, 0};
  if (is_refused(scene)) return;
  const auto engine = run(GetParam(), scene);
  // Met a step late.
  expect_error("stopped at [m]", std::abs(engine->joint_value(kJoint) - 0.05), 1e-8, 1.1 * 0.2 * kStep);
  expect_error("then one [m/s]", norm(*engine->velocity(0) - *engine->velocity(1)), 1e-9, 1e-3);
}

TEST_P(EngineJoints, ALoopOfFourOnTheGroundSwings) {
  // A bar hung level by two legs: a parallelogram.
  constexpr double kLeg = 0.5, kBar = 5.0, kLength = 0.8;
  DynamicScene scene = empty_scene(0.5);
  const std::size_t left = add_box(scene, "left", {0.02, 0.02, 0.8}, {0, 0, -0.4}, kLeg);
  const std::size_t right = add_box(scene, "right", {0.02, 0.02, 0.8}, {1, 0, -0.4}, kLeg);
  const std::size_t bar = add_box(scene, "bar", {1.0, 0.02, 0.02}, {0.5, 0, -0.8}, kBar);
  const auto hinge = [&](const char* name, std::size_t parent, std::size_t child, const Vector3& p_W) {
    SceneBodyJoint joint = joint_at(BodyJointKind::hinge, parent, child, p_W);
    joint.name = name;
    joint.axis_W = {0, 1, 0};
    scene.joints.push_back(joint);
  };
  hinge("joint", kNoObject, left, {0, 0, 0});
  hinge("right top", kNoObject, right, {1, 0, 0});
  hinge("left end", left, bar, {0, 0, -0.8});
  hinge("right end", bar, right, {1, 0, -0.8});
  const double speed = 0.5;
  scene.bodies[bar].v_W = {-speed, 0, 0};
  for (const std::size_t leg : {left, right}) {
    scene.bodies[leg].v_W = {-0.5 * speed, 0, 0};
    scene.bodies[leg].w_W = {0, speed / 0.8, 0};
  }
  if (is_refused(scene)) return;
  const auto engine = run(GetParam(), scene);
  // Where it is, it has the energy that its height leaves. A leg's inertia about its hinge, over the square
  // of its length:
  const double leg = kLeg * (1.0 / 3.0 + 0.02 * 0.02 / (12.0 * kLength * kLength));
  const double height = engine->object_pose(bar).p.z() + kLength, v = norm(*engine->velocity(bar));
  const double expected =
      std::sqrt(speed * speed - 2 * kGravity * height * (kBar + kLeg) / (kBar + 2.0 * leg));
  expect_error("swings at [m/s]", std::abs(v - expected), 1e-9, 3 * kGravity * kStep);
  expect_error("level [rad]", std::abs(engine->object_pose(bar).R(2, 0)), 1e-9, 1e-5);
  // A step of g h^2 / 2 aside, of which error reduction takes 0.2.
  expect_error("loop closed [m]",
               norm(point_of(*engine, bar, {1, 0, -0.8}) - point_of(*engine, right, {1, 0, -0.8})), 1e-9,
               0.5 * kGravity * kStep * kStep / 0.2);
}

TEST_P(EngineJoints, JoinsAsTheyStandAndLetsGo) {
  // A joint that is off joins at 0.5 s, and parts at 1 s.
  DynamicScene scene = two_cubes(BodyJointKind::fixed, 1.5);
  scene.joints[0].is_on = false;
  scene.bodies[1].v_W = {0.1, 0, 0};
  SceneAction action;
  action.kind = SceneAction::Kind::join;
  action.joint = kJoint;
  action.time = 0.5;
  scene.actions.push_back(action);
  action.kind = SceneAction::Kind::part;
  action.time = 1.0;
  scene.actions.push_back(action);
  if (is_refused(scene)) return;
  // Until it joins, only the second cube moves.
  const auto engine = engines().make(GetParam(), scene);
  const auto go_to = [&](double time) {
    while (engine->time() < time - 0.5 * kStep) {
      engine->begin_step();
      ASSERT_TRUE(engine->step().failure.empty());
    }
  };
  const auto apart = [&] { return engine->object_pose(1).p.x() - engine->object_pose(0).p.x(); };
  go_to(0.5);
  EXPECT_NEAR(norm(*engine->velocity(0)), 0.0, 1e-12);
  EXPECT_NEAR(apart(), 2 * kSide + 0.05, 1e-9);
  // Joined they have the momentum's speed, and stay as they stood.
  go_to(1.0);
  expect_error("joined at [m/s]", norm(*engine->velocity(0) - Vector3(0.075, 0, 0)), 1e-9, 1e-6);
  expect_error("as they stood [m]", std::abs(apart() - (2 * kSide + 0.05)), 1e-6, 1.1 * 0.1 * kStep);
  const double before = apart();
  // Parted they go on.
  go_to(1.5);
  EXPECT_NEAR(apart(), before, 1e-6);  // one speed, nothing holds
  EXPECT_NEAR(norm(*engine->velocity(1)), 0.075, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Engines, EngineJoints, ::testing::ValuesIn(choices()), name_of);

}  // namespace
}  // namespace touchstone

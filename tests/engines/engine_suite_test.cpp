// Every dynamics engine with each of its checks: closed forms within what its method may
// be off, stated with each. The own engine's error stands beside in the test's properties.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/engines/engine_suite.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone {
namespace {

using namespace engine_tests;
using physics::BodyKind;
using physics::DynamicScene;
using physics::EngineChoice;
using physics::EngineFeature;
using physics::EngineRegistry;

TEST_P(EngineSuite, FreeFall) {
  DynamicScene scene = empty_scene(1.0);
  const std::size_t box = add_box(scene, "box", {0.2, 0.2, 0.2}, {1, 2, 30}, 3.0);
  scene.bodies[box].v_W = {1, 0, 2};
  const auto engine = run(GetParam(), scene);
  const Vector3 expected(1 + 1, 2, 30 + 2 - 0.5 * kGravity);
  // Semi-implicit Euler: sum of g h^2 i instead of g t^2 / 2, g h t / 2 lower.
  expect_error("free fall [m]", norm(engine->object_pose(box).p - expected), 1e-12,
               0.5 * kGravity * kStep * 1.0 + 1e-9);
  expect_error("its speed [m/s]", norm(*engine->velocity(box) - Vector3(1, 0, 2 - kGravity)), 1e-12, 1e-9);
}

TEST_P(EngineSuite, FlightKeepsMomentum) {
  DynamicScene scene = empty_scene(1.0);
  scene.gravity_W.setZero();
  const std::size_t box = add_box(scene, "box", {0.2, 0.2, 0.2}, {1, 2, 30}, 3.0);
  scene.bodies[box].v_W = {1, -4, 2};
  scene.bodies[box].w_W = {1, 2, -3};
  const auto start = engines().make(GetParam(), scene);
  const auto engine = run(GetParam(), scene);
  expect_error("momentum [N s]", norm(engine->linear_momentum() - start->linear_momentum()), 1e-12, 1e-9);
  // A cube: no gyroscopic moment; an engine's turns are by first-order steps of a constant w.
  expect_error("angular [N m s]", norm(engine->angular_momentum() - start->angular_momentum()), 1e-12, 1e-8);
}

TEST_P(EngineSuite, SlidesToAStop) {
  DynamicScene scene = empty_scene(0.6);
  add_ground(scene);
  const std::size_t plate = add_box(scene, "plate", {0.2, 0.2, 0.002}, {0, 0, 0.001}, 1.0);
  scene.bodies[plate].v_W = {1, 0, 0};
  const auto engine = run(GetParam(), scene);
  const double way = 1.0 / (2 * 0.5 * kGravity);
  // Speed is taken before the way is gone: v h / 2 short. Soft friction takes longer: a share of the way.
  const double limit = is_soft() ? 0.05 * way : 1.0 * kStep;
  expect_error("sliding way [m]", std::abs(engine->object_pose(plate).p.x() - way), 1e-6, limit);
}

TEST_P(EngineSuite, APairHasItsOwnFriction) {
  if (!can(EngineFeature::mixed_friction)) return;  // refused by name: EveryFeatureIsTakenOrNamed
  DynamicScene scene = empty_scene(1.2);
  const std::size_t ground = add_ground(scene);
  const std::size_t rough = add_box(scene, "rough", {0.2, 0.2, 0.01}, {0, 0, 0.005}, 1.0),
                    smooth = add_box(scene, "smooth", {0.2, 0.2, 0.01}, {0, 1, 0.005}, 1.0);
  scene.bodies[rough].v_W = scene.bodies[smooth].v_W = {1, 0, 0};
  scene.pairs.push_back({smooth, ground, 0.1, {}});
  const auto engine = run(GetParam(), scene);
  for (const auto& [plate, friction] : {std::pair{rough, 0.5}, std::pair{smooth, 0.1}})
    expect_error("sliding way [m]",
                 std::abs(engine->object_pose(plate).p.x() - 1.0 / (2 * friction * kGravity)), 1e-6,
                 1.0 * kStep);
}

TEST_P(EngineSuite, RestsOnASlope) {
  DynamicScene scene = empty_scene(1.0);
  // 20 degrees, friction 0.5: the friction angle is 26.6.
  const double angle = 20.0 * 3.14159265358979323846 / 180.0;
  scene.gravity_W = {kGravity * std::sin(angle), 0, -kGravity * std::cos(angle)};
  add_ground(scene);
  const std::size_t box = add_box(scene, "box", {0.2, 0.2, 0.2}, {0, 0, 0.1}, 8.0);
  const auto engine = run(GetParam(), scene);
  // A tenth of what it would slide at friction 0.3 in the time; soft friction creeps at a speed of its own.
  expect_error("slope creep [m]", std::abs(engine->object_pose(box).p.x()), 1e-9, is_soft() ? 2e-2 : 1e-3);
}

TEST_P(EngineSuite, Bounces) {
  DynamicScene scene = empty_scene(1.0);
  const std::size_t ground = add_ground(scene, 0.0);
  const std::size_t box = add_box(scene, "box", {0.2, 0.2, 0.2}, {0, 0, 0.6}, 8.0, 0.0);
  scene.bodies[box].surface.restitution = 0.5;
  scene.bodies[ground].surface.restitution = 0.25;  // the larger counts
  scene.contact_margin = 1e-2;
  if (!can(EngineFeature::restitution)) {
    EXPECT_THROW(engines().make(GetParam(), scene), InputError);
    return;
  }
  const double height = 0.5, v = std::sqrt(2 * kGravity * height), fall = v / kGravity;
  scene.scene.duration = std::round((fall + 0.5 * v / kGravity) / kStep) * kStep;  // the top of the bounce
  const auto engine = run(GetParam(), scene);
  // The hit is a step late or early, and its depth is not taken back at once: v h each way, and (1 + e) g h
  // on the speed, which the rise multiplies by its time.
  double limit = 2 * v * kStep + 1.5 * kGravity * kStep * (0.5 * v / kGravity);
  // Bullet's error reduction, 0.2 of a depth of up to v h a step, is part of the speed that it leaves with.
  if (GetParam().engine == "bullet") limit += (0.7 * 0.7 - 0.5 * 0.5) * height;
  expect_error("bounce height [m]", std::abs(engine->object_pose(box).p.z() - (0.1 + 0.25 * height)), 1e-5,
               limit);
}

TEST_P(EngineSuite, AStackOfFiveStands) {
  DynamicScene scene = empty_scene(2.0);
  add_ground(scene);
  for (int i = 0; i < 5; ++i)
    add_box(scene, "box " + std::to_string(i), {0.2, 0.2, 0.2}, {0, 0, 0.1 + 0.2 * i}, 8.0);
  const auto engine = run(GetParam(), scene);
  ASSERT_TRUE(engine->is_over()) << "stopped at " << engine->time() << " s";
  double moved = 0.0;
  for (std::size_t i = 1; i < scene.bodies.size(); ++i)
    moved = std::max(moved, norm(engine->object_pose(i).p - scene.scene.objects[i].X_WO.p));
  // The penetration that contacts allow, five times; ODE's and Bullet's error reduction leave a step's sag at
  // each.
  expect_error("stack moved [m]", moved, 1e-9, 5e-3);
  std::vector<physics::EngineContact> contacts;
  engine->list_contacts(contacts);
  Vector3 on_ground = Vector3::Zero();
  for (const physics::EngineContact& contact : contacts) {
    if (contact.solids.a == 0) on_ground -= contact.force_W;
    if (contact.solids.b == 0) on_ground += contact.force_W;
  }
  // One step's; sweeps that end early (ODE's 20) leave a share of it to the next.
  const double weight = 5 * 8.0 * kGravity;
  expect_error("its weight [N]", norm(on_ground - Vector3(0, 0, -weight)), 1e-6 * weight, 0.25 * weight);
}

/// Leaning by a thousandth of its size, so that corners bear next to nothing: pivots of ODE's direct method
/// tie. Through MuJoCo's soft contacts such cubes sink and fall; they are asked for a run alone.
TEST_P(EngineSuite, AStackOfMillimetresStands) {
  DynamicScene scene = empty_scene(0.5);
  add_ground(scene);
  for (int i = 0; i < 5; ++i)
    add_box(scene, "box " + std::to_string(i), {3e-3, 3e-3, 3e-3}, {1e-5 * i, 0, 3e-3 * (i + 0.5)}, 7.3e-5);
  const auto engine = run(GetParam(), scene);
  ASSERT_TRUE(engine->is_over()) << "stopped at " << engine->time() << " s";
  double moved = 0.0;
  for (std::size_t i = 1; i < scene.bodies.size(); ++i)
    moved = std::max(moved, norm(engine->object_pose(i).p - scene.scene.objects[i].X_WO.p));
  expect_error("millimetres moved [m]", moved, 1e-9, is_soft() ? 0.1 : 5e-4);
}

/// ODE's direct method breaks down on the same stack: steps are taken again with its contacts softer. An arm
/// beside it holds 100 kg, but for 1e-7 m/s of ODE's usual softness; as soft as contacts of cubes of 0.07 g
/// its hinge would let the load fall.
TEST(EngineOde, AnArmHoldsItsLoadBesideContactsThatAreSoftened) {
  std::size_t asked = 0;
  for (const EngineChoice& choice : choices()) {
    if (choice.engine != "ode_direct") continue;
    ++asked;
    // The stack, and beside it an arm of one link, whose joint brakes.
    DynamicScene scene = empty_scene(0.5);
    add_ground(scene);
    for (int i = 0; i < 5; ++i)
      add_box(scene, "box " + std::to_string(i), {3e-3, 3e-3, 3e-3}, {1e-5 * i, 0, 3e-3 * (i + 0.5)}, 7.3e-5);
    const std::size_t load = add_box(scene, "load", {0.2, 0.2, 0.2}, {3, 0, 1}, 100.0);
    scene.bodies[load].kind = BodyKind::link;
    physics::SceneJoint joint;
    joint.name = "joint";
    joint.child = load;
    joint.p_W = {2, 0, 1};
    joint.axis_W = {0, 1, 0};
    joint.drive.drive = {physics::JointDrive::Mode::brake, 0.0, 0.0, 1e5};
    scene.mechanisms.push_back({"arm", {joint}, {}});
    // Steps that were softened, and the load's speed.
    const auto engine = engines().make(choice, scene);
    std::uint32_t softened = 0;
    double falls = 0.0;
    while (!engine->is_over()) {
      const Vector3 from_W = engine->object_pose(load).p;
      engine->begin_step();
      const physics::EngineStep step = engine->step();
      ASSERT_EQ(step.failure, "") << choice.text();
      EXPECT_LE(step.unconverged, 1u);
      softened += step.unconverged;
      falls = std::max(falls, norm(engine->object_pose(load).p - from_W) / kStep);
    }
    std::printf("  %-18s %u steps softened, its load at %.1e m/s at most\n", choice.text().c_str(), softened,
                falls);
    EXPECT_GT(softened, 0u) << choice.text();
    EXPECT_LT(falls, 1e-6) << choice.text();
  }
  if (asked == 0) GTEST_SKIP() << "no ode_direct in this build";
}

/// By ODE's own check the contacts of such a stack tie so that its direct method breaks down in the fourth
/// step, softened or not.
TEST(EngineOde, AStackOfTwentyGoesOnWhereTheDirectMethodBreaksDown) {
  std::size_t asked = 0;
  for (const EngineChoice& choice : choices()) {
    if (choice.engine != "ode_direct") continue;
    ++asked;
    DynamicScene scene = empty_scene(0.02);
    add_ground(scene);
    for (int i = 0; i < 20; ++i)
      add_box(scene, "box " + std::to_string(i), {0.3, 0.3, 0.3}, {0, 0, 0.3 * (i + 0.5)}, 2.0);
    const auto engine = run(choice, scene);
    EXPECT_TRUE(engine->is_over()) << choice.text() << " stopped at " << engine->time() << " s";
    // What contacts of ODE's usual softness sink by in a step or two.
    for (std::size_t i = 1; i < scene.bodies.size(); ++i)
      EXPECT_LE(norm(engine->object_pose(i).p - scene.scene.objects[i].X_WO.p), 1e-3) << choice.text() << i;
  }
  if (asked == 0) GTEST_SKIP() << "no ode_direct in this build";
}

TEST_P(EngineSuite, AnOverlapAtTheStartPartsAtACappedSpeedOrIsNamed) {
  DynamicScene scene = empty_scene(0.6);
  scene.gravity_W.setZero();
  scene.push_out = 10.0;
  const std::size_t left = add_box(scene, "left", {0.2, 0.2, 0.2}, {0, 0, 5}, 1.0),
                    right = add_box(scene, "right", {0.2, 0.2, 0.2}, {0.19, 0.02, 5.01}, 2.0);
  if (is_soft()) {
    const std::string text = refusal_of([&] { engines().make(GetParam(), scene); });
    EXPECT_EQ(text.find("engine 'mujoco': unsupported: an overlap at the start"), 0u) << text;
    return;
  }
  const auto engine = engines().make(GetParam(), scene);
  double fastest = 0.0;
  while (!engine->is_over()) {
    engine->begin_step();
    ASSERT_EQ(engine->step().failure, "");
    fastest = std::max(fastest, norm(Vector3(*engine->velocity(right) - *engine->velocity(left))));
  }
  EXPECT_LE(fastest, 1.01 * scene.part_speed);
  EXPECT_LT(engine->worst_depth(), 2e-4);
}

TEST_P(EngineSuite, AKinematicBodyPushesOn) {
  DynamicScene scene = empty_scene(1.0);
  scene.gravity_W.setZero();
  const std::size_t box = add_box(scene, "box", {0.2, 0.2, 0.2}, {0, 0, 0}, 2.0, 0.0);
  const std::size_t jaw = add_box(scene, "jaw", {0.2, 0.2, 0.2}, {-0.21, 0, 0}, 0.0, 0.0);
  scene.bodies[jaw].kind = BodyKind::kinematic;
  MotionSegment segment;
  segment.duration = 1.0;
  segment.velocity_W = {0.1, 0, 0};
  scene.scene.objects[jaw].motion.segments.push_back(segment);
  if (!can(EngineFeature::kinematic_bodies)) {
    EXPECT_THROW(engines().make(GetParam(), scene), InputError);
    return;
  }
  const auto engine = run(GetParam(), scene);
  EXPECT_NEAR(engine->object_pose(jaw).p.x(), -0.11, 1e-12);
  // Met a step early or late; depth of a step is taken back over some.
  expect_error("pushed to [m]", std::abs(engine->object_pose(box).p.x() - 0.09), 1e-8, 4 * 0.1 * kStep);
  expect_error("pushed at [m/s]", norm(*engine->velocity(box) - Vector3(0.1, 0, 0)), 1e-9, 1e-3);
}

TEST_P(EngineSuite, NamesWhatItCannotDo) {
  // An arm with everything, a latch, a kinematic body, bounces and a frustum.
  DynamicScene scene = empty_scene(0.1);
  add_ground(scene);
  const std::size_t link = add_box(scene, "link", {0.2, 0.2, 0.2}, {0, 0, 5}, 1.0);
  scene.bodies[link].kind = BodyKind::link;
  const std::size_t tool = add_box(scene, "tool", {0.2, 0.2, 0.2}, {0, 0, 8}, 1.0);
  scene.bodies[tool].surface.restitution = 0.5;
  physics::SceneJoint joint;
  joint.name = "joint";
  joint.child = link;
  joint.p_W = {0, 0, 5};
  joint.lower = -1;
  joint.drive.drive = {physics::JointDrive::Mode::brake, 0.0, 0.0, 10.0};
  scene.mechanisms.push_back({"arm", {joint}, {}});
  physics::SceneAction rate;
  rate.time = 0.01;
  rate.drive.drive = {physics::JointDrive::Mode::rate, 0.0, 0.1, 10.0};
  scene.actions.push_back(rate);
  rate.drive.drive = {physics::JointDrive::Mode::torque, 1.0, 0.0, 10.0};
  scene.actions.push_back(rate);
  scene.scene.latches.push_back({"link", "tool", {}});
  const auto features = engines().engine(GetParam()).features(GetParam().check);
  const std::vector<physics::EngineNeed> needs = physics::needs_of(scene);
  EXPECT_EQ(needs.size(), 7u);
  std::size_t lacking = 0;
  for (const physics::EngineNeed& need : needs) lacking += features.has(need.feature) ? 0 : 1;
  const std::vector<std::string> unsupported = physics::unsupported(features, scene);
  EXPECT_EQ(unsupported.size(), lacking);
  if (lacking == 0) {
    EXPECT_NO_THROW(engines().make(GetParam(), scene));
    return;
  }
  try {
    engines().make(GetParam(), scene);
    ADD_FAILURE() << "a scene that it cannot do was taken";
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find("engine '" + GetParam().text() + "': unsupported: "), 0u) << text;
    for (const std::string& each : unsupported) EXPECT_NE(text.find(each), std::string::npos) << text;
  }
}

/// Two cubes, "box" and "other", on which the scenes below put what they ask for.
constexpr std::size_t kBox = 0, kOther = 1;

/// Makes "box" the link of an arm of one joint.
physics::SceneJoint& add_arm(DynamicScene& scene) {
  scene.bodies[kBox].kind = BodyKind::link;
  physics::SceneJoint joint;
  joint.name = "joint";
  joint.child = kBox;
  joint.p_W = {0, 0, 5};
  scene.mechanisms.push_back({"arm", {joint}, {}});
  return scene.mechanisms[0].joints[0];
}

void add_driven_arm(DynamicScene& scene, physics::JointDrive::Mode mode) {
  physics::JointDrive& drive = add_arm(scene).drive.drive;
  drive.mode = mode;
  drive.torque = drive.rate = drive.stiffness = 0.1, drive.limit = 10.0;
}

void make_frustum(DynamicScene& scene) {
  std::array<Vector3, 8> v = Hexahedron::from_size({0.2, 0.2, 0.2}).vertices();
  for (Vector3& p : v)
    if (p.z() > 0.0) p.x() *= 0.5, p.y() *= 0.5;
  scene.scene.objects[kBox].tree = HexahedronTree({{"box", Hexahedron::from_vertices(v), {}}}, "box");
}

void exempt_a_part(DynamicScene& scene) {
  Pose aside;
  aside.p = {0, 0.2, 0};
  scene.scene.objects[kBox].tree = HexahedronTree({{"box", Hexahedron::from_size({0.2, 0.2, 0.2}), {}},
                                                   {"side", Hexahedron::from_size({0.2, 0.2, 0.2}), aside}},
                                                  "box");
  scene.scene.exempt_pairs.push_back({"box/side", "other/box"});
}

void add_set_joint(DynamicScene& scene) {
  add_arm(scene);
  physics::SceneAction set;
  set.kind = physics::SceneAction::Kind::set_joint;
  scene.actions.push_back(set);
}

void add_ball(DynamicScene& scene) {
  physics::SceneBodyJoint joint;
  joint.name = "ball";
  joint.kind = physics::BodyJointKind::ball;
  joint.parent = kBox, joint.child = kOther;
  joint.p_W = {1, 0, 5};
  scene.joints.push_back(joint);
}

void add_comer(DynamicScene& scene) {
  physics::SceneAction add;
  add.kind = physics::SceneAction::Kind::add;
  add.time = 0.02;
  add.carried = kOther;
  scene.actions.push_back(add);
}

void ask_for(EngineFeature feature, DynamicScene& scene) {
  // The least that needs the feature.
  using enum EngineFeature;
  using Mode = physics::JointDrive::Mode;
  switch (feature) {
    case hulls:
      return make_frustum(scene);
    case kinematic_bodies:
      scene.bodies[kOther].kind = BodyKind::kinematic;
      return;
    case mixed_friction:
      scene.bodies[kOther].surface.friction = 0.1;
      return;
    case restitution:
      scene.bodies[kOther].surface.restitution = 0.5;
      return;
    case exempt_parts:
      return exempt_a_part(scene);
    case arms:
      add_arm(scene);
      return;
    case joint_stops:
      add_arm(scene).upper = 1.0;
      return;
    case torque_drives:
      return add_driven_arm(scene, Mode::torque);
    case rate_drives:
      return add_driven_arm(scene, Mode::rate);
    case brakes:
      return add_driven_arm(scene, Mode::brake);
    case position_drives:
      return add_driven_arm(scene, Mode::position);
    case latches:
      scene.scene.latches.push_back({"box", "other", {}});
      return;
    case set_joints:
      return add_set_joint(scene);
    case joint_losses:
      add_arm(scene).losses.friction = 0.1;
      return;
    case rotors:
      add_arm(scene).rotor = 0.1;
      return;
    case body_joints:
      return add_ball(scene);
    case come_and_go:
      return add_comer(scene);
    case rounded_solids:
      scene.scene.objects[kBox].tree = HexahedronTree({{"ball", Hexahedron::sphere(0.1), {}}}, "box");
      return;
  }
}

/// A scene that asks for the feature, and for little else.
DynamicScene scene_with(EngineFeature feature) {
  DynamicScene scene = empty_scene(0.1);
  add_box(scene, "box", {0.2, 0.2, 0.2}, {0, 0, 5}, 1.0);
  add_box(scene, "other", {0.2, 0.2, 0.2}, {2, 0, 5}, 1.0);
  ask_for(feature, scene);
  return scene;
}

TEST_P(EngineSuite, EveryFeatureIsTakenOrNamed) {
  for (int i = 0; i < physics::kEngineFeatures; ++i) {
    const auto feature = static_cast<EngineFeature>(i);
    const DynamicScene scene = scene_with(feature);
    const std::vector<physics::EngineNeed> needs = physics::needs_of(scene);
    const auto is_it = [&](const physics::EngineNeed& need) { return need.feature == feature; };
    ASSERT_TRUE(std::any_of(needs.begin(), needs.end(), is_it)) << to_string(feature);
    const bool can_all =
        physics::unsupported(engines().engine(GetParam()).features(GetParam().check), scene).empty();
    EXPECT_TRUE(can(feature) || !can_all) << to_string(feature);
    if (can_all) {
      // A feature that it claims runs.
      run(GetParam(), scene);
      continue;
    }
    try {
      engines().make(GetParam(), scene);
      ADD_FAILURE() << to_string(feature) << " was taken";
    } catch (const InputError& error) {
      const std::string text = error.what();
      EXPECT_EQ(text.find("engine '" + GetParam().text() + "': unsupported: "), 0u) << text;
      EXPECT_EQ(text.find(to_string(feature)) != std::string::npos, !can(feature)) << text;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, EngineSuite, ::testing::ValuesIn(choices()), name_of);

TEST(EngineRegistry, NamesWhatThereIsAndWhyNot) {
  EngineRegistry registry;
  register_own_engine(registry, backends());
  registry.add_missing({"havok", "nobody has it"});
  const auto message = [&](const EngineChoice& choice) {
    return refusal_of([&] { registry.engine(choice); });
  };
  EXPECT_EQ(message({"own", "native"}), "accepted");
  EXPECT_EQ(message({"havok", "own"}), "engine 'havok' is missing: nobody has it");
  EXPECT_EQ(message({"jolt", "own"}), "no engine 'jolt'; known are own");
  EXPECT_EQ(message({"own", "sharp"}).find("engine 'own' has no check 'sharp'; it has own, native"), 0u);
  EXPECT_THROW(register_own_engine(registry, backends()), InputError);
  EXPECT_EQ(physics::parse_engine_choice("bullet:native").check, "native");
  EXPECT_EQ(physics::parse_engine_choice("bullet").check, physics::kOwnCheck);
  EXPECT_EQ(physics::parse_engine_choice("bullet:native").text(), "bullet:native");
}

}  // namespace
}  // namespace touchstone

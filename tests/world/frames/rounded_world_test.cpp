#include <gmock/gmock.h>

#include <array>
#include <cmath>

#include "touchstone/contact_core/edge_face/edge_face.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

// Rounded solids as objects: stops and slides known in closed form, refusals by name. Random motions of them
// are judged by `exact` in MotionProof.

namespace touchstone {
namespace {

using testing::HasSubstr;

std::shared_ptr<const HexahedronTree> tree(const std::string& name, const Hexahedron& solid) {
  return std::make_shared<HexahedronTree>(std::vector<PlacedHexahedron>{{"solid", solid, Pose{}}}, name);
}

FrameReport move(ContactWorld& world, ObjectHandle object, const Vector3& by,
                 const Vector3& turn = {0, 0, 0}) {
  const std::array commands{world.move_by(object, by, turn)};
  return world.frame(commands);
}

TEST(RoundedWorld, ABallStopsAtABall) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  world->add({tree("fixed", Hexahedron::sphere(0.5)), at(0, 0, 0), true});
  const ObjectHandle ball = world->add({tree("ball", Hexahedron::sphere(0.25)), at(-3, 0.6, 0)});
  const FrameReport report = move(*world, ball, {6, 0, 0});
  EXPECT_EQ(report.blocked_movers, 1u);
  const double apart = norm(world->actual_pose(ball).p) - 0.75;
  EXPECT_GE(apart, 0.5 * kGap);
  EXPECT_LE(apart, kGap);
  EXPECT_NEAR(world->actual_pose(ball).p.x(), -0.45, 1e-8);
}

TEST(RoundedWorld, ABallRollsOnAFaceInOneStep) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  world->add({box_tree("floor", {6, 6, 1}), at(0, 0, -0.5), true});
  const ObjectHandle ball =
      world->add({tree("ball", Hexahedron::sphere(0.25)), at(-2, 0, 0.25 + 0.75 * kGap)});
  for (int frame = 0; frame < 20; ++frame) {
    const FrameReport report = move(*world, ball, {0.1, 0, 0}, {0, 0.4, 0});
    EXPECT_EQ(report.blocked_movers, 0u) << frame;
    EXPECT_LE(report.queries, 8u) << frame;
  }
  EXPECT_NEAR(world->actual_pose(ball).p.x(), 0.0, 1e-12);
}

TEST(RoundedWorld, ABallSlidesAlongTheSlopeThatItPressesOn) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  const Pose start = add_slope(*world);
  const Vector3 n = start.R.col(2), along = start.R.col(0);
  const ObjectHandle ball =
      world->add({tree("ball", Hexahedron::sphere(0.1)), at(start.p.x(), 0, start.p.z())});
  const Vector3 from = world->actual_pose(ball).p;
  for (int frame = 0; frame < 10; ++frame) move(*world, ball, 0.05 * along - 0.02 * n);
  const Vector3 gone = world->actual_pose(ball).p - from;
  EXPECT_NEAR(dot(gone, along), 0.5, 1e-6);
  EXPECT_GE(dot(world->actual_pose(ball).p, n), 0.1 + 0.5 * kGap - 1e-15);
}

// Each frame along the tangent that the ball before has, and after it back onto the ball.
TEST(RoundedWorld, ABallSlidesRoundABall) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  world->add({tree("fixed", Hexahedron::sphere(0.5)), at(0, 0, 0), true});
  const ObjectHandle ball = world->add({tree("ball", Hexahedron::sphere(0.25)), at(-0.7, 0, 0.35)});
  for (int frame = 0; frame < 200; ++frame) move(*world, ball, {0.01, 0, 0});
  const Vector3 p = world->actual_pose(ball).p;
  EXPECT_GT(p.x(), 0.75) << p.transpose();
  EXPECT_GE(norm(p), 0.75 + 0.5 * kGap - 1e-15);
}

TEST(RoundedWorld, ACapsuleSlidesOverAnEdge) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  world->add({box_tree("step", {2, 4, 1}), at(1, 0, -0.5), true});
  Pose X = at(-0.2, 0, 0.02);  // its axis along y, its lowest line below the step's edge
  X.R.col(0) = Vector3::UnitX(), X.R.col(1) = -Vector3::UnitZ(), X.R.col(2) = Vector3::UnitY();
  const ObjectHandle rod = world->add({tree("rod", Hexahedron::capsule(0.1, 1.0)), X});
  for (int frame = 0; frame < 200; ++frame) move(*world, rod, {0.01, 0, 0});
  const Vector3 p = world->actual_pose(rod).p;
  EXPECT_GT(p.x(), 0.5) << p.transpose();
  EXPECT_GE(p.z(), 0.1 + 0.5 * kGap - 1e-15);
}

// A rod of 2 m about the z axis comes with its round end against a face at y = 0.5.
TEST(RoundedWorld, ALinkStopsByItsRoundEnd) {
  MechanismDescription description;
  description.name = "arm";
  Pose lying = at(1, 0, 0);
  lying.R.col(0) = -Vector3::UnitZ(), lying.R.col(1) = Vector3::UnitY(), lying.R.col(2) = Vector3::UnitX();
  description.links = {{"base", {}, {}}, {"rod", {{"rod", Hexahedron::capsule(0.1, 2.0), lying}}, {}}};
  JointDescription joint;
  joint.name = "turn", joint.kind = JointKind::revolute, joint.parent = "base", joint.child = "rod";
  description.joints = {joint};
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  const MechanismHandle arm = world->add_mechanism({std::make_shared<const Mechanism>(description)});
  world->add({box_tree("post", {4, 1, 1}), at(2, 1, 0), true});
  const std::array<double, 1> goal{1.0};
  const std::array commands{JointCommand{arm, goal}};
  EXPECT_EQ(world->frame({}, commands).blocked_movers, 1u);
  EXPECT_NEAR(world->joint_values(arm)[0], std::asin((0.5 - 0.1) / 2.0), 1e-8);
  EXPECT_LT(world->joint_values(arm)[0], std::asin((0.5 - 0.1) / 2.0));
}

TEST(RoundedWorld, AllocatesNothingWhileItSlides) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  world->add({box_tree("floor", {6, 6, 1}), at(0, 0, -0.5), true});
  world->add({tree("post", Hexahedron::capsule(0.3, 2.0)), at(0, 0.1, 0.9), true});
  const ObjectHandle ball =
      world->add({tree("box", Hexahedron::rounded_box({0.3, 0.2, 0.2}, 0.05)), at(-1, 0, 0.2)});
  std::size_t before = 0, slid = 0;
  for (int frame = 0; frame < 200; ++frame) {
    if (frame == 20) before = allocation_count();
    const double sign = frame / 40 % 2 ? -1.0 : 1.0;
    slid += move(*world, ball, {sign * 0.05, 0.0, -0.02}, {0, 0, 0.01}).slide_steps > 0;
  }
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(slid, 100u);
}

TEST(RoundedWorld, ABackendThatTakesNoneRefusesThemByName) {
  // A backend without rounded solids.
  BackendRegistry registry;
  register_core(registry);
  ContactWorld world(registry.make_narrowphase("edge_face"), registry.make_broadphase("native"), kGap);
  world.add({box_tree("floor", {6, 6, 1}), at(0, 0, -0.5), true});
  const auto error_of = [](const auto& call) -> std::string {
    try {
      call();
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  // Added later one is refused, and the world goes on.
  EXPECT_THAT(
      error_of([&] {
        world.add({tree("ball", Hexahedron::sphere(0.25)), at(0, 0, 1)});
      }),
      HasSubstr("object 'ball': hexahedron 'solid' is rounded (radius 0.25 m), which backend 'edge_face'"));
  EXPECT_NO_THROW(world.frame({}));
  // So is the backend where one is there already.
  world.set_narrowphase(registry.make_narrowphase("native"));
  world.add({tree("ball", Hexahedron::sphere(0.25)), at(0, 0, 1)});
  world.prepare();
  world.set_narrowphase(registry.make_narrowphase("edge_face"));
  EXPECT_THAT(error_of([&] { world.prepare(); }), HasSubstr("object 'ball': hexahedron 'solid' is rounded"));
  world.set_narrowphase(registry.make_narrowphase("native"));
  EXPECT_NO_THROW(world.prepare());
}

}  // namespace
}  // namespace touchstone

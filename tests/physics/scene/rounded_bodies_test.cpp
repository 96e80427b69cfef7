// Spheres and capsules with mass, against closed forms.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/scene/scene_simulation.hpp"
#include "touchstone/tests/physics/hand_made_scene.hpp"
#include "touchstone/tests/support/refusal.hpp"
#ifdef TOUCHSTONE_HAS_BULLET
#include "touchstone/adapters/bullet/bullet.hpp"
#endif

using namespace touchstone;
using namespace touchstone::physics;

namespace {

constexpr double kGravity = 9.81, kSlope = 0.35;  // [m/s2], [rad]

SceneObject solid(const std::string& name, const Hexahedron& shape, const Pose& X_WO) {
  return {HexahedronTree({{name, shape, {}}}, name), X_WO, {}, {}};
}

SceneBody of_mass(const SceneObject& object, double mass, const Surface& surface) {
  return {BodyKind::dynamic,
          inertia_of_mass(object.tree.solids(), mass, object.tree.name()),
          kZero,
          kZero,
          surface,
          {}};
}

constexpr double kRun = 0.5;  // [s]

/// A body that touches a plane which goes down along x, at rest; gravity is turned, not the plane.
struct Slope {
  DynamicScene scene = empty_scene(1.0);

  Slope(const Hexahedron& shape, const Matrix3& R, double height, double friction) {
    scene.step = 1e-3;
    scene.gravity_W = kGravity * Vector3(std::sin(kSlope), 0, -std::cos(kSlope));
    add(scene, box("plane", {40, 4, 1}, at({0, 0, -0.5})), {.surface = {friction, 0.0}});
    const SceneObject object = solid("body", shape, {R, Vector3(0, 0, height)});
    add(scene, object, of_mass(object, 2.0, {friction, 0.0}));
  }
  /// Its speed along the slope and its turning speed about y after half a second.
  std::pair<double, double> speeds() {
    SceneSimulation simulation(scene, native_contacts);
    while (simulation.time() < kRun - 0.5 * scene.step) {
      const StepReport report = step(simulation);
      EXPECT_EQ(report.failure, StepFailure::none);
      EXPECT_EQ(report.unconverged, 0U);
    }
    const std::uint32_t body = *simulation.dynamic_body(1);
    return {simulation.world().velocity(body).x(), simulation.world().angular_velocity(body).y()};
  }
};

TEST(RoundedBodies, ASphereRollsDownASlope) {
  const double r = 0.1;
  const auto [v, w] = Slope(Hexahedron::sphere(r), Matrix3::Identity(), r, 0.5).speeds();
  EXPECT_NEAR(v, 5.0 / 7.0 * kGravity * std::sin(kSlope) * kRun, 1e-3 * v);
  EXPECT_NEAR(w, v / r, 2e-3 * w);
}

// The friction that rolling takes is 2/7 of the slope's tangent, 0.104.
TEST(RoundedBodies, ASphereSlipsWhereFrictionIsLess) {
  const double r = 0.1, friction = 0.05;
  const auto [v, w] = Slope(Hexahedron::sphere(r), Matrix3::Identity(), r, friction).speeds();
  EXPECT_NEAR(v, kGravity * (std::sin(kSlope) - friction * std::cos(kSlope)) * kRun, 1e-5 * v);
  // The normal force does not turn it: behind its middle by half of a step's way, it did by 4.8 %.
  EXPECT_NEAR(w, 2.5 * friction * kGravity * std::cos(kSlope) / r * kRun, 3e-4 * w);
}

// A cylinder with half balls on its ends: m_c r^2 / 2 + m_b 2 r^2 / 5 about its axis.
TEST(RoundedBodies, ACapsuleRollsAboutItsAxis) {
  const double r = 0.1, length = 0.6, cylinder = r * r * length, ball = 4.0 / 3.0 * r * r * r;
  const double of_mass_r2 = (0.5 * cylinder + 0.4 * ball) / (cylinder + ball);
  Matrix3 lying;  // its axis along y
  lying << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const auto [v, w] = Slope(Hexahedron::capsule(r, length), lying, r, 0.5).speeds();
  EXPECT_NEAR(v, kGravity * std::sin(kSlope) / (1.0 + of_mass_r2) * kRun, 1e-3 * v);
  EXPECT_NEAR(w, v / r, 2e-3 * w);
}

TEST(RoundedBodies, ABallThatFallsBouncesToASquareOfItsRestitution) {
  const double r = 0.1, drop = 0.5, restitution = 0.6;
  DynamicScene scene = empty_scene(1.0);
  scene.gravity_W = {0, 0, -kGravity};
  add(scene, box("floor", {4, 4, 1}, at({0, 0, -0.5})), {.surface = {0.5, restitution}});
  const SceneObject ball = solid("ball", Hexahedron::sphere(r), at({0, 0, r + drop}));
  add(scene, ball, of_mass(ball, 1.0, {0.5, restitution}));
  SceneSimulation simulation(scene, native_contacts);
  const double falls = std::sqrt(2.0 * drop / kGravity);
  double highest = 0.0, lowest = 1.0;
  while (!simulation.is_over()) {
    ASSERT_EQ(step(simulation).failure, StepFailure::none);
    const double height = simulation.object_pose(1).p.z() - r;
    lowest = std::min(lowest, height);
    if (simulation.time() > falls + 0.05) highest = std::max(highest, height);
  }
  EXPECT_NEAR(highest, restitution * restitution * drop, 5e-3 * drop);
  EXPECT_GT(lowest, -1e-6);
}

TEST(RoundedBodies, ARoundedBoxRestsOnItsFace) {
  DynamicScene scene = empty_scene(0.5);
  scene.gravity_W = {0, 0, -kGravity};
  add(scene, box("floor", {4, 4, 1}, at({0, 0, -0.5})), {.surface = {0.5, 0.0}});
  const SceneObject cube = solid("cube", Hexahedron::rounded_box({0.2, 0.2, 0.2}, 0.05), at({0, 0, 0.15}));
  add(scene, cube, of_mass(cube, 1.0, {0.5, 0.0}));
  SceneSimulation simulation(scene, native_contacts);
  run(simulation);
  EXPECT_NEAR(simulation.object_pose(1).p.z(), 0.15, 1e-6);
  EXPECT_LT(norm(simulation.world().velocity(*simulation.dynamic_body(1))), 1e-9);
}

TEST(RoundedBodies, BackendsWithoutThemRefuseThemByName) {
  BackendRegistry registry;
  register_core(registry);
#ifdef TOUCHSTONE_HAS_BULLET
  register_bullet(registry);
#endif
  const HexahedronTree tree({{"ball", Hexahedron::sphere(0.1), {}}}, "ball");
  for (const BackendRegistry::NarrowphaseEntry& each : registry.narrowphases()) {
    if (!registry.make_narrowphase(each.name)->capabilities().manifold) continue;
    NarrowphaseContacts contacts(registry.make_broadphase("native"), registry.make_narrowphase(each.name),
                                 1e-3);
    const bool takes = registry.make_narrowphase(each.name)->capabilities().rounded_solids;
    const std::string text = refusal_of([&] {
      contacts.add(Mover::of_body(0), tree, {0.5, 0.0}, {}, false);
    });
    EXPECT_THAT(text, testing::HasSubstr(takes ? "accepted" : each.name));
  }
}

}  // namespace

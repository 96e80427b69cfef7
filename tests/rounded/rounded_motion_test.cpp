#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "touchstone/adapters/exact/signed_distance.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/motion/impact.hpp"
#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/random_solid.hpp"

// Rounded solids in motion: stops known in closed form, and random paths against exact answers on them.

namespace touchstone {
namespace {

constexpr double kGap = 1e-9;

Impact find(const std::array<Hexahedron, 2>& solids, const MotionPath& a, const MotionPath& b) {
  const auto native = make_native();
  native->build(solids);
  NarrowphaseQuery query(*native, 2);
  return find_impact({&solids[0], {}, &a}, {&solids[1], {}, &b}, {kGap}, query);
}

TEST(RoundedMotion, ASphereStopsOnASphere) {
  const std::array solids{Hexahedron::sphere(0.5), Hexahedron::sphere(0.25)};
  // Centres pass each other at 0.6: they are 0.75 apart where the way left is sqrt(0.75^2 - 0.6^2).
  const Impact impact =
      find(solids, RigidPath(at(0, 0, 0)), RigidPath::by(at(-3, 0.6, 0), {6, 0, 0}, {0, 0, 1}));
  EXPECT_EQ(impact.status, ImpactStatus::blocked);
  EXPECT_GE(impact.geometry.separation, 0.5 * kGap);
  EXPECT_LE(impact.geometry.separation, kGap);
  EXPECT_NEAR(impact.lo * 6, 3 - 0.45, 1e-8);
}

TEST(RoundedMotion, ASphereSlidesOverAFaceFreely) {
  const std::array solids{Hexahedron::from_size({4, 4, 1}), Hexahedron::sphere(0.5)};
  const Impact impact = find(solids, RigidPath(at(0, 0, -0.5)),
                             RigidPath::by(at(-1, 0, 0.5 + 0.75 * kGap), {2, 0.5, 0}, {0, 0, 0.5}));
  EXPECT_EQ(impact.status, ImpactStatus::clear);
  EXPECT_LE(impact.queries, 8);
}

TEST(RoundedMotion, ATurningCapsuleStopsByItsEnd) {
  const std::array solids{Hexahedron::capsule(0.25, 2.0), Hexahedron::from_size({1, 1, 1})};
  // Turns about x towards +y; its end's centre comes to y = sin(angle), the wall's face is at y = 0.75.
  const double right = 0.5 * std::numbers::pi;
  const Impact impact =
      find(solids, RigidPath::by(Pose{}, {0, 0, 0}, {-right, 0, 0}), RigidPath(at(0, 1.25, 0.9)));
  EXPECT_EQ(impact.status, ImpactStatus::blocked);
  EXPECT_NEAR(impact.lo * right, std::asin(0.5), 1e-8);
}

// A rod tilts over the edge that it lies across: the plane that the edge and its axis span goes with it, and
// no plane that is fixed does.
TEST(RoundedMotion, ACapsuleTiltsOverAnEdgeInFewSteps) {
  const std::array solids{Hexahedron::from_size({4, 1, 1}), Hexahedron::capsule(0.25, 2.0)};
  Pose edge_up = at(0, 0, -std::sqrt(0.5)), rod = at(0, 0, 0.25 + 0.75 * kGap);
  edge_up.R = rotation_about(Vector3::UnitX(), 0.25 * std::numbers::pi);
  rod.R = rotation_about(Vector3::UnitX(), 0.5 * std::numbers::pi);
  const Impact impact =
      find(solids, RigidPath(edge_up), RigidPath::by(rod, {0, 0, 0}, {0.5, 0, 0}, {0, -rod.p.z(), 0}));
  EXPECT_EQ(impact.status, ImpactStatus::clear);
  EXPECT_LE(impact.queries, 32);
}

Hexahedron random_rounded(Random& random) {
  const double radius = random.uniform(0.01, 0.4);
  switch (random.below(4)) {
    case 0:
      return Hexahedron::sphere(radius);
    case 1:
      return Hexahedron::capsule(radius, random.uniform(0.1, 1.5));
    case 2: {
      const double x = random.uniform(0.1, 1.0), y = random.uniform(0.1, 1.0);
      return Hexahedron::rounded_box({x, y, 0}, radius);
    }
    default:
      return random_solid(random, 1.0).padded(radius);
  }
}

double separation_at(const std::array<Hexahedron, 2>& solids, const Pose& X_WA, const Pose& X_WB) {
  WorldVertices a, b;
  world_vertices(solids[0], X_WA, a), world_vertices(solids[1], X_WB, b);
  return exact_rounded_distance(a, solids[0].radius(), b, solids[1].radius()).separation;
}

TEST(RoundedMotion, NoStopIsLate) {
  std::mt19937_64 engine(20265);
  int blocked = 0, unfinished = 0;
  for (int i = 0; i < 1000; ++i) {
    // Two solids apart, of which one is rounded at least, and their paths.
    Random random(engine());
    const std::array solids{random_rounded(random),
                            random.one_in(3) ? random_solid(random, 1.0) : random_rounded(random)};
    const Pose from_a = random_pose(engine, 1.0), from_b = random_pose(engine, 1.0);
    if (separation_at(solids, from_a, from_b) < 0.01) continue;
    const Vector3 way_a = random.vector(1.0), turn_a = random.vector(1.5);
    const Vector3 way_b = random.vector(1.0), turn_b = random.vector(1.5);
    const RigidPath a = RigidPath::by(from_a, way_a, turn_a), b = RigidPath::by(from_b, way_b, turn_b);
    // The stop is within the gap,
    const Impact impact = find(solids, a, b);
    SCOPED_TRACE(i);
    ASSERT_NE(impact.status, ImpactStatus::failed);
    blocked += impact.status == ImpactStatus::blocked ? 1 : 0;
    unfinished += impact.status == ImpactStatus::iteration_limit ? 1 : 0;
    EXPECT_TRUE(impact.status != ImpactStatus::blocked || impact.geometry.separation <= kGap);
    // and nothing before it is below half the gap.
    constexpr int kSamples = 32;
    for (int k = 0; k <= kSamples; ++k) {
      const double s = impact.lo * k / kSamples;
      const double separation = separation_at(solids, a.at(0, s).X_WO, b.at(0, s).X_WO);
      ASSERT_GE(separation, 0.5 * kGap - 1e-14) << s << " of " << impact.lo;
    }
  }
  EXPECT_GT(blocked, 50);
  EXPECT_EQ(unfinished, 0);
}

}  // namespace
}  // namespace touchstone

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"
#include "touchstone/contact_core/motion/mass_metric.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/tests/support/refusal.hpp"

// Solids with a radius: how they are made, what is refused, who refuses them.

namespace touchstone {
namespace {

using testing::HasSubstr;

TEST(RoundedSolid, CoresMayBeFlatASegmentOrAPoint) {
  const Hexahedron ball = Hexahedron::sphere(0.5);
  EXPECT_TRUE(ball.is_rounded());
  EXPECT_EQ(ball.size(), 0.0);
  for (const Vector3& v : ball.vertices()) EXPECT_EQ(v, Vector3::Zero());
  const Hexahedron capsule = Hexahedron::capsule(0.25, 2.0);
  EXPECT_EQ(capsule.size(), 2.0);
  EXPECT_EQ(capsule.vertices()[7], Vector3(0, 0, 1));
  const Hexahedron plate = Hexahedron::rounded_box({3, 4, 0}, 0.125);
  EXPECT_EQ(plate.size(), 5.0);
  EXPECT_FALSE(Hexahedron::from_size({1, 1, 1}).is_rounded());
}

TEST(RoundedSolid, BoundingSpheresHoldTheRadius) {
  const auto reach = [](const Hexahedron& solid) { return solid.bounding_sphere().radius; };
  EXPECT_GE(reach(Hexahedron::sphere(0.5)), 0.5);
  EXPECT_LT(reach(Hexahedron::sphere(0.5)), 0.5 * (1 + 1e-14));
  EXPECT_GE(reach(Hexahedron::capsule(0.25, 2.0)), 1.25);
  EXPECT_GE(reach(Hexahedron::rounded_box({3, 4, 0}, 0.1)), 2.6);
  EXPECT_GE(reach(Hexahedron::from_size({2, 2, 2}).padded(0.1)), std::sqrt(3.0) + 0.1);
}

TEST(RoundedSolid, PaddingAddsUp) {
  const Hexahedron solid = Hexahedron::rounded_box({1, 1, 0}, 0.25).padded(0.5);
  EXPECT_EQ(solid.radius(), 0.75);
  EXPECT_GE(solid.bounding_sphere().radius, 0.75 + std::sqrt(0.5));
}

TEST(RoundedSolid, BadFiguresAreRefusedByName) {
  EXPECT_THAT(refusal_of([] { Hexahedron::sphere(0.0, "ball"); }),
              HasSubstr("ball: radius is 0, must be > 0"));
  EXPECT_THAT(refusal_of([] { Hexahedron::sphere(-1.0, "ball"); }), HasSubstr("ball: radius is -1"));
  EXPECT_THAT(refusal_of([] { Hexahedron::sphere(kInfinity, "ball"); }),
              HasSubstr("ball: radius is not finite"));
  EXPECT_THAT(refusal_of([] { Hexahedron::sphere(std::nan(""), "ball"); }), HasSubstr("not finite"));
  EXPECT_THAT(refusal_of([] { Hexahedron::capsule(1.0, -2.0, "pin"); }), HasSubstr("pin: length is -2"));
  EXPECT_THAT(refusal_of([] { Hexahedron::capsule(1.0, kInfinity, "pin"); }),
              HasSubstr("pin: length is not finite"));
  EXPECT_THAT(refusal_of([] {
                Hexahedron::rounded_box({1, -1, 1}, 0.1, "lid");
              }),
              HasSubstr("lid: size along y is -1, must be >= 0"));
  EXPECT_THAT(refusal_of([] {
                Hexahedron::rounded_box({1, 1, std::nan("")}, 0.1, "lid");
              }),
              HasSubstr("lid: size along z is not finite"));
  EXPECT_THAT(refusal_of([] { Hexahedron::sphere(1e308).padded(1e308, "ball"); }), HasSubstr("too large"));
}

MassMetric metric_of(const Hexahedron& solid) { return mass_metric(mass_moments(solid)); }

TEST(RoundedSolid, MassOfSpheresAndCapsules) {
  constexpr double kPi = std::numbers::pi;
  const MassMoments ball = mass_moments(Hexahedron::sphere(0.5));
  EXPECT_NEAR(ball.volume, kPi / 6, 1e-15);
  EXPECT_NEAR(metric_of(Hexahedron::sphere(0.5)).J(1, 1), 0.1, 1e-15);
  // A cylinder and two half spheres, their centres of mass 3/8 r from the discs.
  const double r = 0.5, length = 3.0;
  const Hexahedron capsule = Hexahedron::capsule(r, length);
  const double cylinder = kPi * r * r * length, caps = 4.0 / 3.0 * kPi * r * r * r;
  EXPECT_NEAR(mass_moments(capsule).volume, cylinder + caps, 1e-14);
  const Matrix3 J = metric_of(capsule).J;
  EXPECT_NEAR(J(2, 2), (cylinder * r * r / 2 + caps * 0.4 * r * r) / (cylinder + caps), 1e-14);
  const double of_cylinder = r * r / 4 + length * length / 12;
  const double of_caps = 0.4 * r * r + length * length / 4 + 3.0 / 8.0 * length * r;
  EXPECT_NEAR(J(0, 0), (cylinder * of_cylinder + caps * of_caps) / (cylinder + caps), 1e-14);
}

// Against cells of a grid, whose middles are asked for their distance from the core.
TEST(RoundedSolid, MassOfRoundedBoxes) {
  const Vector3 half(0.5, 0.25, 0.0);
  const double r = 0.375;
  constexpr int kCells = 120;
  const Vector3 step = (half + Vector3::Constant(r)) * (2.0 / kCells);
  MassMoments sum;
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j)
      for (int k = 0; k < kCells; ++k) {
        const Vector3 p = Vector3(i + 0.5, j + 0.5, k + 0.5).cwiseProduct(step) - half - Vector3::Constant(r);
        const Vector3 beyond = (p.cwiseAbs() - half).cwiseMax(Vector3::Zero());
        if (norm(beyond) > r) continue;
        const double cell = step.x() * step.y() * step.z();
        sum.volume += cell;
        for (int axis = 0; axis < 3; ++axis) sum.second(axis, axis) += cell * p(axis) * p(axis);
      }
  const MassMoments moments = mass_moments(Hexahedron::rounded_box(2.0 * half, r));
  EXPECT_NEAR(moments.volume, sum.volume, 1e-3 * sum.volume);
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(moments.second(axis, axis), sum.second(axis, axis), 2e-3 * sum.second(axis, axis)) << axis;
}

TEST(RoundedSolid, MassOfOtherCoresIsRefused) {
  std::array<Vector3, 8> v = Hexahedron::from_size({1, 1, 1}).vertices();
  for (Vector3& p : v) p.x() += 0.25 * p.z();
  const Hexahedron sheared = Hexahedron::from_vertices(v).padded(0.1);
  EXPECT_THAT(refusal_of([&] { mass_moments(sheared); }), HasSubstr("whose core is no box"));
}

TEST(RoundedSolid, ObjectsHoldThemAndSpheresEncloseThem) {
  Pose above;
  above.p = {0, 0, 1.5};
  const std::vector<PlacedHexahedron> solids{{"lid", Hexahedron::from_size({2, 2, 1}), Pose{}},
                                             {"knob", Hexahedron::sphere(1), above},
                                             {"bar", Hexahedron::capsule(0.25, 3), Pose{}}};
  const std::vector<HexahedronTree::Node> layout{
      {{}, 1, 2, -1}, {{}, -1, -1, 1}, {{}, 3, 4, -1}, {{}, -1, -1, 0}, {{}, -1, -1, 2}};
  for (const HexahedronTree& pot : {HexahedronTree(solids, "pot"), HexahedronTree(solids, layout, "pot")}) {
    const Sphere& all = pot.nodes()[0].sphere_O;
    EXPECT_GE(all.radius, norm(Vector3(0, 0, 2.5) - all.centre));
    EXPECT_GE(all.radius, norm(Vector3(0, 0, -1.75) - all.centre));
    EXPECT_LE(all.radius, 2.5);
    for (const HexahedronTree::Node& node : pot.nodes())
      if (node.solid == 1) {
        EXPECT_NEAR(node.sphere_O.radius, 1.0, 1e-12);
      }
    EXPECT_THAT(refusal_of([&] { refuse_rounded(pot, "backend 'b'"); }),
                HasSubstr("object 'pot': hexahedron 'knob' is rounded (radius 1 m), which backend 'b' does"));
  }
}

TEST(RoundedSolid, BackendsThatDoNotTakeThemSaySo) {
  BackendRegistry registry;
  register_core(registry);
  const std::vector<Hexahedron> solids{Hexahedron::from_size({1, 1, 1}), Hexahedron::sphere(0.5)};
  const auto edge_face = registry.make_narrowphase("edge_face");
  EXPECT_FALSE(edge_face->capabilities().rounded_solids);
  EXPECT_THAT(refusal_of([&] { edge_face->build(solids); }), HasSubstr("edge_face: solid 1 is rounded"));
  EXPECT_THAT(refusal_of([&] { edge_face->set_solids(0, solids); }),
              HasSubstr("edge_face: solid 1 is rounded"));
}

}  // namespace
}  // namespace touchstone

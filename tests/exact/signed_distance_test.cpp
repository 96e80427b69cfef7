#include "touchstone/adapters/exact/signed_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "touchstone/adapters/exact/contact_patch.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/tests/exact/exhaustive_oracle.hpp"

namespace touchstone {
namespace {

WorldVertices box(const Vector3& centre, const Vector3& half) {
  WorldVertices v;
  for (int i = 0; i < 8; ++i) {
    v.x[i] = centre.x() + ((i >> 2 & 1) != 0 ? half.x() : -half.x());
    v.y[i] = centre.y() + ((i >> 1 & 1) != 0 ? half.y() : -half.y());
    v.z[i] = centre.z() + ((i & 1) != 0 ? half.z() : -half.z());
  }
  return v;
}

WorldVertices unit_cube(double x, double y, double z) { return box({x, y, z}, {0.5, 0.5, 0.5}); }

WorldVertices scaled(WorldVertices v, double s) {
  for (auto* axis : {&v.x, &v.y, &v.z}) {
    for (double& value : *axis) value *= s;
  }
  return v;
}

void expect_symmetric(const WorldVertices& a, const WorldVertices& b) {
  const ExactResult ab = exact_signed_distance(a, b), ba = exact_signed_distance(b, a);
  EXPECT_EQ(ab.pair_class, ba.pair_class);
  EXPECT_EQ(ab.separation, ba.separation);
  EXPECT_EQ(ab.n_AB_W, Vector3(-ba.n_AB_W));
  EXPECT_EQ(ab.p_A_W, ba.p_B_W);
}

TEST(ExactSignedDistance, CubesApartByFaceEdgeAndVertex) {
  EXPECT_EQ(exact_signed_distance(unit_cube(0, 0, 0), unit_cube(3, 0, 0)).separation, 2.0);
  EXPECT_EQ(exact_signed_distance(unit_cube(0, 0, 0), unit_cube(2, 2, 0)).separation, std::sqrt(2.0));
  const ExactResult vertex = exact_signed_distance(unit_cube(0, 0, 0), unit_cube(2, 2, 2));
  EXPECT_EQ(vertex.separation, std::sqrt(3.0));
  EXPECT_EQ(vertex.p_A_W, Vector3(0.5, 0.5, 0.5));
  EXPECT_EQ(vertex.p_B_W, Vector3(1.5, 1.5, 1.5));
}

TEST(ExactSignedDistance, CubesTouchingByFaceEdgeAndVertex) {
  const ExactResult face = exact_signed_distance(unit_cube(0, 0, 0), unit_cube(1, 0.25, 0));
  EXPECT_EQ(face.pair_class, PairClass::touching);
  EXPECT_EQ(face.separation, 0.0);
  EXPECT_EQ(face.n_AB_W, Vector3(1, 0, 0));
  EXPECT_TRUE(face.normal_unique);
  const ExactResult edge = exact_signed_distance(unit_cube(0, 0, 0), unit_cube(1, 1, 0));
  EXPECT_EQ(edge.pair_class, PairClass::touching);
  EXPECT_EQ(edge.tied_normals, 2);
  const ExactResult vertex = exact_signed_distance(unit_cube(0, 0, 0), unit_cube(1, 1, 1));
  EXPECT_EQ(vertex.pair_class, PairClass::touching);
  EXPECT_EQ(vertex.tied_normals, 3);
}

TEST(ExactSignedDistance, OneUlpDecides) {
  const WorldVertices a = unit_cube(0, 0, 0);
  WorldVertices b = unit_cube(1, 0, 0);
  for (double& x : b.x) {
    if (x == 0.5) x = std::nextafter(0.5, 1.0);
  }
  EXPECT_EQ(exact_signed_distance(a, b).separation, 0x1p-53);
  EXPECT_EQ(exact_pair_class(a, b), PairClass::separated);
  for (double& x : b.x) {
    if (x < 1.0) x = std::nextafter(0.5, 0.0);
  }
  EXPECT_EQ(exact_signed_distance(a, b).separation, -0x1p-54);
  EXPECT_EQ(exact_pair_class(a, b), PairClass::penetrating);
}

TEST(ExactSignedDistance, ContainedCubeLeavesThroughTheNearestFace) {
  const ExactResult r = exact_signed_distance(box({0, 0, 0}, {2, 2, 2}), unit_cube(1, 0, 0));
  EXPECT_EQ(r.separation, -1.5);  // from x in [0.5, 1.5] out over x = 2
  EXPECT_EQ(r.n_AB_W, Vector3(1, 0, 0));
  EXPECT_EQ(r.p_A_W.x(), 2.0);
  EXPECT_EQ(r.p_B_W.x(), 0.5);
}

TEST(ExactSignedDistance, IdenticalCubesHaveSixTiedNormals) {
  const ExactResult r = exact_signed_distance(unit_cube(0, 0, 0), unit_cube(0, 0, 0));
  EXPECT_EQ(r.separation, -1.0);
  EXPECT_EQ(r.tied_normals, 6);
  EXPECT_FALSE(r.normal_unique);
  EXPECT_EQ(r.n_AB_W, Vector3(1, 0, 0));
}

TEST(ExactSignedDistance, ConcentricCubesOfTwoSizesStillNegate) {
  expect_symmetric(unit_cube(0, 0, 0), box({0, 0, 0}, {2, 2, 2}));
}

// Two diamonds (squares turned by 45 degrees about x and y) crossing at right angles: edge against edge along
// z.
TEST(ExactSignedDistance, CrossedEdges) {
  WorldVertices a = box({0, 0, 0}, {1, 1, 1}), b = a;
  for (int i = 0; i < 8; ++i) {
    const double y = a.y[i], z = a.z[i];
    a.y[i] = y + z, a.z[i] = z - y;
    const double x = b.x[i], w = b.z[i];
    b.x[i] = x + w, b.z[i] = w - x + 3.75;
  }
  const ExactResult r = exact_signed_distance(a, b);
  EXPECT_EQ(r.separation, -0.25);  // A's edge along x at z = 2, B's along y at z = 1.75
  EXPECT_EQ(r.n_AB_W, Vector3(0, 0, 1));
  EXPECT_EQ(r.p_A_W, Vector3(0, 0, 2));
  EXPECT_EQ(r.p_B_W, Vector3(0, 0, 1.75));
}

TEST(ExactSignedDistance, FullRangeOfDoubles) {
  for (const double s : {0x1p1000, 0x1p1020, 0x1p-1070, 0x1p-1000, 1.0}) {
    EXPECT_EQ(
        exact_signed_distance(scaled(box({0, 0, 0}, {2, 2, 2}), s), scaled(box({5, 0, 0}, {2, 2, 2}), s))
            .separation,
        s);
    EXPECT_EQ(
        exact_signed_distance(scaled(box({0, 0, 0}, {2, 2, 2}), s), scaled(box({3, 0, 0}, {2, 2, 2}), s))
            .separation,
        -s);
  }
  // A speck of the smallest doubles inside and outside a solid of 2^1000.
  const WorldVertices speck = scaled(box({0, 0, 0}, {1, 1, 1}), 0x1p-1074);
  EXPECT_EQ(exact_signed_distance(scaled(box({0, 0, 0}, {1, 1, 1}), 0x1p1000), speck).separation, -0x1p1000);
  EXPECT_EQ(exact_signed_distance(scaled(box({3, 0, 0}, {1, 1, 1}), 0x1p1000), speck).separation, 0x1p1001);
  EXPECT_EQ(exact_signed_distance(speck, scaled(box({3, 0, 0}, {1, 1, 1}), 0x1p-1074)).separation, 0x1p-1074);
}

// A double at 1e16 has steps of 2: the unit cube collapses to a point, the sheared one to whatever is left.
TEST(ExactSignedDistance, CollapsedFarAway) {
  const WorldVertices point = unit_cube(1e17, 1e17, 1e17);
  ASSERT_EQ(point.x[0], point.x[7]);
  EXPECT_EQ(exact_pair_class(point, point), PairClass::touching);
  EXPECT_EQ(exact_signed_distance(point, unit_cube(1e17, 1e17, 1e17 + 64)).separation, 64.0);
  const WorldVertices segment = box({1e17, 1e17, 1e17}, {64, 0.5, 0.5}),
                      far = box({1e17 + 64, 1e17, 1e17}, {64, 0.5, 0.5});
  const ExactResult r = exact_signed_distance(segment, far);
  EXPECT_EQ(r.separation, 0.0);
  EXPECT_EQ(r.n_AB_W.x(), 0.0);
  expect_symmetric(segment, far);
}

TEST(ExactSeparationAlong, RoundsTheGivenDirection) {
  const WorldVertices a = unit_cube(0, 0, 0), b = unit_cube(3, 0, 0);
  EXPECT_EQ(exact_separation_along(a, b, {1, 0, 0}), 2.0);
  EXPECT_EQ(exact_separation_along(a, b, {1e-300, 0, 0}), 2.0);
  EXPECT_EQ(exact_separation_along(a, b, {0, 1, 0}), -1.0);
  EXPECT_EQ(exact_separation_along(a, b, {3, 4, 0}), 0.4);  // (3 * 2.5 + 4 * -0.5 - 3 * 0.5 - 4 * 0.5) / 5
  EXPECT_TRUE(std::isnan(exact_separation_along(a, b, {0, 0, 0})));
}

TEST(ExactSurfaceDistance, InsideOnAndOutside) {
  const WorldVertices cube = unit_cube(0, 0, 0);
  EXPECT_EQ(exact_surface_distance(cube, {0, 0, 0}), 0.5);
  EXPECT_EQ(exact_surface_distance(cube, {0.25, 0, 0}), 0.25);
  EXPECT_EQ(exact_surface_distance(cube, {0.5, 0.1, 0}), 0.0);
  EXPECT_EQ(exact_surface_distance(cube, {1.5, 1.5, 0}), std::sqrt(2.0));
}

TEST(ExactSignedDistanceDecimal, Digits) {
  EXPECT_EQ(exact_signed_distance_decimal(unit_cube(0, 0, 0), unit_cube(2, 2, 0), 30),
            "1.41421356237309504880168872421e0");
  EXPECT_EQ(exact_signed_distance_decimal(unit_cube(0, 0, 0), unit_cube(0, 0, 0), 3), "-1.00e0");
  EXPECT_EQ(exact_signed_distance_decimal(unit_cube(0, 0, 0), unit_cube(1, 0, 0), 3), "0");
  EXPECT_EQ(exact_signed_distance_decimal(unit_cube(0, 0, 0), unit_cube(11, 0, 0), 2), "1.0e1");
}

TEST(ContactPatch, ShiftedCubes) {
  const WorldVertices a = unit_cube(0, 0, 0), b = unit_cube(0.25, 0.5, 1);
  const ContactPatch patch = find_contact_patch(a, b, {0, 0, 1});
  EXPECT_DOUBLE_EQ(patch.area, 0.375);  // 0.75 x 0.5
  EXPECT_EQ(patch.vertex_count, 4);
  for (int k = 0; k < patch.vertex_count; ++k) EXPECT_EQ(patch.vertices[k].separation, 0.0);
}

// --- against the exhaustive oracle ---

using Random = std::mt19937_64;

double uniform(Random& random, double low,
               double high) {  // not std::uniform_..., whose values differ between libraries
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

WorldVertices random_box(Random& random, const Vector3& centre, double thinnest) {
  const auto side = [&] { return uniform(random, thinnest, 1.0); };
  const Hexahedron solid = Hexahedron::from_size({side(), side(), side()});
  Pose X;
  const auto component = [&] { return uniform(random, -1.0, 1.0); };
  X.R = rotation_from_quaternion(component(), component(), component(), component());
  X.p = centre + Vector3(component(), component(), component());
  WorldVertices out;
  world_vertices(solid, X, out);
  return out;
}

WorldVertices random_grid_points(Random& random, int steps) {
  WorldVertices v;
  for (auto* axis : {&v.x, &v.y, &v.z}) {
    for (double& value : *axis) value = static_cast<double>(random() % static_cast<unsigned>(steps));
  }
  return v;
}

void expect_right(const WorldVertices& a, const WorldVertices& b) {
  const ExactResult r = exact_signed_distance(a, b);
  EXPECT_TRUE(exact_test::is_signed_distance(a, b, r.separation)) << r.separation;
  EXPECT_EQ(exact_overlap(a, b), r.pair_class != PairClass::separated);
  EXPECT_EQ(exact_pair_class(a, b), r.pair_class);
  const double scale = std::max(largest_coordinate(a), largest_coordinate(b));
  EXPECT_NEAR(exact_separation_along(a, b, r.n_AB_W), r.separation, 0x1p-50 * scale);
  EXPECT_LE(exact_surface_distance(a, r.p_A_W), 0x1p-51 * scale);  // the points are rounded
  EXPECT_LE(exact_surface_distance(b, r.p_B_W), 0x1p-51 * scale);
  EXPECT_LE(norm(r.p_B_W - r.p_A_W - r.separation * r.n_AB_W), 0x1p-50 * scale);
  expect_symmetric(a, b);
}

TEST(ExactAgainstExhaustion, RandomBoxes) {
  Random random(1);
  for (int i = 0; i < 25; ++i)
    expect_right(random_box(random, {0, 0, 0}, 0.2), random_box(random, {0, 0, 0}, 0.2));
}

TEST(ExactAgainstExhaustion, SlabsAndNeedles) {
  Random random(2);
  for (int i = 0; i < 15; ++i)
    expect_right(random_box(random, {0, 0, 0}, 1e-9), random_box(random, {0, 0, 0}, 1e-9));
}

TEST(ExactAgainstExhaustion, FarFromTheOrigin) {
  Random random(3);
  for (const double offset : {1e6, 1e12, 1e15, 4e15}) {
    const Vector3 centre(offset, -offset, 0.5 * offset);
    for (int i = 0; i < 6; ++i)
      expect_right(random_box(random, centre, 0.2), random_box(random, centre, 0.2));
  }
}

// Points on a coarse grid: coincident vertices, flat and linear hulls, exact touching and ties.
TEST(ExactAgainstExhaustion, GridPoints) {
  Random random(4);
  for (int i = 0; i < 30; ++i) {
    WorldVertices a = random_grid_points(random, 2 + i % 3), b = random_grid_points(random, 2 + i % 3);
    if (i % 5 == 1) a.z.fill(1.0);
    if (i % 5 == 2) a.y.fill(0.0), a.z.fill(1.0);
    if (i % 5 == 3) a.z.fill(1.0), b.z.fill(1.0);
    if (i % 7 == 3) b.x.fill(1.0), b.y.fill(1.0);
    expect_right(a, b);
  }
}

// One box against itself, shifted a little along a face normal: many parallel edges and near ties.
TEST(ExactAgainstExhaustion, ParallelBoxes) {
  Random random(5);
  for (int i = 1; i <= 10; ++i) {
    const WorldVertices a = random_box(random, {0, 0, 0}, 0.2);
    WorldVertices b = a;
    for (double& x : b.x) x += 0.1 * i;
    expect_right(a, b);
  }
}

}  // namespace
}  // namespace touchstone

#include "touchstone/contact_core/geometry/hexahedron.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kEps = std::numeric_limits<double>::epsilon();
using Vertices = std::vector<Vector3>;

Vertices box(const Vector3& size, const Vector3& centre = Vector3::Zero()) {
  Vertices v;
  for (int i = 0; i < 8; ++i)
    v.push_back(centre + Vector3((i & 4 ? 0.5 : -0.5) * size.x(), (i & 2 ? 0.5 : -0.5) * size.y(),
                                 (i & 1 ? 0.5 : -0.5) * size.z()));
  return v;
}

Vertices rhombohedron() {
  Vertices v;
  for (int i = 0; i < 8; ++i)
    v.push_back((i >> 2 & 1) * Vector3(1, 0.25, 0.125) + (i >> 1 & 1) * Vector3(-0.5, 1, 0.25) +
                (i & 1) * Vector3(0.125, 0.5, 2));
  return v;
}

Vertices moved(Vertices v, const Pose& X) {
  for (Vector3& p : v) p = transform(X, p);
  return v;
}

// Outward faces, the vertices on or below each, unit normals, and a sphere around all; `slack` per metre of
// size.
void expect_sound(const Hexahedron& solid, double slack = 64 * kEps) {
  double origin_distance = 0.0;
  for (const Vector3& p : solid.vertices())
    origin_distance = std::max(origin_distance, p.cwiseAbs().maxCoeff());
  const double allowed = slack * (solid.size() + origin_distance);
  for (int f = 0; f < 6; ++f) {
    const Plane& plane = solid.face_plane(f);
    if (plane.normal == Vector3::Zero()) continue;
    EXPECT_NEAR(norm(plane.normal), 1.0, 4 * kEps);
    for (int i = 0; i < 8; ++i) {
      const auto& quad = Hexahedron::kFaceVertices[f];
      const double height = plane.signed_distance(solid.vertices()[i]);
      EXPECT_LE(height, allowed) << "face " << f << " vertex " << i;
      if (std::find(quad.begin(), quad.end(), i) != quad.end()) {
        EXPECT_GE(height, -allowed);
      }
    }
  }
  for (const Vector3& p : solid.vertices()) {
    const Vector3 arm = p - solid.bounding_sphere().centre;
    EXPECT_LE(std::hypot(arm.x(), arm.y(), arm.z()), solid.bounding_sphere().radius);
  }
}

std::set<std::vector<double>> as_set(std::span<const Vector3> vertices) {
  std::set<std::vector<double>> set;
  for (const Vector3& p : vertices) set.insert({p.x(), p.y(), p.z()});
  return set;
}

TEST(Box, VerticesFacesAndSizesAreExact) {
  const Hexahedron solid = Hexahedron::from_size({1, 2, 3});
  EXPECT_TRUE(solid.is_box());
  EXPECT_FALSE(solid.is_warped());
  EXPECT_EQ(solid.half_extents(), Vector3(0.5, 1, 1.5));
  EXPECT_EQ(solid.vertices()[0], Vector3(-0.5, -1, -1.5));
  EXPECT_EQ(solid.vertices()[1], Vector3(-0.5, -1, 1.5));
  EXPECT_EQ(solid.vertices()[7], Vector3(0.5, 1, 1.5));
  EXPECT_EQ(solid.out_of_plane(), 0.0);
  EXPECT_NEAR(solid.size(), std::sqrt(14.0), 4 * kEps);
  for (int f = 0; f < 6; ++f) {
    Vector3 expected = Vector3::Zero();
    expected(f / 2) = f % 2 ? 1 : -1;
    EXPECT_EQ(solid.face_plane(f).normal, expected);
    EXPECT_NEAR(solid.face_plane(f).offset, -solid.half_extents()(f / 2), 4 * kEps);
  }
  expect_sound(solid);
}

TEST(Box, BadSizesAreRefusedNamingTheSide) {
  const double inf = kInfinity;
  for (double bad : {0.0, -1.0, double(NAN), inf, -inf, 5e-324})
    for (int axis = 0; axis < 3; ++axis) {
      Vector3 size(1, 1, 1);
      size(axis) = bad;
      EXPECT_THAT([&] { Hexahedron::from_size(size, "crate"); },
                  ThrowsMessage<InputError>(
                      AllOf(HasSubstr("crate"), HasSubstr(std::string("along ") + "xyz"[axis]))));
    }
  EXPECT_THAT(
      [] {
        Hexahedron::from_size({1, -2.5, 1}, "crate");
      },
      ThrowsMessage<InputError>(HasSubstr("-2.5")));
}

TEST(EdgeLines, RunFromLowerToHigherVertexAlongTheirAxis) {
  const Hexahedron solid = Hexahedron::from_size({1, 2, 3});
  for (int e = 0; e < 12; ++e) {
    Vector3 along = Vector3::Zero();
    const int axis = e / 4;
    along(axis) = 1 + axis;
    EXPECT_EQ(solid.edge_line(e).direction, along);
    EXPECT_EQ(solid.edge_line(e).origin, solid.vertices()[Hexahedron::kEdgeVertices[e][0]]);
  }
}

TEST(FromVertices, MirroredOrderIsRelabelled) {
  Vertices v = rhombohedron();
  for (int axis : {1, 2, 4}) {
    Vertices mirrored(8);
    for (int i = 0; i < 8; ++i) mirrored[i] = v[i ^ axis];
    const Hexahedron solid = Hexahedron::from_vertices(mirrored);
    expect_sound(solid);
    EXPECT_EQ(as_set(solid.vertices()), as_set(v));
  }
}

TEST(FromVertices, AnyOrderOfARhombohedronGivesTheSameSolid) {
  const Vertices given = rhombohedron();
  std::vector<int> order = {0, 1, 2, 3, 4, 5, 6, 7};
  int count = 0;
  do {
    if (count++ % 13 != 0) continue;
    Vertices v;
    for (int i : order) v.push_back(given[i]);
    const Hexahedron solid = Hexahedron::from_vertices(v);
    ASSERT_FALSE(solid.is_warped());
    ASSERT_EQ(as_set(solid.vertices()), as_set(given));
    for (int f = 0; f < 6; ++f) ASSERT_NE(solid.face_plane(f).normal, Vector3::Zero());
    expect_sound(solid);
    if (testing::Test::HasFailure()) FAIL() << "order " << count;
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(FromVertices, RoundedToSinglePrecisionAnyOrderIsRelabelled) {
  Vertices given;
  for (const Vector3& v : rhombohedron())
    given.push_back(transform(Pose{rotation_from_quaternion(0.8, 0.3, -0.4, 0.2), {0.1, 0.2, 0.3}}, v)
                        .cast<float>()
                        .cast<double>());
  std::vector<int> order = {0, 1, 2, 3, 4, 5, 6, 7};
  int count = 0;
  do {
    if (count++ % 131 != 0) continue;
    Vertices v;
    for (int i : order) v.push_back(given[i]);
    for (WarpPolicy warp : {WarpPolicy::within_tolerance, WarpPolicy::accept}) {
      const Hexahedron solid = Hexahedron::from_vertices(v, warp);
      ASSERT_TRUE(solid.is_warped());
      ASSERT_EQ(as_set(solid.vertices()), as_set(given));
      ASSERT_LT(solid.out_of_plane(), 1e-6 * solid.size());
    }
    ASSERT_THROW(Hexahedron::from_vertices(v, WarpPolicy::refuse), InputError);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(FromVertices, AnOrderOtherThanTheGivenOneIsFoundUpToTheToleranceOnly) {
  Vertices v = box({1, 1, 1});
  std::swap(v[0], v[5]), std::swap(v[3], v[4]);
  const Vector3 corner = v[7];
  const double size = std::sqrt(3.0);
  // The corner lifted by h bends its faces by h / 4, and a little less as the plane leans.
  v[7] = corner + Vector3(0, 0, 4 * 0.0098 * size);
  const Hexahedron solid = Hexahedron::from_vertices(v);
  EXPECT_NEAR(solid.out_of_plane(), 0.0098 * size, 1e-3 * size);
  EXPECT_EQ(as_set(solid.vertices()), as_set(v));
  v[7] = corner + Vector3(0, 0, 4 * 0.012 * size);
  for (WarpPolicy warp : {WarpPolicy::within_tolerance, WarpPolicy::accept})
    EXPECT_THAT([&] { Hexahedron::from_vertices(v, warp, "block"); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("block: no convex hexahedron"), HasSubstr(" m; "),
                                                HasSubstr("is warped: a vertex is 0.02"))));
}

TEST(FromVertices, ASheetAsThinAsItsRoundingKeepsTheGivenOrderAndHasNoOther) {
  // As thick as its rounding: what top and sides are, only the order tells.
  std::mt19937_64 random(7);
  const auto rounded = [](double x) { return std::round(x * 1e4) / 1e4; };
  int kept = 0, ambiguous = 0;
  for (int i = 0; i < 200; ++i) {
    Vertices v = moved(box({1, 1, 1e-4}), random_pose(random, 1));
    for (Vector3& p : v) p = {rounded(p.x()), rounded(p.y()), rounded(p.z())};
    std::array<Vector3, 8> given{};
    try {
      const Hexahedron solid = Hexahedron::from_vertices(v);
      std::copy(v.begin(), v.end(), given.begin());
      kept += solid.vertices() == given;
      std::swap(v[0], v[5]), std::swap(v[2], v[6]);
      Hexahedron::from_vertices(v);
    } catch (const InputError& error) {
      ambiguous += std::string(error.what()).find("no unique hexahedron") != std::string::npos;
    }
  }
  EXPECT_EQ(kept, 200);
  EXPECT_GT(ambiguous, 5);
}

// The four sides become bow-ties whose diagonals are parallel, which once passed for collapsed faces.
TEST(FromVertices, ACubeWithOneFaceHalfTurnedIsRelabelled) {
  Vertices v = box({1, 1, 1});
  std::swap(v[4], v[7]), std::swap(v[5], v[6]);
  const Hexahedron solid = Hexahedron::from_vertices(v);
  for (int f = 0; f < 6; ++f) EXPECT_NE(solid.face_plane(f).normal, Vector3::Zero());
  expect_sound(solid);
}

TEST(FromVertices, CollapsedFacesAreAccepted) {
  Vertices pyramid = box({2, 2, 2});
  for (int i : {1, 3, 5, 7}) pyramid[i] = {0, 0, 1};
  expect_sound(Hexahedron::from_vertices(pyramid));
  EXPECT_EQ(Hexahedron::from_vertices(pyramid).face_plane(5).normal, Vector3::Zero());
  Vertices wedge = box({2, 2, 2});
  wedge[1] = wedge[3] = {-1, 0, 1}, wedge[5] = wedge[7] = {1, 0, 1};
  expect_sound(Hexahedron::from_vertices(wedge));
}

TEST(FromVertices, BadInputIsRefusedNamingTheCause) {
  // Each fault in turn: a vertex too few, one that is not finite, no volume, not convex.
  const auto make = [](const Vertices& v, WarpPolicy warp = WarpPolicy::accept) {
    return [v, warp] { Hexahedron::from_vertices(v, warp, "block"); };
  };
  Vertices v = box({1, 1, 1});
  v.pop_back();
  EXPECT_THAT(make(v), ThrowsMessage<InputError>(AllOf(HasSubstr("block"), HasSubstr("has 7 vertices"))));
  v = box({1, 1, 1});
  v[5].y() = NAN;
  EXPECT_THAT(make(v),
              ThrowsMessage<InputError>(AllOf(HasSubstr("block"), HasSubstr("vertex 5 is not finite"))));
  v = box({1, 1, 0});
  EXPECT_THAT(make(v), ThrowsMessage<InputError>(AllOf(HasSubstr("block"), HasSubstr("zero volume"))));
  v = box({1, 1, 1});
  v[7] = {0.1, 0.1, 0.1};
  EXPECT_THAT(make(v),
              ThrowsMessage<InputError>(AllOf(HasSubstr("block"), HasSubstr("not convex: vertex 7"))));
  // Warped by more than the policy takes.
  v = box({1, 1, 1});
  v[7] += Vector3(0.25, 0.25, 0.25);
  for (WarpPolicy warp : {WarpPolicy::refuse, WarpPolicy::within_tolerance})
    EXPECT_THAT(make(v, warp),
                ThrowsMessage<InputError>(
                    HasSubstr("block: face 1 (vertices 4 6 7 5) is warped: a vertex is 0.0495074 m out")));
  EXPECT_THAT(make(v, WarpPolicy::refuse), ThrowsMessage<InputError>(HasSubstr("planar up to 1.5")));
  EXPECT_THAT(make(v, WarpPolicy::within_tolerance),
              ThrowsMessage<InputError>(HasSubstr("tolerated up to 0.0216507 m")));
}

TEST(FromVertices, BentBeyondTheToleranceIsAcceptedOnlyWhenAsked) {
  Vertices v = box({1, 1, 1});
  v[7] += Vector3(0.25, 0.25, 0.25);
  const Hexahedron solid = Hexahedron::from_vertices(v, WarpPolicy::accept);
  EXPECT_TRUE(solid.is_warped());
  // By hand: normal (2.5, -0.25, -0.25) / sqrt(6.375), centroid 1/16 off in each direction.
  EXPECT_NEAR(solid.out_of_plane(), 0.125 / std::sqrt(6.375), 4 * kEps);
  EXPECT_THROW(Hexahedron::from_vertices(v), InputError);
}

TEST(FromVertices, BentFacesArePlanarUpTo32Eps) {
  // Lifting one corner by h puts the four vertices h/4 off the plane through the centroid.
  const double size = std::sqrt(3.0);
  for (double factor : {0.9, 1.1}) {
    Vertices v = box({1, 1, 1}, {0.5, 0.5, 0.5});
    v[7].z() += 4 * factor * 32 * kEps * size;
    EXPECT_EQ(Hexahedron::from_vertices(v, WarpPolicy::accept).is_warped(), factor > 1) << factor;
  }
}

TEST(FromVertices, RotatedBoxesArePlanarWhereverTheyLie) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 500; ++i) {
    const Hexahedron solid = Hexahedron::from_vertices(moved(rhombohedron(), random_pose(random, 1)));
    expect_sound(solid);
  }
  // On a grid of exact coordinates, a metre-sized box a million metres out is as planar as at the origin.
  const Hexahedron far = Hexahedron::from_vertices(box({1, 2, 3}, {1e6, -3e7, 1e9}));
  EXPECT_EQ(far.out_of_plane(), 0.0);
  expect_sound(far);
  Vertices sheared = rhombohedron();
  for (Vector3& p : sheared) p += Vector3(1e6, 1e9, -1e7);
  expect_sound(Hexahedron::from_vertices(sheared));
  EXPECT_LE(Hexahedron::from_vertices(sheared).out_of_plane(), 8 * kEps);
}

TEST(FromVertices, NeedlesAndSlabsAreAccepted) {
  for (double thin : {0x1p-20, 0x1p-40})
    for (const Vector3& size : {Vector3(1, 1, thin), Vector3(thin, thin, 1), Vector3(1, thin, 1)}) {
      const Hexahedron solid = Hexahedron::from_vertices(box(size));
      expect_sound(solid);
      for (int f = 0; f < 6; ++f) EXPECT_NE(solid.face_plane(f).normal, Vector3::Zero());
    }
}

TEST(FromVertices, ScalesFromDenormalToHugeKeepTheShape) {
  const Hexahedron one = Hexahedron::from_vertices(rhombohedron());
  for (int exponent : {-1060, -1022, -500, 0, 500, 1000}) {
    Vertices v = rhombohedron();
    for (Vector3& p : v)
      p = {std::scalbn(p.x(), exponent), std::scalbn(p.y(), exponent), std::scalbn(p.z(), exponent)};
    const Hexahedron solid = Hexahedron::from_vertices(v);
    EXPECT_FALSE(solid.is_warped());
    EXPECT_EQ(as_set(solid.vertices()), as_set(v));
    EXPECT_NEAR(std::scalbn(solid.size(), -exponent), one.size(), exponent < -1022 ? 0x1p-14 : 0.0);
    for (int f = 0; f < 6; ++f) EXPECT_EQ(solid.face_plane(f).normal, one.face_plane(f).normal);
    for (const Vector3& p : solid.vertices()) {
      const Vector3 arm = p - solid.bounding_sphere().centre;
      EXPECT_LE(std::hypot(arm.x(), arm.y(), arm.z()), solid.bounding_sphere().radius);
    }
  }
}

TEST(WorldVertices, FollowTheStatedFormulaToTheBit) {
  std::mt19937_64 random(5);
  const Hexahedron solid = Hexahedron::from_vertices(rhombohedron());
  for (int n = 0; n < 100; ++n) {
    const Pose X = random_pose(random, 1e6);
    WorldVertices world;
    world_vertices(solid, X, world);
    double largest = 0.0;
    for (int i = 0; i < 8; ++i) {
      const Vector3 p = solid.vertices()[i];
      for (int k = 0; k < 3; ++k) {
        const double expected = ((X.R(k, 0) * p.x() + X.R(k, 1) * p.y()) + X.R(k, 2) * p.z()) + X.p(k);
        EXPECT_EQ(world.vertex(i)(k), expected);
        largest = std::max(largest, std::abs(expected));
      }
    }
    EXPECT_EQ(largest_coordinate(world), largest);
  }
}

}  // namespace
}  // namespace touchstone

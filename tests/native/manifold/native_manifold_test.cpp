#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "touchstone/tests/native/native_fixture.hpp"

namespace touchstone {
namespace {

/// Area of the points' convex polygon seen along z, in the given order.
double area_in_order(const Answer& answer) {
  double twice = 0.0;
  const int n = answer.geometry.point_count;
  for (int i = 0; i < n; ++i) {
    const Vector3& p = answer.points[i].p_A_W;
    const Vector3& q = answer.points[(i + 1) % n].p_A_W;
    twice += p.x() * q.y() - p.y() * q.x();
  }
  return 0.5 * std::abs(twice);
}

Pose turned(double angle, double z) {
  Pose X = at(0, 0, z);
  X.R = rotation_from_quaternion(std::cos(angle / 2), 0, 0, std::sin(angle / 2));
  return X;
}

const Hexahedron kCube = Hexahedron::from_size({1, 1, 1});
const double kPi = std::acos(-1.0);

TEST(NativeManifold, FaceOnFaceHasFourPointsAndTheWholeArea) {
  const Answer answer = ask(Hexahedron::from_size({4, 4, 1}), at(0, 0, 0), kCube, at(0.25, 0.5, 0.75));
  ASSERT_EQ(answer.geometry.point_count, 4);
  EXPECT_DOUBLE_EQ(area_in_order(answer), 1.0);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(answer.points[i].separation, -0.25);
    EXPECT_EQ(answer.points[i].p_A_W.z(), 0.5);
    EXPECT_EQ(answer.points[i].p_B_W.z(), 0.25);
  }
}

// 1e15 m out an ulp is 0.125 m: all vertices of the small cube round to one point, which clips nothing.
TEST(NativeManifold, SolidFlattenedToAPointMeetsInThatPoint) {
  const Answer answer = ask(Hexahedron::from_size({1e-3, 1e-3, 1e-3}), at(1e15, 1e15, 1e15),
                            Hexahedron::from_size({64, 64, 64}), at(1e15, 1e15, 1e15 - 40));
  ASSERT_EQ(answer.geometry.point_count, 1);
  EXPECT_EQ(answer.points[0].p_A_W, Vector3(1e15, 1e15, 1e15));
  EXPECT_EQ(answer.points[0].p_B_W, Vector3(1e15, 1e15, 1e15 - 8));
  EXPECT_EQ(answer.points[0].separation, 8.0);
}

TEST(NativeManifold, FlushSidesKeepTheWholeArea) {
  const Answer answer = ask(kCube, at(0, 0, 0), kCube, at(0, 0, 1));
  ASSERT_EQ(answer.geometry.point_count, 4);
  EXPECT_DOUBLE_EQ(area_in_order(answer), 1.0);
}

// An overlapping pair came with a separation of +inf and no points, and with NaN some separated ones with
// theirs.
TEST(NativeManifold, LimitThatIsNoDistanceIsOneOfZero) {
  for (const double limit : {-1e-300, -0.1, -HUGE_VAL, std::nan("")}) {
    Query query = whole_clip();
    query.max_separation = limit;
    const Answer deep = ask(kCube, at(0, 0, 0), kCube, at(0.25, 0, 0.75), query);
    EXPECT_EQ(deep.status, PairStatus::overlapping);
    EXPECT_EQ(deep.geometry.separation, -0.25);
    EXPECT_EQ(deep.geometry.point_count, 4);
    for (const double height : {1 + 0x1p-52, 1.5, 100.0}) {
      const Answer apart = ask(kCube, at(0, 0, 0), kCube, at(0.25, 0, height), query);
      EXPECT_EQ(apart.status, PairStatus::separated);
      EXPECT_EQ(apart.geometry.separation, INFINITY);
      EXPECT_EQ(apart.geometry.point_count, 0);
    }
  }
}

TEST(NativeManifold, SquaresTurned45DegreesMeetInAnOctagon) {
  const Answer answer = ask(kCube, turned(0.0, 0.0), kCube, turned(kPi / 4, 0.875));
  ASSERT_EQ(answer.geometry.point_count, 8);
  EXPECT_NEAR(area_in_order(answer), 2 * (std::sqrt(2.0) - 1), 1e-14);
  std::set<std::uint32_t> ids;
  for (const ContactPoint& point : answer.points) ids.insert(point.feature_id);
  EXPECT_EQ(ids.size(), 8u);
}

TEST(NativeManifold, ReductionKeepsTheDeepestPointAndTheLargestArea) {
  Query query = whole_clip();
  query.max_points = 4;
  const Answer answer = ask(kCube, turned(0.0, 0.0), kCube, turned(kPi / 4, 0.875), query);
  ASSERT_EQ(answer.geometry.point_count, 4);
  // A regular octagon of inradius 1/2 holds a square of side 1 / (2 cos(pi / 8)) * sqrt(2) over four of its
  // corners.
  const double circumradius = 0.5 / std::cos(kPi / 8);
  EXPECT_NEAR(area_in_order(answer), 2 * circumradius * circumradius, 1e-14);
  double deepest = INFINITY;
  for (int i = 0; i < 4; ++i) deepest = std::min(deepest, answer.points[i].separation);
  EXPECT_EQ(deepest, answer.geometry.separation);
}

TEST(NativeManifold, AnyNumberOfPointsHoldsTheDeepest) {
  Random random(11);
  for (int i = 0; i < 300; ++i) {
    const Hexahedron a = random.any(), b = random.any();
    const Pose X_WA = random.pose(0.3), X_WB = random.pose(0.9);
    for (int n = 1; n <= kMaxManifoldPoints; ++n) {
      Query query = whole_clip();
      query.max_points = n;
      const Answer answer = ask(a, X_WA, b, X_WB, query);
      ASSERT_GE(answer.geometry.point_count, 1);
      ASSERT_LE(answer.geometry.point_count, n);
      const auto end = answer.points.begin() + answer.geometry.point_count;
      ASSERT_TRUE(std::any_of(answer.points.begin(), end, [&](const ContactPoint& p) {
        return p.separation == answer.geometry.separation;
      }));
    }
  }
}

TEST(NativeManifold, CrossingEdgesGiveThePointWhereTheyCross) {
  Pose X_WA, X_WB = at(0, 0, std::sqrt(2.0) - 0.0625);
  X_WA.R = rotation_from_quaternion(std::cos(kPi / 8), std::sin(kPi / 8), 0, 0);
  X_WB.R = rotation_from_quaternion(std::cos(kPi / 8), 0, std::sin(kPi / 8), 0);
  const Answer answer = ask(Hexahedron::from_size({4, 1, 1}), X_WA, Hexahedron::from_size({1, 4, 1}), X_WB);
  EXPECT_NEAR(answer.geometry.separation, -0.0625, 1e-15);
  EXPECT_NEAR(norm(answer.geometry.p_A_W - Vector3(0, 0, std::sqrt(0.5))), 0.0, 1e-14);
}

TEST(NativeManifold, SeparatedPairsWithinReachHavePointsToo) {
  Query query = whole_clip();
  query.max_separation = 0.25;
  const Answer answer = ask(kCube, at(0, 0, 0), kCube, at(0.5, 0, 1.125), query);
  ASSERT_EQ(answer.geometry.point_count, 4);
  EXPECT_DOUBLE_EQ(area_in_order(answer), 0.5);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(answer.points[i].separation, 0.125);
}

TEST(NativeManifold, TinyMotionBarelyMovesThePoints) {
  Random random(12);
  for (int i = 0; i < 200; ++i) {
    const Pose X_WA = turned(0.0, 0.0);
    Pose X_WB = turned(random.uniform(0, kPi), 0.9);
    X_WB.p.x() = random.uniform(-0.5, 0.5);
    const Answer before = ask(kCube, X_WA, kCube, X_WB);
    X_WB.p += random.vector(1e-9);
    const Answer after = ask(kCube, X_WA, kCube, X_WB);
    ASSERT_NEAR(area_in_order(before), area_in_order(after), 1e-8);
  }
}

}  // namespace
}  // namespace touchstone

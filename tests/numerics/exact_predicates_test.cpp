#include "touchstone/contact_core/numerics/exact_predicates.hpp"
#include "touchstone/contact_core/geometry/orientation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/tests/numerics/pair_generators.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone::numerics {
namespace {

WorldVertices box(const Vector3& low, const Vector3& high) {
  WorldVertices out;
  for (int i = 0; i < 8; ++i) {
    out.x[i] = i >> 2 & 1 ? high.x() : low.x();
    out.y[i] = i >> 1 & 1 ? high.y() : low.y();
    out.z[i] = i & 1 ? high.z() : low.z();
  }
  return out;
}

bool meet(const WorldVertices& a, const WorldVertices& b) {
  const bool answer = hulls_intersect(a, b);
  EXPECT_EQ(hulls_intersect(b, a), answer);
  return answer;
}

const WorldVertices kUnitBox = box({0, 0, 0}, {1, 1, 1});
constexpr double kUlp = 0x1p-52;  // of 1

TEST(Orient3d, PointsToTheSideOfTheNormal) {
  const Vector3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  EXPECT_EQ(orient3d_sign(a, b, c, {5, 5, 0x1p-1074}), 1);
  EXPECT_EQ(orient3d_sign(a, b, c, {5, 5, -0x1p-1074}), -1);
  EXPECT_EQ(orient3d_sign(a, b, c, {5, 5, 0}), 0);
}

TEST(Orient3d, DecidesTheLastBitOfAnObliquePlane) {
  // On x + y + z = 1, where 0.1 + 0.7 + 0.2 rounds to 1 but is not 1 as doubles.
  const Vector3 a(1, 0, 0), b(0, 1, 0), c(0, 0, 1);
  EXPECT_EQ(orient3d_sign(a, b, c, {0.5, 0.25, 0.25}), 0);
  EXPECT_EQ(orient3d_sign(a, b, c, {0.5, 0.25, 0.25 + 0x1p-54}), 1);
  EXPECT_EQ(orient3d_sign(a, b, c, {0.5, 0.25, 0.25 - 0x1p-55}), -1);
  EXPECT_EQ(orient3d_sign(a, b, c, {0.5, 0.5, 0x1p-1074}), 1);
}

TEST(Orient3d, NeverOverflows) {
  const double m = 0x1.fffffffffffffp1023;
  const Vector3 a(-m, -m, -m), b(m, -m, -m), c(-m, m, -m);
  EXPECT_EQ(orient3d_sign(a, b, c, {m, m, m}), 1);
  EXPECT_EQ(orient3d_sign(a, b, c, {m, m, -m}), 0);
  EXPECT_EQ(orient3d_sign(a, b, c, {m, m, -0x1.ffffffffffffep1023}), 1);
}

TEST(HullsIntersect, ApartByOneUlpAndTouching) {
  EXPECT_TRUE(meet(kUnitBox, box({1, 0, 0}, {2, 1, 1})));
  EXPECT_FALSE(meet(kUnitBox, box({1 + kUlp, 0, 0}, {2, 1, 1})));
  EXPECT_TRUE(meet(kUnitBox, box({1, 1, 0}, {2, 2, 1})));
  EXPECT_FALSE(meet(kUnitBox, box({1, 1 + kUlp, 0}, {2, 2, 1})));
  EXPECT_TRUE(meet(kUnitBox, box({1, 1, 1}, {2, 2, 2})));
  EXPECT_FALSE(meet(kUnitBox, box({1, 1, 1 + kUlp}, {2, 2, 2})));
}

TEST(HullsIntersect, Containment) {
  EXPECT_TRUE(meet(kUnitBox, box({0.25, 0.25, 0.25}, {0.5, 0.5, 0.5})));
  EXPECT_TRUE(meet(kUnitBox, kUnitBox));
  EXPECT_TRUE(meet(kUnitBox, box({0.5, 0.5, 0.5}, {0.5, 0.5, 0.5})));
}

TEST(HullsIntersect, EdgesThatCross) {
  // A roof ridge along x at z = 0 under a keel along y at z = h.
  WorldVertices ridge = box({-1, -1, -1}, {1, 1, 0});
  WorldVertices keel = box({-1, -1, 0}, {1, 1, 1});
  for (int i = 0; i < 8; ++i) {
    if (i & 1) ridge.y[i] = 0;
    if (!(i & 1)) keel.x[i] = 0;
  }
  EXPECT_TRUE(meet(ridge, keel));
  for (int i = 0; i < 8; ++i)
    if (!(i & 1)) keel.z[i] = 0x1p-1074;
  EXPECT_FALSE(meet(ridge, keel));
  for (int i = 0; i < 8; ++i)
    if (!(i & 1)) keel.z[i] = -0x1p-1074;
  EXPECT_TRUE(meet(ridge, keel));
}

TEST(HullsIntersect, FlattenedHulls) {
  const WorldVertices square = box({0, 0, 0}, {1, 1, 0});
  const WorldVertices point = box({1, 1, 0}, {1, 1, 0});
  EXPECT_TRUE(meet(square, box({1, 1, 0}, {2, 2, 0})));
  EXPECT_FALSE(meet(square, box({1, 1 + kUlp, 0}, {2, 2, 0})));
  EXPECT_FALSE(meet(square, box({0, 0, 0x1p-1074}, {1, 1, 0x1p-1074})));
  EXPECT_TRUE(meet(square, box({0.5, 0.5, -1}, {0.5, 0.5, 1})));
  EXPECT_FALSE(meet(square, box({1.5, 0.5, -1}, {1.5, 0.5, 1})));
  EXPECT_TRUE(meet(square, point));
  EXPECT_TRUE(meet(point, point));
  EXPECT_FALSE(meet(point, box({1, 1, 0x1p-1074}, {1, 1, 0x1p-1074})));
  const WorldVertices segment = box({0, 0, 0}, {1, 0, 0});
  EXPECT_TRUE(meet(segment, box({1, 0, 0}, {2, 0, 0})));
  EXPECT_FALSE(meet(segment, box({1 + kUlp, 0, 0}, {2, 0, 0})));
  EXPECT_FALSE(meet(segment, box({0, 0x1p-1074, 0}, {1, 0x1p-1074, 0})));
}

TEST(HullsIntersect, AnswersDependOnTheSetsAlone) {
  Random random(11);
  for (int i = 0; i < 500; ++i) {
    const HullPair pair = i % 2 == 0 ? grid_pair(random, 2) : rotated_box_pair(random);
    const bool answer = meet(pair.a, pair.b);
    EXPECT_EQ(meet(permuted(pair.a, random), permuted(pair.b, random)), answer);
    for (int exponent : {-900, -64, -63, 100, 1000})
      EXPECT_EQ(meet(scaled(pair.a, exponent), scaled(pair.b, exponent)), answer) << exponent;
  }
}

TEST(HullsIntersect, AllocatesNothing) {
  Random random(12);
  for (int i = 0; i < 200; ++i) {
    const HullPair pair = i % 3 == 0   ? grid_pair(random, 2)
                          : i % 3 == 1 ? rotated_box_pair(random)
                                       : scattered_pair(random, -1074, 1023);
    const std::size_t before = allocation_count();
    const bool answer = hulls_intersect(pair.a, pair.b);
    const int sign = orient3d_sign(pair.a.vertex(0), pair.a.vertex(1), pair.a.vertex(2), pair.b.vertex(3));
    EXPECT_EQ(allocation_count(), before);
    EXPECT_TRUE((answer || true) && sign * sign <= 1);
  }
}

}  // namespace
}  // namespace touchstone::numerics

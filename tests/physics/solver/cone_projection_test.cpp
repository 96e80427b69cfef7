#include "touchstone/physics/solver/cone_projection.hpp"

#include <gtest/gtest.h>

namespace touchstone::physics {
namespace {

// Without friction 0 <= 0 y_0 holds for contacts that pull, too: they are below the cone all the same.
TEST(ConeProjection, AContactThatPullsHasNoImpulse) {
  for (const double friction : {0.0, 0.5}) {
    const double y[3] = {-1.0, 0.0, 0.0}, d[3] = {1.0, 2.0, 3.0};
    double p[3], G[9];
    EXPECT_EQ(project_on_cone(friction, y, 0.0, p), ConeRegion::below) << friction;
    EXPECT_EQ(p[0], 0.0);
    slope_of_projection(friction, y, 1.0, G);
    for (const double entry : G) EXPECT_EQ(entry, 0.0);
    const ConeSlope slope = slope_along(friction, y, d);
    EXPECT_EQ(slope.projection, 0.0);
    EXPECT_EQ(slope.change, 0.0);
  }
}

TEST(ConeProjection, AContactThatPressesKeepsItsImpulse) {
  const double y[3] = {2.0, 0.5, 0.0};
  double p[3];
  EXPECT_EQ(project_on_cone(0.5, y, 0.5, p), ConeRegion::in);
  EXPECT_EQ(p[0], 2.0);
  EXPECT_EQ(p[1], 0.5);
  const double straight[3] = {2.0, 0.0, 0.0};
  EXPECT_EQ(project_on_cone(0.0, straight, 0.0, p), ConeRegion::in);
  EXPECT_EQ(p[0], 2.0);
}

// The start of a solve, whose stiffness Newton's first step takes.
TEST(ConeProjection, TheApexIsInTheCone) {
  const double y[3] = {0.0, 0.0, 0.0};
  double p[3];
  EXPECT_EQ(project_on_cone(0.0, y, 0.0, p), ConeRegion::in);
}

}  // namespace
}  // namespace touchstone::physics

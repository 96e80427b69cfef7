#include "touchstone/physics/solver/cone_projection.hpp"

#include <gtest/gtest.h>

#include <cfenv>
#include <cmath>
#include <limits>
#include <random>

#include "touchstone/physics/solver/cone_lanes.hpp"

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

// In the cone, below it, beside it, on its edge and at its apex; with friction and without.
TEST(ConeProjection, FourSideBySideHaveTheBitsOfEach) {
  std::mt19937 random{16};
  const auto draw = [&] { return 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0; };
  for (int i = 0; i < 2000; ++i) {
    double friction[4], factor[4], y[12], d[12], p[12], G[kStiffnessLanes], slope[4], change[4], residual[4];
    for (int lane = 0; lane < 4; ++lane) {
      friction[lane] = random() % 4 == 0 ? 0.0 : 1.0 + draw(), factor[lane] = 1.5 + draw();
      for (int k = lane; k < 12; k += 4) y[k] = random() % 8 == 0 ? 0.0 : draw(), d[k] = draw();
      if (random() % 8 == 0) y[lane] = 1.0, y[4 + lane] = friction[lane], y[8 + lane] = 0.0;
    }
    // Four at once.
    put(project_on_cones(four_at(friction), lanes_at(y)), p);
    put(slopes_of_projection(four_at(friction), lanes_at(y), four_at(factor)), G);
    const ConeSlopes slopes = slopes_along(four_at(friction), lanes_at(y), lanes_at(d));
    put(slopes.projection, slope), put(slopes.change, change);
    put(contact_residuals(four_at(factor), four_at(friction), lanes_at(y), lanes_at(d)), residual);
    // Each by itself.
    for (int lane = 0; lane < 4; ++lane) {
      const double one_y[3] = {y[lane], y[4 + lane], y[8 + lane]},
                   one_d[3] = {d[lane], d[4 + lane], d[8 + lane]};
      double one_p[3], one_G[9];
      project_on_cone(friction[lane], one_y, length_of(one_y[1], one_y[2]), one_p);
      slope_of_projection(friction[lane], one_y, factor[lane], one_G);
      const ConeSlope one_slope = slope_along(friction[lane], one_y, one_d);
      for (int k = 0; k < 3; ++k) EXPECT_EQ(p[4 * k + lane], one_p[k]) << i;
      const int lower[6] = {0, 3, 4, 6, 7, 8};
      for (int k = 0; k < 6; ++k) EXPECT_EQ(G[4 * k + lane], one_G[lower[k]]) << i;
      EXPECT_EQ(slope[lane], one_slope.projection) << i;
      EXPECT_EQ(change[lane], one_slope.change) << i;
      EXPECT_EQ(residual[lane], contact_residual(factor[lane], friction[lane], one_y, one_d)) << i;
    }
  }
}

// A lane that is padding has scale, hardness, friction, impulse and velocity 0. A host may trap exceptions.
TEST(ConeProjection, LanesOfPaddingAreZerosAndRaiseNoException) {
  volatile double none = 0.0;  // not known to the compiler
  const double friction[4] = {0.5, 0.5, 0.5, none}, factor[4] = {1.0, 2.0, 3.0, none};
  const double y[12] = {2.0, -2.0, 0.5, none, 0.5, 0.25, 1.0, none, 0.25, 0.5, 1.0, none};
  double p[12], G[kStiffnessLanes], slope[4], change[4], residual[4];
  std::feclearexcept(FE_ALL_EXCEPT);
  put(project_on_cones(four_at(friction), lanes_at(y)), p);
  put(slopes_of_projection(four_at(friction), lanes_at(y), four_at(factor)), G);
  const ConeSlopes slopes = slopes_along(four_at(friction), lanes_at(y), lanes_at(y));
  put(slopes.projection, slope), put(slopes.change, change);
  put(contact_residuals(four_at(factor), four_at(friction), lanes_at(y), lanes_at(y)), residual);
  EXPECT_EQ(std::fetestexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW), 0);
  for (int k = 3; k < 12; k += 4) EXPECT_EQ(p[k], 0.0);
  for (std::size_t k = 3; k < kStiffnessLanes; k += 4) EXPECT_EQ(G[k], 0.0);
  EXPECT_EQ(slope[3], 0.0);
  EXPECT_EQ(change[3], 0.0);
  EXPECT_EQ(residual[3], 0.0);
}

TEST(ConeProjection, WhatIsNotANumberStaysInItsLaneAndIsSeen) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const double friction[4] = {0.5, 0.5, 0.5, 0.5}, factor[4] = {1.0, 1.0, 1.0, 1.0};
  const double good[12] = {2.0, 1.0, 0.5, 1.0, 0.5, 1.0, 1.0, 0.25, 0.25, 1.0, 1.0, 0.5};
  for (int bad = 0; bad < 12; ++bad) {
    // One number of one lane is none.
    double y[12], G[kStiffnessLanes], of_x[4], of_u[4], worse[4], swapped[4];
    std::copy_n(good, 12, y);
    y[bad] = kNaN;
    put(slopes_of_projection(four_at(friction), lanes_at(y), four_at(factor)), G);
    const Four by_x = contact_residuals(four_at(factor), four_at(friction), lanes_at(y), lanes_at(good));
    put(by_x, of_x);
    put(contact_residuals(four_at(factor), four_at(friction), lanes_at(good), lanes_at(y)), of_u);
    put(worse_of(by_x, in_all(1.0)), worse), put(worse_of(in_all(1.0), by_x), swapped);
    // It shows in this lane alone, and wins where the worse is taken.
    for (int lane = 0; lane < 4; ++lane) {
      const bool is_bad = lane == bad % 4;
      EXPECT_EQ(std::isnan(of_x[lane]), is_bad) << bad;
      EXPECT_EQ(std::isnan(of_u[lane]), is_bad) << bad;
      EXPECT_EQ(std::isnan(worse[lane]), is_bad) << bad;
      EXPECT_EQ(std::isnan(swapped[lane]), is_bad) << bad;
      const double one[3] = {y[lane], y[4 + lane], y[8 + lane]};
      double one_G[9];
      slope_of_projection(friction[lane], one, factor[lane], one_G);
      const int lower[6] = {0, 3, 4, 6, 7, 8};
      for (int k = 0; k < 6; ++k)
        EXPECT_EQ(std::isnan(G[4 * k + lane]), std::isnan(one_G[lower[k]])) << bad << " " << k;
    }
  }
}

}  // namespace
}  // namespace touchstone::physics

#include "touchstone/contact_core/mechanism/mechanism_path.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <numbers>

#include "touchstone/tests/mechanism/jet.hpp"
#include "touchstone/tests/mechanism/random_chain.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone {
namespace {

using test::Draw;
using test::Jet;
using test::JetVector;

/// A mechanism on a path, and what the oracle needs to follow it.
struct Case {
  MechanismDescription description;
  Mechanism mechanism;
  MechanismPath path;
  Pose X_WB;
  std::vector<double> q0, q1;

  Case(Draw& draw, double step)
      : description(draw.mechanism()), mechanism(description), path(mechanism), X_WB(draw.pose(2)) {
    for (std::uint32_t i = 0; i < mechanism.value_count(); ++i) {
      q0.push_back(draw.real(-2, 2));
      q1.push_back(draw.chance(0.2) ? q0.back() : q0.back() + draw.real(-step, step));
    }
    path.set(X_WB, q0, q1);
  }

  JetVector point(double s, std::uint32_t link, const Vector3& p_L) const {
    return test::world_point(description, X_WB, q0, q1, s, description.links[link].name, p_L);
  }
};

Vector3 velocity_at(const BodyState& state, const Vector3& p_W) {
  return state.velocity_W + cross(state.angular_velocity_W, p_W - state.centre_W);
}

TEST(MechanismPath, PosesAndRatesAreTheOraclesAndFiniteDifferences) {
  Draw draw(1);
  double worst_pose = 0, worst_share = 0;
  for (int i = 0; i < 300; ++i) {
    const Case c(draw, 3);
    const auto link =
        static_cast<std::uint32_t>(draw.integer(0, static_cast<int>(c.mechanism.joints().size())));
    const Vector3 p_L = draw.vector(2);
    const double s = draw.chance(0.1) ? draw.integer(0, 1) : draw.real(0, 1);
    const BodyState state = c.path.at(link, s);
    const Vector3 p_W = transform(state.X_WO, p_L), v_W = velocity_at(state, p_W);
    const JetVector exact = c.point(s, link, p_L);
    const double h = 1e-5, low = std::max(0.0, s - h), high = std::min(1.0, s + h);
    const Vector3 difference =
        (transform(c.path.at(link, high).X_WO, p_L) - transform(c.path.at(link, low).X_WO, p_L)) /
        (high - low);
    for (int k = 0; k < 3; ++k) {
      const auto off = std::abs(static_cast<double>(exact[k].v - p_W(k)));
      worst_pose = std::max(worst_pose, off);
      worst_share = std::max(worst_share, off / c.path.rounding(link, p_L));
      EXPECT_NEAR(v_W(k), static_cast<double>(exact[k].d), 1e-12);
      // One-sided at the ends: h |p''| / 2; |p''| < 3^2 8^2 * 40 there.
      EXPECT_NEAR(v_W(k), difference(k), s > 0 && s < 1 ? 1e-5 : 0.2);
    }
  }
  std::printf("poses against long double: worst %.2g m, %.3f of rounding()\n", worst_pose, worst_share);
  EXPECT_LT(worst_share, 1.0);
}

TEST(MechanismPath, PosesAreForwardKinematicsBitByBit) {
  Draw draw(2);
  for (int i = 0; i < 100; ++i) {
    const Case c(draw, 1);
    const double s = i % 5 == 0 ? i % 2 : draw.real(0, 1);
    std::vector<double> q(c.mechanism.value_count());
    c.path.values_at(s, q);
    if (s == 1.0) {
      EXPECT_EQ(q, c.q1);
    }
    std::vector<Pose> poses(c.mechanism.links().size());
    c.mechanism.link_poses(c.path.X_WB(), q, poses);
    for (std::uint32_t link = 0; link < poses.size(); ++link) {
      const Pose X = c.path.at(link, s).X_WO;
      EXPECT_TRUE(X.R == poses[link].R && X.p == poses[link].p);
    }
  }
}

// No tolerance: the oracle's own rounding is far below the bound's enlargement.
TEST(MechanismPath, CurvatureBoundHoldsOverTheWholePath) {
  for (const double step : {0.01, 0.2, 1.0, 6.0}) {
    Draw draw(static_cast<std::uint64_t>(1000 * step));
    std::vector<double> over_estimates;
    for (int i = 0; i < 1500; ++i) {
      // A chain, a point on its last link, a direction, and the rest of the path from s.
      const Case c(draw, step);
      const auto link = static_cast<std::uint32_t>(c.mechanism.joints().size());
      const Vector3 p_L = draw.vector(2);
      const Vector3 n = draw.chance(0.2) ? Vector3(Vector3::Unit(draw.integer(0, 2))) : draw.direction();
      const double s = draw.chance(0.5) ? 0.0 : draw.real(0, 1);
      // The bound holds at each of a hundred places on it.
      const BodyState state = c.path.at(link, s);
      const double bound = c.path.curvature_bound(link, state, transform(state.X_WO, p_L), n);
      double most = 0;
      for (int k = 0; k <= 100; ++k) {
        const JetVector p = c.point(s + (1 - s) * k / 100, link, p_L);
        most = std::max(most, static_cast<double>(std::abs(dot(test::jets(n), p).dd)));
        ASSERT_LE(most, bound) << "chain " << i << " of step " << step;
      }
      if (c.path.moves(link) && most > 1e-9 * step * step) over_estimates.push_back(bound / most);
    }
    // How much larger the bound is.
    std::sort(over_estimates.begin(), over_estimates.end());
    const std::size_t count = over_estimates.size();
    std::printf("step %4.2f rad: bound / largest sampled: median %.3f, 90 %% %.3f, 99 %% %.3f (%zu chains)\n",
                step, over_estimates[count / 2], over_estimates[count * 9 / 10],
                over_estimates[count * 99 / 100], count);
  }
}

TEST(MechanismPath, BoundsOfManyAreThoseOfEach) {
  Draw draw(11);
  for (int i = 0; i < 100; ++i) {
    const Case c(draw, 1);
    const auto link = static_cast<std::uint32_t>(c.mechanism.joints().size());
    const std::array<Sphere, 2> spheres{Sphere{draw.vector(2), draw.real(0, 1)},
                                        Sphere{draw.vector(2), draw.real(0, 1)}};
    const Vector3 n = draw.direction();
    const BodyState state = c.path.at(link, 0.0);
    const MechanismPath::Along along = c.path.along_of(link, n);
    std::array<double, 2> speeds;
    c.path.speed_bounds(link, spheres, speeds);
    for (std::size_t k = 0; k < spheres.size(); ++k) {
      const auto& [centre, radius] = spheres[k];
      EXPECT_EQ(speeds[k], c.path.speed_bound(link, centre) + c.path.turn_bound(link) * radius);
      const Vector3 p_W = transform(state.X_WO, centre);
      EXPECT_EQ(c.path.curvature_along(along, transform(inverse(state.X_WO), p_W)),
                c.path.curvature_bound(link, state, p_W, n));
    }
  }
}

TEST(MechanismPath, BulgeHoldsOverTheWholePath) {
  for (const double step : {0.01, 1.0, 6.0}) {
    Draw draw(7 + static_cast<std::uint64_t>(1000 * step));
    std::vector<double> over_estimates;
    for (int i = 0; i < 1500; ++i) {
      // A chain, and a point on its last link.
      const Case c(draw, step);
      const auto link = static_cast<std::uint32_t>(c.mechanism.joints().size());
      const Vector3 p_L = draw.vector(2);
      const double bound = c.path.bulge(link, p_L);
      const Vector3 from = transform(c.path.at(link, 0).X_WO, p_L),
                    to = transform(c.path.at(link, 1).X_WO, p_L);
      // The bound holds: no place on the path is farther from its chord.
      const Vector3 chord = to - from;
      double most = 0;
      for (int k = 0; k <= 200; ++k) {
        const Vector3 p = transform(c.path.at(link, k / 200.0).X_WO, p_L);
        const double squared = dot(chord, chord);
        const double t = squared > 0 ? std::clamp(dot(p - from, chord) / squared, 0.0, 1.0) : 0.0;
        most = std::max(most, norm(p - (from + t * chord)));
        ASSERT_LE(most, bound) << "chain " << i << " of step " << step;
      }
      if (most > 1e-9 * step * step) over_estimates.push_back(bound / most);
    }
    // How much larger the bound is.
    std::sort(over_estimates.begin(), over_estimates.end());
    const std::size_t count = over_estimates.size();
    std::printf("step %4.2f rad: bulge / largest sampled: median %.3f, 99 %% %.3f (%zu chains)\n", step,
                over_estimates[count / 2], over_estimates[count * 99 / 100], count);
  }
}

/// Every link of 5 m, 0.1 m above the one before.
MechanismDescription planar_arm(int joints) {
  MechanismDescription out = test::straight_arm(joints, 5.0, Vector3::UnitZ());
  for (int j = 0; j < joints; ++j) out.joints[static_cast<std::size_t>(j)].X_PJ.p.z() = 0.1 * j;
  return out;
}

TEST(MechanismPath, BoundIsACirclesForOneJoint) {
  const Mechanism mechanism(planar_arm(3));
  MechanismPath path(mechanism);
  for (const double turn : {0.01, 1.0, 2 * std::numbers::pi}) {
    path.set({}, std::vector{0.3, 0.5, -0.4}, std::vector{0.3 + turn, 0.5, -0.4});
    const BodyState state = path.at(3, 0);
    const Vector3 p_W = transform(state.X_WO, Vector3(2, 0.3, 0.7));
    const double circle = turn * turn * std::hypot(p_W.x(), p_W.y());
    const Vector3 diagonal = Vector3(0.6, 0, 0.8);
    EXPECT_LE(path.curvature_bound(3, state, p_W, Vector3::UnitX()), circle * (1 + 1e-8));
    EXPECT_LE(path.curvature_bound(3, state, p_W, diagonal), 0.6 * circle * (1 + 1e-8));
    EXPECT_LE(path.curvature_bound(3, state, p_W, Vector3::UnitZ()), 1e-11 * turn * turn);
  }
}

TEST(MechanismPath, BoundVanishesAlongTheCommonAxis) {
  const Mechanism mechanism(planar_arm(7));
  MechanismPath path(mechanism);
  Draw draw(3);
  std::vector<double> q0(7), q1(7);
  for (double& q : q0) q = draw.real(-2, 2);
  for (int i = 0; i < 7; ++i) q1[i] = q0[i] + draw.real(-1, 1);
  const Pose X_WB = draw.pose(3);
  path.set(X_WB, q0, q1);
  const BodyState state = path.at(7, 0.3);
  const Vector3 p_W = transform(state.X_WO, Vector3(5, 0.2, 0.2));
  EXPECT_LE(path.curvature_bound(7, state, p_W, X_WB.R.col(2)), 1e-10);
  EXPECT_GE(path.curvature_bound(7, state, p_W, X_WB.R.col(0)), 1e-2);
}

TEST(MechanismPath, LinksBeforeTheFirstMovingJointStandStill) {
  const Mechanism mechanism(planar_arm(3));
  MechanismPath path(mechanism);
  path.set({}, std::vector{0.3, 0.5, -0.4}, std::vector{0.3, 0.5, 0.4});
  EXPECT_FALSE(path.moves(2));
  EXPECT_TRUE(path.moves(3));
  EXPECT_EQ(path.bulge(2, {5, 0, 0}), 0.0);
  EXPECT_EQ(path.at(2, 0.5).angular_velocity_W, Vector3::Zero());
  EXPECT_EQ(path.at(3, 0.5).angular_velocity_W.z(), 0.8);
}

TEST(MechanismPath, SettingAndFollowingAllocateNothing) {
  const Mechanism mechanism(planar_arm(7));
  MechanismPath path(mechanism);
  const std::vector<double> q0(7, 0.1), q1(7, 0.2);
  std::vector<Pose> poses(8);
  const std::size_t before = allocation_count();
  path.set({}, q0, q1);
  const BodyState state = path.at(7, 0.4);
  const double bound =
      path.curvature_bound(7, state, state.X_WO.p, Vector3::UnitX()) + path.bulge(7, {1, 0, 0});
  mechanism.link_poses({}, q0, poses);
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(bound, 0);
}

}  // namespace
}  // namespace touchstone

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"
#include "touchstone/contact_core/mechanism/mechanism_path.hpp"
#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/mechanism/random_chain.hpp"
#include "touchstone/tests/motion/stop_in_gap.hpp"
#include "touchstone/tests/support/at.hpp"
#include "touchstone/tests/support/degree.hpp"

// Links of an arm against a box, at rest or moving: find_impact() on MechanismPath.

namespace touchstone {
namespace {

struct Against {
  std::array<Hexahedron, 2> solids;
  Pose X_OS;
  RigidPath obstacle;
  std::unique_ptr<Narrowphase> native = make_native();

  Against(const Vector3& size, const Pose& in_link, const Vector3& obstacle_size, const Pose& X_WO)
      : solids{Hexahedron::from_size(size), Hexahedron::from_size(obstacle_size)},
        X_OS(in_link),
        obstacle(X_WO) {
    native->build(solids);
  }

  Impact find(const MechanismPath& path, std::uint32_t link) {
    NarrowphaseQuery query(*native, 2);
    return find_impact({&solids[0], X_OS, &path, link}, {&solids[1], {}, &obstacle}, {kGap}, query);
  }
  double separation(const MechanismPath& path, std::uint32_t link, double s) {
    NarrowphaseQuery query(*native, 2);
    PairGeometry out{};
    const Pose X_WS = compose(path.at(link, s).X_WO, X_OS);
    const PairStatus status = query.separation(X_WS, obstacle.pose_at(s), out);
    EXPECT_TRUE(status == PairStatus::separated || status == PairStatus::overlapping);
    return out.separation;
  }
};

// Scene 4: a boom of half-width 0.175 and length 7.11 m lowers at 4 deg/s about a pivot 1.3589 m above the
// Lab's crown, to 12 deg: contact where 7.11 sin a + 0.175 cos a = 1.3589.
TEST(MechanismImpact, BoomMeetsTheCrown) {
  const Mechanism arm(test::straight_arm(1, 0, Vector3::UnitY()));
  Against lab({7.11, 0.35, 0.35}, at(3.555, 0, 0), {8.5, 4.3, 1}, at(4.25, 0, -0.5));
  MechanismPath path(arm);
  path.set(at(0, 0, 1.3589), std::vector{0.0}, std::vector{12 * kDegree});
  const Impact impact = lab.find(path, 1);
  expect_stop_in_gap(impact);
  const double closed_form = std::asin(1.3589 / std::hypot(7.11, 0.175)) - std::atan2(0.175, 7.11);
  EXPECT_NEAR(closed_form / kDegree, 9.605129, 5e-7);
  const double closing = 4 * kDegree * 6.98;
  EXPECT_NEAR(3 * impact.lo, closed_form / (4 * kDegree), 2 * kGap / closing + 1e-12);
  EXPECT_NEAR(impact.geometry.p_B_W.x(), 6.981126, 2e-6);
  EXPECT_LE(impact.queries, 6);
}

// Scene 5 b: a 50 mm bar at the end of a straight arm of seven joints turns at 4 deg/s towards a parallel
// face 5 mm ahead.
TEST(MechanismImpact, BarOnAStraightArmDoesNotTunnel) {
  const Mechanism arm(test::straight_arm(7, 2, Vector3::UnitZ()));
  Against wall({0.05, 0.05, 0.05}, at(16.9378 - 12, -0.025, 0), {1, 0.05, 1}, at(16.9378, 0.005 + 0.025, 0));
  MechanismPath path(arm);
  const std::vector<double> from(7, 0.0);
  std::vector<double> to = from;
  to[0] = 4 * kDegree * 0.1;
  path.set({}, from, to);
  EXPECT_GT(wall.separation(path, 7, 0), 4e-3);
  const Impact impact = wall.find(path, 7);
  expect_stop_in_gap(impact);
  const double closed_form = std::asin(0.005 / 16.9628) / (4 * kDegree);
  EXPECT_NEAR(0.1 * impact.lo, closed_form, 2 * kGap / (4 * kDegree * 16.9) + 1e-12);
}

// The elbow undoes the shoulder's turn: the bar is carried round a circle without turning, and meets the face
// where 2 sin(a) = 5 mm.
TEST(MechanismImpact, BarCarriedWithoutTurning) {
  const Mechanism arm(test::straight_arm(2, 2, Vector3::UnitZ()));
  Against wall({0.05, 0.05, 0.05}, at(3, -0.025, 0), {1, 0.05, 1}, at(5, 0.005 + 0.025, 0));
  MechanismPath path(arm);
  path.set({}, std::vector{0.0, 0.0}, std::vector{0.1, -0.1});
  const Impact impact = wall.find(path, 2);
  expect_stop_in_gap(impact);
  EXPECT_NEAR(impact.lo * 0.1, std::asin(0.0025), 2 * kGap / 2 + 1e-12);
}

// Seven joints turn by up to a right angle each, parallel to a face at twice the gap.
TEST(MechanismImpact, SweepingParallelToAFaceTakesFewQueries) {
  const Mechanism arm(test::straight_arm(7, 1, Vector3::UnitZ()));
  Against slab({1, 0.2, 0.2}, at(0.5, 0, 0), {40, 40, 1}, at(0, 0, -0.1 - 2 * kGap - 0.5));
  test::Draw draw(9);
  int worst = 0;
  for (int i = 0; i < 100; ++i) {
    std::vector<double> from(7), to(7);
    for (int j = 0; j < 7; ++j) from[j] = draw.real(-3, 3), to[j] = from[j] + draw.real(-1.5, 1.5);
    MechanismPath path(arm);
    path.set({}, from, to);
    const Impact impact = slab.find(path, 7);
    EXPECT_EQ(impact.status, ImpactStatus::clear);
    worst = std::max(worst, impact.queries);
  }
  std::printf("parallel at twice the gap: worst %d queries\n", worst);
  EXPECT_LE(worst, 16);
}

/// A path of a random arm, its joint values changed by up to `step`.
MechanismPath draw_path(const Mechanism& arm, double step, test::Draw& draw) {
  std::vector<double> from(arm.value_count()), to(arm.value_count());
  for (std::size_t i = 0; i < from.size(); ++i)
    from[i] = draw.real(-2, 2), to[i] = from[i] + draw.real(-step, step);
  MechanismPath path(arm);
  path.set(draw.pose(2), from, to);
  return path;
}

// Paths that are called clear are: random arms in space, and boxes near them.
TEST(MechanismImpact, ExecutedPathsKeepHalfTheGap) {
  for (const double step : {0.02, 0.5, 3.0}) {
    test::Draw draw(static_cast<std::uint64_t>(100 * step) + 17);
    int blocked = 0, limits = 0, pairs = 0, queries = 0, worst_queries = 0;
    while (pairs < 1500) {
      const Mechanism arm(draw.mechanism());
      const auto link = static_cast<std::uint32_t>(arm.joints().size());
      const MechanismPath path = draw_path(arm, step, draw);
      if (!path.moves(link)) continue;
      Pose X_WO = draw.pose(1);
      // Somewhere near the link's way.
      X_WO.p += path.at(link, draw.real(0, 1)).X_WO.p + draw.vector(step);
      Against box({draw.real(0.1, 2), draw.real(0.1, 2), draw.real(0.1, 2)}, draw.pose(0.5),
                  {draw.real(0.1, 2), draw.real(0.1, 2), draw.real(0.1, 2)}, X_WO);
      const double start = box.separation(path, link, 0);
      if (start <= kGap || start > 5 * step) continue;
      ++pairs;
      const Impact impact = box.find(path, link);
      blocked += impact.status == ImpactStatus::blocked;
      if (impact.status == ImpactStatus::blocked) {
        EXPECT_LE(impact.geometry.separation, kGap);
      }
      limits += impact.status == ImpactStatus::iteration_limit;
      queries += impact.queries;
      worst_queries = std::max(worst_queries, impact.queries);
      for (int k = 0; k <= 20; ++k)
        ASSERT_GE(box.separation(path, link, impact.lo * k / 20), 0.5 * kGap) << "pair " << pairs;
    }
    std::printf("step %4.2f rad: %d of %d blocked, %d iteration limits, queries mean %.1f worst %d\n", step,
                blocked, pairs, limits, static_cast<double>(queries) / pairs, worst_queries);
    EXPECT_GT(blocked, 100);
    EXPECT_EQ(limits, 0);
  }
}

// A bar that an arm carries round a circle presses a corner on a plate, which gives way by as much and turns
// about that corner: they part by a gap, and a plane fixed in the world is left at once.
TEST(MechanismImpact, APlateThatTurnsAsAnArmPushesItIsFollowed) {
  constexpr double kTilt = 2e-3, kPush = 2e-5, kTurn = 6e-5;
  const Mechanism arm(test::straight_arm(2, 2, Vector3::UnitZ()));
  Against plate({0.05, 0.05, 0.05}, at(3, -0.025, 0), {1, 0.05, 1}, {});
  // The bar's corner is at (4.975, 0), before the middle of the plate's face.
  const Matrix3 R_WO = rotation_about(Vector3::UnitZ(), kTilt);
  const Vector3 middle_O(0, -0.025, 0);
  MechanismPath path(arm);
  path.set({}, std::vector{0.0, 0.0}, std::vector{0.5 * kPush, -0.5 * kPush});
  for (const double opens : {1.0, -1.0}) {
    const Pose X_WO = at(Vector3(4.975, 0.75 * kGap, 0) - rotate(R_WO, middle_O), R_WO);
    plate.obstacle = RigidPath::by(X_WO, {0, kPush + opens * kGap, 0}, {0, 0, -kTurn}, middle_O);
    EXPECT_NEAR(plate.separation(path, 2, 0), 0.75 * kGap, 1e-14);
    const Impact impact = plate.find(path, 2);
    EXPECT_LE(impact.queries, 8);
    if (opens > 0.0)
      EXPECT_EQ(impact.status, ImpactStatus::clear);
    else
      expect_stop_in_gap(impact);
  }
}

// Paths that are called clear are, of links in contact with boxes that go along with them and turn.
TEST(MechanismImpact, ExecutedPathsOnTurningBoxesKeepWhatTheyHad) {
  for (const double step : {1e-4, 1e-2, 0.5}) {
    test::Draw draw(static_cast<std::uint64_t>(1e5 * step) + 29);
    int clear = 0, pairs = 0;
    while (pairs < 1500) {
      const Mechanism arm(draw.mechanism());
      const auto link = static_cast<std::uint32_t>(arm.joints().size());
      const MechanismPath path = draw_path(arm, step, draw);
      if (!path.moves(link)) continue;
      Against box({draw.real(0.1, 2), draw.real(0.1, 2), draw.real(0.1, 2)}, draw.pose(0.5),
                  {draw.real(0.5, 2), draw.real(0.5, 2), draw.real(0.5, 2)}, {});
      // The box's upper face is under the link's lowest vertex along n.
      Pose X_WO = draw.pose(1);
      const Vector3 n = X_WO.R.col(2);
      const Pose X_WS = compose(path.at(link, 0).X_WO, box.X_OS);
      Vector3 lowest_S = box.solids[0].vertices()[0];
      for (const Vector3& v : box.solids[0].vertices())
        if (dot(n, rotate(X_WS.R, v)) < dot(n, rotate(X_WS.R, lowest_S))) lowest_S = v;
      const Vector3 top_O = {draw.real(-0.2, 0.2), draw.real(-0.2, 0.2),
                             box.solids[1].vertices()[0].cwiseAbs().z()};
      const Vector3 p = transform(X_WS, lowest_S);
      X_WO.p = p - draw.real(0.5, 1.0) * kGap * n - rotate(X_WO.R, top_O);
      // It goes as far as the vertex does and turns there, and some gaps more or less.
      const Vector3 gone = transform(compose(path.at(link, 1).X_WO, box.X_OS), lowest_S) - p;
      box.obstacle = RigidPath::by(X_WO, gone - draw.real(-2, 20) * std::max(kGap, step * step) * n,
                                   draw.vector(step), top_O);
      const double start = box.separation(path, link, 0);
      if (!(start > 0.25 * kGap)) continue;
      ++pairs;
      const Impact impact = box.find(path, link);
      clear += impact.status == ImpactStatus::clear;
      for (int k = 0; k <= 20; ++k)
        ASSERT_GE(box.separation(path, link, impact.lo * k / 20), std::min(start, 0.5 * kGap) - 1e-13)
            << "pair " << pairs << " at " << impact.lo * k / 20;
    }
    std::printf("step %6.4f rad: %d of %d clear\n", step, clear, pairs);
    EXPECT_GT(clear, 300);
  }
}

// One frame of the arm at its joints' rates at 10 Hz, every hexahedron of the end effector against a box.
TEST(MechanismImpact, SsrmsLowersItsEndEffectorOntoABox) {
  const Mechanism arm(make_ssrms());
  MechanismPath path(arm);
  const std::vector<double> from = {0, 0, -30 * kDegree, 60 * kDegree, -30 * kDegree, 0, 0};
  std::vector<double> to = from;
  for (const int pitch : {2, 3, 4}) to[pitch] += 0.4 * kDegree;
  path.set({}, from, to);
  const std::uint32_t link = arm.find_link("tip_lee");
  const Mechanism::Link& lee = arm.links()[link];
  // A face 5 mm below the mouth's lowest corner.
  double lowest = 1e9;
  Vector3 corner;
  for (std::uint32_t i = 0; i < lee.solid_count; ++i) {
    const PlacedHexahedron& part = arm.placed(lee.first_solid + i);
    for (const Vector3& v : part.solid.vertices()) {
      const Vector3 p = transform(compose(path.at(link, 0).X_WO, part.X_OS), v);
      if (p.z() < lowest) lowest = p.z(), corner = p;
    }
  }
  double lo = 1;
  for (std::uint32_t i = 0; i < lee.solid_count; ++i) {
    const PlacedHexahedron& part = arm.placed(lee.first_solid + i);
    Against floor({1, 1, 1}, part.X_OS, {4, 4, 1}, at(corner.x(), corner.y(), lowest - 0.005 - 0.5));
    floor.solids[0] = part.solid;
    floor.native->build(floor.solids);
    const Impact impact = floor.find(path, link);
    lo = std::min(lo, impact.lo);
    for (int k = 0; k <= 50; ++k) EXPECT_GE(floor.separation(path, link, impact.lo * k / 50), 0.5 * kGap);
  }
  EXPECT_GT(lo, 0.01);
  EXPECT_LT(lo, 0.99);
}

}  // namespace
}  // namespace touchstone

#include "touchstone/contact_core/motion/impact.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/motion/clear_stretch.hpp"
#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/scene/motion.hpp"
#include "touchstone/tests/motion/stop_in_gap.hpp"
#include "touchstone/tests/support/at.hpp"
#include "touchstone/tests/support/degree.hpp"

namespace touchstone {
namespace {

struct Pair {
  std::array<Hexahedron, 2> solids;
  std::unique_ptr<Narrowphase> native = make_native();

  Pair(const Vector3& size_a, const Vector3& size_b)
      : solids{Hexahedron::from_size(size_a), Hexahedron::from_size(size_b)} {
    native->build(solids);
  }

  Impact find(const MotionPath& a, const MotionPath& b, double gap = kGap, double stop_a = 1,
              double stop_b = 1) {
    NarrowphaseQuery query(*native, 2);
    return find_impact({&solids[0], {}, &a, 0, stop_a}, {&solids[1], {}, &b, 0, stop_b}, {gap}, query);
  }
};

// Scene 5 a: two 10 mm plates, 5 mm apart, closing at 0.37 m/s at 10 Hz: contact after 0.005 / 0.37 s.
TEST(Impact, ThinPlatesDoNotTunnel) {
  Pair pair({1, 1, 0.01}, {1, 1, 0.01});
  const Impact impact =
      pair.find(RigidPath(at(0, 0, 0)), RigidPath::by(at(0, 0, 0.015), {0, 0, -0.037}, {0, 0, 0}));
  expect_stop_in_gap(impact);
  EXPECT_NEAR(0.1 * impact.lo, 0.005 / 0.37, 2 * kGap / 0.37 + 1e-12);
  EXPECT_LE(impact.queries, 3);
}

// Scene 5 b: a bar on a straight arm turns at 4 deg/s towards a parallel face 5 mm ahead; its outer edge
// meets it at asin(0.005 / 16.9628) / (4 deg/s).
TEST(Impact, TurningBarMeetsFaceAtItsOuterEdge) {
  Pair pair({0.05, 0.05, 0.05}, {1, 0.05, 1});
  Pose bar = at(16.9378, -0.025, 0);
  // The body's origin is the shoulder: the bar is placed in it.
  const RigidPath arm = RigidPath::by(Pose{}, {0, 0, 0}, {0, 0, 4 * kDegree * 0.1});
  const RigidPath wall(at(16.9378, 0.005 + 0.025, 0));
  NarrowphaseQuery query(*pair.native, 2);
  const Impact impact =
      find_impact({&pair.solids[0], bar, &arm}, {&pair.solids[1], {}, &wall}, {kGap}, query);
  expect_stop_in_gap(impact);
  const double closed_form = std::asin(0.005 / 16.9628) / (4 * kDegree);
  EXPECT_NEAR(closed_form, 4.222164e-3, 1e-9);
  EXPECT_NEAR(0.1 * impact.lo, closed_form, 2 * kGap / (4 * kDegree * 16.9) + 1e-12);
}

// Scene 6: 1.050 x 0.919 m turning in a 1.2 m gate meets a wall at 18.121 deg, though it is clear again past
// 79.491 deg.
TEST(Impact, JumpOverABlockedStretchIsCaught) {
  Pair pair({1.050, 0.919, 0.5}, {4, 0.1, 1});
  const RigidPath turn =
      RigidPath::between(Pose{}, RigidPath::by(Pose{}, {0, 0, 0}, {0, 0, 90 * kDegree}).to());
  const Impact impact = pair.find(turn, RigidPath(at(0, 0.65, 0)));
  expect_stop_in_gap(impact);
  const double half = std::hypot(1.050, 0.919) / 2;
  const double closed_form = std::asin(0.6 / half) - std::atan2(0.919, 1.050);
  EXPECT_NEAR(closed_form / kDegree, 18.121, 5e-4);
  EXPECT_NEAR(impact.lo * 90 * kDegree, closed_form, 1e-8);
}

TEST(Impact, SlidingAlongAFaceAtTwiceTheGapTakesFewQueries) {
  Pair pair({1, 1, 1}, {4, 4, 1});
  const Impact impact =
      pair.find(RigidPath::by(at(-1, 0, 1 + 2 * kGap), {1, 0.3, 0}, {0, 0, 0}), RigidPath(at(0, 0, 0)));
  EXPECT_EQ(impact.status, ImpactStatus::clear);
  EXPECT_LE(impact.queries, 2);
}

// A cube at less than the gap above a row of abutting cubes: the next one's corner must not stop it.
TEST(Impact, SeamsDoNotStopAMotionAlongThem) {
  for (const double height : {0.5, 0.6, 0.75, 0.9, 1.0, 1.5}) {
    Pair pair({1, 1, 1}, {1, 1, 1});
    const RigidPath path = RigidPath::by(at(-1.2, 0, 1 + height * kGap), {2.4, 0.1, 0}, {0, 0, 0});
    const Impact impact = pair.find(path, RigidPath());
    EXPECT_EQ(impact.status, ImpactStatus::clear) << "height " << height;
    EXPECT_LE(impact.queries, 16);
  }
}

// Each look may round; a path that sinks by 64 roundings is not let through one by one.
TEST(Impact, ManyLooksAtAContactDoNotSinkBelowHalfTheGap) {
  Pair pair({1, 1, 1}, {40, 40, 1});
  const double rounding = 32 * kUnitRoundoff * 60;
  for (const double height : {0.5001, 0.502, 0.51}) {
    const double sinks = (height - 0.5) * kGap + 64 * rounding;
    const Impact impact =
        pair.find(RigidPath::by(at(0, 0, 1 + height * kGap), {0.1, 0, -sinks}, {0, 0, 0}), RigidPath());
    EXPECT_EQ(impact.status, ImpactStatus::blocked) << height;
    EXPECT_GE(impact.geometry.separation, 0.5 * kGap - rounding) << height;
    EXPECT_LE(impact.geometry.separation, 0.5 * kGap + rounding) << height;
  }
}

TEST(Impact, SpinningOnAFaceIsFree) {
  Pair pair({1, 1, 1}, {4, 4, 1});
  const Impact impact = pair.find(RigidPath::by(at(0, 0, 1 + 0.6 * kGap), {0, 0, 0}, {0, 0, 360 * kDegree}),
                                  RigidPath(at(0, 0, 0)));
  EXPECT_EQ(impact.status, ImpactStatus::clear);
  EXPECT_LE(impact.queries, 16);
}

TEST(Impact, MovingAwayFromContactIsFreeAndIntoItIsNot) {
  Pair pair({1, 1, 1}, {4, 4, 1});
  const Pose start = at(0, 0, 1 + 0.75 * kGap);
  EXPECT_EQ(pair.find(RigidPath::by(start, {0, 0, 0.5}, {0, 0, 0}), RigidPath()).status, ImpactStatus::clear);
  const Impact down = pair.find(RigidPath::by(start, {0, 0, -0.5}, {0, 0, 0}), RigidPath());
  expect_stop_in_gap(down);
  EXPECT_LT(down.lo, 1e-9);
}

TEST(Impact, PressedAtTheThresholdStillSlides) {
  Pair pair({1, 1, 1}, {40, 40, 1});
  Pose X = at(0, 0, 1 + 0.75 * kGap);
  for (int frame = 0; frame < 1000; ++frame) {
    const RigidPath down = RigidPath::by(X, {0, 0, -0.01}, {0, 0, 0});
    const Impact pressed = pair.find(down, RigidPath());
    X = down.pose_at(pressed.lo);
    const RigidPath along = RigidPath::by(X, {0.01, 0.002, 0}, {0, 0, 0.001});
    const Impact slid = pair.find(along, RigidPath());
    ASSERT_EQ(slid.status, ImpactStatus::clear) << "frame " << frame;
    X = along.pose_at(slid.lo);
    ASSERT_GE(slid.geometry.separation, 0.25 * kGap);
  }
  EXPECT_GE(pair.find(RigidPath(X), RigidPath()).geometry.separation, 0.5 * kGap - 1e-13);
}

TEST(Impact, OverlappingStartMayComeOutButNotGoDeeper) {
  Pair pair({1, 1, 1}, {4, 4, 1});
  const Pose start = at(0, 0, 0.9);
  EXPECT_EQ(pair.find(RigidPath::by(start, {0, 0, 0.5}, {0, 0, 0}), RigidPath()).status, ImpactStatus::clear);
  const Impact along = pair.find(RigidPath::by(start, {0.5, 0, 0}, {0, 0, 0}), RigidPath());
  EXPECT_EQ(along.status, ImpactStatus::clear);
  const Impact deeper = pair.find(RigidPath::by(start, {0, 0, -0.05}, {0, 0, 0}), RigidPath());
  EXPECT_EQ(deeper.status, ImpactStatus::blocked);
  EXPECT_LT(deeper.lo, 1e-9);
}

TEST(Impact, StoppedMoverIsAnObstacleToTheOther) {
  Pair pair({1, 1, 1}, {1, 1, 1});
  // A flees from B at the same speed, but stops half-way.
  const RigidPath a = RigidPath::by(at(0, 0, 0), {4, 0, 0}, {0, 0, 0});
  const RigidPath b = RigidPath::by(at(-2, 0, 0), {4, 0, 0}, {0, 0, 0});
  EXPECT_EQ(pair.find(a, b).status, ImpactStatus::clear);
  const Impact impact = pair.find(a, b, kGap, 0.5);
  expect_stop_in_gap(impact);
  EXPECT_NEAR(impact.lo, 0.75, 1e-9);
}

TEST(Impact, FullTurnOfANeedleIsCaught) {
  Pair pair({2, 0.001, 0.001}, {0.01, 0.01, 1});
  const Impact impact =
      pair.find(RigidPath::by(Pose{}, {0, 0, 0}, {0, 0, 360 * kDegree}), RigidPath(at(0, 0.9, 0)));
  expect_stop_in_gap(impact);
  EXPECT_LT(impact.lo, 0.25);
  EXPECT_LE(impact.queries, 40);
}

// A bar tips over the edge of a post, its face on the edge: the plane of contact is the bar's own and turns
// with it; no plane fixed in the world holds for more than 1e-7 rad.
TEST(Impact, TippingOverAnEdgeIsFollowed) {
  Pair pair({2, 0.2, 0.1}, {0.2, 3, 1});
  const double turn = 1e-3, above = 0.75 * kGap;
  // About the post's edge, and up by the bend: 1 - cos, times the distance of the axis from the face.
  const RigidPath tip =
      RigidPath::by(at(0.1, 0, 0.5 + 0.05 + above), {0, 0, 0.06 * turn * turn}, {0, turn, 0});
  const Impact impact = pair.find(tip, RigidPath());
  EXPECT_EQ(impact.status, ImpactStatus::clear);
  EXPECT_LE(impact.queries, 8);
}

/// Answers as it is told, and notes where it was asked.
struct ToldOverlap final : OverlapAhead {
  explicit ToldOverlap(bool overlap) : answer(overlap) {}
  bool overlaps_at(double s) noexcept override {
    asked_at = s;
    return answer;
  }

  bool answer;
  double asked_at = -1.0;
};

// As above: the plane of the closest points clears next to nothing, another one all.
TEST(Impact, PlanesAreNotTriedWhereAnOverlapIsAhead) {
  Pair pair({2, 0.2, 0.1}, {0.2, 3, 1});
  const double turn = 1e-3;
  const RigidPath tip =
      RigidPath::by(at(0.1, 0, 0.55 + 0.75 * kGap), {0, 0, 0.06 * turn * turn}, {0, turn, 0});
  const RigidPath rest;
  const MovingSolid a{&pair.solids[0], {}, &tip}, b{&pair.solids[1], {}, &rest, 0, 0.0};
  NarrowphaseQuery query(*pair.native, 2);
  PairGeometry geometry{};
  query.separation(a.pose_at(0), b.pose_at(0), geometry);
  for (const bool overlap : {false, true}) {
    ToldOverlap ahead(overlap);
    const PathStep step =
        next_step(place(a, 0), place(b, 0), geometry, {kGap}, 0.5 * kGap, kInfinity, 1, &ahead);
    EXPECT_EQ(ahead.asked_at, kStalled);
    EXPECT_EQ(step.at_end, !overlap);
    EXPECT_EQ(step.is_stalled, overlap);
  }
}

// Two crossed edges, one above the other and turning along it: their plane turns with both.
TEST(Impact, EdgeTurningOnAnEdgeIsFollowed) {
  Pair pair({1, 0.2, 0.2}, {0.2, 1, 0.2});
  const double turn = 1e-3, height = 0.1 * std::sqrt(2.0), above = 0.75 * kGap;
  Pose upper = at(0, 0, 2 * height + above), lower;
  upper.R = rotation_about(Vector3::UnitX(), 45 * kDegree);
  lower.R = rotation_about(Vector3::UnitY(), 45 * kDegree);
  const RigidPath turning = RigidPath::by(upper, {0, 0, height * turn * turn}, {0, turn, 0});
  const Impact impact = pair.find(turning, RigidPath(lower));
  EXPECT_EQ(impact.status, ImpactStatus::clear);
  EXPECT_LE(impact.queries, 8);
}

/// Seeded, and the same with every standard library.
struct Draw {
  explicit Draw(std::uint64_t seed) : engine(seed) {}

  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine() >> 11) * 0x1p-53);
  }
  Vector3 vector(double size) {
    const double x = uniform(-size, size), y = uniform(-size, size);
    return {x, y, uniform(-size, size)};
  }

  std::mt19937_64 engine;
};

/// 65 samples of the way to `end`.
void expect_half_the_gap_on_the_way(NarrowphaseQuery& query, const RigidPath& a, const RigidPath& b,
                                    double end) {
  for (int k = 0; k <= 64; ++k) {
    PairGeometry geometry{};
    query.separation(a.pose_at(end * k / 64), b.pose_at(end * k / 64), geometry);
    ASSERT_GE(geometry.separation, 0.5 * kGap - 32 * 0x1p-53 * 5) << "sample " << k;
  }
}

// Whatever plane was used: nothing on the way is below half the gap. Two boxes that start close, edge over
// edge or face over face, one or both sliding and turning.
TEST(Impact, NothingOnTheWayIsBelowHalfTheGap) {
  Draw draw(17);
  int moved = 0;
  for (int run = 0; run < 1500; ++run) {
    Pair pair({draw.uniform(0.2, 1), draw.uniform(0.2, 1), draw.uniform(0.02, 1)},
              {draw.uniform(0.2, 1), draw.uniform(0.2, 1), draw.uniform(0.02, 1)});
    NarrowphaseQuery query(*pair.native, 2);
    const Pose X_WB;
    Vector3 towards = draw.vector(1);
    if (run % 3 == 0) towards = Vector3(0.1, 0.1, 1);
    const Pose far = RigidPath::by(Pose{}, 3.0 * towards / norm(towards),
                                   run % 3 == 0 ? Vector3(0, 0, draw.uniform(0, 3)) : draw.vector(2))
                         .to();
    // Up to contact first.
    const RigidPath approach = RigidPath::by(far, -2 * far.p, {0, 0, 0});
    const RigidPath rest(X_WB);
    const Impact first = pair.find(approach, rest);
    if (first.status != ImpactStatus::blocked) continue;
    // Along the contact to first order, then a bit away: what bends decides.
    const double size = std::pow(10.0, draw.uniform(-7, -1));
    const Pose X_WA = approach.pose_at(first.lo);
    const Vector3 turn_a = draw.vector(size), turn_b = run % 2 ? draw.vector(size) : Vector3(0, 0, 0);
    const Vector3 v_b = run % 2 ? draw.vector(size) : Vector3(0, 0, 0), v_a = draw.vector(size);
    const Vector3& n = first.geometry.n_AB_W;
    const Vector3 meeting = (v_a + cross(turn_a, first.geometry.p_A_W - X_WA.p)) -
                            (v_b + cross(turn_b, first.geometry.p_A_W - X_WB.p));
    const double away = draw.uniform(0, 0.5) * size * size;
    const RigidPath a = RigidPath::by(X_WA, v_a - (dot(n, meeting) + away) * n, turn_a);
    const RigidPath b = RigidPath::by(X_WB, v_b, turn_b);
    const Impact impact = pair.find(a, b);
    ASSERT_NE(impact.status, ImpactStatus::failed);
    moved += impact.lo > 0.01;
    SCOPED_TRACE("run " + std::to_string(run));
    expect_half_the_gap_on_the_way(query, a, b, impact.lo);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(moved, 300);
}

/// By rows.
Pose exact_pose(const std::array<double, 9>& rows, const Vector3& p) {
  Pose X;
  for (int i = 0; i < 9; ++i) X.R(i / 3, i % 3) = rows[i];
  X.p = p;
  return X;
}

// Two edges in contact whose plane turns away from the motion while the bodies close at half a metre a frame:
// the bound on their height curves upwards, below 0 and back.
TEST(Impact, EdgesThatTurnApartWhileTheBodiesCloseAreCaught) {
  // Two tapered blocks of a random run in which the contact was missed.
  const auto tapered = [](const Vector3& half, double top_x, double top_y) {
    std::array<Vector3, 8> v;
    for (int i = 0; i < 8; ++i) {
      const bool top = (i & 1) != 0;
      v[i] = {(i & 4 ? 1 : -1) * (top ? top_x : half.x()), (i & 2 ? 1 : -1) * (top ? top_y : half.y()),
              (top ? 1 : -1) * half.z()};
    }
    return Hexahedron::from_vertices(v);
  };
  Pair pair({1, 1, 1}, {1, 1, 1});
  pair.solids = {tapered({0x1.40543988c4106p-1, 0x1.a7f2368937d3ep-2, 0x1.de0e43a6df144p-3},
                         0x1.40543988c4106p-1, 0x1.737ef128c5ad8p-3),
                 tapered({0x1.5cfcdf569e6acp-1, 0x1.ed6becafeae98p-2, 0x1.180a5b60eae7cp-2},
                         0x1.ea3997c621ccp-2, 0x1.ed6becafeae98p-2)};
  pair.native->build(pair.solids);
  const Pose X_WA = exact_pose({0x1.fd49f0b6d1475p-1, 0x1.f774a3bc3d342p-7, 0x1.a03b3115079fcp-4,
                                -0x1.daaa98187119cp-8, 0x1.fe5a6de2ba87bp-1, -0x1.46e84b5277b74p-4,
                                -0x1.a3ea485d2de86p-4, 0x1.422961ba5c5bep-4, 0x1.fbb5300906782p-1},
                               {0x1.509adfbd8f7fap+0, 0x1.8529b9eea5721p+0, -0x1.8a485db6f070fp-9});
  // They stop before it.
  const RigidPath closing =
      RigidPath::by(X_WA, {0x1.098f275c1d592p-1, 0x1.30a7f42360cbap-3, -0x1.10f0206417a77p-4},
                    {-0x1.1344cb3d7a3cdp-2, 0x1.6b5dcb30743ccp-4, 0x1.56f333deacf0bp-4});
  const Impact impact = pair.find(closing, RigidPath(at(0x1.4ccccccccccccp+1, 0x1.67d52bfb205d8p+0, 0)));
  expect_stop_in_gap(impact);
  EXPECT_LT(impact.lo, 1e-6);
}

// From a contact in any direction and turning fast, into it, along it and away: no sample on the way is below
// half the gap.
TEST(Impact, NothingOnTheWayFromAContactInAnyDirectionIsBelowHalfTheGap) {
  Draw draw(18);
  int contacts = 0;
  for (int run = 0; run < 3000; ++run) {
    // Two boxes that fly towards each other until they meet.
    Pair pair({draw.uniform(0.2, 1), draw.uniform(0.2, 1), draw.uniform(0.2, 1)},
              {draw.uniform(0.2, 1), draw.uniform(0.2, 1), draw.uniform(0.2, 1)});
    NarrowphaseQuery query(*pair.native, 2);
    const Vector3 towards = draw.vector(1);
    const Pose far = RigidPath::by(Pose{}, 3.0 * towards / norm(towards), draw.vector(2)).to();
    const RigidPath approach = RigidPath::by(far, -2 * far.p, {0, 0, 0});
    const Impact first = pair.find(approach, RigidPath(Pose{}));
    if (first.status != ImpactStatus::blocked) continue;
    ++contacts;
    // From there they move on anyhow: nothing on that way is deeper than half the gap.
    const double size = std::pow(10.0, draw.uniform(-3, 0.3));
    const Vector3 v_a = draw.vector(size), turn_a = draw.vector(size);
    const Vector3 v_b = run % 2 ? draw.vector(size) : Vector3(0, 0, 0);
    const Vector3 turn_b = run % 2 ? draw.vector(size) : Vector3(0, 0, 0);
    const RigidPath a = RigidPath::by(approach.pose_at(first.lo), v_a, turn_a);
    const RigidPath b = RigidPath::by(Pose{}, v_b, turn_b);
    const Impact impact = pair.find(a, b);
    ASSERT_NE(impact.status, ImpactStatus::failed);
    SCOPED_TRACE("run " + std::to_string(run));
    expect_half_the_gap_on_the_way(query, a, b, impact.lo);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(contacts, 1000);
}

}  // namespace
}  // namespace touchstone

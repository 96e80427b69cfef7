#include "touchstone/contact_core/motion/slide.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "touchstone/contact_core/motion/slide_rows.hpp"
#include "touchstone/contact_core/scene/motion.hpp"
#include "touchstone/tests/support/random.hpp"

namespace touchstone {
namespace {

TEST(MassMetric, OfABoxIsTheTextbooks) {
  const Vector3 size(0.6, 0.5, 0.4);
  Pose X;
  X.p = {3, -2, 7};
  X.R = rotation_about(Vector3(2, -1, 2) / 3, 0.7);
  const MassMetric metric = mass_metric(transform(X, mass_moments(Hexahedron::from_size(size))));
  EXPECT_LT(norm(metric.centre - X.p), 1e-14);
  Matrix3 J = Matrix3::Zero();
  for (int i = 0; i < 3; ++i) {
    const double u = size[(i + 1) % 3], v = size[(i + 2) % 3];
    J(i, i) = (u * u + v * v) / 12;
  }
  EXPECT_LT((metric.J - turned(X.R, J)).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LE(least_inertia(J), J(2, 2));
  EXPECT_GE(least_inertia(J), 4.0 / 9.0 * std::min({J(0, 0), J(1, 1), J(2, 2)}));
}

TEST(MassMetric, OfAPyramidAndOfTwoHalves) {
  // A square pyramid, base 2, height 3: its centre is a quarter up; about it, by integration,
  // J_z = 2 (a^2 / 20) with a = 2, J_x = a^2 / 20 + 3 h^2 / 80.
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i) {
    const bool top = i & 1;
    v[i] = top ? Vector3(0, 0, 3) : Vector3(i & 4 ? 1 : -1, i & 2 ? 1 : -1, 0);
  }
  const MassMetric pyramid = mass_metric(mass_moments(Hexahedron::from_vertices(v)));
  EXPECT_LT(norm(pyramid.centre - Vector3(0, 0, 0.75)), 1e-15);
  EXPECT_NEAR(pyramid.J(2, 2), 2 * 4.0 / 20, 1e-15);
  EXPECT_NEAR(pyramid.J(0, 0), 4.0 / 20 + 3 * 9.0 / 80, 1e-15);

  Pose left, right;
  left.p = {-0.5, 0, 0}, right.p = {0.5, 0, 0};
  MassMoments halves = transform(left, mass_moments(Hexahedron::from_size({1, 1, 1})));
  halves += transform(right, mass_moments(Hexahedron::from_size({1, 1, 1})));
  const MassMetric whole = mass_metric(mass_moments(Hexahedron::from_size({2, 1, 1})));
  EXPECT_LT((mass_metric(halves).J - whole.J).cwiseAbs().maxCoeff(), 1e-15);
}

struct Contacts {
  Matrix3 J;
  std::vector<SlideRow> rows;
  std::vector<double> lift;
  Twist goal;

  double left(std::size_t i, const Twist& u) const {
    return dot(rows[i].n, u.v + cross(u.w, rows[i].r)) + rows[i].slack;
  }
};

Contacts random_contacts(Random& random, int count) {
  Contacts out;
  const Vector3 size(random.uniform(0.1, 1), random.uniform(0.1, 1), random.uniform(0.001, 1));
  Pose X;
  X.R = rotation_about(Vector3(2, -1, 2) / 3, random.uniform(0, 3));
  out.J = turned(X.R, mass_metric(mass_moments(Hexahedron::from_size(size))).J);
  out.goal = {random.vector(0.01), random.vector(0.02)};
  for (int i = 0; i < count; ++i) {
    SlideRow row;
    row.n = random.vector(1);
    // Faces and seams: many rows share a normal.
    if (i % 3 != 0 && i > 0) row.n = out.rows[i - 1].n;
    row.n /= norm(row.n);
    row.r = random.vector(0.5);
    row.slack = i % 2 ? 0.0 : random.uniform(0, 0.002);
    out.rows.push_back(row);
  }
  out.lift.assign(out.rows.size(), 0.0);
  return out;
}

// The projection fulfils its rows, and what it leaves undone is a sum of active rows with weights >= 0
// (Karush, Kuhn, Tucker): then it is the closest, as the problem is convex. Checked without weights: no
// twist that the rows allow makes an acute angle with what is left undone.
TEST(SlideProjection, IsTheClosestAllowedTwist) {
  Random random(3);
  int held = 0;
  for (int run = 0; run < 3000; ++run) {
    const Contacts contacts = random_contacts(random, 1 + run % 40);
    Twist u;
    ActiveRows active;
    ASSERT_TRUE(project(contacts.goal, contacts.J, contacts.rows, contacts.lift, false, u, active)) << run;
    held += active.count;
    for (std::size_t i = 0; i < contacts.rows.size(); ++i)
      ASSERT_GE(contacts.left(i, u), -1e-12) << run << " row " << i;
    for (int k = 0; k < active.count; ++k)
      EXPECT_NEAR(contacts.left(static_cast<std::size_t>(active.row[k]), u), 0.0, 1e-14);
    const Twist undone{contacts.goal.v - u.v, contacts.goal.w - u.w};
    // 0 is allowed; so are random twists scaled to be.
    EXPECT_GE(inner_product(contacts.J, undone, u), -1e-17);
    for (int k = 0; k < 20; ++k) {
      Twist other{random.vector(0.01) + contacts.goal.v, random.vector(0.02) + contacts.goal.w};
      double scale = 1.0;
      for (const SlideRow& row : contacts.rows) {
        const double rate = dot(row.n, other.v + cross(other.w, row.r));
        if (row.slack + rate < 0.0) scale = std::min(scale, row.slack / -rate);
      }
      other = scale * other;
      const Twist from_u{other.v - u.v, other.w - u.w};
      EXPECT_LE(inner_product(contacts.J, undone, from_u), 1e-16) << run;
    }
  }
  EXPECT_GT(held, 3000);
}

TEST(SlideProjection, TheOrderOfTheRowsDoesNotMatter) {
  Random random(9);
  for (int run = 0; run < 300; ++run) {
    Contacts contacts = random_contacts(random, 30);
    order_rows(contacts.rows);
    Twist first, second;
    ActiveRows active;
    project(contacts.goal, contacts.J, contacts.rows, contacts.lift, false, first, active);
    std::reverse(contacts.rows.begin(), contacts.rows.end());
    order_rows(contacts.rows);
    project(contacts.goal, contacts.J, contacts.rows, contacts.lift, false, second, active);
    EXPECT_TRUE(first.v == second.v && first.w == second.w);
  }
}

TEST(SlideProjection, TranslationOnlyDoesNotTurnAndAWedgeHolds) {
  const Matrix3 J = 0.1 * Matrix3::Identity();
  std::vector<SlideRow> rows(2);
  rows[0].n = {1, 0, 0}, rows[0].r = {-0.5, 0.1, -0.3};
  rows[1].n = Vector3(-1, 0, 0.01) / std::sqrt(1.0001), rows[1].r = {0.5, 0, 0.2};
  const std::vector<double> lift(2, 0.0);
  Twist u;
  ActiveRows active;
  ASSERT_TRUE(project({{0.003, 0.001, -0.01}, {0.1, 0, 0}}, J, rows, lift, true, u, active));
  EXPECT_EQ(u.w, Vector3(0, 0, 0));
  EXPECT_LT(norm(u.v - Vector3(0, 0.001, 0)), 1e-16);
  EXPECT_EQ(active.count, 2);
  // Free to turn it goes deeper.
  ASSERT_TRUE(project({{0, 0, -0.01}, {0, 0, 0}}, J, rows, lift, false, u, active));
  EXPECT_LT(u.v.z(), -0.001);
}

TEST(SlideProjection, ContradictingRowsAreReported) {
  std::vector<SlideRow> rows(2);
  rows[0].n = {0, 0, 1}, rows[0].slack = -1e-10;
  rows[1].n = {0, 0, -1}, rows[1].slack = -1e-10;
  const std::vector<double> lift(2, 0.0);
  Twist u;
  ActiveRows active;
  const Twist goal{{0.1, 0, 0}, {0, 0, 0}};
  EXPECT_FALSE(project(goal, TwistMetric{}, rows, lift, false, u, active));
  // A slide goes on all the same, without the impossible.
  const SlidePlan plan = plan_slide(goal, TwistMetric{}, rows, false);
  EXPECT_NEAR(plan.twist.v.x(), 0.1, 1e-16);
  EXPECT_NEAR(plan.twist.v.z(), 0.0, 1e-16);
}

// Every point of the path stays above its row by what bends, and the distance shrinks to the end.
TEST(SlidePlan, BendsAreLiftedAndTheDistanceShrinks) {
  Random random(21);
  for (int run = 0; run < 1000; ++run) {
    Contacts contacts = random_contacts(random, 1 + run % 8);
    for (SlideRow& row : contacts.rows) row.room = 2.5e-10, row.turns = run % 2;
    const SlidePlan plan = plan_slide(contacts.goal, contacts.J, contacts.rows, false);
    const Twist& u = plan.twist;
    const double square = inner_product(contacts.J, u, u);
    EXPECT_LE(square, inner_product(contacts.J, u, contacts.goal) * (1 + 1e-12) + 1e-30);
    if (square == 0.0) continue;
    for (std::size_t i = 0; i < contacts.rows.size(); ++i) {
      const SlideRow& row = contacts.rows[i];
      EXPECT_GE(contacts.left(i, u) - 0.5 * bend_of(row, u) + row.room, -1e-2 * bend_of(row, u) - 1e-15)
          << run << " row " << i;
    }
  }
}

// A turn t about y with a point 20 m above the centre: to clear its bend the body has to rise by 10 t^2, for
// t = 0.2 by as much as leaves a fifth of the square of the distance to be gained, for half of that 3/8.
TEST(SlidePlan, PlansForHalfWhereThatGainsMore) {
  SlideRow row;
  row.n = {0, 0, 1}, row.r = {0, 0, 20};
  const Twist goal{{0, 0, 0}, {0, 0.2, 0}};
  const SlidePlan plan = plan_slide(goal, TwistMetric{}, {&row, 1}, false);
  const Twist left{goal.v - plan.twist.v, goal.w - plan.twist.w};
  EXPECT_NEAR(inner_product(TwistMetric{}, left, left), 0.04 * 5 / 8, 1e-12);
  EXPECT_FALSE(plan.is_whole);
}

TEST(SlideRows, SeamsTakeThePlaneThatLetsTheMotionThrough) {
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1});
  NearPair pair{};
  pair.mover = pair.obstacle = &cube;
  const double g = 1e-9, ahead = 5e-4, above = 0.75 * g;
  pair.X_WM.p = {-1 - ahead, 0, 1 + above};
  pair.centre_W = pair.X_WM.p;
  pair.gap = g, pair.share = 1.0, pair.reach = 1.0;
  pair.separation = std::sqrt(ahead * ahead + above * above);
  pair.n = Vector3(-ahead, 0, above) / pair.separation;
  pair.point_count = 1;
  pair.points[0] = {{-0.5, 0, 0.5}, {-0.5 - ahead, 0, 0.5 + above}, pair.separation, 0};
  classify(pair);
  EXPECT_FALSE(pair.is_sure);
  EXPECT_TRUE(choose_plane(pair, {{0.01, 0, 0}, {0, 0, 0}}));
  std::vector<SlideRow> rows;
  rows.reserve(16);
  add_rows(pair, 1e-3, rows);
  ASSERT_FALSE(rows.empty());
  for (const SlideRow& row : rows) EXPECT_GT(row.n.z(), 1 - 1e-12);
  // Straight at it, lower down: its side.
  pair.X_WM.p.z() = pair.centre_W.z() = 0.1;
  pair.n = {-1, 0, 0};
  classify(pair);
  choose_plane(pair, {{0.01, 0, 0}, {0, 0, 0}});
  rows.clear();
  add_rows(pair, 1.0, rows);
  ASSERT_FALSE(rows.empty());
  for (const SlideRow& row : rows) EXPECT_LT(row.n.x(), -1 + 1e-12);
}

}  // namespace
}  // namespace touchstone

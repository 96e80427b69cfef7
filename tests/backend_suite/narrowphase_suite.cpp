#include <cmath>
#include <limits>
#include <thread>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/backend_suite/accuracy_table.hpp"
#include "touchstone/tests/backend_suite/suite.hpp"

// Conventions that hold for every narrowphase, on pairs whose answers are derived by hand.

namespace touchstone::suite {
namespace {

class NarrowphaseSuite : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { narrowphase = backends().make_narrowphase(GetParam()); }
  const Capabilities& capabilities() const { return narrowphase->capabilities(); }
  double resolution(const Body& a, const Body& b) const {
    return capabilities().resolution.at(scale_of(a, b));
  }
  double share_of_depth() const {
    for (const AccuracyRow& row : accuracy_table())
      if (row.backend == GetParam() && row.family == kByHand) return row.depth;
    return 0.0;
  }

  std::unique_ptr<Narrowphase> narrowphase;
};

Pose tilted_pose() {
  Pose X;
  X.R = rotation_from_quaternion(0.8, 0.3, -0.4, 0.2);
  X.p = {3.0, -1.0, 2.0};
  return X;
}

struct KnownPair {
  const char* what;
  Body a;
  Body b;
  double separation;
  Vector3 n_AB_W;
};

// Boxes meeting along x, y and z, in both orders, apart and overlapping.
std::vector<KnownPair> known_pairs() {
  std::vector<KnownPair> pairs;
  const Vector3 cube(2.0, 2.0, 2.0);
  const Vector3 brick(1.0, 0.5, 3.0);
  for (int axis = 0; axis < 3; ++axis) {
    for (double sign : {-1.0, 1.0}) {
      for (double separation : {0.5, -0.125}) {
        const Vector3 n = sign * Vector3::Unit(axis);
        const Vector3 p = n * (1.0 + 0.5 * brick(axis) + separation);
        pairs.push_back({"boxes", box_at(cube, {0, 0, 0}), box_at(brick, p), separation, n});
        pairs.push_back({"hexahedra", as_hexahedron(box_at(cube, {0, 0, 0})), as_hexahedron(box_at(brick, p)),
                         separation, n});
        pairs.push_back(
            {"box and hexahedron", box_at(cube, {0, 0, 0}), as_hexahedron(box_at(brick, p)), separation, n});
      }
    }
  }
  return pairs;
}

TEST_P(NarrowphaseSuite, ClassOfPairsClearlyApartOrClearlyOverlapping) {
  for (const KnownPair& pair : known_pairs()) {
    for (const Pose& X_VW : {Pose{}, tilted_pose()}) {
      const Body a = moved(pair.a, X_VW), b = moved(pair.b, X_VW);
      const Answer answer = ask(*narrowphase, a, b, {.kind = QueryKind::overlap});
      const PairStatus expected = pair.separation > 0 ? PairStatus::separated : PairStatus::overlapping;
      EXPECT_EQ(answer.status, expected)
          << pair.what << " " << pair.separation << " got " << to_string(answer.status);
    }
  }
}

// Spheres, capsules and padded boxes: a backend takes them, every query, or names the first that it refuses.
TEST_P(NarrowphaseSuite, RoundedSolidsAreAnsweredOrRefused) {
  const Hexahedron cube = Hexahedron::from_size({2, 2, 2});
  const std::vector<Hexahedron> solids{cube, Hexahedron::sphere(0.5), Hexahedron::capsule(0.5, 1.0),
                                       cube.padded(0.25)};
  // A backend without rounded solids names the first one.
  if (!capabilities().rounded_solids) {
    try {
      narrowphase->build(solids);
      ADD_FAILURE() << "took a sphere";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("solid 1 is rounded"), std::string::npos) << error.what();
    }
    return;
  }
  // The others answer the closed form: the lowest point over a face.
  const std::vector<double> lowest{-1.0, -0.5, -1.0, -1.25};  // of each solid, in its own frame
  for (std::size_t i = 1; i < solids.size(); ++i)
    for (const double separation : {0.125, -0.125}) {
      const Body floor = box_at({2, 2, 2}, {0, 0, 0});
      const Body above{solids[i], at(0.25, 0.5, 1.0 - lowest[i] + separation)};
      const Body a = moved(floor, tilted_pose()), b = moved(above, tilted_pose());
      const double allowed = resolution(a, b) + 1e-14;
      const Answer overlap = ask(*narrowphase, a, b, {.kind = QueryKind::overlap});
      const Answer answer = ask(*narrowphase, a, b, {.kind = QueryKind::manifold});
      EXPECT_EQ(overlap.status, separation > 0 ? PairStatus::separated : PairStatus::overlapping) << i;
      EXPECT_EQ(answer.status, overlap.status) << i;
      EXPECT_NEAR(answer.geometry.separation, separation, allowed) << i;
      EXPECT_LE(norm(answer.geometry.n_AB_W - tilted_pose().R.col(2)), 1e-12) << i;
      EXPECT_GE(answer.points.size(), 1u) << i;
    }
}

// Those that take up solids one by one answer as if they had been built with them, bit for bit.
TEST_P(NarrowphaseSuite, SolidsTakenUpLaterAnswerAsBuilt) {
  // One solid is replaced, another too, and one comes after them.
  const auto sized = [](double x, double y, double z) { return Hexahedron::from_size({x, y, z}); };
  std::vector<Hexahedron> solids{sized(1, 1, 1), sized(1, 2, 1), sized(1, 1, 3), sized(2, 1, 1)};
  narrowphase->build(solids);
  const auto workspace = narrowphase->make_workspace();
  const Hexahedron changed = as_hexahedron(box_at({1.5, 0.5, 0.5}, {0, 0, 0})).solid;
  const std::vector<Hexahedron> last{sized(0.5, 0.5, 2), changed};
  if (!narrowphase->set_solids(1, std::span(&changed, 1))) return;
  ASSERT_TRUE(narrowphase->set_solids(3, last));
  // A backend that is built of all these from the start answers the same.
  solids[1] = changed, solids[3] = last[0];
  solids.push_back(last[1]);
  const auto fresh = backends().make_narrowphase(GetParam());
  fresh->build(solids);
  const auto fresh_workspace = fresh->make_workspace();
  std::vector<Pose> poses(solids.size());
  std::vector<SolidPair> pairs;
  for (SolidIndex b = 0; b < solids.size(); ++b) {
    poses[b] = tilted_pose();
    poses[b].p += 0.9 * Vector3(b % 2, b / 2 % 2, b / 4);
    for (SolidIndex a = 0; a < b; ++a) pairs.push_back({a, b});
  }
  for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance}) {
    std::vector<PairStatus> status(pairs.size()), expected(pairs.size());
    std::vector<PairGeometry> geometry(pairs.size()), expected_geometry(pairs.size());
    narrowphase->evaluate({pairs, poses, {.kind = kind}}, {status, geometry, {}}, *workspace);
    fresh->evaluate({pairs, poses, {.kind = kind}}, {expected, expected_geometry, {}}, *fresh_workspace);
    EXPECT_EQ(status, expected);
    for (std::size_t i = 0; kind == QueryKind::distance && i < pairs.size(); ++i)
      EXPECT_TRUE(geometry[i].separation == expected_geometry[i].separation ||
                  std::isnan(expected_geometry[i].separation))
          << i;
  }
}

TEST_P(NarrowphaseSuite, SignNormalAndWitnessConventions) {
  for (const KnownPair& pair : known_pairs()) {
    for (const Pose& X_VW : {Pose{}, tilted_pose()}) {
      const Body a = moved(pair.a, X_VW), b = moved(pair.b, X_VW);
      SCOPED_TRACE(std::string(pair.what) + " at " + std::to_string(pair.separation));
      const Answer answer = ask(*narrowphase, a, b, {.kind = QueryKind::distance});
      const PairGeometry& g = answer.geometry;
      if (!gives_distance(capabilities(), pair.separation) && answer.status == PairStatus::unsupported) {
        EXPECT_TRUE(std::isnan(g.separation));
        EXPECT_TRUE(std::isnan(g.n_AB_W.x()) && std::isnan(g.p_A_W.x()) && std::isnan(g.p_B_W.x()));
        continue;
      }
      ASSERT_EQ(answer.status, pair.separation > 0 ? PairStatus::separated : PairStatus::overlapping);
      // The derived answer is for the ideal solids; their rounded world vertices are off by a few ulp of the
      // coordinates.
      const double bound = resolution(a, b) + 8 * std::numeric_limits<double>::epsilon() * scale_of(a, b);
      const double depth = std::max(0.0, -pair.separation);
      EXPECT_NEAR(g.separation, pair.separation, bound + share_of_depth() * depth);
      // Along the normal returned the pair is at most `bound` deeper or nearer than along the right one.
      EXPECT_NEAR(norm(g.n_AB_W), 1.0, 8 * std::max(bound, 1e-15));
      EXPECT_GT(dot(g.n_AB_W, rotate(X_VW.R, pair.n_AB_W)), 0.99);
      EXPECT_LE(norm((g.p_A_W + g.separation * g.n_AB_W) - g.p_B_W), 4 * bound + 1e-15 * scale_of(a, b));
    }
  }
}

TEST_P(NarrowphaseSuite, MovingBByMinusSeparationAlongTheNormalBringsThePairToTouch) {
  for (const KnownPair& pair : known_pairs()) {
    if (!gives_distance(capabilities(), pair.separation)) continue;
    // A backend that may be off by as much as the solids are large claims nothing here.
    if (resolution(pair.a, pair.b) > 0.01) continue;
    if (pair.separation < 0.0 && share_of_depth() > 0.0) continue;  // nor one whose depths are known wrong
    const Body a = moved(pair.a, tilted_pose());
    Body b = moved(pair.b, tilted_pose());
    const Answer before = ask(*narrowphase, a, b, {.kind = QueryKind::distance});
    const double slack = 2 * resolution(a, b) + 1e-14 * scale_of(a, b);
    b.X_WS.p -= (before.geometry.separation - slack) * before.geometry.n_AB_W;
    EXPECT_NE(ask(*narrowphase, a, b, {}).status, PairStatus::overlapping)
        << pair.what << " " << pair.separation;
    b.X_WS.p -= 2 * slack * before.geometry.n_AB_W;
    EXPECT_NE(ask(*narrowphase, a, b, {}).status, PairStatus::separated)
        << pair.what << " " << pair.separation;
  }
}

TEST_P(NarrowphaseSuite, SwappedPairGivesTheSameStatusAndTheNegatedNormal) {
  const bool bit_equal = GetParam() == "native" || GetParam() == "exact";
  for (const KnownPair& pair : known_pairs()) {
    const Body a = moved(pair.a, tilted_pose()), b = moved(pair.b, tilted_pose());
    const Answer ab = ask(*narrowphase, a, b, {.kind = QueryKind::distance});
    const Answer ba = ask(*narrowphase, b, a, {.kind = QueryKind::distance});
    ASSERT_EQ(ab.status, ba.status) << pair.what;
    if (ab.status == PairStatus::unsupported) continue;
    if (bit_equal) {
      EXPECT_EQ(ab.geometry.separation, ba.geometry.separation);
      EXPECT_EQ(ab.geometry.n_AB_W, Vector3(-ba.geometry.n_AB_W));
    } else {
      EXPECT_NEAR(ab.geometry.separation, ba.geometry.separation, 2 * resolution(a, b));
      EXPECT_LT(dot(ab.geometry.n_AB_W, ba.geometry.n_AB_W), -0.99);
    }
  }
}

TEST_P(NarrowphaseSuite, BeyondMaxSeparationIsInfiniteNeverABound) {
  if (!capabilities().distance) return;
  const Body a = box_at({2, 2, 2}, {0, 0, 0}), b = box_at({2, 2, 2}, {2.5, 0, 0});
  const Answer within = ask(*narrowphase, a, b, {.kind = QueryKind::distance, .max_separation = 0.75});
  EXPECT_NEAR(within.geometry.separation, 0.5, resolution(a, b));
  const Answer beyond = ask(*narrowphase, a, b, {.kind = QueryKind::distance, .max_separation = 0.25});
  EXPECT_EQ(beyond.status, PairStatus::separated);
  EXPECT_EQ(beyond.geometry.separation, kInfinity);
  EXPECT_TRUE(std::isnan(beyond.geometry.n_AB_W.x()));
  EXPECT_TRUE(std::isnan(beyond.geometry.p_A_W.x()));
}

TEST_P(NarrowphaseSuite, ManifoldOfARestingFaceHoldsTheDeepestPointAndItsArea) {
  const Body a = box_at({4, 4, 1}, {0, 0, 0}), b = box_at({2, 1, 1}, {0, 0, 0.9375});  // 1/16 deep
  const Answer answer = ask(*narrowphase, a, b, {.kind = QueryKind::manifold});
  if (!capabilities().manifold) {
    EXPECT_EQ(answer.status, PairStatus::unsupported);
    EXPECT_EQ(answer.geometry.point_count, 0);
    return;
  }
  ASSERT_EQ(answer.status, PairStatus::overlapping);
  ASSERT_GE(answer.points.size(), 1u);
  ASSERT_LE(answer.points.size(), 8u);
  const double bound = resolution(a, b);
  double deepest = kInfinity;
  for (const ContactPoint& point : answer.points) {
    deepest = std::min(deepest, point.separation);
    EXPECT_LE(norm((point.p_A_W + point.separation * answer.geometry.n_AB_W) - point.p_B_W),
              4 * bound + 1e-14);
    EXPECT_LE(std::abs(point.p_B_W.x()), 1.0 + bound + 1e-14);
    EXPECT_LE(std::abs(point.p_B_W.y()), 0.5 + bound + 1e-14);
  }
  EXPECT_NEAR(deepest, -0.0625, bound + share_of_depth() * 0.0625);
}

TEST_P(NarrowphaseSuite, ManifoldKeepsToItsSlots) {
  // A block with another on top and one below, both in contact.
  if (!capabilities().manifold) return;
  const std::array solids = {Hexahedron::from_size({4, 4, 1}), Hexahedron::from_size({2, 1, 1}),
                             Hexahedron::from_size({2, 1, 1})};
  std::array<Pose, 3> poses;
  poses[1].p = {0, 0, 0.9375};
  poses[2].p = {0, 0, -0.9375};
  const std::array pairs = {SolidPair{0, 1}, SolidPair{0, 2}};
  narrowphase->build(solids);
  const auto workspace = narrowphase->make_workspace();
  // Whatever number of points is asked for: the deepest is among them, and the place after them is as it was.
  constexpr double kUntouched = -77.0;
  for (int max_points = 1; max_points <= kMaxManifoldPoints; ++max_points) {
    std::array<PairStatus, 2> status{};
    std::array<PairGeometry, 2> geometry{};
    std::vector<ContactPoint> points(2 * max_points + 1);
    for (ContactPoint& point : points) point.separation = kUntouched;
    narrowphase->evaluate(
        {.pairs = pairs, .poses = poses, .query = {.kind = QueryKind::manifold, .max_points = max_points}},
        {.status = status, .geometry = geometry, .points = points}, *workspace);
    for (int i = 0; i < 2; ++i) {
      ASSERT_GE(geometry[i].point_count, 1);
      ASSERT_LE(geometry[i].point_count, max_points);
      double deepest = kInfinity;
      for (int k = 0; k < geometry[i].point_count; ++k)
        deepest = std::min(deepest, points[i * max_points + k].separation);
      EXPECT_NEAR(deepest, geometry[i].separation, 2 * capabilities().resolution.at(6.0) + 1e-14);
    }
    EXPECT_EQ(points.back().separation, kUntouched);
  }
}

// A batch with every kind of pair; result i must depend on pair i alone.
struct Batch {
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;
};

Batch mixed_batch() {
  Batch batch;
  const std::vector<KnownPair> known = known_pairs();
  for (int repeat = 0; repeat < 8; ++repeat) {
    Pose X_VW = tilted_pose();
    X_VW.p *= 1.0 + repeat;
    for (const KnownPair& pair : known) {
      const auto first = static_cast<SolidIndex>(batch.solids.size());
      for (const Body& body : {pair.a, pair.b}) {
        batch.solids.push_back(body.solid);
        batch.poses.push_back(compose(X_VW, body.X_WS));
      }
      batch.pairs.push_back({first, first + 1});
    }
  }
  return batch;
}

struct BatchAnswer {
  std::vector<PairStatus> status;
  std::vector<PairGeometry> geometry;
  std::vector<ContactPoint> points;

  explicit BatchAnswer(std::size_t pairs)
      : status(pairs), geometry(pairs), points(pairs * kMaxManifoldPoints) {}
  NarrowphaseOutput part(std::size_t first, std::size_t count) {
    return {std::span(status).subspan(first, count), std::span(geometry).subspan(first, count),
            std::span(points).subspan(first * kMaxManifoldPoints, count * kMaxManifoldPoints)};
  }
};

bool same_bits(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

void expect_same(const BatchAnswer& expected, const BatchAnswer& got) {
  for (std::size_t i = 0; i < expected.status.size(); ++i) {
    ASSERT_EQ(expected.status[i], got.status[i]) << i;
    ASSERT_TRUE(same_bits(expected.geometry[i].separation, got.geometry[i].separation)) << i;
    ASSERT_EQ(expected.geometry[i].point_count, got.geometry[i].point_count) << i;
    for (int k = 0; k < expected.geometry[i].point_count; ++k) {
      const std::size_t slot = i * kMaxManifoldPoints + k;
      ASSERT_TRUE(same_bits(expected.points[slot].separation, got.points[slot].separation)) << i;
      for (int axis = 0; axis < 3; ++axis)
        ASSERT_TRUE(same_bits(expected.points[slot].p_A_W(axis), got.points[slot].p_A_W(axis))) << i;
    }
  }
}

TEST_P(NarrowphaseSuite, AnswersDoNotDependOnEarlierQueriesOrBatchSize) {
  if (!capabilities().deterministic) return;
  const Batch batch = mixed_batch();
  narrowphase->build(batch.solids);
  const Query query{.kind = capabilities().manifold ? QueryKind::manifold : QueryKind::overlap};
  const auto workspace = narrowphase->make_workspace();
  BatchAnswer whole(batch.pairs.size());
  narrowphase->evaluate({.pairs = batch.pairs, .poses = batch.poses, .query = query},
                        whole.part(0, batch.pairs.size()), *workspace);
  BatchAnswer single(batch.pairs.size());
  for (std::size_t i = batch.pairs.size(); i-- > 0;)
    narrowphase->evaluate(
        {.pairs = std::span(batch.pairs).subspan(i, 1), .poses = batch.poses, .query = query},
        single.part(i, 1), *workspace);
  expect_same(whole, single);
}

TEST_P(NarrowphaseSuite, ThreadsGiveTheSameBitsAsOne) {
  if (!capabilities().thread_safe || !capabilities().deterministic) return;
  // All pairs in one call.
  const Batch batch = mixed_batch();
  narrowphase->build(batch.solids);
  const Query query{.kind = capabilities().manifold ? QueryKind::manifold : QueryKind::overlap};
  BatchAnswer one(batch.pairs.size());
  const auto workspace = narrowphase->make_workspace();
  narrowphase->evaluate({.pairs = batch.pairs, .poses = batch.poses, .query = query},
                        one.part(0, batch.pairs.size()), *workspace);
  // Each in a call of its own, from four threads.
  constexpr std::size_t kThreads = 4;
  BatchAnswer many(batch.pairs.size());
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      const auto own = narrowphase->make_workspace();
      const std::size_t first = batch.pairs.size() * t / kThreads,
                        last = batch.pairs.size() * (t + 1) / kThreads;
      for (std::size_t i = first; i < last; ++i)
        narrowphase->evaluate(
            {.pairs = std::span(batch.pairs).subspan(i, 1), .poses = batch.poses, .query = query},
            many.part(i, 1), *own);
    });
  }
  for (std::thread& thread : threads) thread.join();
  expect_same(one, many);
}

TEST_P(NarrowphaseSuite, AnEmptyBatchIsLegal) {
  const std::array solids = {Hexahedron::from_size({1, 1, 1})};
  const std::array<Pose, 1> poses;
  narrowphase->build(solids);
  const auto workspace = narrowphase->make_workspace();
  narrowphase->evaluate({.pairs = {}, .poses = poses, .query = {}}, {}, *workspace);
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(NarrowphaseSuite);  // a program may have none
INSTANTIATE_TEST_SUITE_P(AllBackends, NarrowphaseSuite, testing::ValuesIn(narrowphase_names()),
                         [](const auto& test) { return test.param; });

}  // namespace

void link_narrowphase_suite() {}

}  // namespace touchstone::suite

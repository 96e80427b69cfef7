#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <thread>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/bullet/backend_under_test.hpp"
#include "touchstone/tests/bullet/reference.hpp"

namespace touchstone::test {
namespace {

const Hexahedron kCube = Hexahedron::from_size({2, 2, 2});
const Query kOverlap{.kind = QueryKind::overlap};
const Query kDistance{.kind = QueryKind::distance};
const Query kManifold{.kind = QueryKind::manifold};
// Rounding of unit-sized figures in the engine's scalar.
const double kRounding = kDouble ? 1e-14 : 1e-5;

Hexahedron as_hull(const Hexahedron& solid) { return Hexahedron::from_vertices(solid.vertices()); }

void expect_vector(const Vector3& actual, const Vector3& expected, double tolerance) {
  EXPECT_LE((actual - expected).cwiseAbs().maxCoeff(), tolerance)
      << actual.transpose() << " is not " << expected.transpose();
}

void expect_witness_identity(const PairGeometry& g, double tolerance) {
  expect_vector(g.p_B_W, g.p_A_W + g.separation * g.n_AB_W, tolerance);
}

TEST(TOUCHSTONE_SUITE, RegistersTwoNarrowphasesAndABroadphaseWithVersionAndPrecision) {
  const BackendRegistry registry = make_registry();
  EXPECT_THAT(registry.narrowphase(kBackend).description,
              testing::HasSubstr(kDouble ? "Bullet 3.24, double" : "Bullet 3.24, single"));
  EXPECT_EQ(registry.make_narrowphase(kGjk)->capabilities().scalar_bits, kDouble ? 64 : 32);
  EXPECT_EQ(registry.make_broadphase(kBackend)->name(), kBackend);
  EXPECT_FALSE(registry.make_narrowphase(kBackend)->capabilities().distance);
  EXPECT_TRUE(registry.make_narrowphase(kGjk)->capabilities().distance);
}

TEST(TOUCHSTONE_SUITE, NormalPointsFromAToBAndWitnessesLieOnTheirSolidsWhenApart) {
  for (const Hexahedron& solid : {kCube, as_hull(kCube)}) {
    const Answer apart = ask(kGjk, {solid, kCube}, {at(1, 0, 0), at(4, 0.5, 0)}, kDistance);
    EXPECT_EQ(apart.status, PairStatus::separated);
    EXPECT_NEAR(apart.geometry.separation, 1.0, kRounding);
    expect_vector(apart.geometry.n_AB_W, {1, 0, 0}, kRounding);
    EXPECT_NEAR(apart.geometry.p_A_W.x(), 2.0, kRounding);
    EXPECT_NEAR(apart.geometry.p_B_W.x(), 3.0, kRounding);
    expect_witness_identity(apart.geometry, kRounding);
  }
}

TEST(TOUCHSTONE_SUITE, NormalPointsFromAToBAndMovingBAlongItSeparatesWhenOverlapping) {
  for (const std::string& backend : {kBackend, kGjk}) {
    for (const Hexahedron& solid : {kCube, as_hull(kCube)}) {
      const Answer overlapping =
          ask(backend, {solid, kCube}, {at(1, 0, 0), at(2.75, 0.25, 0.125)}, kManifold);
      EXPECT_EQ(overlapping.status, PairStatus::overlapping) << backend;
      EXPECT_NEAR(overlapping.geometry.separation, -0.25, kRounding);
      expect_vector(overlapping.geometry.n_AB_W, {1, 0, 0}, kRounding);
      EXPECT_NEAR(overlapping.geometry.p_A_W.x(), 2.0, kRounding);
      EXPECT_NEAR(overlapping.geometry.p_B_W.x(), 1.75, kRounding);
      expect_witness_identity(overlapping.geometry, kRounding);
      ASSERT_GE(overlapping.geometry.point_count, 1);
      EXPECT_EQ(overlapping.points[0].separation, overlapping.geometry.separation);
    }
  }
}

TEST(TOUCHSTONE_SUITE, SwappedPairHasTheOppositeNormal) {
  for (const std::string& backend : {kBackend, kGjk}) {
    const Answer ab = ask(backend, {kCube, kCube}, {at(0, 0, 0), at(0.25, 1.5, 0.125)}, kManifold);
    const Answer ba = ask(backend, {kCube, kCube}, {at(0.25, 1.5, 0.125), at(0, 0, 0)}, kManifold);
    EXPECT_NEAR(ab.geometry.separation, ba.geometry.separation, kRounding);
    expect_vector(ab.geometry.n_AB_W, -ba.geometry.n_AB_W, kRounding);
    expect_vector(ab.geometry.n_AB_W, {0, 1, 0}, kRounding);
  }
}

TEST(TOUCHSTONE_SUITE, TouchingIsUndecidedAndCarriesGeometry) {
  for (const std::string& backend : {kBackend, kGjk}) {
    const Answer touching = ask(backend, {kCube, kCube}, {at(0, 0, 0), at(2, 0.25, 0)}, kManifold);
    EXPECT_EQ(touching.status, PairStatus::undecided) << backend;
    EXPECT_NEAR(touching.geometry.separation, 0.0, kDouble ? 1e-6 : 1e-3);
    expect_vector(touching.geometry.n_AB_W, {1, 0, 0}, kRounding);
  }
}

TEST(TOUCHSTONE_SUITE, BoxDetectorNeverInventsADistance) {
  const std::vector<Hexahedron> boxes{kCube, kCube};
  const std::vector<Pose> poses{at(0, 0, 0), at(5, 0, 0)};
  EXPECT_EQ(ask(kBackend, boxes, poses, kOverlap).status, PairStatus::separated);
  const Answer distance = ask(kBackend, boxes, poses, kDistance);
  EXPECT_EQ(distance.status, PairStatus::unsupported);
  EXPECT_TRUE(std::isnan(distance.geometry.separation));
  const Answer manifold = ask(kBackend, boxes, poses, kManifold);
  EXPECT_EQ(manifold.status, PairStatus::separated);
  EXPECT_TRUE(std::isnan(manifold.geometry.separation));
  EXPECT_EQ(manifold.geometry.point_count, 0);
  const Answer up_to_touch =
      ask(kBackend, boxes, poses, {.kind = QueryKind::distance, .max_separation = 0.0});
  EXPECT_EQ(up_to_touch.status, PairStatus::separated);
  EXPECT_TRUE(std::isinf(up_to_touch.geometry.separation));
}

TEST(TOUCHSTONE_SUITE, BeyondMaxSeparationIsInfiniteNotABound) {
  const Answer answer = ask(kGjk, {kCube, kCube}, {at(0, 0, 0), at(5, 0, 0)},
                            {.kind = QueryKind::distance, .max_separation = 2.5});
  EXPECT_EQ(answer.status, PairStatus::separated);
  EXPECT_TRUE(std::isinf(answer.geometry.separation));
  EXPECT_TRUE(std::isnan(answer.geometry.n_AB_W.x()));
  const Answer within = ask(kGjk, {kCube, kCube}, {at(0, 0, 0), at(5, 0, 0)},
                            {.kind = QueryKind::distance, .max_separation = 3.5});
  EXPECT_NEAR(within.geometry.separation, 3.0, kRounding);
}

TEST(TOUCHSTONE_SUITE, ContainedBoxOverlapsByTheWayOutThroughTheNearestFace) {
  const Hexahedron small = Hexahedron::from_size({0.2, 0.2, 0.2});
  for (const std::string& backend : {kBackend, kGjk}) {
    const Answer answer = ask(backend, {kCube, small}, {at(0, 0, 0), at(0.5, 0.1, 0.05)}, kDistance);
    EXPECT_EQ(answer.status, PairStatus::overlapping);
    EXPECT_NEAR(answer.geometry.separation, -0.6, kRounding) << backend;
    expect_vector(answer.geometry.n_AB_W, {1, 0, 0}, kRounding);
  }
}

TEST(TOUCHSTONE_SUITE, BoxFaceManifoldHasFourPointsDeepestFirstAndHullsHaveOne) {
  const std::vector<Pose> poses{
      at(0, 0, 0), {pose_from_position_vector((Vector6() << 1.0, 0.5, 1.9, 0, 0.01, 0).finished())}};
  const Answer boxes = ask(kBackend, {kCube, kCube}, poses, kManifold);
  ASSERT_EQ(boxes.geometry.point_count, 4);
  EXPECT_EQ(boxes.points[0].separation, boxes.geometry.separation);
  for (std::size_t i = 1; i < boxes.points.size(); ++i)
    EXPECT_LE(boxes.points[i - 1].separation, boxes.points[i].separation);
  for (const ContactPoint& point : boxes.points)
    expect_vector(point.p_B_W, point.p_A_W + point.separation * boxes.geometry.n_AB_W, kRounding);
  const Answer two = ask(kBackend, {kCube, kCube}, poses, {.kind = QueryKind::manifold, .max_points = 2});
  ASSERT_EQ(two.geometry.point_count, 2);
  EXPECT_EQ(two.points[1].separation, boxes.points[1].separation);
  EXPECT_EQ(ask(kBackend, {as_hull(kCube), kCube}, poses, kManifold).geometry.point_count, 1);
}

TEST(TOUCHSTONE_SUITE, RefusedInputLeavesThePreviousBuild) {
  const auto narrowphase = make_registry().make_narrowphase(kGjk);
  narrowphase->build(std::vector<Hexahedron>{kCube, kCube});
  const double tiny = kDouble ? 1e-80 : 1e-12;
  const std::vector<Hexahedron> refused{kCube, Hexahedron::from_size({tiny, tiny, tiny})};
  try {
    narrowphase->build(refused);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("solid 1"));
  }
  EXPECT_NEAR(ask(*narrowphase, std::array{at(0, 0, 0), at(5, 0, 0)}, kDistance).geometry.separation, 3.0,
              kRounding);
}

TEST(TOUCHSTONE_SUITE, PoseBeyondTheScalarFailsInsteadOfAnswering) {
  const Answer answer = ask(kGjk, {kCube, kCube}, {at(0, 0, 0), at(1e300, 0, 0)}, kOverlap);
  EXPECT_EQ(answer.status, PairStatus::failed);
}

TEST(TOUCHSTONE_SUITE, SmallBoxesKeepTheirSizeDespiteTheDefaultMargin) {
  const double size = 1e-3;
  const Hexahedron box = Hexahedron::from_size({size, size, size});
  const Answer answer = ask(kBackend, {box, box}, {at(0, 0, 0), at(0.75 * size, 0, 0)}, kDistance);
  EXPECT_NEAR(answer.geometry.separation, -0.25 * size, kRounding * size);
}

// A family of random pairs at an offset, and how far the backend is from the reference.
struct Statistics {
  int missed = 0;       // overlapping by more than the resolution, answered separated
  int phantom = 0;      // apart by more than the resolution, answered overlapping
  int wrong_class = 0;  // any of the two, at any distance
  int undecided = 0;
  int failed = 0;
  int beyond_apart = 0;  // error beyond the declared resolution, pairs apart
  int beyond_depth = 0;  // the same, pairs that overlap, beyond of_depth too
  double worst_apart = 0.0;
  double worst_share_of_depth = 0.0;  // of what exceeds the resolution
};

Hexahedron random_solid(std::mt19937_64& random, bool hull) {
  const Hexahedron box = Hexahedron::from_size(random_vector(random, 0.5, 1.5));
  if (!hull) return box;
  Matrix3 shear = Matrix3::Identity();
  const Vector3 s = random_vector(random, -0.3, 0.3);
  shear(0, 1) = s.x(), shear(0, 2) = s.y(), shear(1, 2) = s.z();
  std::array<Vector3, 8> vertices;
  for (int i = 0; i < 8; ++i) vertices[i] = rotate(shear, box.vertices()[i]);
  return Hexahedron::from_vertices(vertices);
}

Statistics measure(const std::string& backend, bool hull, double offset, double gap, int count) {
  std::mt19937_64 random(7);
  // Random pairs, moved along their centres until they are the gap apart.
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;
  std::vector<double> truth;
  for (int i = 0; i < count; ++i) {
    const Hexahedron a = random_solid(random, hull), b = random_solid(random, hull);
    Pose X_WA{random_rotation(random),
              Vector3(offset, 0.7 * offset, -0.3 * offset) + random_vector(random, -1, 1)};
    Pose X_WB{random_rotation(random), X_WA.p + random_vector(random, -1.5, 1.5)};
    const Vector3 line = X_WB.p - X_WA.p;
    for (int k = 0; gap > 0 && k < 40; ++k) {
      const double excess = signed_distance(a, X_WA, b, X_WB) - gap;
      if (std::abs(excess) < 1e-3 * gap) break;
      X_WB.p -= 0.9 * excess / norm(line) * line;
    }
    solids.push_back(a), solids.push_back(b), poses.push_back(X_WA), poses.push_back(X_WB);
    pairs.push_back({static_cast<SolidIndex>(2 * i), static_cast<SolidIndex>(2 * i + 1)});
    truth.push_back(signed_distance(a, X_WA, b, X_WB));
  }
  // The backend answers all pairs in one call.
  const auto narrowphase = make_registry().make_narrowphase(backend);
  narrowphase->build(solids);
  std::vector<PairStatus> status(pairs.size());
  std::vector<PairGeometry> geometry(pairs.size());
  const auto workspace = narrowphase->make_workspace();
  narrowphase->evaluate({pairs, poses, kDistance}, {status, geometry, {}}, *workspace);
  const Resolution resolution = narrowphase->capabilities().resolution;
  // Classes and distances against the truth.
  Statistics out;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double scale = std::abs(offset) + 4.0;
    const bool is_missed =
        truth[i] <= 0 && (status[i] == PairStatus::separated || status[i] == PairStatus::unsupported);
    const bool is_phantom = truth[i] > 0 && status[i] == PairStatus::overlapping;
    out.wrong_class += is_missed || is_phantom;
    out.missed += is_missed && truth[i] < -resolution.at(scale);
    out.phantom += is_phantom && truth[i] > resolution.at(scale);
    out.undecided += status[i] == PairStatus::undecided;
    out.failed += status[i] == PairStatus::failed;
    if (!std::isfinite(geometry[i].separation)) continue;
    const double error = std::abs(geometry[i].separation - truth[i]);
    const double excess = error - resolution.at(scale);
    if (truth[i] > 0) {
      out.worst_apart = std::max(out.worst_apart, error);
      out.beyond_apart += excess > 0;
    } else {
      out.worst_share_of_depth = std::max(out.worst_share_of_depth, excess / -truth[i]);
      out.beyond_depth += excess > resolution.of_depth * -truth[i];
    }
  }
  return out;
}

TEST(TOUCHSTONE_SUITE, DeclaredResolutionHoldsOnRandomPairsAtEveryOffset) {
  for (const double offset : {0.0, 10.0, 1e3, 1e6}) {
    for (const std::string& backend : {kBackend, kGjk}) {
      for (const bool hull : {false, true}) {
        SCOPED_TRACE(backend + (hull ? " hulls at " : " boxes at ") + std::to_string(offset));
        const Statistics found = measure(backend, hull, offset, 0.0, 500);
        EXPECT_EQ(found.missed, 0);
        EXPECT_EQ(found.phantom, 0);
        EXPECT_EQ(found.failed, 0);
        EXPECT_EQ(found.beyond_apart, 0) << found.worst_apart;
        EXPECT_EQ(found.beyond_depth, 0) << found.worst_share_of_depth;
      }
    }
  }
}

// Facts of the packaged Bullet 3.24, measured; a newer package may change them.

TEST(TOUCHSTONE_SUITE, FactBoxDetectorSeesContactAcrossASmallGapInHalfOfAllPairs) {
  // Gap 1e-7 m: fudge2 = 1e-5 in the edge tests makes the engine report a depth of about 2e-5 m.
  const Statistics found = measure(kBackend, false, 0.0, 1e-7, 1000);
  EXPECT_GT(found.undecided, 300);
  EXPECT_GT(found.worst_apart, 2e-5);
  EXPECT_LT(found.worst_apart, 1e-3);
}

TEST(TOUCHSTONE_SUITE, FactBoxDetectorOverestimatesDepthByUpToFivePercent) {
  const Statistics found = measure(kBackend, false, 0.0, 0.0, 1000);
  EXPECT_GT(found.worst_share_of_depth, 0.03);
  EXPECT_LT(found.worst_share_of_depth, 0.05);
}

TEST(TOUCHSTONE_SUITE, FactGjkNearTouchIsOffByUpToItsAbsoluteTolerance) {
  const Statistics found = measure(kGjk, false, 0.0, 1e-7, 2000);
  EXPECT_EQ(found.undecided, 2000);
  EXPECT_GT(found.worst_apart, kDouble ? 0.0 : 1e-5);
  EXPECT_LT(found.worst_apart, kDouble ? 1e-6 : 1e-3);
}

TEST(TOUCHSTONE_SUITE, FactGjkInSingleIsOffByMillimetresOnRareHullsNearTouch) {
  const Statistics found = measure(kGjk, true, 0.0, 1e-7, 2000);
  // One pair of 2000: 8.5 mm for a gap of 1e-7 m, past the declared resolution.
  EXPECT_EQ(found.beyond_apart, kDouble ? 0 : 1);
  EXPECT_GT(found.worst_apart, kDouble ? 0.0 : 8e-3);
}

TEST(TOUCHSTONE_SUITE, FactGjkEpaGoesWrongOnRareRandomBoxes) {
  const Statistics found = measure(kGjk, false, 0.0, 0.0, 12000);
  // Double: a depth too large by 0.9 % of itself. Single: a depth of 2.4 mm answered as 9 mm apart, one of 12
  // 000.
  EXPECT_EQ(found.beyond_depth, kDouble ? 0 : 1);
  EXPECT_EQ(found.missed, kDouble ? 0 : 1);
  EXPECT_GT(found.worst_share_of_depth, kDouble ? 5e-3 : 4.0);
}

TEST(TOUCHSTONE_SUITE, ThreadsWithTheirOwnWorkspacesGetTheSameBits) {
  std::mt19937_64 random(6);
  const AllPairs scene = all_pairs(
      80, [&](SolidIndex i) { return random_solid(random, i % 2 == 0); },
      [&] { return random_pose(random, 2); });
  for (const std::string& backend : {kBackend, kGjk}) {
    const auto narrowphase = make_registry().make_narrowphase(backend);
    narrowphase->build(scene.solids);
    std::array<Answers, 3> answers;
    const auto run = [&](std::size_t slot) {
      answers[slot] = ask(*narrowphase, scene.pairs, scene.poses, kDistance);
    };
    run(0);
    std::thread first(run, 1), second(run, 2);
    first.join(), second.join();
    for (std::size_t slot : {1, 2}) {
      EXPECT_EQ(answers[slot].status, answers[0].status);
      for (std::size_t i = 0; i < scene.pairs.size(); ++i)
        EXPECT_EQ(std::bit_cast<std::uint64_t>(answers[slot].geometry[i].separation),
                  std::bit_cast<std::uint64_t>(answers[0].geometry[i].separation));
    }
  }
}

TEST(TOUCHSTONE_SUITE, RawCheckCountsTheContactsThatTheInterfaceReports) {
  for (const std::string& backend : {kBackend, kGjk}) {
    std::mt19937_64 random(3);
    const AllPairs scene = all_pairs(
        200, [&](SolidIndex i) { return random_solid(random, i % 3 == 0); },
        [&] { return random_pose(random, 3); });
    const BackendRegistry registry = make_registry();
    const auto narrowphase = registry.make_narrowphase(backend);
    narrowphase->build(scene.solids);
    const std::vector<PairStatus> status = ask(*narrowphase, scene.pairs, scene.poses, kOverlap).status;
    const auto overlapping =
        static_cast<std::size_t>(std::count(status.begin(), status.end(), PairStatus::overlapping));
    const auto undecided =
        static_cast<std::size_t>(std::count(status.begin(), status.end(), PairStatus::undecided));
    const auto raw = registry.narrowphase(backend).make_raw();
    raw->build(scene.solids);
    raw->set_poses(scene.poses);
    EXPECT_GT(overlapping, 100u);
    for (const QueryKind kind : {QueryKind::overlap, QueryKind::manifold}) {
      const std::size_t counted = raw->run(scene.pairs, kind);
      EXPECT_GE(counted, overlapping) << backend;
      EXPECT_LE(counted, overlapping + undecided) << backend;
    }
  }
}

}  // namespace
}  // namespace touchstone::test

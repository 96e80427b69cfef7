#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/ask.hpp"

// Rounded pairs whose answers are derived by hand, for the backends that take them.

namespace touchstone {
namespace {

class RoundedPairs : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    BackendRegistry registry;
    register_native(registry);
    register_exact(registry);
    narrowphase = registry.make_narrowphase(GetParam());
    ASSERT_TRUE(narrowphase->capabilities().rounded_solids);
  }

  Answer ask_pair(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB,
                  const Query& query = {.kind = QueryKind::distance}) {
    const std::array solids{a, b};
    narrowphase->build(solids);
    const std::array poses{X_WA, X_WB};
    return ask(*narrowphase, poses, query);
  }

  PairStatus class_of(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB) {
    const PairStatus status = ask_pair(a, X_WA, b, X_WB, {.kind = QueryKind::overlap}).status;
    EXPECT_EQ(status, ask_pair(a, X_WA, b, X_WB).status);
    EXPECT_EQ(status, ask_pair(b, X_WB, a, X_WA).status);
    return status;
  }

  std::unique_ptr<Narrowphase> narrowphase;
};

constexpr double kTiny = 1e-14;

void expect_pair(const Answer& answer, double separation, const Vector3& n, const Vector3& p_A) {
  EXPECT_EQ(answer.status, separation > 0 ? PairStatus::separated : PairStatus::overlapping);
  EXPECT_NEAR(answer.geometry.separation, separation, kTiny);
  EXPECT_LT(norm(answer.geometry.n_AB_W - n), kTiny);
  EXPECT_LT(norm(answer.geometry.p_A_W - p_A), kTiny);
  EXPECT_LT(norm(answer.geometry.p_B_W - (p_A + separation * n)), kTiny);
}

double next(double value) { return std::nextafter(value, 1e300); }
double before(double value) { return std::nextafter(value, -1e300); }

TEST_P(RoundedPairs, SphereAndSphere) {
  const Hexahedron a = Hexahedron::sphere(2.0), b = Hexahedron::sphere(1.0);
  expect_pair(ask_pair(a, at(0, 0, 0), b, at(3, 4, 0)), 2.0, {0.6, 0.8, 0}, {1.2, 1.6, 0});
  expect_pair(ask_pair(a, at(0, 0, 0), b, at(0, -2, 0)), -1.0, {0, -1, 0}, {0, -2, 0});
}

TEST_P(RoundedPairs, ConcentricSpheresAreAsDeepAsBothRadii) {
  const Hexahedron a = Hexahedron::sphere(2.0), b = Hexahedron::sphere(1.0);
  const Answer answer = ask_pair(a, at(1, 2, 3), b, at(1, 2, 3));
  EXPECT_EQ(answer.status, PairStatus::overlapping);
  EXPECT_EQ(answer.geometry.separation, -3.0);
  EXPECT_NEAR(norm(answer.geometry.n_AB_W), 1.0, kTiny);
}

// 3-4-5: the distance of the centres is exactly the sum of the radii.
TEST_P(RoundedPairs, SpheresAtExactTouchAndOneBitToBothSides) {
  for (const double scale : {1.0, 0x1p-30, 0x1p40, 0x1p-300, 0x1p400}) {
    const Hexahedron a = Hexahedron::sphere(2.0 * scale), b = Hexahedron::sphere(3.0 * scale);
    const auto status = [&](double x, double y) { return class_of(a, at(0, 0, 0), b, at(x, y, 0)); };
    EXPECT_EQ(status(3 * scale, 4 * scale), PairStatus::overlapping) << scale;
    EXPECT_EQ(status(next(3 * scale), 4 * scale), PairStatus::separated) << scale;
    EXPECT_EQ(status(before(3 * scale), 4 * scale), PairStatus::overlapping) << scale;
    EXPECT_EQ(ask_pair(a, at(0, 0, 0), b, at(3 * scale, 4 * scale, 0)).geometry.separation, 0.0) << scale;
    EXPECT_GT(ask_pair(a, at(0, 0, 0), b, at(next(3 * scale), 4 * scale, 0)).geometry.separation, 0.0);
    const Hexahedron larger = Hexahedron::sphere(next(3.0 * scale));
    const Hexahedron smaller = Hexahedron::sphere(before(3.0 * scale));
    EXPECT_EQ(class_of(a, at(0, 0, 0), larger, at(next(3 * scale), 4 * scale, 0)), PairStatus::overlapping);
    EXPECT_EQ(class_of(a, at(0, 0, 0), smaller, at(3 * scale, 4 * scale, 0)), PairStatus::separated);
  }
}

TEST_P(RoundedPairs, FarFromTheOriginTouchIsStillDecided) {
  const Hexahedron a = Hexahedron::sphere(2.0), b = Hexahedron::sphere(3.0);
  const double far = 0x1p30;
  EXPECT_EQ(class_of(a, at(far, far, far), b, at(far + 3, far + 4, far)), PairStatus::overlapping);
  EXPECT_EQ(class_of(a, at(far, far, far), b, at(next(far + 3), far + 4, far)), PairStatus::separated);
}

TEST_P(RoundedPairs, SphereOverAFace) {
  const Hexahedron floor = Hexahedron::from_size({4, 4, 2}), ball = Hexahedron::sphere(0.5);
  expect_pair(ask_pair(floor, at(0, 0, -1), ball, at(1, 0.5, 0.75)), 0.25, {0, 0, 1}, {1, 0.5, 0});
  expect_pair(ask_pair(ball, at(1, 0.5, 0.375), floor, at(0, 0, -1)), -0.125, {0, 0, -1}, {1, 0.5, -0.125});
  EXPECT_EQ(class_of(floor, at(0, 0, -1), ball, at(1, 0.5, 0.5)), PairStatus::overlapping);
  EXPECT_EQ(class_of(floor, at(0, 0, -1), ball, at(1, 0.5, next(0.5))), PairStatus::separated);
  EXPECT_EQ(class_of(floor, at(0, 0, -1), ball, at(1, 0.5, before(0.5))), PairStatus::overlapping);
}

// The centre below the surface: through the nearest face.
TEST_P(RoundedPairs, SphereWithItsCentreInABox) {
  const Hexahedron box = Hexahedron::from_size({4, 4, 2}), ball = Hexahedron::sphere(0.5);
  expect_pair(ask_pair(box, at(0, 0, 0), ball, at(0.5, 0.25, 0.75)), -0.75, {0, 0, 1}, {0.5, 0.25, 1});
}

TEST_P(RoundedPairs, ParallelAndCrossingCapsules) {
  const Hexahedron a = Hexahedron::capsule(0.5, 4.0), b = Hexahedron::capsule(0.25, 2.0);
  const Answer parallel = ask_pair(a, at(0, 0, 0), b, at(1, 0, 0.5));
  EXPECT_EQ(parallel.status, PairStatus::separated);
  EXPECT_NEAR(parallel.geometry.separation, 0.25, kTiny);
  EXPECT_LT(norm(parallel.geometry.n_AB_W - Vector3(1, 0, 0)), kTiny);

  Pose across = at(0.0, 1.0, 0.25);  // its axis along x
  across.R.col(0) = Vector3(0, 0, -1), across.R.col(1) = Vector3(0, 1, 0), across.R.col(2) = Vector3(1, 0, 0);
  expect_pair(ask_pair(a, at(0, 0, 0), b, across), 0.25, {0, 1, 0}, {0, 0.5, 0.25});
  across.p.y() = 0.75;
  EXPECT_EQ(class_of(a, at(0, 0, 0), b, across), PairStatus::overlapping);
  across.p.y() = next(0.75);
  EXPECT_EQ(class_of(a, at(0, 0, 0), b, across), PairStatus::separated);
}

// The segments cross in one point: apart along their common normal, either way, by both radii.
TEST_P(RoundedPairs, CapsulesWhoseAxesCross) {
  const Hexahedron a = Hexahedron::capsule(0.5, 4.0), b = Hexahedron::capsule(0.25, 4.0);
  Pose across = at(0, 0, 0.5);
  across.R.col(0) = Vector3(0, 0, -1), across.R.col(1) = Vector3(0, 1, 0), across.R.col(2) = Vector3(1, 0, 0);
  const Answer answer = ask_pair(a, at(0, 0, 0), b, across);
  EXPECT_EQ(answer.status, PairStatus::overlapping);
  EXPECT_NEAR(answer.geometry.separation, -0.75, kTiny);
  EXPECT_NEAR(std::abs(answer.geometry.n_AB_W.y()), 1.0, kTiny);
}

TEST_P(RoundedPairs, CapsulesEndToEnd) {
  const Hexahedron a = Hexahedron::capsule(0.5, 4.0), b = Hexahedron::capsule(0.25, 2.0);
  expect_pair(ask_pair(a, at(0, 0, 0), b, at(0, 0, 4.0)), 0.25, {0, 0, 1}, {0, 0, 2.5});
  // Axes on one line, one within the other: sideways by both radii.
  const Answer within = ask_pair(a, at(0, 0, 0), b, at(0, 0, 0));
  EXPECT_NEAR(within.geometry.separation, -0.75, kTiny);
  EXPECT_NEAR(within.geometry.n_AB_W.z(), 0.0, kTiny);
}

TEST_P(RoundedPairs, RoundedCornersAndEdges) {
  const Hexahedron cube = Hexahedron::from_size({2, 2, 2}).padded(0.5), ball = Hexahedron::sphere(0.25);
  const double corner = 1.0 / std::numbers::sqrt3;
  const double distance = std::sqrt(3.0) - 0.75;
  expect_pair(ask_pair(cube, at(0, 0, 0), ball, at(2, 2, 2)), distance, {corner, corner, corner},
              Vector3(1, 1, 1) + 0.5 * Vector3(corner, corner, corner));
  // Over an edge 3-4-5: the corner of the cube's padding is cut off.
  EXPECT_EQ(class_of(cube, at(0, 0, 0), Hexahedron::sphere(4.5), at(4, 5, 0)), PairStatus::overlapping);
  EXPECT_EQ(class_of(cube, at(0, 0, 0), Hexahedron::sphere(4.5), at(4, next(5), 0)), PairStatus::separated);
}

// Cores 1.5 m apart, radii of 2 m in all. The axes across nearly parallel edges are as short as the turn.
TEST_P(RoundedPairs, HoweverLittleTheyAreTurnedPaddedBoxesMeet) {
  const Hexahedron box = Hexahedron::rounded_box({2, 2, 2}, 1.0);
  const std::array solids{box, box, box};
  for (const double turn : {0.0, 1e-9, 1e-40, 1e-80, 1.5e-162, 1e-200, 1e-300}) {
    SCOPED_TRACE(turn);
    const auto above = [turn](double z) {
      Pose X_WB = at(0, 0, z);
      X_WB.R(1, 0) = turn, X_WB.R(0, 1) = -turn;
      return X_WB;
    };
    EXPECT_EQ(class_of(box, at(0, 0, 0), box, above(3.5)), PairStatus::overlapping);
    EXPECT_EQ(class_of(box, at(0, 0, 0), box, above(4.001)), PairStatus::separated);
    // In a batch, too.
    narrowphase->build(solids);
    const std::array poses{at(0, 0, 0), above(3.5), above(4.001)};
    std::vector<SolidPair> pairs(16, {0, 1});
    pairs.insert(pairs.end(), 16, {0, 2});
    const Answers all = ask(*narrowphase, pairs, poses, {.kind = QueryKind::overlap});
    for (std::size_t i = 0; i < pairs.size(); ++i)
      EXPECT_EQ(all.status[i], i < 16 ? PairStatus::overlapping : PairStatus::separated) << i;
  }
}

TEST_P(RoundedPairs, PlateOnPlate) {
  const Hexahedron plate = Hexahedron::rounded_box({2, 2, 0}, 0.25);
  expect_pair(ask_pair(plate, at(0, 0, 0), Hexahedron::sphere(0.25), at(0.5, 0.5, 1.0)), 0.5, {0, 0, 1},
              {0.5, 0.5, 0.25});
  EXPECT_EQ(class_of(plate, at(0, 0, 0), plate, at(0.5, 0.25, 0.5)), PairStatus::overlapping);
  EXPECT_EQ(class_of(plate, at(0, 0, 0), plate, at(0.5, 0.25, next(0.5))), PairStatus::separated);
  // Plates within each other: up or down by both radii, though a plate is no solid without them.
  const Answer answer = ask_pair(plate, at(0, 0, 0), plate, at(0.5, 0.25, 0));
  EXPECT_NEAR(answer.geometry.separation, -0.5, kTiny);
  EXPECT_NEAR(std::abs(answer.geometry.n_AB_W.z()), 1.0, kTiny);
}

TEST_P(RoundedPairs, BeyondTheLimitNothingIsSaid) {
  const Hexahedron a = Hexahedron::sphere(2.0), b = Hexahedron::capsule(1.0, 2.0);
  Query query{.kind = QueryKind::distance, .max_separation = 0.5};
  EXPECT_NEAR(ask_pair(a, at(0, 0, 0), b, at(3.25, 0, 0), query).geometry.separation, 0.25, kTiny);
  const Answer beyond = ask_pair(a, at(0, 0, 0), b, at(3.75, 0, 0), query);
  EXPECT_EQ(beyond.status, PairStatus::separated);
  EXPECT_EQ(beyond.geometry.separation, kInfinity);
  EXPECT_TRUE(std::isnan(beyond.geometry.n_AB_W.x()));
  Pose nowhere;
  nowhere.p.x() = kNaN;
  EXPECT_EQ(ask_pair(a, nowhere, b, at(0, 0, 0), query).status, PairStatus::failed);
}

// Points of a manifold by their place on A, sorted.
std::vector<std::array<double, 3>> places(const Answer& answer) {
  std::vector<std::array<double, 3>> out;
  for (const ContactPoint& point : answer.points) {
    out.push_back({point.p_A_W.x(), point.p_A_W.y(), point.p_A_W.z()});
    EXPECT_LT(norm(point.p_B_W - point.p_A_W - point.separation * answer.geometry.n_AB_W), kTiny);
  }
  std::sort(out.begin(), out.end());
  return out;
}

using testing::DoubleNear;
using testing::ElementsAre;

auto place(double x, double y, double z) {
  return ElementsAre(DoubleNear(x, kTiny), DoubleNear(y, kTiny), DoubleNear(z, kTiny));
}

const Query kManifold{.kind = QueryKind::manifold};

TEST_P(RoundedPairs, ManifoldOfASphereIsOnePoint) {
  const Hexahedron floor = Hexahedron::from_size({4, 4, 2}), ball = Hexahedron::sphere(0.5);
  const Answer answer = ask_pair(floor, at(0, 0, -1), ball, at(1, 0.5, 0.25), kManifold);
  EXPECT_THAT(places(answer), ElementsAre(place(1, 0.5, 0)));
  EXPECT_NEAR(answer.points[0].separation, -0.25, kTiny);
}

TEST_P(RoundedPairs, ManifoldOfALyingCapsuleIsItsEnds) {
  const Hexahedron floor = Hexahedron::from_size({4, 4, 2}), pin = Hexahedron::capsule(0.5, 2.0);
  Pose lying = at(0.5, 0, 0.25);
  lying.R.col(0) = Vector3(0, 0, -1), lying.R.col(1) = Vector3(0, 1, 0), lying.R.col(2) = Vector3(1, 0, 0);
  EXPECT_THAT(places(ask_pair(floor, at(0, 0, -1), pin, lying, kManifold)),
              ElementsAre(place(-0.5, 0, 0), place(1.5, 0, 0)));
  lying.p.x() = 1.5;  // beyond the floor's edge
  EXPECT_THAT(places(ask_pair(floor, at(0, 0, -1), pin, lying, kManifold)),
              ElementsAre(place(0.5, 0, 0), place(2, 0, 0)));
  // One on another along it.
  Pose upper = lying;
  upper.p += Vector3(0.5, 0, 0.875);
  EXPECT_THAT(places(ask_pair(pin, lying, pin, upper, kManifold)),
              ElementsAre(place(1, 0, 0.75), place(2.5, 0, 0.75)));
}

TEST_P(RoundedPairs, ManifoldOfRoundedFacesIsTheFlatPart) {
  const Hexahedron floor = Hexahedron::from_size({4, 4, 2}), lid = Hexahedron::rounded_box({2, 1, 0.5}, 0.25);
  EXPECT_THAT(places(ask_pair(floor, at(0, 0, -1), lid, at(0, 0, 0.5 - 0x1p-10), kManifold)),
              ElementsAre(place(-1, -0.5, 0), place(-1, 0.5, 0), place(1, -0.5, 0), place(1, 0.5, 0)));
  const Hexahedron plate = Hexahedron::rounded_box({2, 2, 0}, 0.25);
  EXPECT_THAT(places(ask_pair(plate, at(0, 0, 0), plate, at(1, 1, 0.5), kManifold)),
              ElementsAre(place(0, 0, 0.25), place(0, 1, 0.25), place(1, 0, 0.25), place(1, 1, 0.25)));
  Query two = kManifold;
  two.max_points = 2;
  EXPECT_EQ(ask_pair(plate, at(0, 0, 0), plate, at(1, 1, 0.5), two).points.size(), 2u);
}

INSTANTIATE_TEST_SUITE_P(Backends, RoundedPairs, testing::Values("native", "exact"),
                         [](const auto& param) { return param.param; });

}  // namespace
}  // namespace touchstone

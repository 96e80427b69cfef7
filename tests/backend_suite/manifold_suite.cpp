#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/measures/accuracy/surface_measure.hpp"
#include "touchstone/tests/backend_suite/accuracy_table.hpp"
#include "touchstone/tests/backend_suite/suite.hpp"

// The definition of a manifold in narrowphase.hpp, held against every narrowphase that has manifolds.

namespace touchstone::suite {
namespace {

struct Case {
  std::string what;
  Body a, b;
};

/// Turned about y by `tilt` [rad], its lowest corner `gap` above the slab's top at z = 0.
Body block_above(double tilt, double gap) {
  const Vector3 size(1.0, 0.5, 0.5);
  const double c = std::cos(tilt), s = std::sin(tilt);
  Pose X;
  X.R << c, 0, s, 0, 1, 0, -s, 0, c;
  const double lowest = -(0.5 * size.x() * std::abs(s) + 0.5 * size.z() * c);
  X.p = {0.25, -0.125, gap - lowest};
  return box(size, X);
}

/// A block on a slab: deep, barely in, touching, apart; flat or tilted by rounding, by noise and visibly; as
/// boxes and as hulls, here and turned elsewhere.
std::vector<Case> cases() {
  const Body slab = box_at({4.0, 4.0, 1.0}, {0.0, 0.0, -0.5});
  Pose elsewhere;
  elsewhere.R = rotation_from_quaternion(0.8, 0.3, -0.4, 0.2);
  elsewhere.p = {3.0, -1.0, 2.0};
  std::vector<Case> out;
  for (const double gap : {-0.0625, -1e-3, -1e-6, 0.0, 1e-6, 1e-3, 0.25}) {
    for (const double tilt : {0.0, 1e-15, 1e-9, 1e-4, 0.01, -0.3}) {
      for (const Pose& X_VW : {Pose{}, elsewhere}) {
        const Body block = block_above(tilt, gap);
        const std::string what = "gap " + std::to_string(gap) + " tilt " + std::to_string(tilt);
        out.push_back({what, moved(slab, X_VW), moved(block, X_VW)});
        out.push_back(
            {what + ", hulls", moved(as_hexahedron(slab), X_VW), moved(as_hexahedron(block), X_VW)});
        out.push_back({what + ", swapped", moved(block, X_VW), moved(as_hexahedron(slab), X_VW)});
      }
    }
  }
  return out;
}

class ManifoldSuite : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { narrowphase = backends().make_narrowphase(GetParam()); }

  /// How far answers about the pair may be off [m].
  double bound(const Body& a, const Body& b, double depth) const {
    double share_of_depth = 0.0;
    for (const AccuracyRow& row : accuracy_table())
      if (row.backend == GetParam() && row.family == kByHand) share_of_depth = row.depth;
    return 4 * narrowphase->capabilities().resolution.at(scale_of(a, b)) + 1e-13 * scale_of(a, b) +
           share_of_depth * depth;
  }

  Answer ask_manifold(const Case& c, double limit, int max_points = kMaxManifoldPoints) {
    return ask(*narrowphase, c.a, c.b,
               {.kind = QueryKind::manifold, .max_points = max_points, .max_point_separation = limit});
  }

  std::unique_ptr<Narrowphase> narrowphase;
};

TEST_P(ManifoldSuite, HasNoPointBeyondItsLimit) {
  if (!narrowphase->capabilities().manifold) return;
  for (const Case& c : cases()) {
    for (const double limit : {0.0, 1e-9, 1e-4, 0.05, kInfinity}) {
      for (const int max_points : {kMaxManifoldPoints, 3}) {
        SCOPED_TRACE(c.what + " limit " + std::to_string(limit));
        const Answer answer = ask_manifold(c, limit, max_points);
        // As near as the pair to rounding counts as within.
        const double rounding = 1e-13 * scale_of(c.a, c.b);
        for (const ContactPoint& point : answer.points)
          EXPECT_LE(point.separation, std::max(limit, answer.geometry.separation + rounding));
      }
    }
  }
}

TEST_P(ManifoldSuite, HasNoPointBeyondTheDefaultLimitOfZeroWherePairsOverlap) {
  if (!narrowphase->capabilities().manifold) return;
  EXPECT_EQ(Query{}.max_point_separation, 0.0);
  for (const Case& c : cases()) {
    const Answer answer = ask(*narrowphase, c.a, c.b, {.kind = QueryKind::manifold});
    if (answer.status != PairStatus::overlapping) continue;
    for (const ContactPoint& point : answer.points)
      EXPECT_LE(point.separation, 1e-13 * scale_of(c.a, c.b)) << c.what;
  }
}

TEST_P(ManifoldSuite, HasTheDeepestPointWithThePairsSeparation) {
  if (!narrowphase->capabilities().manifold) return;
  const bool is_ours = GetParam() == "native" || GetParam() == "exact";
  for (const Case& c : cases()) {
    for (const double limit : {0.0, 1e-4, kInfinity}) {
      for (const int max_points : {kMaxManifoldPoints, 3, 1}) {
        SCOPED_TRACE(c.what + " limit " + std::to_string(limit));
        const Answer answer = ask_manifold(c, limit, max_points);
        const double separation = answer.geometry.separation;
        if (is_ours) {
          ASSERT_TRUE(std::isfinite(separation));
        }
        if (!std::isfinite(separation)) {
          EXPECT_TRUE(answer.points.empty());
          continue;
        }
        ASSERT_GE(answer.points.size(), 1u);
        ASSERT_LE(static_cast<int>(answer.points.size()), max_points);
        double deepest = kInfinity;
        for (const ContactPoint& point : answer.points) deepest = std::min(deepest, point.separation);
        EXPECT_NEAR(deepest, separation, is_ours ? 1e-14 * scale_of(c.a, c.b) : 0.0);
      }
    }
  }
}

TEST_P(ManifoldSuite, HasItsPointsOnBothSurfaces) {
  if (!narrowphase->capabilities().manifold) return;
  for (const Case& c : cases()) {
    // MuJoCo 2.2.2's box against box puts a point 2.39 m off boxes turned by 1e-15 to 1e-9 rad.
    if (GetParam() == "mujoco" && c.a.solid.is_box() && c.b.solid.is_box()) continue;
    WorldVertices a, b;
    world_vertices(c.a.solid, c.a.X_WS, a), world_vertices(c.b.solid, c.b.X_WS, b);
    const measures::SurfaceMeasure surface_a(a), surface_b(b);
    for (const double limit : {0.0, 1e-4, kInfinity}) {
      SCOPED_TRACE(c.what + " limit " + std::to_string(limit));
      const Answer answer = ask_manifold(c, limit);
      const Vector3& n = answer.geometry.n_AB_W;
      for (const ContactPoint& point : answer.points) {
        const double within = bound(c.a, c.b, std::max(0.0, -point.separation));
        EXPECT_LE(surface_a.distance(point.p_A_W), within);
        EXPECT_LE(surface_b.distance(point.p_B_W), within);
        EXPECT_LE(norm((point.p_A_W + point.separation * n) - point.p_B_W), within);
      }
    }
  }
}

/// A block that noise tilts on a slab keeps its four corners, asked with a positive limit: what stacks need.
TEST_P(ManifoldSuite, KeepsTheCornersOfABlockTiltedByNoiseUnderAPositiveLimit) {
  if (GetParam() != "native" && GetParam() != "exact") return;  // engines: measured as patch coverage
  for (const Case& c : cases()) {
    const Answer answer = ask_manifold(c, 0.0);
    if (c.what.find("tilt 0.000000") == std::string::npos) continue;
    const double near = std::max(answer.geometry.separation, 0.0) + 1e-6;
    EXPECT_EQ(ask_manifold(c, near).points.size(), 4u) << c.what;
  }
}

TEST_P(ManifoldSuite, OfFlatFacesApartHasAllCornersByDefault) {
  if (GetParam() != "native" && GetParam() != "exact") return;
  for (const Case& c : cases()) {
    if (c.what.find("tilt 0.000000") == std::string::npos) continue;
    const Answer wide = ask_manifold(c, kInfinity), answer = ask_manifold(c, 0.0);
    double highest = -kInfinity;
    for (const ContactPoint& point : wide.points) highest = std::max(highest, point.separation);
    if (highest - answer.geometry.separation > 1e-15) continue;
    EXPECT_EQ(answer.points.size(), 4u) << c.what;
  }
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(ManifoldSuite);  // a program may have none
INSTANTIATE_TEST_SUITE_P(AllBackends, ManifoldSuite, testing::ValuesIn(narrowphase_names()),
                         [](const auto& test) { return test.param; });

}  // namespace

void link_manifold_suite() {}

}  // namespace touchstone::suite

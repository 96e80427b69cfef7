#include "touchstone/adapters/fcl/fcl.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/tests/support/ask.hpp"

namespace touchstone {
namespace {

Hexahedron cube(bool is_box) {
  const Hexahedron box = Hexahedron::from_size({1, 1, 1});
  return is_box ? box : Hexahedron::from_vertices(box.vertices());
}

std::unique_ptr<Narrowphase> cubes(std::string_view name, bool boxes) {
  BackendRegistry registry;
  register_fcl(registry);
  auto narrowphase = registry.make_narrowphase(name);
  narrowphase->build(std::array{cube(boxes), cube(boxes)});
  return narrowphase;
}

std::array<Pose, 2> at_distance(double x) { return {at(0, 0, 0), at(x, 0.2, 0.1)}; }

TEST(Fcl, BoxesMeetInManifoldsAndOthersInOnePoint) {
  for (const bool boxes : {false, true}) {
    for (const double sign : {-1.0, 1.0}) {
      const Answer answer = ask(*cubes("fcl", boxes), at_distance(sign * 0.9), {.kind = QueryKind::manifold});
      ASSERT_EQ(answer.status, PairStatus::overlapping);
      EXPECT_EQ(answer.geometry.point_count, boxes ? 4 : 1);
      EXPECT_NEAR(answer.geometry.n_AB_W.x(), sign, 1e-12);
      for (const ContactPoint& point : answer.points) {
        EXPECT_NEAR(point.separation, -0.1, 1e-12);
        EXPECT_NEAR(dot(point.p_A_W - point.p_B_W, answer.geometry.n_AB_W), 0.1, 1e-12);
      }
    }
  }
}

TEST(Fcl, ApartHasTheDistanceOfTheNearestPoints) {
  for (const char* name : {"fcl", "fcl_indep"}) {
    for (const bool boxes : {false, true}) {
      const auto narrowphase = cubes(name, boxes);
      const Answer answer = ask(*narrowphase, at_distance(1.25), {.kind = QueryKind::distance});
      ASSERT_EQ(answer.status, PairStatus::separated);
      EXPECT_NEAR(answer.geometry.separation, 0.25, 1e-12);
      EXPECT_NEAR(answer.geometry.p_A_W.x(), 0.5, 1e-12);
      EXPECT_NEAR(answer.geometry.p_B_W.x(), 0.75, 1e-12);
      const Answer beyond =
          ask(*narrowphase, at_distance(1.25), {.kind = QueryKind::distance, .max_separation = 0.125});
      EXPECT_EQ(beyond.geometry.separation, kInfinity);
    }
  }
}

TEST(Fcl, CloserThanItsToleranceIsUndecided) {
  const auto narrowphase = cubes("fcl", true);
  for (const double x : {1.0 - 1e-7, 1.0 + 1e-7}) {
    const Answer answer = ask(*narrowphase, at_distance(x), {.kind = QueryKind::distance});
    EXPECT_EQ(answer.status, PairStatus::undecided);
    EXPECT_NEAR(answer.geometry.separation, x - 1.0, 1e-12);
  }
}

TEST(Fcl, TheIndependentSolverHasNoDepthsAndNoManifolds) {
  const auto narrowphase = cubes("fcl_indep", false);
  EXPECT_EQ(ask(*narrowphase, at_distance(0.9), {}).status, PairStatus::overlapping);
  EXPECT_EQ(ask(*narrowphase, at_distance(0.9), {.kind = QueryKind::distance}).status,
            PairStatus::unsupported);
  for (const double x : {0.9, 1.1})
    EXPECT_EQ(ask(*narrowphase, at_distance(x), {.kind = QueryKind::manifold}).status,
              PairStatus::unsupported);
}

TEST(Fcl, PosesThatAreNotFiniteFail) {
  for (const char* name : {"fcl", "fcl_indep"})
    for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance})
      EXPECT_EQ(ask(*cubes(name, false), at_distance(std::nan("")), {.kind = kind}).status,
                PairStatus::failed);
}

TEST(Fcl, TheRawCheckLeavesOutWhatWouldEndTheProcess) {
  BackendRegistry registry;
  register_fcl(registry);
  const auto raw = registry.narrowphase("fcl").make_raw();
  const double size = 0x1p1001;  // the hard cases' `scale-2^1000-apart`: an assertion within FCL's distance
  raw->build(std::array{cube(true), cube(true), Hexahedron::from_size({size, size, size}),
                        Hexahedron::from_size({size, size, size})});
  raw->set_poses(std::array{at(0, 0, 0), at(0.9, 0.2, 0.1), at(0, 0, 0), at(1.5 * size, 0.5 * size, 0.0)});
  for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold})
    EXPECT_EQ(raw->run(std::array{SolidPair{2, 3}, SolidPair{0, 1}}, kind), 1u);
}

}  // namespace
}  // namespace touchstone

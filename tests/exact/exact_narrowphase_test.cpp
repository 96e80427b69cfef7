#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/tests/support/ask.hpp"

namespace touchstone {
namespace {

Answer ask(const Vector3& p_b, Query query, SolidPair pair = {0, 1}) {
  BackendRegistry registry;
  register_exact(registry);
  const auto backend = registry.make_narrowphase("exact");
  const std::vector<Hexahedron> solids(2, Hexahedron::from_size({1, 1, 1}));
  backend->build(solids);
  std::array<Pose, 2> poses;
  poses[1].p = p_b;
  return ask(*backend, poses, query, pair);
}

TEST(ExactNarrowphase, RestingFaceHasFourPoints) {
  const Answer answer = ask({0, 0, 1}, {QueryKind::manifold});
  EXPECT_EQ(answer.status, PairStatus::overlapping);
  EXPECT_EQ(answer.geometry.separation, 0.0);
  EXPECT_EQ(answer.geometry.n_AB_W, Vector3(0, 0, 1));
  EXPECT_EQ(answer.geometry.point_count, 4);
  Query two{QueryKind::manifold};
  two.max_points = 2;
  EXPECT_EQ(ask({0, 0, 1}, two).geometry.point_count, 2);
}

TEST(ExactNarrowphase, TheDeepestPointHasTheSeparation) {
  for (const Vector3& p :
       {Vector3(0.9, 0.1, 0.2), Vector3(0, 0, 0.999), Vector3(1.5, 1.5, 1.5), Vector3(1, 1, 0)}) {
    const Answer answer = ask(p, {QueryKind::manifold});
    double deepest = kInfinity;
    for (int k = 0; k < answer.geometry.point_count; ++k)
      deepest = std::min(deepest, answer.points[k].separation);
    EXPECT_NEAR(deepest, answer.geometry.separation, 1e-14);
  }
}

TEST(ExactNarrowphase, BeyondMaxSeparationIsInfinite) {
  Query query{QueryKind::distance};
  query.max_separation = 1.5;
  EXPECT_EQ(ask({2.5, 0, 0}, query).geometry.separation, 1.5);
  const Answer beyond = ask({3, 0, 0}, query);
  EXPECT_EQ(beyond.status, PairStatus::separated);
  EXPECT_EQ(beyond.geometry.separation, kInfinity);
  EXPECT_TRUE(beyond.geometry.n_AB_W.hasNaN());
}

TEST(ExactNarrowphase, SwappedPairNegatesTheNormalEvenOfIdenticalSolids) {
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(0.5, 0.25, 0), Vector3(2, 2, 2)}) {
    const Answer ab = ask(p, {QueryKind::distance}), ba = ask(p, {QueryKind::distance}, {1, 0});
    EXPECT_EQ(ab.geometry.separation, ba.geometry.separation);
    EXPECT_EQ(ab.geometry.n_AB_W, Vector3(-ba.geometry.n_AB_W));
  }
}

TEST(ExactNarrowphase, OverlapQueryWritesTheStatus) {
  EXPECT_EQ(ask({1, 1, 1}, {QueryKind::overlap}).status, PairStatus::overlapping);
  EXPECT_EQ(ask({1.0000001, 0, 0}, {QueryKind::overlap}).status, PairStatus::separated);
}

}  // namespace
}  // namespace touchstone

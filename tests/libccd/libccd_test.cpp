#include "touchstone/adapters/libccd/libccd.hpp"

#include <ccd/ccd.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "touchstone/adapters/libccd/libccd_narrowphase.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/measures/common/allocations.hpp"
#include "touchstone/tests/support/ask.hpp"

namespace touchstone {
namespace {

std::unique_ptr<Narrowphase> cubes(std::string_view name) {
  BackendRegistry registry;
  register_libccd(registry);
  auto narrowphase = registry.make_narrowphase(name);
  narrowphase->build(std::array{Hexahedron::from_size({1, 1, 1}), Hexahedron::from_size({1, 1, 1})});
  return narrowphase;
}

std::array<Pose, 2> at_distance(double x) { return {at(0, 0, 0), at(x, 0.2, 0.1)}; }

TEST(Libccd, MprGivesDepthNormalAndPointsOfOverlappingCubes) {
  for (const double sign : {-1.0, 1.0}) {
    const Answer answer = ask(*cubes("libccd_mpr"), at_distance(sign * 0.9), {.kind = QueryKind::distance});
    ASSERT_EQ(answer.status, PairStatus::overlapping);
    EXPECT_NEAR(answer.geometry.separation, -0.1, 1e-12);
    EXPECT_NEAR(answer.geometry.n_AB_W.x(), sign, 1e-12);
    EXPECT_NEAR(norm(answer.geometry.p_B_W - answer.geometry.p_A_W), 0.1, 1e-12);
  }
}

TEST(Libccd, WhatItCannotAnswerIsUnsupported) {
  for (const char* name : {"libccd_gjk", "libccd_mpr"}) {
    const auto narrowphase = cubes(name);
    EXPECT_EQ(ask(*narrowphase, at_distance(1.1), {}).status, PairStatus::separated);
    const Answer apart = ask(*narrowphase, at_distance(1.1), {.kind = QueryKind::distance});
    EXPECT_EQ(apart.status, PairStatus::unsupported);
    EXPECT_TRUE(std::isnan(apart.geometry.separation));
    for (const double x : {0.9, 1.1})
      EXPECT_EQ(ask(*narrowphase, at_distance(x), {.kind = QueryKind::manifold}).status,
                PairStatus::unsupported);
  }
  const Answer apart =
      ask(*cubes("libccd_mpr"), at_distance(1.1), {.kind = QueryKind::distance, .max_separation = 0.0});
  EXPECT_EQ(apart.status, PairStatus::separated);
  EXPECT_EQ(apart.geometry.separation, kInfinity);
  EXPECT_EQ(ask(*cubes("libccd_gjk"), at_distance(0.9), {.kind = QueryKind::distance}).status,
            PairStatus::unsupported);
}

TEST(Libccd, ASearchThatEndsAtItsLimitIsUndecided) {
  // In contact, which GJK sees after a few iterations.
  std::array<Pose, 2> poses = {at(0, 0, 0), at(0.75, 0.9, 0.8)};
  poses[1].R = rotation_from_quaternion(0.8, 0.3, -0.4, 0.2);
  const std::array solids = {Hexahedron::from_size({1, 1, 1}), Hexahedron::from_size({1, 1, 1})};
  const auto limited = libccd::make_narrowphase(libccd::Method::gjk, 1);
  limited->build(solids);
  EXPECT_EQ(ask(*limited, poses, {}).status, PairStatus::undecided);
  EXPECT_EQ(ask(*cubes("libccd_gjk"), poses, {}).status, PairStatus::overlapping);
}

TEST(Libccd, WhatIsNotFiniteOrTooLargeFails) {
  for (const char* name : {"libccd_gjk", "libccd_mpr"})
    for (const double x : {kNaN, 1e80})
      EXPECT_EQ(ask(*cubes(name), at_distance(x), {}).status, PairStatus::failed);
}

TEST(Libccd, NothingIsAllocated) {
  if (!measures::thread_allocations()) GTEST_SKIP() << "this build cannot count them";
  for (const char* name : {"libccd_gjk", "libccd_mpr"}) {
    const auto narrowphase = cubes(name);
    const auto workspace = narrowphase->make_workspace();
    const std::array pairs = {SolidPair{0, 1}};
    Answers answers;
    for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance}) {
      evaluate(*narrowphase, pairs, at_distance(0.9), {.kind = kind}, *workspace, answers);
      const auto before = measures::thread_allocations();
      evaluate(*narrowphase, pairs, at_distance(0.9), {.kind = kind}, *workspace, answers);
      EXPECT_EQ(measures::thread_allocations(), before);
    }
  }
}

void support(const void* vertices, const ccd_vec3_t* direction, ccd_vec3_t* out) {
  const auto& v = *static_cast<const WorldVertices*>(vertices);
  const Vector3 d(direction->v[0], direction->v[1], direction->v[2]);
  Vector3 best = v.vertex(0);
  for (int i = 1; i < 8; ++i)
    if (dot(v.vertex(i), d) > dot(best, d)) best = v.vertex(i);
  ccdVec3Set(out, best.x(), best.y(), best.z());
}

// Why libccd_gjk answers no depths: boxes 0.125 deep, turned together.
TEST(Libccd, ItsEpaFindsNoDepthOfPlainBoxes) {
  Pose X_VW;
  X_VW.R = rotation_from_quaternion(0.8, 0.3, -0.4, 0.2);
  X_VW.p = {3.0, -1.0, 2.0};
  int wrong = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3 brick(1.0, 0.5, 3.0);
    for (const double sign : {-1.0, 1.0}) {
      Pose X_VB;
      X_VB.p = sign * Vector3::Unit(axis) * (1.0 + 0.5 * brick(axis) - 0.125);
      WorldVertices a, b;
      world_vertices(Hexahedron::from_size({2, 2, 2}), X_VW, a);
      world_vertices(Hexahedron::from_size(brick), compose(X_VW, X_VB), b);
      ccd_t settings;
      CCD_INIT(&settings);
      settings.support1 = settings.support2 = &support;
      settings.max_iterations = 100;
      double depth = 0.0;
      ccd_vec3_t n, p;
      ASSERT_EQ(ccdGJKPenetration(&a, &b, &settings, &depth, &n, &p), 0);
      wrong += std::abs(depth - 0.125) > 1e-3;
    }
  }
  EXPECT_GE(wrong, 3) << "libccd's EPA is better than it was: let libccd_gjk answer depths";
}

}  // namespace
}  // namespace touchstone

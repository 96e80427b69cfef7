#include "touchstone/adapters/mujoco/mujoco.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "touchstone/adapters/mujoco/engine.hpp"
#include "touchstone/adapters/mujoco_plugin/mujoco_plugin.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/measures/common/allocations.hpp"
#include "touchstone/tests/mujoco_plugin/collision_scene.hpp"
#include "touchstone/tests/support/ask.hpp"

namespace touchstone {
namespace {

std::unique_ptr<Narrowphase> built(const std::vector<Hexahedron>& solids) {
  BackendRegistry registry;
  register_mujoco(registry);
  auto narrowphase = registry.make_narrowphase("mujoco");
  narrowphase->build(solids);
  return narrowphase;
}

Hexahedron cube(bool is_box) {
  const Hexahedron box = Hexahedron::from_size({1, 1, 1});
  return is_box ? box : Hexahedron::from_vertices(box.vertices());
}

/// Its top is half as wide as its base.
Hexahedron frustum(const Vector3& middle = Vector3::Zero()) {
  std::array<Vector3, 8> vertices = Hexahedron::from_size({1, 1, 1}).vertices();
  for (Vector3& v : vertices) {
    if (v.z() > 0.0) v.x() *= 0.5, v.y() *= 0.5;
    v += middle;
  }
  return Hexahedron::from_vertices(vertices);
}

std::array<Pose, 2> at_distance(double x) { return {at(0, 0, 0), at(x, 0.2, 0.1)}; }

/// Later versions are better.
constexpr bool kIsDebians = mjVERSION_HEADER == 222;

TEST(Mujoco, TwoBoxesGiveHalfTheDepthOfAManifoldAndMeshesOnePointOfAll) {
  if (!kIsDebians) GTEST_SKIP() << "a fact about version 2.2.2";
  for (const bool a_is_box : {false, true}) {
    for (const bool b_is_box : {false, true}) {
      for (const double sign : {-1.0, 1.0}) {
        const auto narrowphase = built({cube(a_is_box), cube(b_is_box)});
        const Answer answer = ask(*narrowphase, at_distance(sign * 0.9), {.kind = QueryKind::manifold});
        const bool boxes = a_is_box && b_is_box;
        const double depth = boxes ? 0.05 : 0.1, tolerance = boxes ? 1e-12 : 1e-6;
        ASSERT_EQ(answer.status, PairStatus::overlapping);
        EXPECT_EQ(answer.geometry.point_count, boxes ? 4 : 1);
        EXPECT_NEAR(answer.geometry.separation, -depth, tolerance);
        EXPECT_NEAR(answer.geometry.n_AB_W.x(), sign, tolerance);
        // Half-way between the surfaces, whatever the depth.
        EXPECT_NEAR(0.5 * (answer.geometry.p_A_W.x() + answer.geometry.p_B_W.x()), sign * 0.45, tolerance);
        EXPECT_NEAR((answer.geometry.p_B_W - answer.geometry.p_A_W).x(), -sign * depth, tolerance);
      }
    }
  }
}

TEST(Mujoco, AMeshIsWhereItsSolidIs) {
  // MuJoCo has moved the frusta's vertices to their centres of mass, and turned them.
  const Vector3 middle(3, -2, 1);
  const auto narrowphase = built({frustum(middle), frustum()});
  const double resolution = narrowphase->capabilities().resolution.absolute;
  EXPECT_LT(resolution, 2e-6);
  Pose X_WA;
  X_WA.R = rotation_from_quaternion(0.8, 0.3, -0.4, 0.2);
  X_WA.p = {5, 6, -7};
  for (const double separation : {-4 * resolution, 4 * resolution, -0.01}) {
    Pose X_AB;  // base on top
    X_AB.p = middle + Vector3(0.0, 0.0, 1.0 + separation);
    const std::array poses = {X_WA, compose(X_WA, X_AB)};
    const Answer answer = ask(*narrowphase, poses, {.kind = QueryKind::distance, .max_separation = 0.0});
    ASSERT_EQ(answer.status, separation > 0.0 ? PairStatus::separated : PairStatus::overlapping)
        << separation;
    if (separation > 0.0) continue;
    EXPECT_NEAR(answer.geometry.separation, separation, resolution);
    EXPECT_GT(dot(answer.geometry.n_AB_W, rotate(X_WA.R, Vector3(0, 0, 1))), 1.0 - 1e-3);
  }
}

TEST(Mujoco, TheResolutionIsThatOfTheVerticesAsStored) {
  const auto resolution_of = [](const std::vector<Hexahedron>& solids) {
    return built(solids)->capabilities().resolution.absolute;
  };
  EXPECT_EQ(resolution_of({cube(true), cube(true)}), 0.0);
  const double mpr = 1e-6, ulp_at_1000 = 0x1p-14;         // of a float
  EXPECT_NEAR(resolution_of({cube(false)}), mpr, 1e-12);  // its vertices are floats
  const double far = resolution_of({cube(true), frustum({1000.1, 0, 0})});
  EXPECT_GT(far, mpr + 0.1 * ulp_at_1000);
  EXPECT_LT(far, mpr + 2 * std::sqrt(3.0) * ulp_at_1000);
}

TEST(Mujoco, ItHasNoDistances) {
  for (const bool boxes : {false, true}) {
    const auto narrowphase = built({cube(boxes), cube(boxes)});
    EXPECT_EQ(ask(*narrowphase, at_distance(1.1), {}).status, PairStatus::separated);
    for (const QueryKind kind : {QueryKind::distance, QueryKind::manifold}) {
      const Answer apart = ask(*narrowphase, at_distance(1.1), {.kind = kind});
      EXPECT_EQ(apart.status, PairStatus::unsupported);
      EXPECT_TRUE(std::isnan(apart.geometry.separation));
      const Answer asked_no_more = ask(*narrowphase, at_distance(1.1), {.kind = kind, .max_separation = 0.0});
      EXPECT_EQ(asked_no_more.status, PairStatus::separated);
      EXPECT_EQ(asked_no_more.geometry.separation, kInfinity);
    }
  }
}

// Why it has none: what MuJoCo lists where geoms have a margin.
TEST(Mujoco, WithAMarginItListsNoDistances) {
  if (!kIsDebians) GTEST_SKIP() << "a fact about version 2.2.2";
  BackendRegistry registry;
  register_core(registry);
  const auto native = registry.make_narrowphase("native");
  native->build(std::array{cube(true), cube(true)});
  const auto share_of_distance = [&](const test::GeomText& geom, const Pose& X_WB) {
    test::CollisionScene scene({geom, geom}, 2.0);
    scene.place(0, at(0, 0, 0));
    scene.place(1, X_WB);
    const double least = test::least_distance(scene.collide()).value_or(kInfinity);
    return least /
           ask(*native, std::array{at(0, 0, 0), X_WB}, {.kind = QueryKind::distance}).geometry.separation;
  };
  Pose corner_first = at(1.8, 0.2, 0.1);
  corner_first.R = rotation_from_quaternion(0.95, 0.1, 0.0, 0.3);
  const char* const better = "better than it was: let mujoco answer distances";
  EXPECT_NEAR(share_of_distance(test::box(1, 1, 1), corner_first), 0.5, 1e-6) << better;
  const auto cube_mesh = test::mesh(Hexahedron::from_size({1, 1, 1}).vertices());
  EXPECT_LT(share_of_distance(cube_mesh, at(1.5, 0.9, 0)), 0.9) << better;
}

/// As thick as one that MuJoCo's hull finder takes to be flat.
Hexahedron flat() { return Hexahedron::from_vertices(Hexahedron::from_size({1, 1, 1e-16}).vertices()); }
/// Its edges overflow once its inertia is computed.
Hexahedron huge() { return Hexahedron::from_vertices(Hexahedron::from_size({1e30, 1e30, 1e30}).vertices()); }

TEST(Mujoco, AMeshThatItRefusesIsUnsupportedAndTheOthersAreAnswered) {
  if (!kIsDebians) GTEST_SKIP() << "a fact about version 2.2.2";
  for (const Hexahedron& refused : {flat(), huge()}) {
    const auto narrowphase = built({cube(false), refused, cube(true)});
    const auto workspace = narrowphase->make_workspace();
    const std::array pairs = {SolidPair{0, 1}, SolidPair{0, 2}, SolidPair{1, 2}};
    const std::array poses = {at(0, 0, 0), at(0, 0, 0.2), at(0.9, 0.2, 0.1)};
    Answers answers;
    for (const QueryKind kind : {QueryKind::overlap, QueryKind::manifold}) {
      evaluate(*narrowphase, pairs, poses, {.kind = kind}, *workspace, answers);
      EXPECT_EQ(answers.status[0], PairStatus::unsupported);
      EXPECT_EQ(answers.status[1], PairStatus::overlapping);
      EXPECT_EQ(answers.status[2], PairStatus::unsupported);
    }
  }
}

TEST(Mujoco, WhatIsNotFiniteOrTooLargeFails) {
  for (const bool boxes : {false, true})
    for (const double x : {kNaN, 1e80})
      EXPECT_EQ(ask(*built({cube(boxes), cube(boxes)}), at_distance(x), {}).status, PairStatus::failed);
}

TEST(Mujoco, ThePluginsCheckIsNeverAsked) {
  // ctest runs each test in a process of its own: here the plugin has been in the table before any backend.
  const MujocoOverride native;
  const std::uint64_t before = mujoco_native_checks();
  for (const bool boxes : {false, true}) {
    const auto narrowphase = built({cube(boxes), cube(boxes)});
    const Answer answer = ask(*narrowphase, at_distance(0.9), {.kind = QueryKind::distance});
    const double depth = -answer.geometry.separation;  // of boxes half of it before version 3.10
    EXPECT_TRUE(std::abs(depth - 0.1) < 1e-6 || (boxes && std::abs(depth - 0.05) < 1e-6)) << depth;
  }
  EXPECT_EQ(mujoco_native_checks(), before);
}

TEST(Mujoco, AWorkspaceFollowsTheNextBuildAndNothingIsAllocatedAfterItsFirstCall) {
  if (!measures::thread_allocations()) GTEST_SKIP() << "this build cannot count them";
  const auto narrowphase = built({cube(true)});
  const auto workspace = narrowphase->make_workspace();
  const std::array pairs = {SolidPair{0, 1}};
  for (const bool boxes : {false, true}) {
    narrowphase->build(std::array{cube(boxes), cube(boxes)});
    Answers answers;
    for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold}) {
      evaluate(*narrowphase, pairs, at_distance(0.9), {.kind = kind}, *workspace, answers);
      EXPECT_EQ(answers.status[0], PairStatus::overlapping);
      const auto before = measures::thread_allocations();
      evaluate(*narrowphase, pairs, at_distance(0.9), {.kind = kind}, *workspace, answers);
      EXPECT_EQ(measures::thread_allocations(), before);
    }
  }
}

TEST(Mujoco, TheRawCheckFindsTheSameContacts) {
  BackendRegistry registry;
  register_mujoco(registry);
  const auto raw = registry.narrowphase("mujoco").make_raw();
  raw->build(std::array{cube(true), cube(false), cube(true), flat()});
  const std::array pairs = {SolidPair{0, 1}, SolidPair{0, 2}, SolidPair{1, 2}, SolidPair{0, 3}};
  raw->set_poses(std::array{at(0, 0, 0), at(0.9, 0, 0), at(-1.1, 0, 0), at(0, 0, 0)});
  EXPECT_EQ(raw->run(pairs, QueryKind::overlap), 1u);
  raw->set_poses(std::array{at(0, 0, 0), at(0.9, 0, 0), at(0.3, 0, 0), at(0, 0, 0)});
  EXPECT_EQ(raw->run(pairs, QueryKind::overlap), 3u);
}

}  // namespace
}  // namespace touchstone

#include "touchstone/contact_core/edge_face/edge_face.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone {
namespace {

Pose at(double x, double y = 0, double z = 0) { return {Matrix3::Identity(), {x, y, z}}; }

PairStatus check(const std::vector<Hexahedron>& solids, const std::vector<Pose>& poses) {
  BackendRegistry registry;
  register_core(registry);
  const auto backend = registry.make_narrowphase("edge_face");
  backend->build(solids);
  const auto workspace = backend->make_workspace();
  const std::vector<SolidPair> pairs = {{0, 1}};
  std::vector<PairStatus> status(1, PairStatus::failed);
  backend->evaluate({pairs, poses, {}}, {status, {}, {}}, *workspace);
  return status[0];
}

PairStatus check_boxes(const Vector3& size_a, const Vector3& size_b, const Pose& X_WA, const Pose& X_WB) {
  return check({Hexahedron::from_size(size_a), Hexahedron::from_size(size_b)}, {X_WA, X_WB});
}

const Vector3 kCube(1, 1, 1);

TEST(EdgeFace, SeesCrossingBoxesAndLeavesThoseApart) {
  EXPECT_EQ(check_boxes(kCube, kCube, at(0), at(0.9, 0.3, 0.2)), PairStatus::overlapping);
  EXPECT_EQ(check_boxes(kCube, kCube, at(0), at(1.1, 0.3, 0.2)), PairStatus::separated);
  EXPECT_EQ(check_boxes({3, 1, 1}, {1, 3, 0.5}, at(0), at(0, 0, 0)), PairStatus::overlapping);
}

TEST(EdgeFace, AnEndpointOnAFaceCountsAsTIsInclusive) {
  EXPECT_EQ(check_boxes(kCube, {0.5, 0.5, 0.5}, at(0), at(0.75, 0, 0)), PairStatus::overlapping);
}

TEST(EdgeFace, ACrossingOnAnEdgeCountsAsZeroCrossProductsAreInside) {
  // The long box's edges along x pass exactly through edges of the cube's faces.
  EXPECT_EQ(check_boxes(kCube, {3, 1, 1}, at(0), at(0, 0.5, 0.5)), PairStatus::overlapping);
}

TEST(EdgeFace, BlindSpotContainmentIsMissed) {
  EXPECT_EQ(check_boxes(kCube, {0.5, 0.5, 0.5}, at(0), at(0)), PairStatus::separated);
}

TEST(EdgeFace, BlindSpotSpheresThatJustTouchAreApart) {
  // Two cubes corner to corner: the spheres meet in that very corner.
  EXPECT_EQ(check_boxes({2, 2, 2}, {2, 2, 2}, at(0), at(2, 2, 2)), PairStatus::separated);
}

TEST(EdgeFace, TakesAPyramidWhoseCollapsedFaceHasNoPlane) {
  std::vector<Vector3> pyramid;
  for (int i = 0; i < 8; ++i)
    pyramid.push_back(i & 1 ? Vector3(0, 0, 1) : Vector3(i & 4 ? 1 : -1, i & 2 ? 1 : -1, -1));
  const Hexahedron solid = Hexahedron::from_vertices(pyramid);
  EXPECT_EQ(check({solid, Hexahedron::from_size({0.1, 0.1, 4})}, {at(0), at(0.2, 0.3, 0)}),
            PairStatus::overlapping);
}

TEST(EdgeFace, AnswersOverlapOnly) {
  BackendRegistry registry;
  register_core(registry);
  const auto backend = registry.make_narrowphase("edge_face");
  EXPECT_FALSE(backend->capabilities().overlap_complete);
  EXPECT_FALSE(backend->capabilities().distance);
  const std::vector<Hexahedron> solids(2, Hexahedron::from_size(kCube));
  backend->build(solids);
  const std::vector<SolidPair> pairs = {{0, 1}};
  const std::vector<Pose> poses = {at(0), at(0.9)};
  for (QueryKind kind : {QueryKind::distance, QueryKind::manifold}) {
    std::vector<PairStatus> status(1);
    std::vector<PairGeometry> geometry(1);
    std::vector<ContactPoint> points(8);
    backend->evaluate({pairs, poses, {.kind = kind}}, {status, geometry, points}, *backend->make_workspace());
    EXPECT_EQ(status[0], PairStatus::unsupported);
    EXPECT_TRUE(std::isnan(geometry[0].separation));
    EXPECT_TRUE(std::isnan(geometry[0].n_AB_W.x()));
    EXPECT_TRUE(std::isnan(geometry[0].p_B_W.z()));
    EXPECT_EQ(geometry[0].point_count, 0);
  }
}

// A hit is a common point, to rounding.
TEST(EdgeFace, HasNoPhantomsAndIsSymmetricOnRandomBoxes) {
  std::mt19937_64 random(6);
  int hits = 0;
  for (int i = 0; i < 3000; ++i) {
    const Pose X_WA = random_pose(random, 1), X_WB = random_pose(random, 1);
    const PairStatus found = check_boxes({1, 0.6, 0.8}, {0.7, 1.2, 0.4}, X_WA, X_WB);
    EXPECT_EQ(found, check_boxes({0.7, 1.2, 0.4}, {1, 0.6, 0.8}, X_WB, X_WA));
    if (found != PairStatus::overlapping) continue;
    ++hits;
    // Separating axes of two boxes: no axis may part them.
    WorldVertices a, b;
    world_vertices(Hexahedron::from_size({1, 0.6, 0.8}), X_WA, a);
    world_vertices(Hexahedron::from_size({0.7, 1.2, 0.4}), X_WB, b);
    const auto parted = [&](const Vector3& axis) {
      double high_a = -1e9, low_a = 1e9, high_b = -1e9, low_b = 1e9;
      for (int k = 0; k < 8; ++k) {
        const double ha = dot(axis, a.vertex(k)), hb = dot(axis, b.vertex(k));
        high_a = std::max(high_a, ha), low_a = std::min(low_a, ha);
        high_b = std::max(high_b, hb), low_b = std::min(low_b, hb);
      }
      return low_b > high_a + 1e-14 || low_a > high_b + 1e-14;
    };
    for (int m = 0; m < 3; ++m) {
      EXPECT_FALSE(parted(X_WA.R.col(m)));
      EXPECT_FALSE(parted(X_WB.R.col(m)));
      for (int n = 0; n < 3; ++n) EXPECT_FALSE(parted(cross(X_WA.R.col(m), X_WB.R.col(n))));
    }
  }
  EXPECT_GT(hits, 300);
}

TEST(EdgeFace, TakesWarpedSolids) {
  std::vector<Vector3> vertices;
  for (int i = 0; i < 8; ++i) vertices.emplace_back(i & 4 ? 1 : -1, i & 2 ? 1 : -1, i & 1 ? 1 : -1);
  vertices[7] = {1.3, 1.3, 1.3};
  const Hexahedron warped = Hexahedron::from_vertices(vertices, WarpPolicy::accept);
  EXPECT_EQ(check({warped, Hexahedron::from_size(kCube)}, {at(0), at(1.2, 0.1, 0.2)}),
            PairStatus::overlapping);
  EXPECT_EQ(check({warped, Hexahedron::from_size(kCube)}, {at(0), at(1.9, 0.1, 0.2)}), PairStatus::separated);
}

}  // namespace
}  // namespace touchstone

#include "touchstone/adapters/robots/enclosing_box.hpp"

#include <gtest/gtest.h>

#include <random>

#include "touchstone/contact_core/numerics/exact_predicates.hpp"

namespace touchstone {
namespace {

/// A block of the given size, turned and moved.
TriangleMesh block(const Vector3& size, const Pose& X) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back(
        transform(X, Vector3((i >> 2 & 1) - 0.5, (i >> 1 & 1) - 0.5, (i & 1) - 0.5).cwiseProduct(size)));
  for (const auto& face : Hexahedron::kFaceVertices) {
    mesh.triangles.push_back({face[0], face[1], face[2]});
    mesh.triangles.push_back({face[0], face[2], face[3]});
  }
  return mesh;
}

/// Asked of the predicate on hulls, which the search for the box does not use.
bool holds(const MeshCover& cover, const TriangleMesh& mesh) {
  WorldVertices box;
  world_vertices(cover.solids[0].solid, cover.solids[0].X_OS, box);
  for (const Vector3& v : mesh.vertices) {
    WorldVertices point;
    point.x.fill(v.x()), point.y.fill(v.y()), point.z.fill(v.z());
    if (!numerics::hulls_intersect(box, point)) return false;
  }
  return true;
}

double volume(const MeshCover& cover) {
  const Vector3 h = cover.solids[0].solid.half_extents();
  return 8.0 * h.x() * h.y() * h.z();
}

TEST(EnclosingBox, ATurnedBlocksBoxIsItself) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(-3.0, 3.0), metre(-20.0, 20.0);
  for (int i = 0; i < 200; ++i) {
    Vector6 position;
    for (int k = 0; k < 6; ++k) position[k] = k < 3 ? metre(random) : angle(random);
    const TriangleMesh mesh = block({0.3, 1.1, 2.0}, pose_from_position_vector(position));
    const MeshCover cover = enclosing_box(mesh, "block");
    EXPECT_TRUE(holds(cover, mesh));
    EXPECT_LT(volume(cover), 1.02 * 0.3 * 1.1 * 2.0);  // the search stops where 1 % is left to gain
  }
}

TEST(EnclosingBox, ABlockAlongTheAxesKeepsThem) {
  const MeshCover cover = enclosing_box(block({1, 2, 3}, {Matrix3::Identity(), {5, 6, 7}}), "block");
  EXPECT_EQ(cover.solids[0].X_OS.R, Matrix3::Identity());
  EXPECT_LT(volume(cover), 6.0 + 1e-12);
}

TEST(EnclosingBox, RandomCloudsAreHeldAtEveryScale) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (const double scale : {1e-6, 1.0, 1e5})
    for (int i = 0; i < 50; ++i) {
      TriangleMesh mesh;
      for (std::uint32_t k = 0; k < 30; ++k) {
        mesh.vertices.push_back(scale * (Vector3(normal(random), 3.0 * normal(random), 0.1 * normal(random)) +
                                         Vector3(40, 0, 9)));
        if (k >= 2) mesh.triangles.push_back({k - 2, k - 1, k});
      }
      EXPECT_TRUE(holds(enclosing_box(mesh, "cloud"), mesh)) << scale;
    }
}

TEST(EnclosingBox, ASheetIsHeld) {
  TriangleMesh sheet{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  const MeshCover cover = enclosing_box(sheet, "sheet");
  EXPECT_TRUE(holds(cover, sheet));
  EXPECT_LT(cover.error, 0.13);  // half a cell's diagonal: cells are 1/12 m
}

TEST(EnclosingBox, TheErrorIsNoLessThanAnySampledPoints) {
  // An L: the box's free corner is 0.7 m from it, along the diagonal of the notch.
  TriangleMesh mesh = block({1.0, 0.01, 0.5}, {Matrix3::Identity(), {0.5, 0.0, 0.0}});
  const TriangleMesh other = block({0.01, 1.0, 0.5}, {Matrix3::Identity(), {0.0, 0.5, 0.0}});
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& t : other.triangles) mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  const MeshCover cover = enclosing_box(mesh, "L");
  EXPECT_TRUE(holds(cover, mesh));
  const double worst = cover.solids[0].X_OS.R == Matrix3::Identity() ? 0.99 : 0.49;
  EXPECT_GE(cover.error, worst);
  EXPECT_LE(cover.error, 1.2);
}

}  // namespace
}  // namespace touchstone

// Whether points and tetrahedra are in the solid that a mesh bounds, and how far a hexahedron reaches out of
// it.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include "touchstone/contact_core/fit/excess.hpp"
#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/tests/fit/meshes.hpp"
#include "touchstone/tests/fit/random_shells.hpp"

namespace touchstone {
namespace {

using test::append;
using test::box_mesh;
using test::box_vertices;
using test::tube_mesh;

TEST(MeshDistance, KnowsOutsideSurfaceAndInside) {
  const MeshDistance box(weld(box_mesh({0, 0, 0}, {2, 2, 2})));
  EXPECT_NEAR(box.signed_distance({3, 1, 1}), 1.0, 1e-15);
  EXPECT_NEAR(box.signed_distance({3, 3, 1}), std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(box.signed_distance({1.5, 1, 1}), -0.5, 1e-15);
  EXPECT_EQ(box.to_solid({1, 1, 1}), 0.0);
}

TEST(MeshDistance, ATriangleWithTwoCornersInOnePlaceIsItsEdge) {
  const Vector3 a(0, 0, 0), b(1, 0, 0), p(0.5, 2, 0);
  for (const TriangleMesh& mesh :
       {TriangleMesh{{a, a, b}, {{0, 1, 2}}}, TriangleMesh{{a, b, a}, {{0, 1, 2}}},
        TriangleMesh{{b, a, a}, {{0, 1, 2}}}, TriangleMesh{{a, b, b}, {{0, 1, 2}}}})
    EXPECT_EQ(MeshDistance(mesh).to_triangle(p, 0), 2.0);
}

TEST(MeshDistance, ShellsMayOverlapBeCavitiesOrStandInsideOut) {
  TriangleMesh overlapping = box_mesh({0, 0, 0}, {2, 2, 2});
  append(overlapping, box_mesh({1, 1, 1}, {3, 3, 3}));
  EXPECT_TRUE(MeshDistance(weld(overlapping)).is_inside({1.5, 1.51, 1.52}));

  TriangleMesh inverted = box_mesh({1, 1, 1}, {2, 2, 2});
  for (auto& t : inverted.triangles) std::swap(t[1], t[2]);
  EXPECT_TRUE(MeshDistance(weld(inverted)).is_inside({1.5, 1.51, 1.52}));
  append(inverted, box_mesh({0, 0, 0}, {3, 3, 3}));
  EXPECT_FALSE(MeshDistance(weld(inverted)).is_inside({1.5, 1.51, 1.52}));
}

// Counts the random tetrahedra of a size in a cube that are called solid; points of these are inside.
std::size_t solid_of_random(const MeshDistance& mesh, std::mt19937_64& engine, int tries, double cube,
                            double size) {
  const auto next = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  std::size_t solid = 0;
  for (int i = 0; i < tries; ++i) {
    const Vector3 at(cube * next(), cube * next(), cube * next());
    std::array<Vector3, 4> t;
    for (Vector3& p : t) p = at + size * Vector3(next() - 0.5, next() - 0.5, next() - 0.5);
    if (!mesh.is_solid(t)) continue;
    ++solid;
    for (int k = 0; k < 60; ++k) {
      const std::array<double, 4> w = {next(), next(), next(), next()};
      const double sum = w[0] + w[1] + w[2] + w[3];
      EXPECT_TRUE(mesh.is_inside((w[0] * t[0] + w[1] * t[1] + w[2] * t[2] + w[3] * t[3]) / sum)) << i;
    }
  }
  return solid;
}

// Walls of shells within others: a tetrahedron that they cut is solid all the same, and never where a point
// of it is outside or in a cavity.
TEST(MeshDistance, ATetrahedronAcrossInnerWallsIsSolid) {
  TriangleMesh post = box_mesh({0, 0, 0}, {2, 2, 2});
  append(post, box_mesh({0.5, 0.5, 0.5}, {1, 1, 4}));
  const MeshDistance mesh(weld(post));
  EXPECT_TRUE(mesh.is_solid({Vector3(0.4, 0.7, 0.9), {1.1, 0.71, 0.9}, {0.7, 0.6, 1.2}, {0.7, 0.9, 1.3}}));
  EXPECT_TRUE(mesh.is_solid({Vector3(0.7, 0.7, 1.9), {0.8, 0.7, 1.9}, {0.7, 0.8, 1.9}, {0.7, 0.7, 2.3}}));
  EXPECT_FALSE(mesh.is_solid({Vector3(0.4, 0.7, 1.9), {0.8, 0.7, 1.9}, {0.7, 0.8, 1.9}, {0.4, 0.7, 2.3}}));

  std::mt19937_64 engine(2718);
  const auto next = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  std::size_t solid = 0;
  for (int round = 0; round < 40; ++round) {
    TriangleMesh blocks;
    for (int i = 0; i < 5; ++i) {
      const Vector3 low(next(), next(), next()), size(0.3 + next(), 0.3 + next(), 0.3 + next());
      TriangleMesh block = box_mesh(low, low + size);
      if (i == 4 && round % 2 == 0)  // a cavity, where it is within one of them
        for (auto& t : block.triangles) std::swap(t[1], t[2]);
      append(blocks, block);
    }
    solid += solid_of_random(MeshDistance(weld(blocks)), engine, 500, 2.0, 0.5);
  }
  EXPECT_GT(solid, 1000U);
}

// Flush walls of two shells are passed at once: the point behind both is in two shells, and that before them
// in none.
TEST(MeshDistance, ATetrahedronAcrossFlushWallsIsNotSolid) {
  TriangleMesh flush = box_mesh({0, 0, 0}, {2.6, 4, 4});
  append(flush, box_mesh({1, 0, 0}, {2.6, 4, 4}));
  const std::array<Vector3, 4> across = {Vector3(2, 2, 2), {3.2, 2, 2}, {2, 2.5, 2}, {2, 2, 2.5}};
  EXPECT_FALSE(MeshDistance(weld(flush)).is_solid(across));
  TriangleMesh twice = box_mesh({0, 0, 0}, {2.6, 4, 4});
  append(twice, box_mesh({0, 0, 0}, {2.6, 4, 4}));
  EXPECT_FALSE(MeshDistance(weld(twice)).is_solid(across));
  // Of one within the other, two triangles of its wall are one.
  TriangleMesh behind = box_mesh({0, 0, 0}, {4, 4, 4});
  append(behind, box_mesh({1, 0, 0}, {2.6, 4, 4}));
  EXPECT_TRUE(MeshDistance(weld(behind)).is_solid(across));
}

// Blocks on a grid, some of them twice: many walls are flush.
TEST(MeshDistance, ATetrahedronAcrossWallsOnAGridIsSolidOnlyWhereAllOfItIs) {
  std::mt19937_64 engine(161803);
  const auto step = [&](int most) {
    return 0.25 * static_cast<double>(1 + engine() % static_cast<unsigned>(most));
  };
  std::size_t solid = 0;
  for (int round = 0; round < 60; ++round) {
    TriangleMesh blocks;
    for (int i = 0; i < 6; ++i) {
      const Vector3 low(step(4), step(4), step(4)), size(step(5), step(5), step(5));
      TriangleMesh block = box_mesh(low, low + size);
      if (i == 5 && round % 3 == 0)
        for (auto& t : block.triangles) std::swap(t[1], t[2]);
      append(blocks, block);
      if (i % 3 == 0) append(blocks, block);
    }
    solid += solid_of_random(MeshDistance(weld(blocks)), engine, 2500, 2.5, 0.8);
  }
  EXPECT_GT(solid, 1000U);
}

// Corners are at random, on corners of the mesh, or near to the middle of a triangle.
TEST(MeshDistance, ATetrahedronInCrossingShellsIsSolidOnlyWhereAllOfItIs) {
  std::size_t solid = 0;
  for (std::uint64_t round = 0; round < 300; ++round) {
    test::RandomShells random(7000 + round);
    const MeshDistance mesh(weld(random.mesh()));
    const auto any_of = [&](std::size_t count) {
      return static_cast<std::size_t>(random.next() * static_cast<double>(count));
    };
    for (int k = 0; k < 150; ++k) {
      // A tetrahedron: each corner at a vertex, near the middle of a triangle, or anywhere.
      const Vector3 centre = random.within(mesh.bounds().low, mesh.bounds().high);
      const double size = random.next() * random.next();
      std::array<Vector3, 4> t;
      for (Vector3& p : t) {
        const std::size_t how = any_of(4);
        const auto& corners = mesh.mesh().triangles[any_of(mesh.mesh().triangles.size())];
        if (how == 0) p = mesh.mesh().vertices[corners[0]];
        if (how == 1)
          p = 0.5 * centre + (mesh.mesh().vertices[corners[0]] + mesh.mesh().vertices[corners[1]] +
                              mesh.mesh().vertices[corners[2]]) /
                                 6.0;
        if (how > 1) p = centre + size * (random.within({0, 0, 0}, {1, 1, 1}) - Vector3::Constant(0.5));
      }
      if (!mesh.is_solid(t)) continue;
      ++solid;
      // No point of a solid one is outside by the winding number, where that is certain.
      for (int i = 0; i < 20; ++i) {
        std::array<double, 4> w{};
        for (double& each : w) each = random.next() * (random.one_in(3) ? 0.02 : 1.0);
        const Vector3 p =
            (w[0] * t[0] + w[1] * t[1] + w[2] * t[2] + w[3] * t[3]) / (w[0] + w[1] + w[2] + w[3]);
        const double winding = test::winding_by_angles(mesh.mesh(), p);
        if (std::abs(winding - std::round(winding)) > 0.01) continue;
        EXPECT_NE(std::round(winding), 0.0) << "round " << round << ", tetrahedron " << k;
      }
    }
  }
  EXPECT_GT(solid, 500U);
}

TEST(MeshDistance, TheWindingNumberNearAKnownPointIsThatOfARay) {
  std::size_t changed = 0;
  for (std::uint64_t round = 0; round < 200; ++round) {
    test::RandomShells random(9000 + round);
    const MeshDistance mesh(weld(random.mesh()));
    for (int k = 0; k < 200; ++k) {
      const auto point = [&] { return random.within(mesh.bounds().low, mesh.bounds().high); };
      // Grids make points on surfaces, edges and corners, and ways along axes.
      const auto on_grid = [&](Vector3 p) {
        return random.one_in(2) ? p : Vector3((4.0 * p).array().round() / 4.0);
      };
      const Vector3 known = on_grid(point()), p = on_grid(known + 0.5 * random.next() * (point() - known));
      const MeshDistance::Known there{known, mesh.nearest(known).distance, mesh.winding(known)};
      if (mesh.nearest(p).distance < 1e-6) continue;
      EXPECT_EQ(mesh.winding_near(there, p), mesh.winding(p)) << "round " << round << ", point " << k;
      changed += there.winding != mesh.winding(p) ? 1 : 0;
    }
  }
  EXPECT_GT(changed, 1000U);
}

TEST(Excess, IsTheLargestDistanceNotOnlyOnTheSurface) {
  const MeshDistance box(weld(box_mesh({0, 0, 0}, {2, 2, 2})));
  const ExcessBound larger = bound_excess(box, box_vertices({-0.5, 0, 0}, {2, 2, 2.25}), 1e-3);
  EXPECT_GE(larger.most, std::sqrt(0.25 + 0.0625));
  EXPECT_LE(larger.most, std::sqrt(0.25 + 0.0625) + 1.1e-3);

  // The middle of a tube that is filled is farthest, and lies inside of the hexahedron.
  const MeshDistance tube(weld(tube_mesh(0.5, 0.6, 1.0, 64)));
  const ExcessBound filled = bound_excess(tube, box_vertices({-0.4, -0.4, 0}, {0.4, 0.4, 1}), 1e-3);
  EXPECT_NEAR(filled.most, 0.5 * std::cos(std::numbers::pi / 64), 2e-3);
}

}  // namespace
}  // namespace touchstone

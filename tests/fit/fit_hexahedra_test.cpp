#include <algorithm>
#include <cstdint>
#include <random>

#include "touchstone/contact_core/fit/excess.hpp"
#include "touchstone/contact_core/fit/fit.hpp"
#include "touchstone/contact_core/fit/parts/prisms.hpp"
#include "touchstone/contact_core/fit/parts/sectors.hpp"
#include "touchstone/contact_core/fit/round_parts.hpp"
#include "touchstone/contact_core/fit/search/accepted_solids.hpp"
#include "touchstone/contact_core/fit/search/cells.hpp"
#include "touchstone/contact_core/fit/search/pool.hpp"
#include "touchstone/contact_core/fit/search/set_cover.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/fit/meshes.hpp"
#include "touchstone/tests/fit/random_shells.hpp"

namespace touchstone {
namespace {

using test::angle_mesh;
using test::append;
using test::box_mesh;
using test::box_vertices;
using test::cone_mesh;
using test::tube_mesh;

FitOptions within(double over) {
  FitOptions options;
  options.over = over;
  options.repairs = 3;
  return options;
}

// Runs of 11 among 120 in a row, all of them to begin with: 11 runs need 120 of the 121 that they can hold.
TEST(FewerSets, HoldEverythingByFewest) {
  constexpr std::uint32_t kElements = 120, kLength = 11;
  std::vector<std::vector<std::uint32_t>> sets;
  std::vector<std::size_t> all;
  for (std::uint32_t first = 0; first + kLength <= kElements; ++first) {
    all.push_back(sets.size());
    for (sets.emplace_back(); sets.back().size() < kLength;)
      sets.back().push_back(first + static_cast<std::uint32_t>(sets.back().size()));
  }
  const std::vector<std::size_t> fewest = fit::fewer_sets(sets, kElements, all, 20'000'000);
  EXPECT_EQ(fewest.size(), 11U);
  std::vector<bool> is_held(kElements, false);
  for (const std::size_t s : fewest)
    for (const std::uint32_t e : sets[s]) is_held[e] = true;
  EXPECT_EQ(std::count(is_held.begin(), is_held.end(), true), kElements);
  EXPECT_EQ(fit::fewer_sets(sets, kElements, all, 0), all);
}

TEST(FewerSets, NoCoverHasFewerThanElementsThatNoTwoSetsShare) {
  // Two sets hold all; elements 0 and 3 are in no common one.
  const std::vector<std::vector<std::uint32_t>> two = {{0, 1}, {1, 2}, {2, 3}, {0}, {3}};
  EXPECT_EQ(fit::least_sets(two, 4), 2U);
  // Any two elements share a set, and yet no two sets hold all: the bound stays below.
  const std::vector<std::vector<std::uint32_t>> ring = {{0, 1}, {1, 2}, {2, 0}};
  EXPECT_EQ(fit::least_sets(ring, 3), 1U);
  // Where the bound is met the search ends, though it has leave to work for an hour.
  EXPECT_EQ(fit::fewer_sets(two, 4, {0, 2}, 1'000'000'000'000), (std::vector<std::size_t>{0, 2}));
}

// Against counting each cell of each candidate, while candidates come, cells are covered and one is
// forgotten.
TEST(OpenCells, CountWhatEachCandidateHoldsOfThem) {
  constexpr std::size_t kCells = 300;
  std::mt19937_64 random(11);
  fit::CandidatePool pool(kCells);
  std::vector<std::vector<std::uint32_t>> cells_of;
  const auto add = [&] {
    std::vector<std::uint32_t> cells;
    for (std::uint32_t cell = static_cast<std::uint32_t>(random() % 200); cell < kCells && cells.size() < 90;
         cell += 1 + static_cast<std::uint32_t>(random() % 5))
      cells.push_back(cell);
    pool.add(fit::Candidate({}, cells));
    cells_of.push_back(cells);
  };
  for (int i = 0; i < 60; ++i) add();
  pool.forget(7);
  cells_of[7].clear();
  fit::CellBits all((kCells + 63) / 64, 0);
  std::vector<bool> is_open(kCells, true);
  for (std::size_t cell = 0; cell < kCells; ++cell) fit::set(all, cell);
  fit::OpenCells open(pool, all);
  const auto gain = [&](const std::vector<std::uint32_t>& cells) {
    return static_cast<std::size_t>(
        std::count_if(cells.begin(), cells.end(), [&](std::uint32_t cell) { return is_open[cell]; }));
  };
  for (;;) {
    add();
    ASSERT_EQ(pool.size(), cells_of.size());
    const auto first = std::max_element(cells_of.begin(), cells_of.end(), [&](const auto& a, const auto& b) {
      return gain(a) < gain(b);
    });  // of equal ones the first
    const fit::OpenCells::Best best = open.best();
    ASSERT_EQ(best.gain, gain(*first));
    ASSERT_EQ(open.count(), static_cast<std::size_t>(std::count(is_open.begin(), is_open.end(), true)));
    if (best.gain == 0) break;
    ASSERT_EQ(best.index, static_cast<std::size_t>(first - cells_of.begin()));
    const std::size_t cell = open.next_from(random() % kCells, kCells);
    EXPECT_TRUE(is_open[cell]);
    const fit::OpenCells::Best at = open.best_at(cell);
    const std::vector<std::uint32_t>& held = cells_of[at.index];
    EXPECT_TRUE(at.gain == 0 || (at.gain == gain(held) && std::count(held.begin(), held.end(), cell) == 1));
    open.cover(pool[best.index]);
    for (const std::uint32_t i : cells_of[best.index]) is_open[i] = false;
  }
}

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

TEST(Fit, ABoxIsOneHexahedron) {
  const Fit fit = fit_hexahedra(box_mesh({1, 2, 3}, {2, 4, 6}), within(0.05));
  ASSERT_EQ(fit.hexahedra.size(), 1U);
  EXPECT_LE(fit.excess, 0.05 / 16);
  EXPECT_GE(fit.excess, 0.0);
}

// Walls are not looked at place by place; before that this took more than ten minutes and 3.8 GB. What two
// hexahedra share goes where it fits: what is left is the cell at the inner edge.
TEST(Fit, AnAngleIsItsTwoLegsAtAThreeHundredthOfItsSize) {
  for (const double angle : {0.0, 0.4}) {
    TriangleMesh mesh = angle_mesh();
    const double c = std::cos(angle), s = std::sin(angle);
    for (Vector3& p : mesh.vertices) p = Vector3(c * p.x() - s * p.z(), p.y(), s * p.x() + c * p.z());
    const Fit fit = fit_hexahedra(mesh, within(0.01));
    ASSERT_EQ(fit.hexahedra.size(), 2U) << angle;
    EXPECT_LE(fit.excess, 0.6 * 0.01) << angle;
  }
}

TEST(Fit, AnAngleIsTwoAndATurnedOneToo) {
  EXPECT_EQ(fit_hexahedra(angle_mesh(), within(0.2)).hexahedra.size(), 2U);
  TriangleMesh turned = angle_mesh();
  const double c = 0.8, s = 0.6;
  for (Vector3& p : turned.vertices) p = Vector3(c * p.x() - s * p.z(), p.y(), s * p.x() + c * p.z());
  const Fit fit = fit_hexahedra(turned, within(0.2));
  EXPECT_EQ(fit.hexahedra.size(), 2U);
  EXPECT_LE(fit.excess, 0.2);
}

// Blocks that overlap, turned about z.
TriangleMesh random_blocks(int count, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const auto next = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  TriangleMesh blocks;
  for (int i = 0; i < count; ++i) {
    Vector3 low, size;
    for (int axis = 0; axis < 3; ++axis) {
      low(axis) = 3.0 * next();
      size(axis) = 0.2 + (axis < 2 ? 1.5 : 0.3) * next();
    }
    TriangleMesh block = box_mesh(low, low + size);
    const double angle = std::numbers::pi * next(), c = std::cos(angle), s = std::sin(angle);
    for (Vector3& p : block.vertices) p = Vector3(c * p.x() - s * p.y(), s * p.x() + c * p.y(), p.z());
    append(blocks, block);
  }
  return blocks;
}

// With as many repairs as asked and no more these take 15 and 14.
TEST(Fit, WhereRepairsCostLittleThereAreMoreOfThem) {
  std::size_t hexahedra = 0;
  for (const std::uint64_t seed : {1, 2}) {
    const MeshDistance blocks(weld(random_blocks(14, seed)));
    FitOptions options = within(0.05 * blocks.bounds().diagonal());
    options.repairs = 1;
    hexahedra += fit_hexahedra(blocks, options).hexahedra.size();
  }
  EXPECT_LE(hexahedra, 27U);
}

TEST(Fit, OfSeveralTriesTheFewestHexahedraCount) {
  const MeshDistance blocks(weld(random_blocks(8, 3)));
  FitOptions options = within(0.1 * blocks.bounds().diagonal());
  options.repairs = 2;
  const std::size_t one = fit_hexahedra(blocks, options).hexahedra.size();
  options.tries = 3;
  const Fit fit = fit_hexahedra(blocks, options);
  EXPECT_LE(fit.excess, options.over);
  EXPECT_LT(fit.hexahedra.size(), one);
}

TEST(Fit, KeepsToItsErrorAndToARegionsSmallerOne) {
  const TriangleMesh tube = tube_mesh(0.3, 0.6, 0.5, 48);
  FitOptions options = within(0.15);
  const Fit coarse = fit_hexahedra(tube, options);
  EXPECT_LE(coarse.excess, 0.15);
  options.regions.push_back({"bore", {Vector3(-0.3, -0.3, 0), Vector3(0.3, 0.3, 0.5)}, 0.05});
  const Fit open = fit_hexahedra(tube, options);
  EXPECT_LE(open.excess, 0.15);
  ASSERT_EQ(open.region_excess.size(), 1U);
  EXPECT_LE(open.region_excess[0], 0.05);
  EXPECT_GT(coarse.excess, 0.05);  // the region is what keeps it
}

/// A rod of `facets` facets from the origin along an axis of no mesh's frame.
TriangleMesh slanted_rod(double radius, double length, int facets) {
  const TriangleMesh tube = tube_mesh(0.5 * radius, radius, length, facets);
  TriangleMesh rod;
  const auto place = [&](double x, double y, double z) {
    const Vector3 axis = Vector3(2, 3, 6) / 7.0, u = Vector3(3, -6, 2) / 7.0, v = Vector3(6, 2, -3) / 7.0;
    return Vector3(x * u + y * v + z * axis);
  };
  const auto at = [&](int i, double z) {
    const double angle = 2.0 * std::numbers::pi * (i % facets) / facets;
    return place(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  for (int i = 0; i < facets; ++i) {
    test::append_quad(rod, at(i, 0), at(i + 1, 0), at(i + 1, length), at(i, length));
    if (i == 0 || i == facets - 1) continue;
    append(rod, {{at(0, 0), at(i + 1, 0), at(i, 0)}, {{0, 1, 2}}});
    append(rod, {{at(0, length), at(i, length), at(i + 1, length)}, {{0, 1, 2}}});
  }
  return rod;
}

// Before these took more than a minute, and four hexahedra along an axis of the mesh.
TEST(Fit, ARodAlongNoAxisTakesSlabsOfAPolygonAboutIt) {
  const MeshDistance rod(weld(slanted_rod(0.05, 0.8, 24)));
  ASSERT_EQ(fit::find_prisms(rod, 0.005).size(), 1U);
  // Eight tangents leave 4.1 mm at their corners: (8 - 2) / 2 slabs. Twelve leave 1.8 mm; between the levels
  // of 24 facets it takes two more.
  const std::array<std::pair<double, std::size_t>, 2> fewest = {{{0.005, 3}, {0.002, 7}}};
  for (const auto& [over, count] : fewest) {
    const Fit fit = fit_hexahedra(rod, within(over));
    EXPECT_LE(fit.hexahedra.size(), count) << over;
    EXPECT_LE(fit.excess, over);
    for (const FittedHexahedron& each : fit.hexahedra)
      EXPECT_LE(bound_excess(rod, each.vertices, over / 16.0).least, each.excess) << over;
  }
}

TEST(Prisms, AreShellsThatNothingIsCutFrom) {
  const auto count = [](const TriangleMesh& mesh) {
    return fit::find_prisms(MeshDistance(weld(mesh)), 1e-3).size();
  };
  TriangleMesh two = box_mesh({0, 0, 0}, {1, 1, 1});
  append(two, box_mesh({0.5, 0.5, 0.5}, {2, 0.7, 0.7}));
  EXPECT_EQ(count(two), 2U);
  EXPECT_EQ(count(angle_mesh()), 2U);  // both its steps
  EXPECT_EQ(count(tube_mesh(0.1, 0.2, 0.5, 12)), 0U);
  // A box that a cavity may be in is none, nor one that a millimetre is much of.
  TriangleMesh hollow = box_mesh({0.2, 0.2, 0.2}, {0.8, 0.8, 0.8});
  for (auto& t : hollow.triangles) std::swap(t[1], t[2]);
  append(hollow, box_mesh({0, 0, 0}, {1, 1, 1}));
  EXPECT_EQ(count(hollow), 0U);
  EXPECT_EQ(count(box_mesh({0, 0, 0}, {1, 1, 0.007})), 0U);
}

/// Leaning and turned, along no axis of the mesh.
TriangleMesh leaning(TriangleMesh mesh) {
  for (Vector3& p : mesh.vertices) {
    const double x = p.x() + 0.3 * p.z();
    p = Vector3(0.8 * x - 0.6 * p.z() + 1.0, p.y() + 2.0, 0.6 * x + 0.8 * p.z());
  }
  return mesh;
}

TEST(Prisms, MayBeTaperedUpToATipAndLean) {
  const auto narrows = [](const TriangleMesh& mesh) {
    const std::vector<fit::Prism> prisms = fit::find_prisms(MeshDistance(weld(mesh)), 1e-3);
    return prisms.size() == 1 && prisms[0].is_tapered() ? prisms[0].narrows : -1.0;
  };
  EXPECT_NEAR(narrows(cone_mesh(0.08, 0.03, 0.12, 32)), 0.625, 1e-9);
  EXPECT_NEAR(narrows(cone_mesh(0.03, 0.08, 0.12, 32)), 0.625, 1e-9);
  EXPECT_NEAR(narrows(leaning(cone_mesh(0.08, 0.03, 0.12, 32))), 0.625, 1e-9);
  // At a tip slabs keep a width.
  EXPECT_NEAR(narrows(cone_mesh(0.08, 0.0, 0.12, 32)), 1.0 - 0.25e-3 / 0.08, 1e-9);
  // Not so where sides are no planes, or where more than two levels are.
  TriangleMesh bent = cone_mesh(0.08, 0.03, 0.12, 32);
  for (Vector3& p : bent.vertices)
    if (p.z() > 0.06) p = Vector3(0.8 * p.x() - 0.6 * p.y(), 0.6 * p.x() + 0.8 * p.y(), p.z());
  EXPECT_EQ(narrows(bent), -1.0);
  TriangleMesh dented = cone_mesh(0.08, 0.03, 0.12, 32);
  for (Vector3& p : dented.vertices)
    if (norm(p - Vector3(0, 0, 0.12)) < 1e-9) p.z() = 0.1;
  EXPECT_EQ(narrows(dented), -1.0);
}

// Boxes that reach out of a cone by a little less than what is asked.
TEST(Excess, WhatFindBeyondAcceptsIsJudgedToKeepToTheLimit) {
  const MeshDistance cone(weld(leaning(cone_mesh(0.08, 0.03, 0.12, 32))));
  test::RandomShells random(11);
  int left_open = 0;  // by a bound of the same resolution
  for (int i = 0; i < 60; ++i) {
    const Vector3 low = random.within(cone.bounds().low, cone.bounds().high),
                  size = random.within(Vector3::Constant(0.01), Vector3::Constant(0.1));
    const std::array<Vector3, 8> box = box_vertices(low, low + size);
    const double excess = bound_excess(cone, box, 1e-5).most;
    for (const double more : {1e-6, 1e-5, 3e-5}) {
      const double limit = excess + more, resolution = limit / 512.0;
      if (find_beyond(cone, box, limit, resolution)) continue;
      left_open += bound_excess(cone, box, resolution, limit).most > limit ? 1 : 0;
      const ExcessBound judged = judge_excess(cone, box, limit, resolution);
      EXPECT_LE(judged.most, limit) << i;
      EXPECT_LE(judged.least, judged.most) << i;
    }
  }
  EXPECT_GT(left_open, 0);
}

TEST(AcceptedSolids, HoldWhatIsWithinThemThoughItsCornersAreRounded) {
  test::RandomShells random(12);
  int solids = 0, held_exactly = 0;
  while (solids < 200) {
    // Six slanted planes about a point.
    const Vector3 middle = random.within(Vector3::Constant(-3.0), Vector3::Constant(3.0));
    fit::SixPlanes solid;
    for (int f = 0; f < 6; ++f) {
      Vector3 normal = random.within(Vector3::Constant(-0.3), Vector3::Constant(0.3));
      normal(f / 2) += f % 2 == 0 ? -1.0 : 1.0;
      normal /= norm(normal);
      solid.planes[f] = {normal, -dot(normal, middle) - 0.5};
    }
    if (!solid.is_hexahedron()) continue;
    // One plane further in, and one further out.
    fit::SixPlanes smaller = solid, larger = solid;
    smaller.planes[solids % 6].offset += 0.1;
    larger.planes[solids % 6].offset -= 1e-9;
    fit::AcceptedSolids accepted(4.0), exactly(0.0);
    accepted.add(solid), exactly.add(solid);
    EXPECT_TRUE(accepted.holds(solid) && accepted.holds(smaller)) << solids;
    EXPECT_FALSE(accepted.holds(larger)) << solids;
    held_exactly += exactly.holds(smaller) ? 1 : 0;
    ++solids;
  }
  EXPECT_LT(held_exactly, solids / 2);  // what the margin is for
}

// Eight slabs go around 32 facets within a millimetre of a circle of 80. Before it took minutes.
TEST(Fit, AConeTakesTaperedSlabs) {
  for (const double top : {0.03, 0.0}) {
    const MeshDistance cone(weld(leaning(cone_mesh(0.08, top, 0.12, 32))));
    const Fit fit = fit_hexahedra(cone, within(1e-3));
    EXPECT_LE(fit.hexahedra.size(), 15U) << top;
    EXPECT_LE(fit.pieces, 400U) << top;
    EXPECT_LE(fit.excess, 1e-3);
    for (const FittedHexahedron& each : fit.hexahedra)
      EXPECT_LE(bound_excess(cone, each.vertices, 1e-3 / 16.0).least, each.excess) << top;
  }
}

// A grapple fixture on a beam: plate, ring, cone and pin in a region of a small error, and a large one
// elsewhere. Before the pieces were as many as the fixture's surface has squares of the small error.
TEST(Fit, RoundPartsInARegionOfASmallErrorCostWhatTheyTake) {
  TriangleMesh mesh = box_mesh({-2, -0.3, -0.3}, {2, 0.3, 0.3});
  append(mesh, box_mesh({-0.25, -0.25, 0.28}, {0.25, 0.25, 0.32}));
  const auto append_at = [&](TriangleMesh more, double z) {
    for (Vector3& p : more.vertices) p.z() += z;
    append(mesh, more);
  };
  append_at(tube_mesh(0.16, 0.2, 0.05, 32), 0.315);
  append_at(cone_mesh(0.08, 0.03, 0.12, 32), 0.315);
  append_at(cone_mesh(0.015, 0.015, 0.3, 24), 0.4);
  const MeshDistance fixture(weld(mesh));
  FitOptions options = within(0.3);
  options.regions.push_back({"fixture", {Vector3(-0.3, -0.3, 0.3), Vector3(0.3, 0.3, 0.8)}, 0.002});
  const Fit fit = fit_hexahedra(fixture, options);
  EXPECT_LE(fit.region_excess[0], 0.002);
  EXPECT_LE(fit.excess, 0.3);
  EXPECT_LE(fit.pieces, 2000U);
  EXPECT_LE(fit.hexahedra.size(), 50U);
}

TriangleMesh turned_tube(double inner, double outer, double height, int facets) {
  TriangleMesh tube = tube_mesh(inner, outer, height, facets);
  for (Vector3& p : tube.vertices)
    p = Vector3(0.8 * p.x() - 0.6 * p.z() + 1.0, p.y() + 2.0, 0.6 * p.x() + 0.8 * p.z());
  return tube;
}

TEST(RoundParts, ATubeIsAPinAndABore) {
  const std::vector<RoundPart> parts = find_round_parts(MeshDistance(weld(turned_tube(0.1, 0.15, 0.05, 40))));
  ASSERT_EQ(parts.size(), 2U);
  for (const RoundPart& part : parts) {
    EXPECT_NEAR(part.radius, part.is_bore ? 0.1 : 0.15, 1e-12);
    EXPECT_NEAR(part.length, 0.05, 1e-12);
    EXPECT_EQ(part.facets, 40);
    EXPECT_NEAR(std::abs(dot(part.axis, Vector3(-0.6, 0, 0.8))), 1.0, 1e-12);
    EXPECT_NEAR(norm(part.foot - Vector3(1, 2, 0)), 0.0, 1e-9);
  }
  EXPECT_NE(parts[0].is_bore, parts[1].is_bore);
  EXPECT_TRUE(find_round_parts(MeshDistance(weld(angle_mesh()))).empty());
}

// Chords of 30 degrees leave 3.41 mm: fewer than twelve do not go around.
TEST(Fit, ABoreStaysOpenWithAHexahedronASector) {
  const MeshDistance ring(weld(tube_mesh(0.1, 0.15, 0.03, 48)));
  FitOptions options = within(0.02);
  options.repairs = 1;
  for (const RoundPart& part : find_round_parts(ring))
    if (part.is_bore) options.regions.push_back({"bore", part.bounds(), 3.6e-3});
  ASSERT_EQ(options.regions.size(), 1U);
  const Fit fit = fit_hexahedra(ring, options);
  EXPECT_EQ(fit.hexahedra.size(), 12U);
  EXPECT_LE(fit.region_excess[0], 3.6e-3);
  EXPECT_GE(fit.region_excess[0], 0.1 * (1.0 - std::cos(std::numbers::pi / 12)));
}

// Chords of a circle would take 23; there are sixteen facets.
TEST(Fit, ABoreOfFewFacetsIsAHexahedronAFacet) {
  const MeshDistance ring(weld(tube_mesh(0.1, 0.15, 0.03, 16)));
  FitOptions options = within(1e-3);
  options.repairs = 1;
  EXPECT_EQ(fit_hexahedra(ring, options).hexahedra.size(), 16U);
}

// A tube that a slit of one facet's width opens: corners of 48 facets all are on a ring.
TriangleMesh slit_tube(double inner, double outer, double height) {
  TriangleMesh mesh = tube_mesh(inner, outer, height, 48);
  mesh.triangles.resize(mesh.triangles.size() - 8);  // of the last facet
  const auto at = [&](double radius, int i, double z) {
    const double angle = 2.0 * std::numbers::pi * i / 48;
    return Vector3(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  test::append_quad(mesh, at(inner, 0, 0), at(outer, 0, 0), at(outer, 0, height), at(inner, 0, height));
  test::append_quad(mesh, at(inner, 47, height), at(outer, 47, height), at(outer, 47, 0), at(inner, 47, 0));
  return mesh;
}

// A block with a bore, a plate round about the same axis elsewhere, and a key with its eight corners on the
// walls and at the ends of the room between the two.
TriangleMesh block_and_key() {
  TriangleMesh mesh = tube_mesh(0.05, 0.07, 0.05, 48);
  for (Vector3& p : mesh.vertices)
    if (std::hypot(p.x(), p.y()) > 0.06) p = {1.02 * p.x(), p.y(), p.z()};  // this wall is not round
  TriangleMesh plate = cone_mesh(0.1, 0.1, 0.05, 48);
  for (Vector3& p : plate.vertices) p.z() += 0.2;
  append(mesh, plate);
  const auto at = [](double radius, int i, double z) {
    const double angle = 2.0 * std::numbers::pi * i / 48;
    return Vector3(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  TriangleMesh key = box_mesh({0, 0, 0}, {1, 1, 1});
  for (Vector3& p : key.vertices)
    p = at(p.x() > 0.5 ? 0.1 : 0.05, p.y() > 0.5 ? 1 : 0, p.z() > 0.5 ? 0.05 : 0.0);
  append(mesh, key);
  return mesh;
}

bool has_ring(const TriangleMesh& mesh, double over, const std::vector<fit::LimitBox>& boxes = {}) {
  const MeshDistance distance(weld(mesh));
  const fit::AllowedSpace allowed(distance, over, boxes);
  const std::vector<fit::Sectors> sectors =
      fit::sectors_about_bores(distance, find_round_parts(distance), allowed);
  return std::any_of(sectors.begin(), sectors.end(),
                     [](const fit::Sectors& each) { return each.has_shell(); });
}

// Cells of sectors that went across a slit had no cover.
TEST(Sectors, AreOfShellsThatGoAllAround) {
  EXPECT_TRUE(has_ring(tube_mesh(0.05, 0.1, 0.05, 48), 5e-3));
  EXPECT_FALSE(has_ring(slit_tube(0.05, 0.1, 0.05), 5e-3));
  EXPECT_FALSE(has_ring(block_and_key(), 5e-3));
  FitOptions options = within(5e-3);
  options.repairs = 1;
  const Fit fit = fit_hexahedra(slit_tube(0.05, 0.1, 0.05), options);
  EXPECT_LE(fit.excess, 5e-3);
  EXPECT_GE(fit.hexahedra.size(), 7U);
}

// A bore's limit is not the outer wall's: tangents of twelve sectors go 5.3 mm beyond that.
TEST(Sectors, GoAsFarAsEachWallLetsThem) {
  const TriangleMesh tube = tube_mesh(0.1, 0.15, 0.03, 48);
  EXPECT_TRUE(has_ring(tube, 0.02, {{{Vector3(-0.1, -0.05, 0), Vector3(0.1, 0.05, 0.03)}, 3.6e-3}}));
}

// A region in a bore that touches no wall of it: eight sectors' chords go 3.8 mm into the bore, and through
// that.
TEST(Sectors, KeepToARegionInTheBore) {
  const TriangleMesh tube = tube_mesh(0.05, 0.1, 0.05, 64);
  const Bounds in_bore = {Vector3(0.045, -0.002, 0.0), Vector3(0.0495, 0.002, 0.05)};
  EXPECT_TRUE(has_ring(tube, 5e-3));
  EXPECT_FALSE(has_ring(tube, 5e-3, {{in_bore, 2e-4}}));
  FitOptions options = within(5e-3);
  options.repairs = 1;
  options.regions.push_back({"bore", in_bore, 2e-4});
  const Fit fit = fit_hexahedra(tube, options);
  EXPECT_LE(fit.region_excess[0], 2e-4);
  EXPECT_LE(fit.excess, 5e-3);
}

// Of the cavity two millimetres are too far from what is solid: no sample of a sector shows it, but its
// proof.
TEST(Fit, ARingWithACavityIsCutByBoxes) {
  TriangleMesh mesh = tube_mesh(0.05, 0.1, 0.05, 48);
  const Vector3 middle(0.073, 0.0213, 0.0293), half = Vector3::Constant(0.006);
  TriangleMesh cavity = box_mesh(middle - half, middle + half);
  for (auto& t : cavity.triangles) std::swap(t[1], t[2]);
  append(mesh, cavity);
  ASSERT_TRUE(has_ring(mesh, 5e-3));
  FitOptions options = within(5e-3);
  options.repairs = 1;
  EXPECT_LE(fit_hexahedra(mesh, options).excess, 5e-3);
}

// Solids are cut along walls that face the axes, and along their straight edges they are not cut finer: a
// tenth of the error takes hardly more pieces.
TEST(Cells, StraightEdgesCostNoMoreWhereTheErrorIsSmaller) {
  TriangleMesh steps = box_mesh({0, 0, 0}, {1, 1, 0.1});
  append(steps, box_mesh({0, 0, 0.1}, {0.5, 1, 0.2}));
  append(steps, box_mesh({0.1, 0.1, 0.2}, {0.4, 0.9, 0.23}));
  const MeshDistance mesh(weld(steps));
  const auto pieces = [&](double over) {
    const fit::AllowedSpace space(mesh, over, {});
    return fit::Cells(mesh, space, over).size();
  };
  const std::size_t some = pieces(1e-2), more = pieces(1e-3);
  EXPECT_LE(more, some + some / 4) << some;
}

// A region is a box along the mesh's own axes: the search turns it, too. Before such a mesh was cut as it
// stood, at the cost of its slanted edges.
TEST(Fit, AnAngleThatIsTurnedHasRegionsAtTheCostOfOneThatIsNot) {
  TriangleMesh mesh = angle_mesh();
  const double c = 0.8, s = 0.6;
  for (Vector3& p : mesh.vertices) p = Vector3(c * p.x() - s * p.z(), p.y(), s * p.x() + c * p.z());
  FitOptions options = within(0.05);
  options.repairs = 1;
  const Vector3 end(c * 2.0 - s * 0.5, 0.25, s * 2.0 + c * 0.5);
  options.regions.push_back({"end", {end - Vector3::Constant(0.3), end + Vector3::Constant(0.3)}, 0.01});
  const Fit fit = fit_hexahedra(mesh, options), straight = fit_hexahedra(angle_mesh(), within(0.05));
  EXPECT_EQ(fit.hexahedra.size(), 2U);
  ASSERT_EQ(fit.region_excess.size(), 1U);
  EXPECT_LE(fit.region_excess[0], 0.01);
  EXPECT_LE(fit.pieces, 2 * straight.pieces);
}

TEST(Fit, AnOpenSheetIsCoveredByAPlate) {
  TriangleMesh sheet;
  test::append_quad(sheet, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
  const Fit fit = fit_hexahedra(sheet, within(0.02));
  ASSERT_EQ(fit.hexahedra.size(), 1U);
  EXPECT_LE(fit.excess, 0.02);
  EXPECT_EQ(make_tree(fit, "sheet").solids().size(), 1U);
}

// The whole and each region are measured twice: each time a share of all. A jump back or to the end in the
// middle would show.
TEST(Fit, WhatIsMeasuredGoesOnToAll) {
  FitOptions options = within(0.05);
  options.regions.push_back({"leg", {Vector3(1.0, -1, -1), Vector3(3, 1, 2)}, 0.02});
  options.regions.push_back({"other", {Vector3(-1, 1.0, -1), Vector3(1, 3, 2)}, 0.02});
  std::vector<double> shares;
  options.progress = [&](std::string_view stage, double share) {
    if (stage == "measure") shares.push_back(share);
  };
  const Fit fit = fit_hexahedra(angle_mesh(), options);
  ASSERT_GE(shares.size(), 2 * fit.hexahedra.size() + 4);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_EQ(std::count(shares.begin(), shares.end(), 1.0), 1);
  EXPECT_EQ(shares.back(), 1.0);
}

TEST(Fit, TheSameMeshGivesTheSameBits) {
  const Fit a = fit_hexahedra(angle_mesh(), within(0.2)), b = fit_hexahedra(angle_mesh(), within(0.2));
  ASSERT_EQ(a.hexahedra.size(), b.hexahedra.size());
  for (std::size_t i = 0; i < a.hexahedra.size(); ++i)
    EXPECT_EQ(a.hexahedra[i].vertices, b.hexahedra[i].vertices);
}

TEST(Fit, ACountIsKeptWithLessErrorForMore) {
  const TriangleMesh tube = tube_mesh(0.3, 0.6, 0.5, 8);
  FitOptions options = within(0.4);
  options.repairs = 0;
  double two = 0.0, four = 0.0;
  EXPECT_LE(fit_count(tube, 2, options, &two).hexahedra.size(), 2U);
  EXPECT_LE(fit_count(tube, 4, options, &four).hexahedra.size(), 4U);
  EXPECT_LT(four, two);
}

TEST(Fit, ACountThatABoxNeverReachesEnds) {
  const Fit fit = fit_count(box_mesh({0, 0, 0}, {1, 1, 1}), 3, within(0.1));
  EXPECT_EQ(fit.hexahedra.size(), 1U);
}

TEST(Fit, BadRequestsAreNamed) {
  const TriangleMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  for (const double over : {0.0, -1.0, 1e-9, kNaN})
    EXPECT_THROW(fit_hexahedra(box, within(over)), InputError) << over;
  FitOptions options = within(0.1);
  options.tries = 0;
  EXPECT_THROW(fit_hexahedra(box, options), InputError);
  options.tries = 1;
  options.regions.push_back({"port", {Vector3(0, 0, 0), Vector3(1, 1, 1)}, 0.2});
  EXPECT_THROW(fit_hexahedra(box, options), InputError);
  EXPECT_THROW(fit_hexahedra(TriangleMesh(), within(0.1)), InputError);
}

}  // namespace
}  // namespace touchstone

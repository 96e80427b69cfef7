#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <span>
#include <utility>

#include "touchstone/contact_core/fit/fit.hpp"
#include "touchstone/contact_core/fit/search/accepted_solids.hpp"
#include "touchstone/contact_core/fit/search/cells.hpp"
#include "touchstone/contact_core/fit/search/pool.hpp"
#include "touchstone/contact_core/fit/search/set_cover.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/fit/fit_options.hpp"
#include "touchstone/tests/fit/meshes.hpp"
#include "touchstone/tests/fit/random_shells.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone {
namespace {

using test::angle_mesh;
using test::append;
using test::box_mesh;
using test::tube_mesh;
using test::within;

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

/// Parts that share nothing, of so many elements each.
struct Parts {
  /// `of_one`: the sets of the first, of which the cover to start from has two.
  Parts(std::uint32_t parts, std::uint32_t elements, const std::vector<std::vector<std::uint32_t>>& of_one) {
    for (std::uint32_t part = 0; part < parts; ++part) {
      start.insert(start.end(), {sets.size(), sets.size() + 1});
      for (std::vector<std::uint32_t> set : of_one) {
        for (std::uint32_t& e : set) e += part * elements;
        sets.push_back(set);
      }
    }
  }

  std::vector<std::vector<std::uint32_t>> sets;
  std::vector<std::size_t> start;
};

// Of parts that share nothing each is looked at by itself: the bound of all together is half of what they
// take, and yet the search ends, though it has leave to work for an hour.
TEST(FewerSets, PartsThatShareNothingHaveTheirOwnFewest) {
  const Parts parts(30, 3, {{0, 1}, {1, 2}, {2, 0}});
  EXPECT_EQ(fit::least_sets(parts.sets, 90), 30U);
  EXPECT_EQ(fit::fewer_sets(parts.sets, 90, parts.start, 1'000'000'000'000).size(), 60U);
}

// Also from a cover of two sets: one that holds both elements is looked for.
TEST(FewerSets, PartsThatStartFromTwoSetsMayEndWithOne) {
  const Parts parts(10, 2, {{0}, {1}, {0, 1}});
  EXPECT_EQ(fit::fewer_sets(parts.sets, 20, parts.start, 1'000'000).size(), 10U);
  EXPECT_TRUE(fit::fewer_sets({}, 0, {}, 1'000'000).empty());
}

// Against counting each cell of each candidate, while candidates come, cells are covered and one is
// forgotten.
TEST(OpenCells, CountWhatEachCandidateHoldsOfThem) {
  constexpr std::size_t kCells = 300;
  std::mt19937_64 random(11);
  fit::CandidatePool pool(kCells);
  std::vector<std::vector<std::uint32_t>> cells_of;
  // Sixty candidates, of which one is forgotten.
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
  // All cells are open.
  fit::CellBits all((kCells + 63) / 64, 0);
  std::vector<bool> is_open(kCells, true);
  for (std::size_t cell = 0; cell < kCells; ++cell) fit::set(all, cell);
  fit::OpenCells open(pool, all);
  const auto gain = [&](const std::vector<std::uint32_t>& cells) {
    return static_cast<std::size_t>(
        std::count_if(cells.begin(), cells.end(), [&](std::uint32_t cell) { return is_open[cell]; }));
  };
  // The best candidate, by counting.
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
    // The best one for a cell holds it.
    const std::size_t cell = open.next_from(random() % kCells, kCells);
    EXPECT_TRUE(is_open[cell]);
    const fit::OpenCells::Best at = open.best_at(cell);
    const std::vector<std::uint32_t>& held = cells_of[at.index];
    EXPECT_TRUE(at.gain == 0 || (at.gain == gain(held) && std::count(held.begin(), held.end(), cell) == 1));
    // The best one's cells are covered.
    open.cover(pool[best.index]);
    for (const std::uint32_t i : cells_of[best.index]) is_open[i] = false;
  }
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
  // Where a later try is refused, as it would take too much memory, the cover of those before stands.
  int tries = 0;
  options.progress = [&](std::string_view stage, double) {
    if (stage == "cut" && ++tries == 2) throw InputError("too many cells");
  };
  EXPECT_EQ(fit_hexahedra(blocks, options).hexahedra.size(), one);
  EXPECT_EQ(tries, 2);
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

// A pin in a region takes as many slabs as alone: a hexahedron is at least as thick as a share of what is
// asked, and that was a share of the whole's error, beyond what the region allows.
TEST(Fit, AThinSlabInARegionIsNoThickerThanTheRegionAllows) {
  const TriangleMesh pin = test::cone_mesh(0.022, 0.022, 0.03, 24);
  FitOptions alone = within(1e-3);
  alone.repairs = 1;
  TriangleMesh both = pin;
  append(both, box_mesh({3, 0, 0}, {4, 1, 1}));
  FitOptions options = within(1.0);
  options.repairs = 1;
  options.regions.push_back({"pin", {{-0.03, -0.03, -0.01}, {0.03, 0.03, 0.04}}, 1e-3});
  const Fit fit = fit_hexahedra(both, options);
  EXPECT_LE(fit.region_excess[0], 1e-3);
  EXPECT_EQ(fit.hexahedra.size(), fit_hexahedra(pin, alone).hexahedra.size() + 1);
}

fit::SixPlanes box_planes(const Vector3& low, const Vector3& high) {
  const std::array<Vector3, 6> normals = {-Vector3::UnitX(), Vector3::UnitX(),  -Vector3::UnitY(),
                                          Vector3::UnitY(),  -Vector3::UnitZ(), Vector3::UnitZ()};
  return fit::enclosing(normals, std::array<Vector3, 2>{low, high});
}

// Two regions that meet are as one to a face that grows: where they meet is no border.
TEST(AllowedSpace, RegionsThatMeetCostNoMoreThanOne) {
  const MeshDistance mesh(weld(box_mesh({0, 0, 0}, {1, 1, 1})));
  const auto visits = [&](std::span<const fit::LimitBox> boxes) {
    fit::AllowedSpace space(mesh, 2.0, boxes);
    EXPECT_NEAR(space.room(box_planes({0, 0, 0}, {1, 1, 1}), 1, 2.0), 0.2, 1e-2);
    return space.visits();
  };
  const double limit = 2e-3;
  const std::array<fit::LimitBox, 1> one = {{{{{1.2, -0.5, -0.5}, {1.5, 1.5, 1.5}}, limit}}};
  const std::array<fit::LimitBox, 2> two = {
      {{{{1.2, -0.5, -0.5}, {1.5, 0.49, 1.5}}, limit}, {{{1.2, 0.49, -0.5}, {1.5, 1.5, 1.5}}, limit}}};
  EXPECT_LE(visits(two), 2 * visits(one));
}

// What would take all memory is refused.
TEST(AllowedSpace, CellsAreBounded) {
  const MeshDistance mesh(weld(tube_mesh(0.5, 1.0, 1.0, 48)));
  fit::AllowedSpace space(mesh, 1e-3, {}, 1000);
  const fit::SixPlanes solid = box_planes({0.6, -0.1, 0.4}, {0.7, 0.1, 0.5});
  EXPECT_THAT(
      refusal_of([&] {
        for (int face = 0; face < 6; ++face) (void)space.room(solid, face, 1.0);
      }),
      testing::HasSubstr("more than 1000 cells of space about a mesh of 3 m, at an error of 0.001 m"));
  fit::AllowedSpace free(mesh, 1e-3, {});
  EXPECT_THAT(refusal_of([&] { fit::Cells(mesh, free, 1e-3, {}, 0.0, {}, 100); }),
              testing::HasSubstr("more than 100 pieces of a mesh of 3 m"));
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
  ASSERT_GE(shares.size(), 3 * fit.hexahedra.size() + 4);
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

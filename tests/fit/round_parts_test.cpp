// Round parts and prisms: found in meshes, and covered by slabs and sectors.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "touchstone/contact_core/fit/excess.hpp"
#include "touchstone/contact_core/fit/fit.hpp"
#include "touchstone/contact_core/fit/parts/chords.hpp"
#include "touchstone/contact_core/fit/parts/prisms.hpp"
#include "touchstone/contact_core/fit/parts/sectors.hpp"
#include "touchstone/contact_core/fit/round_parts.hpp"
#include "touchstone/tests/fit/fit_options.hpp"
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
using test::within;

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

// As a cover's hexahedra, which a search has found to keep to what is asked.
TEST(Excess, WhatIsKnownToBeTheMostEndsABoundSooner) {
  const MeshDistance tube(weld(tube_mesh(0.4, 0.5, 1.0, 32)));
  const std::array<Vector3, 8> box = box_vertices({-0.45, -0.4, 0.02}, {0.4, 0.45, 0.97});
  constexpr std::size_t kMost = 200000;
  constexpr double kResolution = 3e-3;
  const double most = bound_excess(tube, box, kResolution / 8.0).most;
  const ExcessBound sought = bound_excess(tube, box, kResolution),
                    known = bound_excess(tube, box, kResolution, 0.0, nullptr, kMost, most);
  EXPECT_LE(known.most, most);
  EXPECT_GE(known.least, most - kResolution);
  EXPECT_LT(2 * known.pieces, sought.pieces);
  // What is far above says nothing.
  const ExcessBound far = bound_excess(tube, box, kResolution, 0.0, nullptr, kMost, 10.0 * most);
  EXPECT_EQ(far.most, sought.most);
  EXPECT_EQ(far.pieces, sought.pieces);
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

// 24 chords of a circle keep to 0.9 mm; of 50 facets, which they may cut, 25. Sectors of as many facets each
// were 32 of 64, and none of 50 and 104, where the region's corner was taken to reach the outer wall.
TEST(Fit, ABoreOfAnyNumberOfFacetsStaysOpenWithAboutAsFew) {
  for (const int facets : {50, 64, 104}) {
    const MeshDistance ring(weld(tube_mesh(0.1, 0.15, 0.03, facets)));
    FitOptions options = within(5e-3);
    options.repairs = 1;
    for (const RoundPart& part : find_round_parts(ring))
      if (part.is_bore) options.regions.push_back({"bore", part.bounds(), 0.9e-3});
    ASSERT_EQ(options.regions.size(), 1U);
    const Fit fit = fit_hexahedra(ring, options);
    EXPECT_LE(fit.hexahedra.size(), 25U) << facets;
    EXPECT_LE(fit.region_excess[0], 0.9e-3) << facets;
  }
}

TEST(Chords, GoAroundAsDeepAsTheyMay) {
  for (const int facets : {8, 31, 64, 360}) {
    for (const fit::ChordLimits& limits : {fit::ChordLimits{9e-3, 1.0}, {1.0, 9e-3}, {0.0, 0.0}}) {
      const std::vector<fit::Chord> chords = fit::fewest_chords(facets, limits);
      ASSERT_FALSE(chords.empty());
      const bool is_deep = facets >= 64 && limits.inner != limits.outer;
      EXPECT_LE(chords.size(), is_deep ? 25U : static_cast<std::size_t>(facets)) << facets;
      EXPECT_NEAR(chords.back().end - chords.front().begin, 2.0 * std::numbers::pi, 1e-12);
      for (std::size_t i = 0; i < chords.size(); ++i) {
        EXPECT_EQ(chords[i].begin, i == 0 ? chords[0].begin : chords[i - 1].end);
        EXPECT_TRUE(limits.allow(chords[i])) << facets;
      }
    }
  }
  // Of eight facets two: to the middle corner it is one less its cosine.
  const fit::Chord two = fit::chord_between(8, 0.0, 0.5 * std::numbers::pi);
  EXPECT_NEAR(two.out, 0.25 * std::numbers::pi, 1e-15);
  EXPECT_NEAR(two.height, std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(two.depth, 1.0 - std::sqrt(0.5), 1e-15);
}

TEST(LimitBox, IsTouchedByWhatReachesIt) {
  const fit::LimitBox box{{Vector3(-1, -1, -1), Vector3(1, 1, 1)}, 1e-3};
  // Across the corner: the box about the two ends reaches the limit's box either way.
  const auto is_touched = [&](double away) {
    return box.touches(
        std::array{Vector3(2 * away, 0, 0), Vector3(0, 2 * away, 0), Vector3(away, away, 0.5)});
  };
  EXPECT_TRUE(is_touched(0.5));
  EXPECT_TRUE(is_touched(1.0));
  EXPECT_FALSE(is_touched(1.0 + 1e-9));
  EXPECT_TRUE(box.touches(std::array{Vector3(-9, -9, -9), Vector3(9, 8, 7)}));
  EXPECT_TRUE(box.touches(std::array{Vector3(0.5, 0.5, 0.5)}));
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

}  // namespace
}  // namespace touchstone

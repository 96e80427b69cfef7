#include "touchstone/adapters/cover_proof/cover_proof.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "touchstone/contact_core/fit/fit.hpp"
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
using testing::HasSubstr;

CoverClaim claim_of(const Fit& fit) {
  CoverClaim claim;
  claim.excess = fit.excess;
  for (const FittedHexahedron& each : fit.hexahedra) claim.hexahedra.push_back(each.vertices);
  return claim;
}

CoverClaim claim_of(std::initializer_list<std::array<Vector3, 8>> hexahedra, double excess) {
  CoverClaim claim;
  claim.hexahedra = hexahedra;
  claim.excess = excess;
  return claim;
}

TEST(CoverProof, FitsOfPartsAreProven) {
  FitOptions options;
  options.repairs = 2;
  options.over = 0.15;
  TriangleMesh shells = box_mesh({0, 0, 0}, {1, 1, 1});
  append(shells, box_mesh({0.7, 0.7, 0.7}, {2, 1.2, 1.3}));
  TriangleMesh turned = angle_mesh();
  for (Vector3& p : turned.vertices)
    p = Vector3(0.8 * p.x() - 0.6 * p.z(), p.y() + 1e3, 0.6 * p.x() + 0.8 * p.z());
  TriangleMesh sheet;
  test::append_quad(sheet, {0, 0, 0}, {1, 0, 0.3}, {1, 1, 0}, {0, 1, 0.1});
  for (const TriangleMesh& mesh : {angle_mesh(), turned, shells, sheet, test::tube_mesh(0.3, 0.6, 0.5, 20)}) {
    const CoverVerdict verdict = check_cover(mesh, claim_of(fit_hexahedra(mesh, options)));
    EXPECT_TRUE(verdict.is_proven) << verdict.reason;
    EXPECT_EQ(verdict.in_one_hexahedron + verdict.cut, mesh.triangles.size());
  }
}

// A shaft as files have it, in single precision along no axis: corners of a step are a rounding apart, and a
// slice that began at one of them left out what others have beyond.
TEST(CoverProof, AShaftThatStepsIsCovered) {
  // A turned shaft along no axis, its corners in single precision.
  constexpr std::array<std::array<double, 2>, 9> kOutline = {{{0.0, 0.0},
                                                              {0.02, 0.0},
                                                              {0.02, 0.06},
                                                              {0.015, 0.06},
                                                              {0.015, 0.09},
                                                              {0.03, 0.1},
                                                              {0.012, 0.15},
                                                              {0.012, 0.2},
                                                              {0.0, 0.2}}};
  constexpr int kFacets = 24;
  const auto at = [&](std::size_t k, int i) {
    const double angle = 2.0 * std::numbers::pi * (i % kFacets) / kFacets, radius = kOutline[k][0];
    const double x = radius * std::cos(angle), y = radius * std::sin(angle), z = kOutline[k][1];
    const Vector3 p = (Vector3(2, 3, 6) * z + Vector3(3, -6, 2) * x + Vector3(6, 2, -3) * y) / 7.0;
    return Vector3(p.cast<float>().cast<double>());
  };
  TriangleMesh shaft;
  for (std::size_t k = 1; k < kOutline.size(); ++k) {
    for (int i = 0; i < kFacets; ++i) {
      if (k > 1) append(shaft, {{at(k - 1, i), at(k - 1, i + 1), at(k, i + 1)}, {{0, 1, 2}}});
      if (k == 1) append(shaft, {{at(0, 0), at(1, i + 1), at(1, i)}, {{0, 1, 2}}});
      if (k > 1 && kOutline[k][0] > 0.0) append(shaft, {{at(k - 1, i), at(k, i + 1), at(k, i)}, {{0, 1, 2}}});
    }
  }
  // Proven within both errors.
  FitOptions options;
  options.repairs = 3;
  for (const double over : {0.004, 0.002}) {  // within the smaller one stairs cover the cone at 56 degrees
    options.over = over;
    const Fit fit = fit_hexahedra(shaft, options);
    EXPECT_LE(fit.pieces, 1000U) << over;
    const CoverVerdict verdict = check_cover(shaft, claim_of(fit));
    EXPECT_TRUE(verdict.is_proven) << verdict.reason;
  }
}

// Rings by sectors, cones by tapered slabs, a shaft and a beam: the whole and what a region asks, in a small
// search.
TEST(CoverProof, RoundPartsAreCoveredByTheirOwnPieces) {
  FitOptions options;
  options.repairs = 1;
  options.over = 5e-3;
  const auto turned = [](TriangleMesh mesh) {
    for (Vector3& p : mesh.vertices)
      p = Vector3(0.8 * p.x() - 0.6 * p.z() + 1.0, p.y() - 2.0, 0.6 * p.x() + 0.8 * p.z());
    return mesh;
  };
  for (const TriangleMesh& mesh :
       {test::tube_mesh(0.05, 0.1, 0.05, 48), test::cone_mesh(0.08, 0.0, 0.12, 32),
        turned(test::tube_mesh(0.05, 0.1, 0.05, 48)), turned(test::cone_mesh(0.08, 0.0, 0.12, 32))}) {
    const Fit fit = fit_hexahedra(mesh, options);
    EXPECT_LE(fit.hexahedra.size(), 16U);
    const CoverVerdict verdict = check_cover(mesh, claim_of(fit));
    EXPECT_TRUE(verdict.is_proven) << verdict.reason;
  }
}

TEST(CoverProof, AFixtureInARegionIsCoveredToItsError) {
  TriangleMesh mesh = box_mesh({-2, -0.3, -0.3}, {2, 0.3, 0.3});
  const auto append_at = [&](TriangleMesh more, double z) {
    for (Vector3& p : more.vertices) p.z() += z;
    append(mesh, more);
  };
  append_at(test::tube_mesh(0.16, 0.2, 0.05, 32), 0.3);
  append_at(test::cone_mesh(0.08, 0.03, 0.12, 32), 0.3);
  append_at(test::cone_mesh(0.015, 0.015, 0.3, 24), 0.38);
  FitOptions options;
  options.repairs = 1;
  options.over = 0.3;
  options.regions.push_back({"fixture", {Vector3(-0.3, -0.3, 0.3), Vector3(0.3, 0.3, 0.8)}, 0.002});
  const Fit fit = fit_hexahedra(mesh, options);
  CoverClaim claim = claim_of(fit);
  claim.regions.push_back(
      {"fixture", options.regions[0].box.low, options.regions[0].box.high, fit.region_excess[0]});
  const CoverVerdict verdict = check_cover(mesh, claim);
  EXPECT_TRUE(verdict.is_proven) << verdict.reason;
}

TEST(CoverProof, ATightVertexMovedInwardByOnePartIn1e12IsRefused) {
  const TriangleMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  CoverClaim claim = claim_of({box_vertices({0, 0, 0}, {1, 1, 1})}, 1e-6);
  EXPECT_TRUE(check_cover(box, claim).is_proven);
  claim.hexahedra[0][7] -= Vector3::Constant(1e-12);
  const CoverVerdict moved = check_cover(box, claim);
  EXPECT_FALSE(moved.is_proven);
  EXPECT_THAT(moved.reason, HasSubstr("is not covered at"));

  // So is one of a fit, whose faces stand off by what rounding asks for.
  FitOptions options;
  options.over = 0.05;
  CoverClaim fitted = claim_of(fit_hexahedra(box, options));
  fitted.excess = 1e-6;
  EXPECT_TRUE(check_cover(box, fitted).is_proven);
  for (int i = 0; i < 8; ++i) {
    CoverClaim tight = fitted;
    tight.hexahedra[0][i] += 1e-12 * (Vector3::Constant(0.5) - tight.hexahedra[0][i]).cwiseSign();
    EXPECT_FALSE(check_cover(box, tight).is_proven) << i;
  }
}

/// Six plates of 0.1 m hold the whole surface of a unit cube, and not the inside.
CoverClaim six_plates() {
  CoverClaim claim;
  claim.excess = 1e-6;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double at : {0.0, 0.9}) {
      Vector3 low(0, 0, 0), high(1, 1, 1);
      low(axis) = at;
      high(axis) = at + 0.1;
      claim.hexahedra.push_back(box_vertices(low, high));
    }
  }
  return claim;
}

TEST(CoverProof, AHollowCoverIsRefused) {
  const TriangleMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  CoverClaim claim = six_plates();
  const CoverVerdict hollow = check_cover(box, claim);
  EXPECT_FALSE(hollow.is_proven);
  EXPECT_THAT(hollow.reason, HasSubstr("inside is not covered"));
  claim.hexahedra.push_back(box_vertices({0.1, 0.1, 0.1}, {0.9, 0.9, 0.9}));
  EXPECT_TRUE(check_cover(box, claim).is_proven) << "filled to the last bit: abutting faces are in one plane";
}

// A slab that two hexahedra cover from below, their upper faces in one plane: neither may hide the other's.
TEST(CoverProof, FacesInOnePlaneDoNotHideEachOther) {
  const TriangleMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  CoverClaim claim = six_plates();
  // Twice: each hides what it can of its twin.
  for (std::size_t i = 0; i < 6; ++i) claim.hexahedra.push_back(claim.hexahedra[i]);
  EXPECT_THAT(check_cover(box, claim).reason, HasSubstr("inside is not covered"));
}

TEST(CoverProof, AGapOfOneBitInASeamIsFound) {
  const TriangleMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  const double seam = 0.3;
  EXPECT_TRUE(
      check_cover(
          box, claim_of({box_vertices({0, 0, 0}, {seam, 1, 1}), box_vertices({seam, 0, 0}, {1, 1, 1})}, 1e-9))
          .is_proven);
  const CoverVerdict gap =
      check_cover(box, claim_of({box_vertices({0, 0, 0}, {seam, 1, 1}),
                                 box_vertices({std::nextafter(seam, 1.0), 0, 0}, {1, 1, 1})},
                                1e-9));
  EXPECT_FALSE(gap.is_proven);
}

TEST(CoverProof, AnErrorClaimedTooSmallIsRefusedAtAPoint) {
  const TriangleMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  CoverClaim claim = claim_of({box_vertices({0, 0, 0}, {1, 1, 1.25})}, 0.25 * (1 + 1e-9));
  EXPECT_TRUE(check_cover(box, claim).is_proven);
  claim.excess = 0.249;
  EXPECT_THAT(check_cover(box, claim).reason, HasSubstr("hexahedron 0 is farther than claimed at"));
  claim.excess = 0.26;
  claim.regions.push_back({"port", {0.4, 0.4, 1.1}, {0.6, 0.6, 1.2}, 0.2000001});
  EXPECT_TRUE(check_cover(box, claim).is_proven == false)
      << "a tetrahedron across the border counts as a whole";
  claim.regions[0].excess = 0.1;
  EXPECT_THAT(check_cover(box, claim).reason, HasSubstr("in region 'port'"));
}

// A block with posts that stand in it, claimed to a hundred-thousandth: before each place of a wall within
// was looked at as closely as that, in more than a million pieces.
TEST(CoverProof, WallsWithinTheSolidCostLittle) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {2, 2, 1});
  CoverClaim claim = claim_of({box_vertices({0, 0, 0}, {2, 2, 1})}, 1e-5);
  for (int i = 0; i < 4; ++i) {
    const Vector3 low(0.3 + 0.4 * i, 0.5, 0.4), high(0.5 + 0.4 * i, 1.5, 1.6);
    append(mesh, box_mesh(low, high));
    claim.hexahedra.push_back(box_vertices(low, high));
  }
  const CoverVerdict verdict = check_cover(mesh, claim, 30000);
  EXPECT_TRUE(verdict.is_proven) << verdict.reason;
}

// Of blocks that overlap, one of them inside out: one hexahedron about all, claimed to 0.97 of what is seen.
TEST(CoverProof, NoErrorIsProvenThatAPointExceeds) {
  std::mt19937_64 engine(31415);
  const auto next = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  for (int round = 0; round < 60; ++round) {
    TriangleMesh mesh;
    for (int i = 0; i < 4; ++i) {
      const Vector3 low(next(), next(), next()), size(0.4 + next(), 0.4 + next(), 0.4 + next());
      TriangleMesh block = box_mesh(low, low + size);
      if (i == 3 && round % 3 != 0)
        for (auto& t : block.triangles) std::swap(t[1], t[2]);
      append(mesh, block);
    }
    const MeshDistance distance(weld(mesh));
    const Bounds& box = distance.bounds();
    double seen = 0.0;
    for (int k = 0; k < 20000; ++k) {
      const Vector3 share(next(), next(), next());
      seen = std::max(seen, distance.to_solid(box.low + share.cwiseProduct(box.high - box.low)));
    }
    const CoverClaim claim = claim_of({box_vertices(box.low, box.high)}, 0.97 * seen);
    EXPECT_FALSE(check_cover(mesh, claim, 100000).is_proven) << round;
  }
}

// Flush walls of two shells are passed at once: a slot of 1 m behind them, in a claim of a twentieth.
TEST(CoverProof, ASlotBehindFlushWallsIsSeen) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {2.6, 4, 4});
  append(mesh, box_mesh({1, 0, 0}, {2.6, 4, 4}));
  append(mesh, box_mesh({0, 0, 0}, {4, 4, 1}));
  append(mesh, box_mesh({3.6, 0, 0}, {4, 4, 4}));
  EXPECT_FALSE(check_cover(mesh, claim_of({box_vertices({0, 0, 0}, {4, 4, 4})}, 0.05)).is_proven);
  EXPECT_TRUE(check_cover(mesh, claim_of({box_vertices({0, 0, 0}, {4, 4, 4})}, 0.51)).is_proven);
}

// Blocks on a grid, some of them twice, in a block that has a slot: the claim is half of the slot's depth
// less.
TEST(CoverProof, NoErrorIsProvenThatAPointBetweenWallsOnAGridExceeds) {
  std::mt19937_64 engine(27182);
  const auto step = [&](unsigned most) { return 0.25 * static_cast<double>(1 + engine() % most); };
  for (int round = 0; round < 40; ++round) {
    const double from = 1.0 + step(6), to = from + 0.5;
    TriangleMesh mesh = box_mesh({0, 0, 0}, {from, 4, 4});
    append(mesh, box_mesh({to, 0, 0}, {4, 4, 4}));
    append(mesh, box_mesh({0, 0, 0}, {4, 4, step(4)}));
    for (int i = 0; i < 4; ++i) {
      const double low = step(3), high = i % 2 == 0 ? from : low + 0.25;
      append(mesh, box_mesh({low, 0, 0}, {high, 2 + step(8), 4}));
      if (i == 0) append(mesh, box_mesh({low, 0, 0}, {high, 4, 4}));
    }
    const CoverClaim claim = claim_of({box_vertices({0, 0, 0}, {4, 4, 4})}, 0.2);
    EXPECT_FALSE(check_cover(mesh, claim, 100000).is_proven) << round;
  }
}

// One hexahedron about slanted shells that cross themselves and each other, claimed to 0.95 of what is seen.
TEST(CoverProof, NoErrorIsProvenThatAPointBetweenCrossingShellsExceeds) {
  std::size_t claims = 0, farther = 0;
  for (std::uint64_t round = 0; round < 60; ++round) {
    test::RandomShells random(8000 + round);
    const TriangleMesh mesh = random.mesh();
    const MeshDistance distance(weld(mesh));
    const Bounds& box = distance.bounds();
    double seen = 0.0;
    for (int k = 0; k < 1000; ++k) {
      const Vector3 p = random.within(box.low, box.high);
      if (std::abs(test::winding_by_angles(mesh, p)) < 0.01)
        seen = std::max(seen, distance.nearest(p).distance);
    }
    if (seen < 0.01 || (box.high - box.low).minCoeff() < 0.01) continue;
    ++claims;
    const CoverClaim claim = claim_of({box_vertices(box.low, box.high)}, 0.95 * seen);
    const CoverVerdict verdict = check_cover(mesh, claim, 50000);
    EXPECT_FALSE(verdict.is_proven) << round;
    farther += verdict.reason.find("farther") != std::string::npos ? 1 : 0;
  }
  EXPECT_GT(claims, 30U);
  EXPECT_GT(farther, claims / 2);  // a proof that refuses everything names no such point
}

TEST(CoverProof, ATriangleWithoutAreaIsASegment) {
  TriangleMesh mesh{{Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(2, 0, 0)}, {{0, 1, 2}}};
  const std::array<Vector3, 8> left = box_vertices({-0.1, -0.1, -0.1}, {1, 0.1, 0.1});
  const std::array<Vector3, 8> right = box_vertices({1, -0.1, -0.1}, {2.1, 0.1, 0.1});
  EXPECT_TRUE(check_cover(mesh, claim_of({left, right}, 0.5)).is_proven);
  EXPECT_THAT(check_cover(mesh, claim_of({left}, 0.5)).reason, HasSubstr("triangle 0"));
}

TEST(CoverProof, WhatIsNoCoverIsAnError) {
  const TriangleMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  EXPECT_THROW(check_cover(box, claim_of({}, 1.0)), InputError);
  EXPECT_THROW(check_cover(box, claim_of({box_vertices({0, 0, 0}, {1, 1, 0})}, 1.0)), InputError);
  EXPECT_THROW(check_cover(box, claim_of({box_vertices({0, 0, 0}, {1, 1, 1})}, 0.0)), InputError);
}

// Six slabs outside of a box, each on one side of it and beyond one edge, where the next one begins: they
// touch the next one's outer face only along that edge, so nothing divides the face where the surface turns
// away.
TEST(CoverProof, AFaceThatTheSurfaceLeavesIsJudgedOnBothSides) {
  const TriangleMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  const auto slab = [](int axis, bool is_upper, int along, bool is_up) {
    Vector3 low(0, 0, 0), high(1, 1, 1);
    (is_up ? high : low)(along) += is_up ? 1.5 : -1.5;
    std::array<Vector3, 8> vertices;
    for (int i = 0; i < 8; ++i) {
      const double inset = (i & 4) != 0 ? 0.25 : 0.0, off = (i & 4) != 0 ? 0.125 : 0.0;
      const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
      vertices[i](axis) = is_upper ? 1.0 + off : -off;
      vertices[i](u) = (i & 2) != 0 ? high(u) - inset : low(u) + inset;
      vertices[i](v) = (i & 1) != 0 ? high(v) - inset : low(v) + inset;
    }
    return vertices;
  };
  CoverClaim claim = claim_of({slab(2, false, 0, true), slab(0, true, 1, true), slab(1, true, 0, false),
                               slab(0, false, 2, true), slab(2, true, 1, false), slab(1, false, 0, false)},
                              2.2);
  EXPECT_THAT(check_cover(box, claim).reason, HasSubstr("inside is not covered"));
  claim.hexahedra.push_back(box_vertices({0, 0, 0}, {1, 1, 1}));
  EXPECT_TRUE(check_cover(box, claim).is_proven);
}

TEST(CoverProof, ClaimsThatNobodyCanMeetAreErrors) {
  const TriangleMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  const std::array<Vector3, 8> longer = box_vertices({0, 0, 0}, {1, 1, 2});
  const double infinite = kInfinity;
  const Vector3 low(0, 0, 0), high(2, 2, 2);
  for (const CoverClaim::Region& region :
       {CoverClaim::Region{"port", low, high, -3.0}, CoverClaim::Region{"port", low, high, kNaN},
        CoverClaim::Region{"port", low, high, infinite}, CoverClaim::Region{"port", high, low, 1e-9},
        CoverClaim::Region{"port", low, {2, 2, infinite}, 1e-9}}) {
    CoverClaim claim = claim_of({longer}, 2.0);
    claim.regions.push_back(region);
    EXPECT_THROW(check_cover(box, claim), InputError);
  }
  EXPECT_THROW(check_cover(box, claim_of({longer}, infinite)), InputError);
  for (const double far : {1e71, 1e200, infinite})
    EXPECT_THROW(
        check_cover(box,
                    claim_of({longer, box_vertices(Vector3::Constant(-far), Vector3::Constant(far))}, 1.0)),
        InputError)
        << far;
}

TEST(CoverProof, AnErrorBelowTheRoundingOfDistancesIsNeverProven) {
  const TriangleMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  EXPECT_FALSE(
      check_cover(box, claim_of({box_vertices({0, 0, 0}, {1, 1, 1.0 + 0x1p-46})}, 1e-300)).is_proven);
}

// The hull of points on a line up to rounding: its facets' normals are noise in doubles.
TEST(CoverProof, ANeedleAcrossAGapIsRefused) {
  TriangleMesh boxes = box_mesh({0, 0, 0}, {1, 1, 1});
  append(boxes, box_mesh({1.1, 0, 0}, {2.1, 1, 1}));
  const Vector3 a(0.4055658370909866, 0.3818724600363589, 0.4735998664780244);
  const Vector3 b(1.1516654616291429, 0.6938292726932138, 0.6269226548970482);
  const Vector3 c(0.4206385567786261, 0.3881746178678105, 0.4766972965470956);
  const Vector3 d(0.4131021969348064, 0.3850235389520847, 0.47514858151255995);
  const CoverVerdict verdict = check_cover(boxes, claim_of({box_vertices({0, 0, 0}, {1, 1, 1}),
                                                            box_vertices({1.1, 0, 0}, {2.1, 1, 1}),
                                                            {a, b, c, d, d, c, d, a}},
                                                           1e-6));
  EXPECT_FALSE(verdict.is_proven);
}

// The foot of a perpendicular on a sliver is off its plane by more than the limit.
TEST(CoverProof, APointOffASliverIsNoNearerThanItIs) {
  const Vector3 a = Vector3(0.7247099090346579, 0.3992069039098525, 0.1924723711557268);
  const Vector3 b = Vector3(1.2404465440939059, 0.7117232229925274, -0.10481449620116079);
  const Vector3 c = Vector3(1.21465971234016, 0.6960974070414344, -0.08995015283147945);
  const Vector3 off = Vector3(1.2074451580849435, 0.6917193950172407, -0.08578107269546699);
  const TriangleMesh sliver{{a, b, c}, {{0, 1, 2}}};
  EXPECT_FALSE(
      check_cover(sliver, claim_of({{a, b, c, off, a, b, c, off}}, 5.1230264634088415e-06)).is_proven);
}

}  // namespace
}  // namespace touchstone

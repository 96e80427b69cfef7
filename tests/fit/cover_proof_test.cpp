#include "touchstone/adapters/cover_proof/cover_proof.hpp"

#include "touchstone/contact_core/fit/fit.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/fit/meshes.hpp"

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

// Six plates hold the whole surface, and not the inside.
TEST(CoverProof, AHollowCoverIsRefused) {
  const TriangleMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
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
  const CoverVerdict hollow = check_cover(box, claim);
  EXPECT_FALSE(hollow.is_proven);
  EXPECT_THAT(hollow.reason, HasSubstr("inside is not covered"));
  claim.hexahedra.push_back(box_vertices({0.1, 0.1, 0.1}, {0.9, 0.9, 0.9}));
  EXPECT_TRUE(check_cover(box, claim).is_proven) << "filled to the last bit: abutting faces are in one plane";
}

// A slab that two hexahedra cover from below, their upper faces in one plane: neither may hide the other's.
TEST(CoverProof, FacesInOnePlaneDoNotHideEachOther) {
  const TriangleMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  CoverClaim claim;
  claim.excess = 1e-6;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double at : {0.0, 0.9}) {
      Vector3 low(0, 0, 0), high(1, 1, 1);
      low(axis) = at;
      high(axis) = at + 0.1;
      claim.hexahedra.push_back(box_vertices(low, high));
      claim.hexahedra.push_back(box_vertices(low, high));  // twice: each hides what it can of its twin
    }
  }
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

}  // namespace
}  // namespace touchstone

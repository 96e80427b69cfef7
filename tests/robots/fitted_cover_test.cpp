#include "touchstone/adapters/robots/fitted_cover.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/fit/meshes.hpp"

namespace touchstone {
namespace {

using testing::HasSubstr;

bool is_held(const MeshCover& cover, const Vector3& p) {
  for (const PlacedHexahedron& each : cover.solids) {
    bool inside = true;
    for (int face = 0; face < 6; ++face)
      inside = inside && each.solid.face_plane(face).signed_distance(p) <= 0.0;
    if (inside) return true;
  }
  return false;
}

/// An L's hull is 0.35 m outside of it: two legs are not.
TEST(FittedCover, HoldsAnAngleWithinTheErrorAskedFor) {
  FittedCoverOptions options;
  options.over = 0.1;
  options.repairs = 2;  // soon done
  const TriangleMesh angle = test::angle_mesh();
  const MeshCover cover = fitted_cover(options)(angle, "angle");
  EXPECT_EQ(cover.solids.size(), 2u);
  EXPECT_LE(cover.error, 0.1);
  for (const Vector3& v : angle.vertices) EXPECT_TRUE(is_held(cover, v)) << v.transpose();
  EXPECT_TRUE(is_held(cover, {1.9, 0.25, 0.5}));
  EXPECT_TRUE(is_held(cover, {0.25, 1.9, 0.5}));
  EXPECT_FALSE(is_held(cover, {0.65, 0.65, 0.5}));  // farther outside than asked
}

TEST(FittedCover, AShareIsOfTheMeshsSize) {
  FittedCoverOptions options;
  options.repairs = 2;
  options.over_share = 0.7;  // 2.1 m: one hexahedron, 1.5 m off at its corner, will do
  EXPECT_EQ(fitted_cover(options)(test::angle_mesh(), "angle").solids.size(), 1u);
  options.over_share = 0.03;
  EXPECT_EQ(fitted_cover(options)(test::angle_mesh(), "angle").solids.size(), 2u);
}

/// Of a boom twice as wide as high: by its width, not by its length.
TEST(FittedCover, AShareOfABoomIsNotByItsLength) {
  FittedCoverOptions options;
  options.repairs = 2;
  options.over_share = 0.2;
  double asked = 0.0;
  TriangleMesh boom = test::angle_mesh();
  for (Vector3& v : boom.vertices) v = Vector3(20.0 * v.x(), v.y(), v.z());
  options.check = [&](const TriangleMesh&, const Fit& fit, const std::string&) { asked = fit.excess; };
  fitted_cover(options)(boom, "boom");
  EXPECT_LE(asked, 0.2 * 3.0 * 2.0);
}

TEST(FittedCover, FitsAMeshOnceARun) {
  // Options that count the fits.
  int fits = 0;
  std::string named_mesh;
  FittedCoverOptions options;
  options.over = 0.1;
  options.repairs = 2;  // soon done
  options.progress = [&](const std::string& mesh, std::string_view, double share) {
    named_mesh = mesh;
    EXPECT_TRUE(share >= 0.0 && share <= 1.0);
  };
  options.check = [&](const TriangleMesh&, const Fit& fit, const std::string& name) {
    ++fits;
    EXPECT_EQ(fit.hexahedra.size(), 2u);
    EXPECT_EQ(name, "angle");
  };
  // One mesh is fitted once, also by a copy and under another name.
  const CoverMesh cover = fitted_cover(options);
  const CoverMesh copy = cover;
  TriangleMesh angle = test::angle_mesh();
  const double error = cover(angle, "angle").error;
  EXPECT_EQ(copy(angle, "the same").error, error);
  EXPECT_EQ(fits, 1);
  EXPECT_EQ(named_mesh, "angle");
  // Another mesh is fitted anew.
  for (Vector3& v : angle.vertices) v *= 0.9;
  cover(angle, "angle");
  EXPECT_EQ(fits, 2);
}

TEST(FittedCover, WhatCannotBeMetNamesTheMesh) {
  FittedCoverOptions options;
  options.over = 1e-12;
  try {
    fitted_cover(options)(test::angle_mesh(), "angle.stl");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("mesh 'angle.stl': "));
  }
}

}  // namespace
}  // namespace touchstone

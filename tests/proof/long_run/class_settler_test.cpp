#include "touchstone/tests/proof/long_run/class_settler.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/adapters/exact/signed_distance.hpp"
#include "touchstone/tests/proof/pairs/families.hpp"
#include "touchstone/tests/proof/pairs/pair_text.hpp"
#ifdef TOUCHSTONE_HAS_SCENE_FILES
#include "touchstone/adapters/scene_files/pair_file.hpp"
#endif

namespace touchstone::proof {
namespace {

PosedSolids cubes(double x, double y, double z, double scale = 1.0) {
  PosedSolids solids{Hexahedron::from_size(Vector3(2, 2, 2) * scale),
                     Hexahedron::from_size(Vector3(2, 2, 2) * scale), Pose{}, Pose{}};
  solids.X_WB.p = Vector3(x, y, z) * scale;
  return solids;
}

TEST(ClassSettler, CubesByHand) {
  for (const double scale : {1.0, 0x1p-300, 0x1p300, 0x1p-1050, 0x1p1000}) {
    SCOPED_TRACE(scale);
    EXPECT_EQ(settle_class(cubes(2.5, 0, 0, scale)).pair_class, PairClass::separated);
    EXPECT_EQ(settle_class(cubes(1.5, 0.5, 1, scale)).pair_class, PairClass::penetrating);
    EXPECT_EQ(settle_class(cubes(0, 0, 0, scale)).pair_class, PairClass::penetrating);
    EXPECT_EQ(settle_class(cubes(2, 0.5, 0, scale)).pair_class, PairClass::touching);
    EXPECT_EQ(settle_class(cubes(2, 2, 0.5, scale)).pair_class, PairClass::touching);
    EXPECT_EQ(settle_class(cubes(2, 2, 2, scale)).pair_class, PairClass::touching);
  }
  EXPECT_EQ(settle_class(cubes(std::nextafter(2.0, 3.0), 0, 0)).pair_class, PairClass::separated);
  EXPECT_EQ(settle_class(cubes(2.0 - 0x1p-51, 0, 0)).pair_class, PairClass::penetrating);
}

TEST(ClassSettler, OneOrdinaryPairNeedsNoInteger) {
  PosedSolids solids = cubes(1.75, 0.5, 0.25);
  solids.X_WB.R = rotation_from_quaternion(0.8, 0.2, -0.4, 0.3);
  EXPECT_EQ(settle_class(solids).directions_in_integers, 0);
  EXPECT_EQ(settle_class(solids).pair_class, PairClass::penetrating);
  solids.X_WB.p.x() = 3.5;
  EXPECT_EQ(settle_class(solids).directions_in_integers, 0);
  EXPECT_EQ(settle_class(solids).pair_class, PairClass::separated);
}

TEST(ClassSettler, SaysWhenItsDirectionsDoNotDecide) {
  // So far out that rounding leaves two overlapping squares in one plane.
  PosedSolids solids = cubes(0.5, 0.5, 0);
  solids.X_WA.p.z() = solids.X_WB.p.z() = 0x1p60;
  EXPECT_FALSE(settle_class(solids).pair_class);
  // The same plane, apart in another: any direction proves that.
  solids.X_WB.p.z() = 0x1p61;
  EXPECT_EQ(settle_class(solids).pair_class, PairClass::separated);
}

// The filter against integers for all directions, and both against `exact`.
TEST(ClassSettler, FilterIntegersAndExactAgree) {
  int unsettled = 0;
  for (std::size_t family = 0; family < families().size(); ++family) {
    const bool many = families()[family].name == "decoded";
    for (std::uint64_t index = 0; index < (many ? 150u : 15u); ++index) {
      const PosedSolids solids = make_pair(family, 7, index);
      WorldVertices a, b;
      world_vertices(solids.a, solids.X_WA, a), world_vertices(solids.b, solids.X_WB, b);
      const SettledClass settled = settle_class(solids);
      EXPECT_EQ(settled.pair_class, settle_class_in_integers(solids).pair_class) << pair_text(solids);
      unsettled += !settled.pair_class;
      if (settled.pair_class) {
        EXPECT_EQ(*settled.pair_class, exact_pair_class(a, b)) << pair_text(solids);
      }
    }
  }
  EXPECT_LT(unsettled, 20);
}

#ifdef TOUCHSTONE_HAS_SCENE_FILES
TEST(ClassSettler, IsRightOnTheHardCases) {
  int cases = 0;
  for (const char* file :
       {"containment", "coplanar", "far", "hexahedra", "near_parallel", "scale", "thin", "touching"}) {
    for (const PairCase& hard : load_pairs(std::string(TOUCHSTONE_HARD_CASES "/") + file + ".json")) {
      ASSERT_TRUE(hard.pair && hard.exact) << hard.id;
      const auto& [solids, X_WS] = *hard.pair;
      const SettledClass settled = settle_class({solids[0], solids[1], X_WS[0], X_WS[1]});
      ++cases;
      if (settled.pair_class) {
        EXPECT_EQ(*settled.pair_class, hard.exact->pair_class) << hard.id;
      }
    }
  }
  EXPECT_GT(cases, 100);
}
#endif

}  // namespace
}  // namespace touchstone::proof

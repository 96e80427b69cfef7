#include "touchstone/contact_core/fit/levels.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/contact_core/fit/fit.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/tests/fit/meshes.hpp"
#include "touchstone/tests/support/random_solid.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone {
namespace {

using testing::HasSubstr;

std::vector<std::shared_ptr<const HexahedronTree>> trees_of(const std::vector<CoarserLevel>& levels) {
  std::vector<std::shared_ptr<const HexahedronTree>> out;
  for (const CoarserLevel& level : levels) out.push_back(level.tree);
  return out;
}

/// Points of a hexahedron at random, corners among them.
Vector3 point_in(const Hexahedron& solid, Random& random) {
  Vector3 p = Vector3::Zero();
  double sum = 0.0;
  std::array<double, 8> weights;
  for (double& weight : weights) sum += weight = std::pow(random.uniform(0, 1), 8.0);
  for (std::size_t i = 0; i < 8; ++i) p += weights[i] / sum * solid.vertices()[i];
  return p;
}

TEST(CoarserLevels, OfATubeHoldWhatIsFinerAndKeepToTheirErrors) {
  const MeshDistance solid(weld(test::tube_mesh(0.4, 0.5, 1.0, 12)));
  FitOptions options;
  options.over = 0.05, options.repairs = 2;
  const HexahedronTree fine = make_tree(fit_hexahedra(solid, options), "tube");
  const std::array overs{0.06, 0.2, 2.0};
  const std::vector<CoarserLevel> levels = coarser_levels(fine, solid, overs);
  ASSERT_EQ(levels.size(), 3U);
  validate_levels(fine, trees_of(levels));
  Random random(18300);
  std::size_t before = fine.solids().size();
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_LE(levels[k].excess, overs[k]);
    EXPECT_LE(levels[k].tree->solids().size(), before);
    before = levels[k].tree->solids().size();
    double worst = 0.0;
    for (const PlacedHexahedron& placed : levels[k].tree->solids())
      for (int i = 0; i < 500; ++i) worst = std::max(worst, solid.to_solid(point_in(placed.solid, random)));
    EXPECT_LE(worst, levels[k].excess);
  }
  EXPECT_LT(levels[1].tree->solids().size(), fine.solids().size());
  EXPECT_EQ(before, 1U);  // one box about all
}

TEST(CoarserLevels, OfATreeAloneAreHeldTo) {
  Random random(18301);
  for (int run = 0; run < 2; ++run) {
    std::vector<PlacedHexahedron> solids;
    for (int i = 0; i < 30; ++i) {
      Pose X;
      X.R = rotation_from_quaternion(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1), 1);
      X.p = Vector3(0.4 * i, 0, 0) + random.vector(0.5) + Vector3::Constant(run % 2 ? 1e3 : 0.0);
      solids.push_back({"h" + std::to_string(i), random_solid(random, 1.0), X});
    }
    const HexahedronTree fine(solids, "pile");
    const std::vector<CoarserLevel> levels = coarser_levels(fine, std::array{0.6, 20.0});
    validate_levels(fine, trees_of(levels));
    EXPECT_LE(levels[0].excess, 0.6);
    EXPECT_LE(levels[1].excess, 20.0);
    EXPECT_LE(levels[0].tree->solids().size(), 30U);
    EXPECT_EQ(levels[1].tree->solids().size(), 1U);
  }
}

TEST(CoarserLevels, RefuseErrorsThatDoNotAscendAndRoundedHexahedra) {
  const HexahedronTree box({{"box", Hexahedron::from_size({1, 1, 1}), Pose{}}}, "box");
  for (const std::array overs : {std::array{0.1, 0.1}, {0.0, 1.0}, {0.1, std::nan("")}, {0.1, HUGE_VAL}})
    EXPECT_THAT(refusal_of([&] { coarser_levels(box, overs); }), HasSubstr("levels: error")) << overs[1];
  const HexahedronTree ball({{"ball", Hexahedron::sphere(1.0), Pose{}}}, "ball");
  EXPECT_THAT(refusal_of([&] { coarser_levels(ball, std::array{0.1}); }), HasSubstr("'ball' is rounded"));
}

}  // namespace
}  // namespace touchstone

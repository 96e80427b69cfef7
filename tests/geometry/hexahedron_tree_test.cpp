#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone {
namespace {

std::vector<PlacedHexahedron> random_solids(int count, std::mt19937_64& random) {
  std::vector<PlacedHexahedron> solids;
  for (int i = 0; i < count; ++i)
    solids.push_back(
        {"part" + std::to_string(i), Hexahedron::from_size({1, 0.5, 2}), random_pose(random, 10)});
  return solids;
}

void expect_encloses(const HexahedronTree& tree, int node, const Sphere& sphere) {
  const HexahedronTree::Node& below = tree.nodes()[node];
  if (below.solid < 0) {
    expect_encloses(tree, below.left, sphere);
    expect_encloses(tree, below.right, sphere);
    return;
  }
  const PlacedHexahedron& placed = tree.solids()[below.solid];
  for (const Vector3& p : placed.solid.vertices())
    EXPECT_LE(norm(transform(placed.X_OS, p) - sphere.centre), sphere.radius);
}

TEST(HexahedronTree, EveryNodesSphereEnclosesAllBelow) {
  std::mt19937_64 random(1);
  for (int count : {1, 2, 3, 7, 64, 100}) {
    const HexahedronTree tree(random_solids(count, random));
    EXPECT_EQ(tree.nodes().size(), 2u * count - 1);
    std::vector<int> seen(count, 0);
    for (std::size_t i = 0; i < tree.nodes().size(); ++i) {
      expect_encloses(tree, static_cast<int>(i), tree.nodes()[i].sphere_O);
      if (tree.nodes()[i].solid >= 0) ++seen[tree.nodes()[i].solid];
    }
    EXPECT_THAT(seen, testing::Each(1));
  }
}

TEST(HexahedronTree, BadInputIsRefusedNamingObjectAndPart) {
  std::mt19937_64 random(2);
  EXPECT_THROW(HexahedronTree({}, "arm"), InputError);
  auto solids = random_solids(3, random);
  solids[2].name = "part0";
  EXPECT_THAT([&] { HexahedronTree(solids, "arm"); },
              testing::ThrowsMessage<InputError>(
                  testing::AllOf(testing::HasSubstr("arm"), testing::HasSubstr("part0"))));
  solids = random_solids(3, random);
  solids[1].X_OS.R *= 2;
  EXPECT_THAT([&] { HexahedronTree(solids, "arm"); },
              testing::ThrowsMessage<InputError>(
                  testing::AllOf(testing::HasSubstr("arm"), testing::HasSubstr("part1"))));
}

TEST(HexahedronTree, GlobalPositionsAreTheComposedPoses) {
  std::mt19937_64 random(3);
  const HexahedronTree tree(random_solids(37, random));
  const Pose X_WO = random_pose(random, 1e4);
  std::vector<Pose> found(37);
  find_global_positions(tree, X_WO, found);
  for (int i = 0; i < 37; ++i) {
    const Pose expected = compose(X_WO, tree.solids()[i].X_OS);
    EXPECT_EQ(found[i].R, expected.R);
    EXPECT_EQ(found[i].p, expected.p);
  }
}

}  // namespace
}  // namespace touchstone

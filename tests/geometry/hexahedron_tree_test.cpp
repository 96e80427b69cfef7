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

using Node = HexahedronTree::Node;
Node leaf(int solid) { return {.sphere_O = {Vector3::Zero(), 0.0}, .solid = solid}; }
Node inner(int left, int right) { return {.sphere_O = {Vector3::Zero(), 0.0}, .left = left, .right = right}; }

TEST(HexahedronTree, TheUsersTreeIsKept) {
  std::mt19937_64 random(4);
  // ((2, 0), 1), in an order of the user's.
  const std::vector<Node> layout = {inner(3, 1), leaf(1), leaf(0), inner(4, 2), leaf(2)};
  const HexahedronTree tree(random_solids(3, random), layout, "arm");
  EXPECT_EQ(tree.name(), "arm");
  const std::array<std::array<int, 3>, 5> expected = {
      {{1, 4, -1}, {2, 3, -1}, {-1, -1, 2}, {-1, -1, 0}, {-1, -1, 1}}};
  ASSERT_EQ(tree.nodes().size(), expected.size());
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(tree.nodes()[i].left, expected[i][0]) << i;
    EXPECT_EQ(tree.nodes()[i].right, expected[i][1]) << i;
    EXPECT_EQ(tree.nodes()[i].solid, expected[i][2]) << i;
    expect_encloses(tree, i, tree.nodes()[i].sphere_O);
  }
}

TEST(HexahedronTree, AUsersTreeThatIsNoneIsRefusedNamingTheNode) {
  std::mt19937_64 random(5);
  const std::vector<PlacedHexahedron> solids = random_solids(2, random);
  const auto expect = [&](const std::vector<Node>& layout, const char* what) {
    EXPECT_THAT([&] { HexahedronTree(solids, layout, "arm"); },
                testing::ThrowsMessage<InputError>(
                    testing::AllOf(testing::HasSubstr("object 'arm'"), testing::HasSubstr(what))));
  };
  expect({}, "node 0 does not exist");
  expect({inner(1, 2), leaf(0)}, "node 2 does not exist");
  expect({inner(1, -1), leaf(0)}, "node -1 does not exist");
  expect({inner(1, 1), leaf(0)}, "node 1 is reached twice");
  expect({inner(1, 0), leaf(0)}, "node 0 is reached twice");
  expect({inner(1, 2), leaf(0), leaf(0)}, "node 2 holds hexahedron 0, as another does");
  expect({inner(1, 2), leaf(0), leaf(2)}, "node 2 holds hexahedron 2, which does not exist");
  expect({inner(1, 2), leaf(0), leaf(-1)}, "node 2 holds hexahedron -1, which does not exist");
  expect({leaf(0)}, "holds hexahedron 1");
  expect({inner(1, 2), leaf(0), leaf(1), leaf(1)}, "node 3 is not reached from the root");
  Node both = inner(1, 2);
  both.solid = 0;
  expect({both, leaf(0), leaf(1)}, "node 0 holds a solid and has children");
}

// A chain: every node has a leaf and the rest.
TEST(HexahedronTree, AUsersTreeHasABoundedDepth) {
  std::mt19937_64 random(6);
  const auto chain = [](int solids) {
    std::vector<Node> layout;
    for (int i = 0; i + 1 < solids; ++i) {
      layout.push_back(inner(2 * i + 1, 2 * i + 2));
      layout.push_back(leaf(i));
    }
    layout.push_back(leaf(solids - 1));
    return layout;
  };
  const int most = HexahedronTree::kMostLevels;
  EXPECT_EQ(HexahedronTree(random_solids(most, random), chain(most)).nodes().size(), 2u * most - 1);
  EXPECT_THROW(HexahedronTree(random_solids(most + 1, random), chain(most + 1)), InputError);
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

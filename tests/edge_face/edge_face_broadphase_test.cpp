#include <gtest/gtest.h>

#include "touchstone/tests/broadphase/random_scene.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

// The paper's coarse check: what it finds, and what it keeps of that build. What it shares with the others is
// tested with them.

namespace touchstone {
namespace {

using namespace broadphase_tests;

// Boxes centred on their frames, one an object, have the same spheres in both.
TEST(EdgeFaceBroadphase, FindsWhatBruteForceFindsAmongCentredBoxes) {
  std::mt19937_64 random(71);
  for (int objects : {2, 5, 100, 400}) {
    Scene scene;
    for (int i = 0; i < objects; ++i)
      scene.add({{"", Hexahedron::from_size(Vector3::Constant(1.1) + random_vector(random, 1.0)), {}}},
                random_pose(random, 1.5 * std::cbrt(objects)));
    const Pairs found = sweep(*make("edge_face", scene, 0.05), 256);
    EXPECT_GE(found.size(), static_cast<std::size_t>(objects / 2));
    EXPECT_EQ(found, sweep(*make("brute_force", scene, 0.05), 256)) << objects;
  }
}

// An inner node holds the vertices below, not the spheres: it may rule out pairs of spheres that meet.
TEST(EdgeFaceBroadphase, TreesFindNoMoreThanBruteForce) {
  const Scene scene = random_scene(300, 25, 0, 72);
  const Pairs found = sweep(*make("edge_face", scene, 0.05), 256);
  const Pairs spheres = sweep(*make("brute_force", scene, 0.05), 256);
  EXPECT_TRUE(std::includes(spheres.begin(), spheres.end(), found.begin(), found.end()));
  EXPECT_GT(found.size(), 9 * spheres.size() / 10);
  EXPECT_LT(found.size(), spheres.size());
}

// Half sizes 1, 2, 2: a radius of 3 without rounding, and a corner on the line of the centres.
Scene corner_to_corner(const Vector3& p) {
  Scene scene;
  const Hexahedron box = Hexahedron::from_size({2, 4, 4});
  scene.add({{"", box, {}}}, {});
  scene.add({{"", box, {}}}, {Matrix3::Identity(), p});
  return scene;
}

TEST(EdgeFaceBroadphase, MissesSpheresThatTouchExactly) {
  const Scene touching = corner_to_corner({2, 4, 4});
  EXPECT_EQ(sweep(*make("brute_force", touching, 0.0), 4), Pairs({{0, 1}}));
  EXPECT_EQ(sweep(*make("edge_face", touching, 0.0), 4), Pairs());
  EXPECT_EQ(sweep(*make("edge_face", touching, 0x1p-40), 4), Pairs({{0, 1}}));
  EXPECT_EQ(sweep(*make("edge_face", corner_to_corner({2, 4, 4 - 0x1p-40}), 0.0), 4), Pairs({{0, 1}}));
}

// A cube that lies 10 m from its frame: the sphere about the frame reaches round to the other side.
TEST(EdgeFaceBroadphase, RadiiAreAboutTheFrames) {
  auto corners = Hexahedron::from_size({1, 1, 1}).vertices();
  for (Vector3& p : corners) p.x() += 10;
  Scene scene;
  scene.add({{"", Hexahedron::from_vertices(corners), {}}}, {});
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1});
  const double reach = std::sqrt(10.5 * 10.5 + 0.5) + std::sqrt(0.75);
  scene.add({{"", cube, {}}}, {Matrix3::Identity(), {-reach + 1e-9, 0, 0}});
  scene.add({{"", cube, {}}}, {Matrix3::Identity(), {-reach - 1e-9, 0, 0}});
  EXPECT_EQ(sweep(*make("brute_force", scene, 0.0), 4), Pairs({{1, 2}}));
  EXPECT_EQ(sweep(*make("edge_face", scene, 0.0), 4), Pairs({{0, 1}, {1, 2}}));
}

// The first cube lies at the object's origin, its own frame 10 m from there, so that its sphere reaches the
// other object. Together with the second it is within 2 m of the object's origin and out of range.
TEST(EdgeFaceBroadphase, DescendsTheUsersTree) {
  using Node = HexahedronTree::Node;
  auto corners = Hexahedron::from_size({1, 1, 1}).vertices();
  for (Vector3& p : corners) p.x() -= 10;
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1});
  const std::vector<PlacedHexahedron> solids = {
      {"", Hexahedron::from_vertices(corners), {Matrix3::Identity(), {10, 0, 0}}},
      {"", cube, {}},
      {"", cube, {Matrix3::Identity(), {30, 0, 0}}}};
  const auto leaf = [](int solid) { return Node{.sphere_O = {Vector3::Zero(), 0.0}, .solid = solid}; };
  const auto inner = [](int left, int right) {
    return Node{.sphere_O = {Vector3::Zero(), 0.0}, .left = left, .right = right};
  };
  const std::vector<Node> apart = {inner(1, 2), leaf(0), inner(3, 4), leaf(1), leaf(2)};
  const std::vector<Node> together = {inner(1, 2), inner(3, 4), leaf(2), leaf(0), leaf(1)};
  for (const bool is_together : {false, true}) {
    Scene scene;
    scene.trees.reserve(2);
    scene.add(solids, {});
    scene.add({{"", cube, {}}}, {Matrix3::Identity(), {20, 0, 0}});
    scene.trees[0] = HexahedronTree(solids, is_together ? together : apart);
    EXPECT_EQ(sweep(*make("edge_face", scene, 0.0), 4), is_together ? Pairs() : Pairs({{0, 3}}));
    EXPECT_EQ(sweep(*make("native", scene, 0.0), 4), Pairs());
  }
}

TEST(EdgeFaceBroadphase, AllocatesAListNodeForEachPairInEachFrame) {
  const Scene scene = random_scene(80, 15, 0, 8);
  const auto broadphase = make("edge_face", scene, 0.1);
  Pairs block(64);
  for (int frame = 0; frame < 3; ++frame) {
    const std::size_t before = allocation_count();
    broadphase->update(scene.poses, {});
    const std::size_t after = allocation_count();
    std::size_t pairs = 0;
    for (PairCursor cursor; !cursor.done;) pairs += broadphase->find_pairs(cursor, block);
    ASSERT_GT(pairs, 100u);
    EXPECT_EQ(after - before, pairs);
    EXPECT_EQ(allocation_count(), after);
  }
}

TEST(EdgeFaceBroadphase, KnowsPosesOnly) {
  const Scene scene = random_scene(40, 8, 0, 9);
  const auto broadphase = make("edge_face", scene, 0.1);
  const Pairs all = sweep(*broadphase, 64);
  ASSERT_FALSE(all.empty());
  EXPECT_FALSE(broadphase->update_paths({scene.poses, scene.poses, {}}, {}));
  EXPECT_EQ(sweep(*broadphase, 64), all);
}

}  // namespace
}  // namespace touchstone

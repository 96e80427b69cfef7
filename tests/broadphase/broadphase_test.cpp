#include "touchstone/contact_core/broadphase/broadphase.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/broadphase/random_scene.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone {
namespace {

using namespace broadphase_tests;

// Pairs that must come up: a vertex or a midpoint of two vertices of one solid is within margin of one of the
// other's. These points lie in the hulls, so such hulls are within margin beyond doubt; long double keeps
// rounding out.
Pairs surely_close(const Scene& scene, double margin) {
  using P = Eigen::Matrix<long double, 3, 1>;
  std::vector<std::vector<P>> points(scene.solids.size());
  for (std::size_t s = 0; s < scene.solids.size(); ++s) {
    WorldVertices v;
    world_vertices(scene.solids[s], scene.poses[s], v);
    for (int i = 0; i < 8; ++i)
      for (int j = i; j < 8; ++j)
        points[s].push_back((v.vertex(i).cast<long double>() + v.vertex(j).cast<long double>()) / 2);
  }
  Pairs pairs;
  const auto close = [&](std::size_t a, std::size_t b) {
    for (const P& p : points[a])
      for (const P& q : points[b])
        if ((p - q).squaredNorm() <= static_cast<long double>(margin) * margin) return true;
    return false;
  };
  for (SolidIndex a = 0; a < points.size(); ++a)
    for (SolidIndex b = a + 1; b < points.size(); ++b)
      if (scene.object_of[a] != scene.object_of[b] && close(a, b)) pairs.push_back({a, b});
  return pairs;
}

class BroadphaseTest : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Core, BroadphaseTest, testing::Values("brute_force", "native", "edge_face"),
                         [](const auto& test) { return std::string(test.param); });

// Properties that the paper's broadphase lacks by its documentation: edge_face_broadphase_test.cpp.
class WholeContractTest : public BroadphaseTest {};
INSTANTIATE_TEST_SUITE_P(Core, WholeContractTest, testing::Values("brute_force", "native"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(BroadphaseTest, NeverMissesAPairWithinMargin) {
  for (double offset : {0.0, 1e6, 1e12})
    for (double margin : {0.3, 1.0}) {
      const Scene scene = random_scene(60, 5, offset, 7);
      const Pairs found = sweep(*make(GetParam(), scene, margin), 64);
      const Pairs close = surely_close(scene, margin);
      ASSERT_GT(close.size(), 50u);
      EXPECT_TRUE(std::includes(found.begin(), found.end(), close.begin(), close.end())) << offset;
      EXPECT_EQ(std::adjacent_find(found.begin(), found.end(), std::greater_equal<>()), found.end());
      for (SolidPair pair : found) {
        ASSERT_LT(pair.a, pair.b);
        ASSERT_NE(scene.object_of[pair.a], scene.object_of[pair.b]);
      }
    }
}

TEST_P(BroadphaseTest, AnyBlockSizeGivesTheSameSequence) {
  const Scene scene = random_scene(80, 15, 0, 8);
  const auto broadphase = make(GetParam(), scene, 0.1);
  const Pairs all = sweep(*broadphase, 100000);
  ASSERT_GT(all.size(), 100u);
  for (std::size_t block : {1, 2, 3, 7, 64}) EXPECT_EQ(sweep(*broadphase, block), all);
  EXPECT_EQ(sweep(*broadphase, all.size()), all);
}

TEST_P(BroadphaseTest, CursorsOnTheSameSweepDoNotDisturbEachOther) {
  const Scene scene = random_scene(40, 8, 0, 9);
  const auto broadphase = make(GetParam(), scene, 0.1);
  const Pairs all = sweep(*broadphase, 1000);
  PairCursor one, other;
  Pairs block(5);
  ASSERT_EQ(broadphase->find_pairs(one, block), 5u);
  broadphase->find_pairs(other, block);
  broadphase->find_pairs(other, block);
  ASSERT_EQ(broadphase->find_pairs(one, block), 5u);
  EXPECT_TRUE(std::equal(block.begin(), block.end(), all.begin() + 5));
}

TEST_P(WholeContractTest, BoxesThatTouchExactlyComeUpAtAnyScaleAndPlace) {
  for (double size : {1e-300, 1e-160, 1e-8, 1.0, 1e8, 1e153})
    for (double place : {0.0, 1e3, 1e15}) {
      Scene scene;
      const Hexahedron cube = Hexahedron::from_size(Vector3::Constant(size));
      const Vector3 p = place * size * Vector3(1, 1, 1);
      scene.add({{"", cube, {}}}, {Matrix3::Identity(), p});
      scene.add({{"", cube, {}}}, {Matrix3::Identity(), p + Vector3(size, size, size)});
      EXPECT_EQ(sweep(*make(GetParam(), scene, 0.0), 4), Pairs({{0, 1}})) << size << " at " << place;
    }
}

TEST_P(BroadphaseTest, BoxesFarApartDoNotComeUp) {
  Scene scene;
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1});
  for (double x : {0.0, 3.0, 1e6}) scene.add({{"", cube, {}}}, {Matrix3::Identity(), {x, 0, 0}});
  EXPECT_EQ(sweep(*make(GetParam(), scene, 0.0), 4), Pairs());
  EXPECT_EQ(sweep(*make(GetParam(), scene, 1.3), 4), Pairs({{0, 1}}));
}

TEST_P(BroadphaseTest, UpdatesWithMovedObjectsMatchAFreshBuild) {
  Scene scene = random_scene(120, 18, 0, 10);
  const auto broadphase = make(GetParam(), scene, 0.1);
  std::mt19937_64 random(11);
  for (int frame = 0; frame < 30; ++frame) {
    std::vector<std::uint32_t> moved;
    for (std::uint32_t object = frame % 7; object < 120; object += 7) {
      scene.place(object, random_pose(random, 18));
      moved.push_back(object);
    }
    broadphase->update(scene.poses, moved);
    ASSERT_EQ(sweep(*broadphase, 64), sweep(*make(GetParam(), scene, 0.1), 64)) << frame;
  }
}

TEST_P(WholeContractTest, FramesDoNotAllocate) {
  Scene scene = random_scene(200, 20, 0, 12);
  const auto broadphase = make(GetParam(), scene, 0.1);
  std::vector<std::uint32_t> everything(200);
  std::iota(everything.begin(), everything.end(), 0u);
  Pairs block(64);
  std::mt19937_64 random(13);
  for (double extent : {20.0, 5.0, 0.1}) {  // in the end everything overlaps everything
    for (std::uint32_t object = 0; object < 200; ++object) scene.place(object, random_pose(random, extent));
    const std::size_t before = allocation_count();
    broadphase->update(scene.poses, everything);
    for (PairCursor cursor; !cursor.done;) broadphase->find_pairs(cursor, block);
    EXPECT_EQ(allocation_count(), before);
  }
}

TEST_P(BroadphaseTest, EmptyAndSingleObjectScenesHaveNoPairs) {
  EXPECT_EQ(sweep(*make(GetParam(), {}, 0.0), 4), Pairs());
  EXPECT_EQ(sweep(*make(GetParam(), random_scene(1, 1, 0, 14), 1.0), 4), Pairs());
}

TEST_P(BroadphaseTest, BadInputIsRefusedAndTheOldBuildStays) {
  const Scene scene = random_scene(30, 5, 0, 15);
  const auto broadphase = make(GetParam(), scene, 0.1);
  const Pairs all = sweep(*broadphase, 64);
  const auto trees = scene.tree_pointers();
  const std::vector<const HexahedronTree*> none = {nullptr};
  EXPECT_THROW(broadphase->build({none, 0.0}), InputError);
  for (double margin : {-1.0, double(NAN), double(INFINITY)})
    EXPECT_THROW(broadphase->build({trees, margin}), InputError);
  EXPECT_EQ(sweep(*broadphase, 64), all);
}

// Both cull by the same spheres of solids in the end, so here they agree to the pair.
TEST(NativeBroadphase, FindsWhatBruteForceFinds) {
  for (int objects : {2, 3, 5, 9, 100, 700}) {
    const Scene scene = random_scene(objects, 4 * std::cbrt(objects), 0, 16);
    EXPECT_EQ(sweep(*make("native", scene, 0.05), 256), sweep(*make("brute_force", scene, 0.05), 256))
        << objects;
  }
}

// A chain as the user lays it out, the leaf that comes last on top.
HexahedronTree chain_of(const HexahedronTree& tree) {
  std::vector<HexahedronTree::Node> layout;
  const int count = static_cast<int>(tree.solids().size());
  for (int i = 0; i + 1 < count; ++i) {
    layout.push_back({.sphere_O = {Vector3::Zero(), 0.0}, .left = 2 * i + 2, .right = 2 * i + 1});
    layout.push_back({.sphere_O = {Vector3::Zero(), 0.0}, .solid = count - 1 - i});
  }
  layout.push_back({.sphere_O = {Vector3::Zero(), 0.0}, .solid = 0});
  return HexahedronTree(tree.solids(), layout, tree.name());
}

TEST(NativeBroadphase, FindsWhatBruteForceFindsInTreesOfTheUsers) {
  Scene scene = random_scene(300, 25, 0, 18);
  const Pairs found = sweep(*make("brute_force", scene, 0.05), 256);
  for (HexahedronTree& tree : scene.trees) tree = chain_of(tree);
  ASSERT_GT(found.size(), 100u);
  EXPECT_EQ(sweep(*make("native", scene, 0.05), 256), found);
}

// Centres of a crowd of unit boxes.
struct Crowd {
  const char* name;
  int objects;
  Vector3 (*centre)(int i);
};

Vector3 grid_point(int i, int side) {
  const int column = i % side, row = i / side % side, layer = i / side / side;
  return 4.0 * Vector3(column, row, layer);
}

Vector3 plane_point(int i) {
  const int column = i % 24, row = i / 24;
  return {0.9 * column, 0.9 * row, 7};
}

const Crowd kCrowds[] = {
    {"one place", 150, [](int) -> Vector3 { return Vector3(3, 4, 5); }},
    {"line", 600, [](int i) -> Vector3 { return Vector3(0.5 * i, 0, 0); }},
    {"plane", 600, plane_point},
    {"stray", 600,
     [](int i) -> Vector3 { return i == 0 ? Vector3(1e15, -1e15, 1e15) : Vector3(0.3 * grid_point(i, 9)); }},
    {"two far crowds", 600,
     [](int i) -> Vector3 { return (i % 2) * Vector3(1e8, 0, 0) + 0.3 * grid_point(i, 9); }},
    {"each twice as far", 600, [](int i) -> Vector3 { return Vector3(std::scalbn(1.0, i - 300), 0, 0); }},
};

Scene crowd_scene(const Crowd& crowd, int objects) {
  Scene scene;
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1});
  for (int i = 0; i < objects; ++i) scene.add({{"", cube, {}}}, {Matrix3::Identity(), crowd.centre(i)});
  return scene;
}

TEST(NativeBroadphase, FindsWhatBruteForceFindsInDegenerateCrowds) {
  for (const Crowd& crowd : kCrowds) {
    const Scene scene = crowd_scene(crowd, crowd.objects);
    const Pairs found = sweep(*make("native", scene, 0.0), 256);
    EXPECT_GT(found.size(), 100u) << crowd.name;
    EXPECT_EQ(found, sweep(*make("brute_force", scene, 0.0), 256)) << crowd.name;
  }
}

TEST(NativeBroadphase, FindsWhatBruteForceFindsAmongGiants) {
  std::mt19937_64 random(17);
  Scene scene;
  for (int i = 0; i < 500; ++i) {
    const double size = std::pow(10.0, -(i % 10));
    scene.add({{"", Hexahedron::from_size(Vector3::Constant(size)), {}}}, random_pose(random, 3));
  }
  EXPECT_EQ(sweep(*make("native", scene, 0.0), 256), sweep(*make("brute_force", scene, 0.0), 256));
}

// Objects so far away that the others are one point beside them, in any common float frame.
TEST(NativeBroadphase, StrayObjectsDoNotChangeThePairsOfTheCrowd) {
  constexpr int kObjects = 2000;
  Scene scene = crowd_scene(
      {"", kObjects, [](int i) -> Vector3 { return 0.3 * grid_point(i * 7919 % kObjects, 13); }}, kObjects);
  std::vector<SolidPair> crowd = sweep(*make("native", scene, 0.0), 256);
  std::erase_if(crowd, [](const SolidPair& pair) { return pair.a < 2; });
  scene.place(0, {Matrix3::Identity(), {1e15, 1e15, 1e15}});
  scene.place(1, {Matrix3::Identity(), {-1e15, -1e15, -1e15}});
  EXPECT_GT(crowd.size(), 1000u);
  EXPECT_EQ(sweep(*make("native", scene, 0.0), 256), crowd);
}

}  // namespace
}  // namespace touchstone

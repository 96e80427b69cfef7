#include <algorithm>

#include "touchstone/contact_core/broadphase/swept_sphere.hpp"
#include "touchstone/contact_core/scene/motion.hpp"
#include "touchstone/tests/backend_suite/suite.hpp"
#include "touchstone/tests/support/random_poses.hpp"

// Properties of every broadphase: sorted, the same for every block size, and no pair within the margin
// missed.

namespace touchstone::suite {
namespace {

// Objects of one to five hexahedra, a third of them rounded, sizes over three decades, some touching by
// construction.
struct RandomScene {
  std::vector<HexahedronTree> trees;
  std::vector<Hexahedron> solids;
  std::vector<std::uint32_t> object_of;
  std::vector<Pose> X_WO;
  std::vector<Pose> poses;
  Vector3 centre;
  double extent;

  RandomScene(std::uint64_t seed, int objects, const Vector3& where, double half_width)
      : centre(where), extent(half_width) {
    std::mt19937_64 random(seed);
    for (int k = 0; k < objects; ++k) {
      std::vector<PlacedHexahedron> placed;
      const double size = std::exp2(uniform(random, -5, 2));
      const int count = 1 + static_cast<int>(random() % 5);
      for (int i = 0; i < count; ++i) {
        const Vector3 sides(size * uniform(random, 0.1, 1), size * uniform(random, 0.1, 1), size);
        const Hexahedron solid = random() % 3 == 0
                                     ? Hexahedron::rounded_box({0.0, sides.x(), sides.z()}, sides.y())
                                     : Hexahedron::from_size(sides);
        placed.push_back({"part" + std::to_string(i), solid, random_pose(random, size)});
      }
      for (const PlacedHexahedron& part : placed) {
        solids.push_back(part.solid);
        object_of.push_back(static_cast<std::uint32_t>(k));
      }
      trees.emplace_back(std::move(placed), "object" + std::to_string(k));
      X_WO.push_back(random_pose(random, centre, extent));
    }
    place();
  }

  void place() {
    poses.resize(solids.size());
    std::size_t first = 0;
    for (std::size_t k = 0; k < trees.size(); ++k) {
      const std::size_t count = trees[k].solids().size();
      find_global_positions(trees[k], X_WO[k], std::span(poses).subspan(first, count));
      first += count;
    }
  }

  std::vector<std::uint32_t> move_some(std::mt19937_64& random) {
    std::vector<std::uint32_t> moved;
    for (std::uint32_t k = 0; k < trees.size(); ++k)
      if (random() % 3 == 0) moved.push_back(k), X_WO[k] = random_pose(random, centre, extent);
    place();
    return moved;
  }

  std::vector<const HexahedronTree*> pointers() const {
    std::vector<const HexahedronTree*> all;
    for (const HexahedronTree& tree : trees) all.push_back(&tree);
    return all;
  }
};

std::vector<SolidPair> all_pairs(Broadphase& broadphase, std::size_t block_size) {
  std::vector<SolidPair> pairs;
  std::vector<SolidPair> block(block_size);
  PairCursor cursor;
  while (!cursor.done) {
    const std::size_t count = broadphase.find_pairs(cursor, block);
    EXPECT_TRUE(count > 0 || cursor.done) << "no progress";
    pairs.insert(pairs.end(), block.begin(), block.begin() + static_cast<std::ptrdiff_t>(count));
  }
  return pairs;
}

// Pairs truly within the margin, by the native distance (itself held to `exact` elsewhere).
std::vector<SolidPair> pairs_within(const RandomScene& scene, double margin) {
  BackendRegistry core;
  register_core(core);
  const auto native = core.make_narrowphase("native");
  native->build(scene.solids);
  const auto workspace = native->make_workspace();
  std::vector<SolidPair> within;
  for (SolidIndex a = 0; a < scene.solids.size(); ++a) {
    for (SolidIndex b = a + 1; b < scene.solids.size(); ++b) {
      if (scene.object_of[a] == scene.object_of[b]) continue;
      const double reach = scene.solids[a].size() + scene.solids[b].size() +
                           (scene.solids[a].radius() + scene.solids[b].radius()) + margin;
      if (norm(scene.poses[a].p - scene.poses[b].p) > reach) continue;
      const std::array pairs = {SolidPair{a, b}};
      std::array<PairStatus, 1> status{};
      std::array<PairGeometry, 1> geometry{};
      native->evaluate({.pairs = pairs, .poses = scene.poses, .query = {.kind = QueryKind::distance}},
                       {.status = status, .geometry = geometry}, *workspace);
      if (geometry[0].separation <= margin) within.push_back({a, b});
    }
  }
  return within;
}

class BroadphaseSuite : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { broadphase = backends().make_broadphase(GetParam()); }
  std::unique_ptr<Broadphase> broadphase;
};

void expect_sound(Broadphase& broadphase, const RandomScene& scene, double margin) {
  const std::vector<SolidPair> found = all_pairs(broadphase, 64);
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_LT(found[i].a, found[i].b);
    ASSERT_NE(scene.object_of[found[i].a], scene.object_of[found[i].b]);
    if (i > 0) {
      ASSERT_LT(found[i - 1], found[i]);
    }
  }
  const std::vector<SolidPair> needed = pairs_within(scene, margin);
  ASSERT_FALSE(needed.empty());
  std::vector<SolidPair> missed;
  std::set_difference(needed.begin(), needed.end(), found.begin(), found.end(), std::back_inserter(missed));
  EXPECT_TRUE(missed.empty()) << missed.size() << " of " << needed.size() << " pairs missed, first ("
                              << missed[0].a << ", " << missed[0].b << ")";
}

TEST_P(BroadphaseSuite, NeverMissesAPair) {
  struct Place {
    Vector3 centre;
    double margin;
  };
  for (const Place& place : {Place{{0, 0, 0}, 0.0}, Place{{0, 0, 0}, 0.3}, Place{{1e3, -2e3, 17.0}, 1e-3},
                             Place{{1e6, 1e6, -1e6}, 0.0}}) {
    RandomScene scene(7, 60, place.centre, 4.0);
    const auto trees = scene.pointers();
    broadphase->build({.trees = trees, .margin = place.margin});
    broadphase->update(scene.poses, {});
    SCOPED_TRACE("centre x " + std::to_string(place.centre.x()));
    expect_sound(*broadphase, scene, place.margin);
    std::mt19937_64 random(11);
    for (int frame = 0; frame < 3; ++frame) {
      const std::vector<std::uint32_t> moved = scene.move_some(random);
      broadphase->update(scene.poses, moved);
      expect_sound(*broadphase, scene, place.margin);
    }
  }
}

TEST_P(BroadphaseSuite, StaticObjectsPairWithMovingOnes) {
  RandomScene scene(17, 60, {0, 0, 0}, 4.0);
  const auto trees = scene.pointers();
  std::vector<std::uint8_t> is_static(trees.size());
  for (std::size_t k = 0; k < is_static.size(); k += 2) is_static[k] = 1;
  broadphase->build({.trees = trees, .margin = 0.1, .is_static = is_static});
  broadphase->update(scene.poses, {});
  const std::vector<SolidPair> found = all_pairs(*broadphase, 64);
  std::vector<SolidPair> needed = pairs_within(scene, 0.1);
  std::erase_if(needed, [&](SolidPair pair) {
    return is_static[scene.object_of[pair.a]] != 0 && is_static[scene.object_of[pair.b]] != 0;
  });
  ASSERT_FALSE(needed.empty());
  EXPECT_TRUE(std::includes(found.begin(), found.end(), needed.begin(), needed.end()));
}

// Objects that go and turn from where they are by interpolate(); some rest.
struct ScenePaths {
  std::vector<Pose> X_WO_from, X_WO_to;
  std::vector<Pose> from, to;
  std::vector<double> bulge;

  SolidPaths paths() const { return {from, to, bulge}; }

  /// Leaves the scene's poses at the start of the paths. Returns the objects that have new ones.
  std::vector<std::uint32_t> draw(RandomScene& scene, std::mt19937_64& random) {
    std::vector<std::uint32_t> changed;
    // The last paths' ends are these ones' starts.
    const bool first = X_WO_from.empty();
    X_WO_from = scene.X_WO;
    if (first) X_WO_to = scene.X_WO, bulge.assign(scene.solids.size(), 0.0);
    // A third stays. What moved before or moves now is reported.
    for (std::uint32_t k = 0; k < scene.trees.size(); ++k) {
      const bool had_moved = X_WO_to[k].p != X_WO_from[k].p;
      const bool moves = random() % 3 != 0;
      if (moves) {
        X_WO_to[k] = random_pose(random, scene.centre, scene.extent);
        if (k % 2 != 0) X_WO_to[k].p = X_WO_from[k].p + random_vector(random, 0.3);
      } else {
        X_WO_to[k] = X_WO_from[k];
      }
      if (moves || had_moved || first) changed.push_back(k);
    }
    // Solids' poses at both ends, and how far each turns off the straight line between them.
    from = scene.poses;
    scene.X_WO = X_WO_to;
    scene.place();
    to = scene.poses;
    std::size_t solid = 0;
    for (std::size_t k = 0; k < scene.trees.size(); ++k)
      for (const PlacedHexahedron& placed : scene.trees[k].solids()) {
        const double arm = norm(transform(placed.X_OS, placed.solid.bounding_sphere().centre)) * (1 + 1e-15);
        bulge[solid++] = bulge_of_interpolation(arm, X_WO_from[k], X_WO_to[k]);
      }
    scene.X_WO = X_WO_from;
    scene.place();
    return changed;
  }

  /// Every object somewhere on its path, each at a time of its own: one of them may have been stopped.
  void place_along(RandomScene& scene, std::mt19937_64& random) const {
    for (std::size_t k = 0; k < scene.trees.size(); ++k)
      scene.X_WO[k] = interpolate(X_WO_from[k], X_WO_to[k], uniform(random, 0, 1));
    scene.place();
  }
};

/// By the interface a broadphase may take poses only (update_paths() returns false); the paper's is the only
/// one here.
bool knows_poses_only(Broadphase& broadphase, const SolidPaths& paths) {
  return broadphase.name() == "edge_face" && !broadphase.update_paths(paths, {});
}

// Whole paths that bend and turn, sampled; what came to rest and a change back to poses among them.
TEST_P(BroadphaseSuite, NoPairThatMeetsOnItsPathsIsMissed) {
  RandomScene scene(19, 50, {10, -20, 5}, 4.0);
  const auto trees = scene.pointers();
  broadphase->build({.trees = trees, .margin = 0.01});
  std::mt19937_64 random(23);
  ScenePaths moving;
  std::size_t found_over = 0, found_at_rest = 0;
  for (int frame = 0; frame < 6; ++frame) {
    const std::vector<std::uint32_t> changed = moving.draw(scene, random);
    if (knows_poses_only(*broadphase, moving.paths())) GTEST_SKIP() << "knows poses only";
    ASSERT_TRUE(broadphase->update_paths(moving.paths(), changed)) << GetParam() << " knows poses only";
    const std::vector<SolidPair> found = all_pairs(*broadphase, 64);
    found_over += found.size();
    for (int i = 0; i < 12; ++i) {
      moving.place_along(scene, random);
      const std::vector<SolidPair> needed = pairs_within(scene, 0.01);
      ASSERT_FALSE(needed.empty());
      EXPECT_TRUE(std::includes(found.begin(), found.end(), needed.begin(), needed.end()))
          << "frame " << frame << " sample " << i;
    }
    if (frame == 3) {
      broadphase->update(scene.poses, {});
      expect_sound(*broadphase, scene, 0.01);
      found_at_rest = all_pairs(*broadphase, 64).size();
    }
  }
  // Paths are covered, and not everything is a pair.
  EXPECT_GT(found_over, 6 * found_at_rest);
  EXPECT_LT(found_over, 6 * scene.solids.size() * (scene.solids.size() - 1) / 2);
}

TEST_P(BroadphaseSuite, BlockSizeDoesNotShowOnPaths) {
  RandomScene scene(29, 50, {0, 0, 0}, 3.0);
  const auto trees = scene.pointers();
  broadphase->build({.trees = trees, .margin = 0.01});
  std::mt19937_64 random(31);
  ScenePaths moving;
  const std::vector<std::uint32_t> changed = moving.draw(scene, random);
  if (knows_poses_only(*broadphase, moving.paths())) GTEST_SKIP() << "knows poses only";
  ASSERT_TRUE(broadphase->update_paths(moving.paths(), changed));
  const std::vector<SolidPair> whole = all_pairs(*broadphase, 1 << 16);
  ASSERT_GT(whole.size(), 10u);
  for (std::size_t block : {1, 7, 64}) EXPECT_EQ(all_pairs(*broadphase, block), whole) << block;
}

TEST_P(BroadphaseSuite, BlockSizeDoesNotShow) {
  RandomScene scene(3, 50, {0, 0, 0}, 3.0);
  const auto trees = scene.pointers();
  broadphase->build({.trees = trees, .margin = 0.01});
  broadphase->update(scene.poses, {});
  const std::vector<SolidPair> whole = all_pairs(*broadphase, 1 << 16);
  ASSERT_GT(whole.size(), 10u);
  for (std::size_t block : {1, 2, 7, 64}) EXPECT_EQ(all_pairs(*broadphase, block), whole) << block;
}

TEST_P(BroadphaseSuite, TouchingFacesAndIdenticalObjectsArePairs) {
  std::vector<HexahedronTree> trees;
  for (int k = 0; k < 3; ++k)
    trees.emplace_back(std::vector<PlacedHexahedron>{{"cube", Hexahedron::from_size({1, 1, 1}), {}}},
                       "object" + std::to_string(k));
  std::vector<const HexahedronTree*> pointers = {&trees[0], &trees[1], &trees[2]};
  std::vector<Pose> poses(3);
  poses[1].p = {1.0, 0.0, 0.0};  // face to face
  broadphase->build({.trees = pointers, .margin = 0.0});
  broadphase->update(poses, {});
  const std::vector<SolidPair> expected = {{0, 1}, {0, 2}, {1, 2}};
  EXPECT_EQ(all_pairs(*broadphase, 1), expected);
}

TEST_P(BroadphaseSuite, OneObjectHasNoPairs) {
  const HexahedronTree tree(
      {{"a", Hexahedron::from_size({1, 1, 1}), {}}, {"b", Hexahedron::from_size({1, 1, 1}), {}}});
  const std::array trees = {&tree};
  const std::array<Pose, 2> poses;
  broadphase->build({.trees = trees, .margin = 0.0});
  broadphase->update(poses, {});
  EXPECT_TRUE(all_pairs(*broadphase, 8).empty());
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(BroadphaseSuite);  // a program may have none
INSTANTIATE_TEST_SUITE_P(AllBackends, BroadphaseSuite, testing::ValuesIn(broadphase_names()),
                         [](const auto& test) { return test.param; });

}  // namespace

void link_broadphase_suite() {}

}  // namespace touchstone::suite

#include <gtest/gtest.h>

#include <array>
#include <numeric>

#include "touchstone/tests/broadphase/random_scene.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

// Static objects, and frames in which only some objects move.

namespace touchstone {
namespace {

using namespace broadphase_tests;

std::vector<std::uint8_t> every(std::size_t nth, std::size_t objects) {
  std::vector<std::uint8_t> flags(objects);
  for (std::size_t i = 0; i < objects; i += nth) flags[i] = 1;
  return flags;
}

class IncrementalTest : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Core, IncrementalTest, testing::Values("brute_force", "native"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(IncrementalTest, StaticObjectsPairWithMovingOnesOnly) {
  const Scene scene = random_scene(120, 12, 0, 31);
  const std::vector<std::uint8_t> is_static = every(2, 120);
  Pairs expected = sweep(*make(GetParam(), scene, 0.1), 64);
  const std::size_t all = expected.size();
  std::erase_if(expected, [&](const SolidPair& pair) {
    return is_static[scene.object_of[pair.a]] && is_static[scene.object_of[pair.b]];
  });
  ASSERT_LT(expected.size(), all);
  EXPECT_EQ(sweep(*make(GetParam(), scene, 0.1, is_static), 64), expected);
  EXPECT_EQ(sweep(*make(GetParam(), scene, 0.1, std::vector<std::uint8_t>(120, 1)), 64), Pairs());
  EXPECT_THROW(build(GetParam(), scene, 0.1, every(2, 119)), std::exception);
}

// Frames of every kind in turn: none, one, few, many, all moved; several updates before pairs are asked for;
// pairs asked for in part.
void run_any_history(const std::string& name, Scene scene, double extent, bool is_for_grid) {
  constexpr std::uint32_t kObjects = 900;
  const bool is_native = name == "native";
  const std::vector<std::uint8_t> is_static = every(5, kObjects);
  const auto broadphase = make(name, scene, 0.1, is_static);
  std::mt19937_64 random(33);
  Pairs some(7);
  int in_grid = 0;
  // Few or many move in a frame, in any order, some named twice.
  for (int frame = 0; frame < 120; ++frame) {
    const std::uint64_t one_in[] = {kObjects * 10, kObjects, 100, 20, 3, 1};
    std::vector<std::uint32_t> moved;
    for (std::uint32_t object = 0; object < kObjects; ++object)
      if (random() % one_in[random() % 2 == 0 ? frame % 6 : 1] == 0) {
        const bool stays = is_static[object] != 0 && random() % 8 != 0;
        if (stays) continue;
        scene.place(object, random_pose(random, extent));
        moved.push_back(object);
      }
    if (frame % 4 == 3) std::reverse(moved.begin(), moved.end());
    if (frame % 8 == 6) moved.insert(moved.end(), moved.begin(), moved.end());  // named twice
    broadphase->update(scene.poses, moved);
    // Some lists are not asked for, some only begun.
    if (frame % 5 == 1) continue;
    if (frame % 3 != 2 && is_native) {
      Pairs by_place;
      ASSERT_TRUE(broadphase->find_pairs_by_place(by_place));
      in_grid += is_by_place(by_place);
    }
    if (frame % 7 < 2 && is_native) {
      Pairs of_moved = {{1, 2}};
      ASSERT_TRUE(broadphase->find_moved_pairs(of_moved));
      EXPECT_EQ(of_moved.front(), SolidPair({1, 2}));
      of_moved.erase(of_moved.begin());
      ASSERT_EQ(of_moved, pairs_of(scene, moved, sweep(*broadphase, 64))) << frame;
    }
    PairCursor cursor;
    broadphase->find_pairs(cursor, some);
    if (frame % 5 == 2) continue;
    // Now as built anew, and as brute force finds them.
    ASSERT_EQ(sweep(*broadphase, 64), sweep(*make("native", scene, 0.1, is_static), 4096)) << frame;
    if (frame % 20 == 0) {
      ASSERT_EQ(sweep(*broadphase, 64), sweep(*make("brute_force", scene, 0.1, is_static), 4096)) << frame;
    }
  }
  EXPECT_EQ(in_grid > 5, is_native && is_for_grid);
}

TEST_P(IncrementalTest, AnyHistoryOfUpdatesGivesThePairsOfAFreshBuild) {
  run_any_history(GetParam(), random_scene(900, 55, 0, 32), 55, false);
}
TEST_P(IncrementalTest, AnyHistoryOfEvenScenesGivesThePairsOfAFreshBuild) {
  run_any_history(GetParam(), even_scene(900, 9, 32), 9, true);
}

std::vector<PlacedHexahedron> row_of_boxes(int count) {
  std::vector<PlacedHexahedron> placed;
  for (int i = 0; i < count; ++i)
    placed.push_back({"", Hexahedron::from_size({1, 2, 1}), {Matrix3::Identity(), {0.9 * i, 0, 0}}});
  return placed;
}

/// A scene in which objects come, go and come back as others, static or not.
struct Changing {
  Scene scene;
  double extent;
  std::mt19937_64 random{42};
  std::vector<std::uint8_t> is_static = every(5, scene.trees.size());
  std::vector<std::uint8_t> is_gone = std::vector<std::uint8_t>(scene.trees.size());
  std::vector<std::uint32_t> moved = {};  ///< in this frame, some twice

  void place(std::uint32_t object) {
    scene.place(object, random_pose(random, extent));
    moved.push_back(object);
  }

  void add(Broadphase& broadphase, int solids) {
    const auto added = static_cast<std::uint32_t>(scene.trees.size());
    scene.add(row_of_boxes(solids), random_pose(random, extent));
    is_static.push_back(random() % 4 == 0), is_gone.push_back(0);
    ASSERT_TRUE(broadphase.set_object(added, &scene.trees.back(), is_static.back() != 0));
    moved.push_back(added);
  }

  /// Adds an object of so many solids, or takes one out, or replaces one, or brings one in again.
  void change_one(Broadphase& broadphase, int solids) {
    const std::uint64_t places = scene.trees.size() + scene.trees.size() / 8;
    const std::uint32_t object = static_cast<std::uint32_t>(random() % places);
    if (object >= scene.trees.size()) {
      add(broadphase, solids);
    } else if (is_gone[object] == 0 && random() % 3 != 0) {
      is_gone[object] = 1;
      ASSERT_TRUE(broadphase.set_object(object, nullptr, false));
      std::erase(moved, object);
    } else {
      is_gone[object] = 0, is_static[object] = random() % 4 == 0;
      place(object);
      ASSERT_TRUE(broadphase.set_object(object, &scene.trees[object], is_static[object] != 0));
    }
  }

  /// Of all, by trying all.
  Pairs pairs(bool on_paths) const {
    const auto oracle = build("brute_force", scene, 0.1, is_static);
    if (on_paths)
      oracle->update_paths({scene.poses, scene.poses, {}}, {});
    else
      oracle->update(scene.poses, {});
    Pairs pairs = sweep(*oracle, 4096);
    std::erase_if(pairs, [&](const SolidPair& pair) {
      return is_gone[scene.object_of[pair.a]] != 0 || is_gone[scene.object_of[pair.b]] != 0;
    });
    return pairs;
  }
};

/// Every solid's partners are those that the sweep pairs it with.
void expect_partners(Broadphase& broadphase, const Scene& scene, const Pairs& pairs) {
  std::vector<std::vector<SolidIndex>> wanted(scene.poses.size());
  for (const SolidPair& pair : pairs) wanted[pair.a].push_back(pair.b), wanted[pair.b].push_back(pair.a);
  for (SolidIndex solid = 0; solid < scene.poses.size(); ++solid) {
    std::vector<SolidIndex> partners;
    ASSERT_TRUE(broadphase.find_partners(solid, partners));
    std::sort(partners.begin(), partners.end()), std::sort(wanted[solid].begin(), wanted[solid].end());
    ASSERT_EQ(partners, wanted[solid]) << "solid " << solid;
  }
}

enum class Placed { at_poses, on_paths, in_turns };

// Objects change while others move; at poses and on paths, in turns after frames in the grid. Those that come
// are of one solid at first, of up to three later, which the grid takes no more. @return in how many frames
// the grid served.
int change_objects(const char* name, Scene of_start, double extent, Placed placed) {
  Changing changing{.scene = std::move(of_start), .extent = extent};
  const auto broadphase = build(name, changing.scene, 0.1, changing.is_static);
  int in_grid = 0;
  for (int frame = 0; frame < 150 && !testing::Test::HasFatalFailure(); ++frame) {
    SCOPED_TRACE(frame);
    Scene& scene = changing.scene;
    // Objects come, go and come again, and some of the others move.
    std::vector<std::uint32_t>& moved = changing.moved;
    moved.clear();
    if (frame == 99) changing.add(*broadphase, 3);  // after one that the grid was made in
    for (int i = 0; frame > 0 && i < frame % 4; ++i)
      changing.change_one(*broadphase, frame < 99 ? 1 : 1 + static_cast<int>(changing.random() % 3));
    for (std::uint32_t object = 0; object < scene.trees.size(); ++object)
      if (changing.is_gone[object] == 0 && changing.random() % (frame % 7 == 0 ? 2 : 40) == 0)
        changing.place(object);
    std::sort(moved.begin(), moved.end());
    moved.erase(std::unique(moved.begin(), moved.end()), moved.end());
    // The broadphase is brought up to date, the oracle built anew.
    const bool on_paths = placed == Placed::on_paths || (placed == Placed::in_turns && frame % 14 >= 8);
    if (on_paths)
      broadphase->update_paths({scene.poses, scene.poses, {}}, moved);
    else
      broadphase->update(scene.poses, moved);
    const Pairs expected = changing.pairs(on_paths);
    // All pairs, and each solid's partners, are the oracle's.
    if (frame % 3 != 0) {
      EXPECT_EQ(sweep(*broadphase, 64), expected);
    }
    expect_partners(*broadphase, scene, expected);
    Pairs by_place;
    if (!broadphase->find_pairs_by_place(by_place)) continue;
    in_grid += is_by_place(by_place);
    std::sort(by_place.begin(), by_place.end());
    EXPECT_EQ(by_place, expected);
  }
  return in_grid;
}

TEST_P(IncrementalTest, ObjectsThatComeAndGoGiveThePairsOfAFreshBuild) {
  change_objects(GetParam(), random_scene(150, 20, 3, 41), 20, Placed::at_poses);
}
TEST_P(IncrementalTest, ObjectsThatComeAndGoOnPathsGiveThePairsOfAFreshBuild) {
  change_objects(GetParam(), random_scene(150, 20, 3, 41), 20, Placed::on_paths);
}
TEST(NativeBroadphase, ObjectsThatComeAndGoInTheGridGiveThePairsOfAFreshBuild) {
  EXPECT_GT(change_objects("native", even_scene(600, 8, 44), 8, Placed::at_poses), 15);
}
TEST(NativeBroadphase, ObjectsThatComeAndGoOnPathsAfterTheGridGiveThePairsOfAFreshBuild) {
  EXPECT_GT(change_objects("native", even_scene(600, 8, 45), 8, Placed::in_turns), 5);
}

// The grid has the numbers of objects, which were those of solids when it was made.
TEST(NativeBroadphase, AnObjectOfSeveralSolidsThatComesToTheGridGivesItsPairs) {
  // All have moved, so that the grid serves.
  Scene scene = even_scene(600, 8, 47);
  const auto broadphase = make("native", scene, 0.1);
  std::vector<std::uint32_t> all(600);
  std::iota(all.begin(), all.end(), 0u);
  broadphase->update(scene.poses, all);
  Pairs by_place;
  ASSERT_TRUE(broadphase->find_pairs_by_place(by_place));
  ASSERT_TRUE(is_by_place(by_place));
  std::sort(by_place.begin(), by_place.end());
  const Pairs before = by_place;
  // The object comes.
  scene.add(row_of_boxes(3), Pose{});
  ASSERT_TRUE(broadphase->set_object(600, &scene.trees[600], false));
  by_place.clear();
  broadphase->update(scene.poses, std::array{600u});
  ASSERT_TRUE(broadphase->find_pairs_by_place(by_place));
  std::sort(by_place.begin(), by_place.end());
  EXPECT_EQ(by_place, sweep(*make("brute_force", scene, 0.1), 4096));
  EXPECT_GT(by_place.size(), before.size());
}

TEST(NativeBroadphase, AllPairsAreThoseOfWhatMovedInTheFirstUpdate) {
  const Scene scene = random_scene(200, 15, 0, 34);
  const auto broadphase = make("native", scene, 0.1);
  Pairs of_moved;
  ASSERT_TRUE(broadphase->find_moved_pairs(of_moved));
  EXPECT_GT(of_moved.size(), 100u);
  EXPECT_EQ(of_moved, sweep(*broadphase, 64));
  broadphase->update(scene.poses, {});
  of_moved.clear();
  ASSERT_TRUE(broadphase->find_moved_pairs(of_moved));
  EXPECT_EQ(of_moved, Pairs());
}

// Enough pairs that rows are asked for one by one; sparse rows among crowded ones, objects that are static
// or gone, and with `parts` solids each.
void heap_up(std::uint32_t parts, bool on_paths) {
  constexpr std::uint32_t kObjects = 700;
  // A heap of objects in each other, and a few in a row.
  Scene scene;
  std::mt19937_64 random(51);
  for (std::uint32_t object = 0; object < kObjects; ++object) {
    std::vector<PlacedHexahedron> placed(parts, {"", Hexahedron::from_size({1, 1, 1}), {}});
    Pose X = random_pose(random, 0.3);
    if (object % 50 < 12) X.p.x() += 5.0 * object;
    scene.add(std::move(placed), X);
  }
  const std::vector<std::uint8_t> is_static = every(3, kObjects);
  // Objects are taken away; all pairs of the rest are found, whatever the block's size.
  std::vector<Pairs> found;
  for (const char* name : {"native", "brute_force"}) {
    const auto broadphase = build(name, scene, 0.0, is_static);
    for (std::uint32_t object = 5; object < kObjects; object += 40)
      ASSERT_TRUE(broadphase->set_object(object, nullptr, false));
    if (on_paths)
      broadphase->update_paths({scene.poses, scene.poses, {}}, {});
    else
      broadphase->update(scene.poses, {});
    found.push_back(sweep(*broadphase, 1000));
    EXPECT_EQ(sweep(*broadphase, 77), found.back());
  }
  EXPECT_GT(found[0].size(), 100000u);
  EXPECT_EQ(found[0], found[1]);
}

TEST(NativeBroadphase, FindsWhatBruteForceFindsInHeaps) { heap_up(1, false); }
TEST(NativeBroadphase, FindsWhatBruteForceFindsInHeapsOfSeveralSolids) { heap_up(2, false); }
TEST(NativeBroadphase, FindsWhatBruteForceFindsInHeapsOnPaths) { heap_up(1, true); }

// So many nodes a level that a query looks at some of them after the others.
TEST(NativeBroadphase, NamesAllPartnersInALargeHeap) {
  constexpr std::uint32_t kObjects = 5000;
  Scene scene;
  for (std::uint32_t object = 0; object < kObjects; ++object)
    scene.add({{"", Hexahedron::from_size({1, 1, 1}), {}}}, {Matrix3::Identity(), {1e-4 * object, 0, 0}});
  const auto broadphase = make("native", scene, 0.0);
  for (const SolidIndex solid : {0u, 777u, 4999u}) {
    std::vector<SolidIndex> partners;
    ASSERT_TRUE(broadphase->find_partners(solid, partners));
    std::sort(partners.begin(), partners.end());
    EXPECT_EQ(std::unique(partners.begin(), partners.end()), partners.end());
    EXPECT_EQ(partners.size(), kObjects - 1);
  }
}

TEST_P(IncrementalTest, AnotherNumberOfSolidsIsRefused) {
  Scene scene = random_scene(4, 5, 0, 43);
  const auto broadphase = make(GetParam(), scene, 0.1);
  const HexahedronTree two(
      {{"a", Hexahedron::from_size({1, 1, 1}), {}}, {"b", Hexahedron::from_size({1, 1, 1}), {}}});
  EXPECT_THROW(broadphase->set_object(1, &two, false), std::exception);
  EXPECT_EQ(sweep(*broadphase, 64), sweep(*make("brute_force", scene, 0.1), 64));
}

// Every cube meets every other: 350 partners each are more than the list of `native` holds.
TEST_P(IncrementalTest, CrowdsThatThickenAndThinGiveThePairsOfAFreshBuild) {
  constexpr std::uint32_t kObjects = 700;
  Scene scene;
  std::mt19937_64 random(35);
  for (std::uint32_t i = 0; i < kObjects; ++i)
    scene.add({{"", Hexahedron::from_size({1, 1, 1}), {}}}, random_pose(random, 0.3));
  const auto broadphase = make(GetParam(), scene, 0.0);
  ASSERT_EQ(sweep(*broadphase, 256).size(), kObjects * (kObjects - 1) / 2);
  for (std::uint32_t frame = 0; frame < 40; ++frame) {
    const double extent = frame % 20 < 10 ? 20.0 : 0.3;
    const std::uint32_t nth = frame % 3 == 0 ? 41 : 5;
    std::vector<std::uint32_t> moved;
    for (std::uint32_t object = frame % nth; object < kObjects; object += nth)
      scene.place(object, random_pose(random, extent)), moved.push_back(object);
    broadphase->update(scene.poses, moved);
    ASSERT_EQ(sweep(*broadphase, 256), sweep(*make("brute_force", scene, 0.0), 4096)) << frame;
  }
}

TEST_P(IncrementalTest, FramesDoNotAllocateWhateverMoves) {
  constexpr std::uint32_t kObjects = 1000;
  Scene scene = random_scene(kObjects, 60, 0, 36);
  const auto broadphase = make(GetParam(), scene, 0.1, every(3, kObjects));
  std::vector<std::uint32_t> everything(kObjects);
  std::iota(everything.begin(), everything.end(), 0u);
  Pairs block(64);
  std::mt19937_64 random(37);
  for (std::size_t count :
       {std::size_t{1}, std::size_t{10}, std::size_t{60}, std::size_t{500}, everything.size()})
    for (double extent : {60.0, 1.0, 60.0}) {
      const std::span<const std::uint32_t> moved = std::span(everything).first(count);
      for (std::uint32_t object : moved) scene.place(object, random_pose(random, extent));
      const std::size_t before = allocation_count();
      broadphase->update(scene.poses, moved);
      for (PairCursor cursor; !cursor.done;) broadphase->find_pairs(cursor, block);
      EXPECT_EQ(allocation_count(), before) << count;
    }
}

// More pairs of few objects than there is room to sort by digits.
TEST(NativeBroadphase, MovedPairsOfACrowdDoNotAllocate) {
  constexpr std::uint32_t kObjects = 300;
  Scene scene = even_scene(kObjects, 0.2, 46);
  const auto broadphase = make("native", scene, 0.0);
  // From a third on all pairs are listed, and those of what stands are left out.
  for (const std::uint32_t count : {1u, 4u, 15u, 25u, 120u}) {
    std::vector<std::uint32_t> moved(count);
    std::iota(moved.begin(), moved.end(), 7 * count % (kObjects - count));
    broadphase->update(scene.poses, moved);
    const std::size_t expected = count * (kObjects - count) + count * (count - 1) / 2;
    Pairs pairs;
    pairs.reserve(expected);
    const std::size_t before = allocation_count();
    ASSERT_TRUE(broadphase->find_moved_pairs(pairs));
    EXPECT_EQ(allocation_count(), before) << count;
    EXPECT_EQ(pairs.size(), expected);
    EXPECT_EQ(pairs, pairs_of(scene, moved, sweep(*broadphase, 4096))) << count;
  }
}

}  // namespace
}  // namespace touchstone

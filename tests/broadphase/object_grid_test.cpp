#include "touchstone/contact_core/broadphase/native/object_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>
#include <random>

#include "touchstone/contact_core/broadphase/native/pair_sort.hpp"
#include "touchstone/contact_core/broadphase/native/sphere_tests.hpp"
#include "touchstone/contact_core/threads/thread_team.hpp"
#include "touchstone/tests/broadphase/random_scene.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

// The native broadphase's grid against trying all pairs, in scenes even and degenerate.

namespace touchstone {
namespace {

using namespace broadphase_tests;

/// A crowd of cubes, and what becomes of some of them.
struct Crowd {
  const char* name;
  int objects = 900;
  double spacing = 1.7;             ///< of cubes of 1 [m]
  Vector3 shape = Vector3::Ones();  ///< sides of the region, scaled to that spacing
  Vector3 place = Vector3::Zero();  ///< its middle [m]
  double scale = 1.0;               ///< of all lengths
  double margin = 0.0;              ///< [m]
  double decades = 0.0;             ///< sizes are scaled by 10^0 down to 10^-decades
  int giants = 0;                   ///< a hundred times as large
  int strays = 0;                   ///< 1e15 times as far
  int lost = 0;                     ///< at no place
  bool on_lattice = false;          ///< spheres touch to rounding
  int crowds = 1;                   ///< 1e7 sides from each other
  int solids = 1;                   ///< an object
  int still = 0;                    ///< one in so many is static
  bool is_served = true;            ///< by the grid
};

void PrintTo(const Crowd& crowd, std::ostream* out) { *out << crowd.name; }

const Crowd kCrowds[] = {
    {.name = "even"},
    {.name = "dense", .spacing = 0.9},
    {.name = "sparse", .spacing = 20.0},
    {.name = "dust", .spacing = 2000.0},
    {.name = "margin", .spacing = 3.0, .margin = 0.8},
    {.name = "line along x", .shape = {1, 0, 0}},
    {.name = "line along y", .shape = {0, 1, 0}},
    {.name = "line along z", .shape = {0, 0, 1}},
    {.name = "plane", .shape = {1, 0, 1}},
    {.name = "slab", .shape = {0.1, 1, 1}},
    {.name = "far", .place = {1e6, -2e6, 3e6}},
    {.name = "farther", .place = {1e12, 1e12, -1e12}},
    {.name = "tiny", .scale = 1e-150},
    {.name = "least", .scale = 2e-152},
    {.name = "huge", .scale = 1e120},
    {.name = "lattice", .on_lattice = true},
    {.name = "far lattice", .place = {1e5, 1e5, 1e5}, .on_lattice = true},
    {.name = "two decades", .spacing = 1.1, .decades = 2.0},
    {.name = "giants", .giants = 5},
    {.name = "strays", .strays = 4},
    {.name = "lost", .lost = 3},
    {.name = "all kinds", .giants = 2, .strays = 2, .lost = 2, .still = 3},
    {.name = "two far crowds", .crowds = 2, .is_served = false},
    {.name = "one place", .shape = {0, 0, 0}, .is_served = false},
    {.name = "too many strays", .strays = 60, .is_served = false},
    {.name = "few", .objects = 300, .is_served = false},
    {.name = "several solids", .spacing = 3.0, .solids = 3, .is_served = false},
    {.name = "static ones", .still = 2},
};

/// Objects at random places of a crowd, and the bounds that the grid reads.
class CrowdScene {
 public:
  CrowdScene(const Crowd& crowd, std::uint64_t seed) : crowd_(crowd), random_(seed) {
    // A region with as much room as the spacing says, whatever its shape.
    int sides = 0;
    double room = 1.0;
    for (int i = 0; i < 3; ++i)
      if (crowd.shape(i) > 0.0) ++sides, room *= crowd.shape(i);
    const double count = crowd.objects / crowd.crowds;
    extent_ = sides == 0 ? 0.0 : crowd.spacing * std::pow(count / room, 1.0 / sides);
    for (int i = 0; i < crowd.objects; ++i) add(i);
    const std::vector<const HexahedronTree*> trees = scene_.tree_pointers();
    for (int i = 0; i < crowd.objects; ++i) is_static_.push_back(crowd.still > 0 && i % crowd.still == 0);
    BroadphaseInput input;
    input.trees = trees, input.margin = crowd.margin, input.is_static = is_static_;
    bounds_ = std::make_unique<SolidBounds>(input);
    grid_.reserve(bounds_->objects());
    place();
  }

  SolidBounds& bounds() { return *bounds_; }
  ObjectGrid& grid() { return grid_; }
  void place() {
    for (std::uint32_t object = 0; object < bounds_->objects(); ++object)
      bounds_->place(object, scene_.poses);
  }
  void move() {
    for (std::uint32_t object = 0; object < bounds_->objects(); ++object)
      scene_.place(object, pose(static_cast<int>(object)));
    place();
  }

  /// One in so many, from this one on; other than at first those at no place are found, and others get lost.
  std::vector<std::uint32_t> move_some(std::uint32_t first, std::uint32_t nth) {
    std::vector<std::uint32_t> moved;
    for (std::uint32_t object = first; object < bounds_->objects(); object += nth) {
      scene_.place(object, pose(static_cast<int>(object + first) % crowd_.objects));
      bounds_->place(object, scene_.poses);
      moved.push_back(object);
    }
    return moved;
  }
  void come(std::uint32_t object) { bounds_->set_object(object, &scene_.trees[object], false); }

  bool pairs(std::uint32_t object, std::uint32_t other) const {
    const SolidBounds& b = *bounds_;
    return object != other && !b.is_gone(object) && !b.is_gone(other) &&
           !(b.is_static(object) && b.is_static(other)) && b.may_pair(object, other);
  }
  /// By trying all.
  Pairs wanted() const {
    Pairs out;
    for (std::uint32_t a = 0; a < bounds_->objects(); ++a)
      for (std::uint32_t b = a + 1; b < bounds_->objects(); ++b)
        if (pairs(a, b)) out.push_back({a, b});
    return out;
  }
  /// By the grid, part by part.
  Pairs found(TaskRunner* threads) const {
    PairList list;
    list.reserve(bounds_->objects()), list.set_objects(bounds_->objects());
    list.start();
    auto task = [&](std::size_t part) {
      PairList::Writer writer(list, part);
      grid_.list_part(part, *bounds_, writer);
      EXPECT_FALSE(writer.is_full());
      writer.close();
    };
    run_tasks(threads, grid_.parts(), task);
    Pairs out;
    list.append_found(out);
    return out;
  }

 private:
  Pose pose(int i) {
    Pose X = random_pose(random_, 1.0);
    for (int k = 0; k < 3; ++k) X.p(k) *= 0.5 * extent_ * crowd_.shape(k);
    if (crowd_.on_lattice) X = {Matrix3::Identity(), std::sqrt(3.0) * Vector3(i % 9, i / 9 % 10, i / 90)};
    X.p.x() += 1e7 * (i % crowd_.crowds) * extent_;
    X.p = crowd_.scale * (X.p + crowd_.place);
    if (i < crowd_.strays) X.p *= 1e15;
    if (i >= crowd_.strays && i < crowd_.strays + crowd_.lost)
      X.p.y() = i % 2 == 0 ? std::numeric_limits<double>::quiet_NaN() : INFINITY;
    return X;
  }
  void add(int i) {
    double size = crowd_.scale * std::pow(10.0, -crowd_.decades * uniform(random_, 0.0, 1.0));
    if (crowd_.giants > 0 && i % (crowd_.objects / crowd_.giants) == 7) size *= 100.0;
    std::vector<PlacedHexahedron> placed;
    for (int part = 0; part < crowd_.solids; ++part)
      placed.push_back(
          {"", Hexahedron::from_size(Vector3::Constant(size)), {Matrix3::Identity(), {part * size, 0, 0}}});
    scene_.add(std::move(placed), pose(i));
  }

  Crowd crowd_;
  std::mt19937_64 random_;
  double extent_ = 0.0;
  Scene scene_;
  std::vector<std::uint8_t> is_static_;
  std::unique_ptr<SolidBounds> bounds_;
  ObjectGrid grid_;
};

Pairs sorted(Pairs pairs) {
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

class GridOfCrowd : public testing::TestWithParam<Crowd> {};
INSTANTIATE_TEST_SUITE_P(Grid, GridOfCrowd, testing::ValuesIn(kCrowds), [](const auto& test) {
  std::string name = test.param.name;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
});

TEST_P(GridOfCrowd, FindsWhatTryingAllFinds) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    CrowdScene crowd(GetParam(), seed);
    ASSERT_EQ(crowd.grid().build(crowd.bounds(), nullptr), GetParam().is_served);
    if (!GetParam().is_served) return;
    ASSERT_EQ(sorted(crowd.found(nullptr)), crowd.wanted()) << seed;
    crowd.move();
    ASSERT_TRUE(crowd.grid().build(crowd.bounds(), nullptr));
    ASSERT_EQ(sorted(crowd.found(nullptr)), crowd.wanted()) << seed;
  }
}

/// Of these objects, asked about at once.
void expect_neighbours_of(CrowdScene& crowd, std::span<const std::uint32_t> objects) {
  Pairs found, wanted;
  crowd.grid().for_each_near_of(
      static_cast<std::uint32_t>(objects.size()),
      [&](std::uint32_t k) { return crowd.bounds().object_spheres_W()[objects[k]]; },
      [&](std::uint32_t k, std::uint32_t other, bool is_sure) {
        const bool pairs = crowd.pairs(objects[k], other);
        ASSERT_TRUE(pairs || !is_sure || other == objects[k]) << objects[k] << ", " << other;
        if (pairs) found.push_back({objects[k], other});
      });
  for (const std::uint32_t object : objects)
    for (std::uint32_t other = 0; other < crowd.bounds().objects(); ++other)
      if (crowd.pairs(object, other)) wanted.push_back({object, other});
  ASSERT_EQ(sorted(found), sorted(wanted));
}

/// Of every `step`-th object from `first` on, one by one and several at once.
void expect_all_neighbours(CrowdScene& crowd, std::uint32_t first, std::uint32_t step) {
  for (std::uint32_t object = first; object < crowd.bounds().objects(); object += step) {
    std::vector<std::uint32_t> found, wanted;
    crowd.grid().for_each_near(crowd.bounds().object_spheres_W()[object], [&](std::uint32_t other) {
      if (crowd.pairs(object, other)) found.push_back(other);
    });
    for (std::uint32_t other = 0; other < crowd.bounds().objects(); ++other)
      if (crowd.pairs(object, other)) wanted.push_back(other);
    std::sort(found.begin(), found.end());
    ASSERT_EQ(found, wanted) << object;
  }
  std::vector<std::uint32_t> asked;
  for (std::uint32_t object = first; object < crowd.bounds().objects(); object += step) {
    asked.push_back(object);
    if (asked.size() < ObjectGrid::kTogether && object + step < crowd.bounds().objects()) continue;
    ASSERT_NO_FATAL_FAILURE(expect_neighbours_of(crowd, asked));
    asked.clear();
  }
}

TEST_P(GridOfCrowd, NamesAllNeighboursOfAnObject) {
  CrowdScene crowd(GetParam(), 4);
  ASSERT_EQ(crowd.grid().build(crowd.bounds(), nullptr), GetParam().is_served);
  if (!GetParam().is_served) return;
  expect_all_neighbours(crowd, 0, 3);
}

TEST_P(GridOfCrowd, FollowsAFewThatMove) {
  CrowdScene crowd(GetParam(), 14);
  ASSERT_EQ(crowd.grid().build(crowd.bounds(), nullptr), GetParam().is_served);
  if (!GetParam().is_served) return;
  for (const std::uint32_t first : {0u, 1u, 0u, 9u, 2u, 1u}) {
    ASSERT_TRUE(crowd.grid().move(crowd.bounds(), crowd.move_some(first, 30)));
    ASSERT_EQ(sorted(crowd.found(nullptr)), crowd.wanted()) << first;
    expect_all_neighbours(crowd, first, 10);
  }
}

// Those that went and come again, elsewhere; and too many of them.
TEST(ObjectGrid, FollowsWhatGoesAndComes) {
  CrowdScene crowd({.name = ""}, 15);
  ASSERT_TRUE(crowd.grid().build(crowd.bounds(), nullptr));
  for (const std::uint32_t first : {0u, 5u, 0u}) {
    for (std::uint32_t object = first; object < 900; object += 40)
      crowd.bounds().set_object(object, nullptr, false);
    crowd.grid().note_changes();
    ASSERT_EQ(sorted(crowd.found(nullptr)), crowd.wanted());
    for (std::uint32_t object = first; object < 900; object += 40) crowd.come(object);
    ASSERT_TRUE(crowd.grid().move(crowd.bounds(), crowd.move_some(first, 40)));
    ASSERT_EQ(sorted(crowd.found(nullptr)), crowd.wanted());
  }
  EXPECT_FALSE(crowd.grid().move(crowd.bounds(), crowd.move_some(0, 2)));
}

TEST(ObjectGrid, GivesTheSameOrderOnAnyNumberOfThreads) {
  const Crowd crowd{.name = "", .objects = 20000, .giants = 3, .strays = 2};
  CrowdScene alone(crowd, 5);
  ASSERT_TRUE(alone.grid().build(alone.bounds(), nullptr));
  const Pairs pairs = alone.found(nullptr);
  EXPECT_GT(pairs.size(), 30000u);
  for (std::size_t count : {2, 5}) {
    ThreadTeam team(count);
    CrowdScene together(crowd, 5);
    ASSERT_TRUE(together.grid().build(together.bounds(), &team));
    ASSERT_EQ(together.found(&team), pairs) << count;
  }
}

TEST(ObjectGrid, NamesNoneThatWentSinceItWasBuilt) {
  CrowdScene crowd({.name = ""}, 6);
  ASSERT_TRUE(crowd.grid().build(crowd.bounds(), nullptr));
  const std::size_t before = crowd.wanted().size();
  for (std::uint32_t object = 0; object < 900; object += 9) crowd.bounds().set_object(object, nullptr, false);
  crowd.grid().note_changes();
  EXPECT_LT(crowd.wanted().size(), before);
  EXPECT_EQ(sorted(crowd.found(nullptr)), crowd.wanted());
  ASSERT_TRUE(crowd.grid().build(crowd.bounds(), nullptr));
  EXPECT_EQ(sorted(crowd.found(nullptr)), crowd.wanted());
}

// Two spheres in the grid's corner, where floats have no digits left for squares of their radii.
TEST(ObjectGrid, FindsThePairsOfDustInItsCorner) {
  std::mt19937_64 random(11);
  int pairs = 0;
  for (double size = 1e-24; size < 1e-18; size *= 1.7) {
    // The others' centres run from 1 m to 33 m, which puts the corner at 0.
    Scene scene;
    for (int i = 0; i < 729; ++i)
      scene.add({{"", Hexahedron::from_size({1, 1, 1}), {}}},
                {Matrix3::Identity(), 4.0 * Vector3(i % 9, i / 9 % 9, i / 81) + Vector3(1, 1, 1)});
    const std::uint32_t dust = 729;
    for (int i = 0; i < 2; ++i) scene.add({{"", Hexahedron::from_size(Vector3::Constant(size)), {}}}, Pose{});
    const std::vector<const HexahedronTree*> trees = scene.tree_pointers();
    BroadphaseInput input;
    input.trees = trees;
    SolidBounds bounds(input);
    ObjectGrid grid;
    grid.reserve(bounds.objects());
    for (int i = 0; i < 40; ++i) {
      const Vector3 apart = random_vector(random, 1.0).normalized() * uniform(random, 0.97, 1.0);
      scene.place(dust + 1, {Matrix3::Identity(), std::sqrt(3.0) * size * apart.cwiseAbs()});
      for (std::uint32_t object = 0; object < bounds.objects(); ++object) bounds.place(object, scene.poses);
      ASSERT_TRUE(grid.build(bounds, nullptr) && bounds.may_pair(dust, dust + 1));
      bool finds = false;
      grid.for_each_near(bounds.object_spheres_W()[dust],
                         [&](std::uint32_t other) { finds = finds || other == dust + 1; });
      ASSERT_TRUE(finds) << size << ", " << apart.transpose();
      ++pairs;
    }
  }
  EXPECT_GT(pairs, 500);
}

TEST(ObjectGrid, LeavesOutTheCellsForStrays) {
  CrowdScene crowd({.name = "", .strays = 4}, 12);
  ASSERT_TRUE(crowd.grid().build(crowd.bounds(), nullptr));
  for (const std::uint32_t stray : {0u, 1u, 2u, 3u}) {
    int visits = 0;
    crowd.grid().for_each_near(crowd.bounds().object_spheres_W()[stray], [&](std::uint32_t) { ++visits; });
    EXPECT_EQ(visits, 4);
  }
}

// However many objects there are, those in no cell are few.
TEST(ObjectGrid, RefusesMoreThan64Strays) {
  CrowdScene crowd({.name = "", .objects = 59000, .strays = 65}, 13);
  EXPECT_FALSE(crowd.grid().build(crowd.bounds(), nullptr));
  crowd.bounds().set_object(0, nullptr, false);
  ObjectGrid other;
  other.reserve(crowd.bounds().objects());
  EXPECT_TRUE(other.build(crowd.bounds(), nullptr));
}

// What a scene would cost is found out now and then only.
TEST(ObjectGrid, WaitsWhereItWasNotQuick) {
  CrowdScene crowd({.name = "", .shape = {0, 0, 0}}, 7);
  EXPECT_FALSE(crowd.grid().build(crowd.bounds(), nullptr));
  CrowdScene even({.name = ""}, 7);
  int frames = 0;
  while (!crowd.grid().build(even.bounds(), nullptr)) ASSERT_LT(++frames, 100);
  EXPECT_GT(frames, 8);
}

/// A scene in which all move in each frame, by the whole broadphase.
struct Frames {
  Scene scene;
  std::mt19937_64 random{8};
  std::vector<std::uint32_t> all;

  explicit Frames(int solids) {
    for (std::uint32_t i = 0; i < 1200; ++i) {
      scene.add(std::vector<PlacedHexahedron>(static_cast<std::size_t>(solids),
                                              {"", Hexahedron::from_size({1, 1.2, 0.8}), {}}),
                random_pose(random, 9.0));
      all.push_back(i);
    }
  }
  std::vector<std::uint32_t> step(std::uint32_t nth) {
    std::vector<std::uint32_t> moved;
    for (const std::uint32_t object : all)
      if (object % nth == 0) scene.place(object, random_pose(random, 9.0)), moved.push_back(object);
    return moved;
  }
};

// Many move, few, none, and objects go, in turns: the grid and the trees take turns.
TEST(NativeBroadphase, FindsAllPairsByPlace) {
  for (int solids : {1, 2}) {
    Frames frames(solids);
    const auto native = make("native", frames.scene, 0.05),
               brute_force = make("brute_force", frames.scene, 0.05);
    std::uint32_t frame = 0;
    for (std::uint32_t nth : {1u, 1u, 2u, 300u, 1u, 40u, 1u, 1u}) {
      std::vector<std::uint32_t> moved = frames.step(nth);
      if (++frame % 2 == 0) {
        const std::uint32_t gone = 11 * frame;
        ASSERT_TRUE(native->set_object(gone, nullptr, false) &&
                    brute_force->set_object(gone, nullptr, false));
        std::erase(moved, gone);
      }
      native->update(frames.scene.poses, moved), brute_force->update(frames.scene.poses, moved);
      Pairs by_place = {{1, 2}};
      ASSERT_TRUE(native->find_pairs_by_place(by_place));
      EXPECT_EQ(by_place.front(), SolidPair({1, 2}));
      by_place.erase(by_place.begin());
      if (nth == 1 && solids == 1) {
        EXPECT_TRUE(is_by_place(by_place)) << "the grid does not serve";
      }
      const Pairs wanted = sweep(*brute_force, 4096);
      ASSERT_GT(wanted.size(), 1000u);
      ASSERT_EQ(sorted(by_place), wanted) << frame;
      ASSERT_EQ(sweep(*native, 100), wanted) << frame;
      Pairs of_moved;
      ASSERT_TRUE(native->find_moved_pairs(of_moved));
      ASSERT_EQ(of_moved, pairs_of(frames.scene, moved, wanted)) << frame;
      // One goes after the update.
      ASSERT_TRUE(native->set_object(7 * frame, nullptr, false) &&
                  brute_force->set_object(7 * frame, nullptr, false));
      by_place.clear();
      ASSERT_TRUE(native->find_pairs_by_place(by_place));
      ASSERT_EQ(sorted(by_place), sweep(*brute_force, 4096)) << frame;
      ASSERT_EQ(sweep(*native, 100), sorted(by_place)) << frame;
    }
  }
}

TEST(NativeBroadphase, FramesInTheGridDoNotAllocate) {
  Frames frames(1);
  const auto native = make("native", frames.scene, 0.05);
  Pairs by_place, block(256);
  by_place.reserve(100000);
  for (int frame = 0; frame < 5; ++frame) {
    const std::vector<std::uint32_t> moved = frames.step(1);
    const std::size_t before = allocation_count();
    native->update(frames.scene.poses, moved);
    by_place.clear();
    native->find_pairs_by_place(by_place);
    for (PairCursor cursor; !cursor.done;) native->find_pairs(cursor, block);
    EXPECT_EQ(allocation_count(), before);
    EXPECT_TRUE(is_by_place(by_place)) << "the grid does not serve";
  }
}

/// Hits as SphereTests has them, by one sphere and one position at a time.
std::vector<std::array<std::uint32_t, 3>> meet_one_by_one(
    const SphereColumns& s, const std::vector<std::array<std::uint32_t, 3>>& runs) {
  std::vector<std::array<std::uint32_t, 3>> out;
  for (const auto& [of, first, end] : runs)
    for (std::uint32_t at = first; at < end; ++at) {
      const float dx = s.x[at] - s.x[of], dy = s.y[at] - s.y[of], dz = s.z[at] - s.z[of];
      const float sum = s.radius[at] + s.radius[of];
      const float slack = sum * sum - ((dx * dx + dy * dy) + dz * dz);
      if (slack >= 0.0F) out.push_back({of, at, slack > s.doubt ? 1U : 0U});
    }
  return out;
}

TEST(SphereTests, MeetTheSameOnEachInstructionSet) {
  constexpr std::uint32_t kSpheres = 300;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(0.0F, 4.0F), radius(0.1F, 0.8F);
  std::array<std::vector<float>, 4> columns;
  for (std::uint32_t i = 0; i < kSpheres + SphereColumns::kPadding; ++i) {
    for (int k = 0; k < 3; ++k) columns[k].push_back(place(random));
    columns[3].push_back(radius(random));
  }
  const SphereColumns spheres{columns[0].data(), columns[1].data(), columns[2].data(), columns[3].data(),
                              0.05F};
  // Runs of every length, of none and to the very end, more than there is room for at once.
  std::vector<std::array<std::uint32_t, 3>> runs;
  for (std::uint32_t i = 0; i < 600; ++i) {
    const auto first = static_cast<std::uint32_t>(random() % kSpheres);
    runs.push_back(
        {static_cast<std::uint32_t>(random() % kSpheres), first, std::min(kSpheres, first + i % 40)});
  }
  runs.push_back({0, 0, kSpheres});
  const auto expected = meet_one_by_one(spheres, runs);
  ASSERT_GT(expected.size(), 500U);
  for (const SphereTests::Kind& kind : SphereTests::available()) {
    std::vector<std::array<std::uint32_t, 3>> met;
    auto meet = [&](std::uint32_t of, std::uint32_t at, bool is_sure) {
      met.push_back({of, at, is_sure ? 1U : 0U});
    };
    SphereTests tests(spheres, kind);
    for (const auto& [of, first, end] : runs) tests.add(of, first, end, meet);
    tests.finish(meet);
    EXPECT_EQ(met, expected) << kind.isa;
  }
}

TEST(PairSort, PutsPairsInAscendingOrder) {
  std::mt19937_64 bits(10);
  std::vector<SolidPair> scratch;
  scratch.reserve(5000);
  for (const std::size_t count : {0, 1, 255, 256, 5000, 5001})
    for (const std::uint32_t most : {1u, 511u, 512u, 100000u, 0xFFFFFFFFu}) {
      Pairs pairs(count);
      for (SolidPair& pair : pairs)
        pair = {static_cast<SolidIndex>(bits() % most), static_cast<SolidIndex>(bits() % most)};
      const Pairs wanted = sorted(pairs);
      sort_pairs(pairs, scratch);
      ASSERT_EQ(pairs, wanted) << count << " below " << most;
    }
}

}  // namespace
}  // namespace touchstone

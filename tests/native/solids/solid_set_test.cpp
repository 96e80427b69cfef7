#include "touchstone/contact_core/native/solids/solid_set.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <new>

#include "touchstone/contact_core/native/solids/solid_features.hpp"
#include "touchstone/tests/native/native_fixture.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone {
namespace {

using native::HullRecord;
using native::SolidSet;

/// A box, a parallelepiped or a general hexahedron, now and then beyond ordinary magnitudes.
Hexahedron random_solid(Random& random, int kinds) {
  const Vector3 size = std::ldexp(1.0, random.below(12) == 0 ? 300 : 0) * random.vector(0.2, 2);
  if (const int kind = random.below(kinds); kind == 0) return Hexahedron::from_size(size);
  const double shear = random.uniform(-0.3, 0.3),
               taper = random.below(2) == 0 ? 1.0 : random.uniform(0.5, 0.9);
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i) {
    const Vector3 corner{i & 4 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 1 ? 0.5 : -0.5};
    const double width = corner.z() > 0 ? taper : 1.0;
    v[i] = {size.x() * (width * corner.x() + shear * corner.z()), size.y() * width * corner.y(),
            size.z() * corner.z()};
  }
  return Hexahedron::from_vertices(v);
}

template <class Record>
void expect_same_bytes(const GrowingList<Record>& p, const GrowingList<Record>& q) {
  ASSERT_EQ(p.size(), q.size());
  for (std::size_t i = 0; i < p.size(); ++i)
    EXPECT_EQ((std::bit_cast<std::array<std::byte, sizeof(Record)>>(p[i])),
              (std::bit_cast<std::array<std::byte, sizeof(Record)>>(q[i])))
        << i;
}

TEST(SolidSet, BoxesOfAllSizesHaveTheHullThatTheyShare) {
  Random random(1);
  HullRecord shared, own;
  native::find_features(Hexahedron::from_size({1, 1, 1}), &shared);
  for (int i = 0; i < 1000; ++i) {
    Vector3 size = random.vector(0.5, 2);
    for (int k = 0; k < 3; ++k) size(k) = std::ldexp(size(k), random.below(200) - 100);
    native::find_features(Hexahedron::from_size(size), &own);
    const auto& normals = shared.normals[0];
    for (int f = 0; f < 6; ++f) {
      EXPECT_EQ(normals.x[f], own.normals[0].x[f]);
      EXPECT_EQ(normals.y[f], own.normals[0].y[f]);
      EXPECT_EQ(normals.z[f], own.normals[0].z[f]);
    }
    EXPECT_EQ(std::memcmp(&shared.topology, &own.topology, sizeof own.topology), 0);
    EXPECT_EQ(std::memcmp(&own.topology, &native::kRegularHull, sizeof own.topology), 0);
  }
}

TEST(SolidSet, ChangedInAnyOrderIsTheSetBuiltAtOnce) {
  Random random(2);
  for (int run = 0; run < 200; ++run) {
    std::vector<Hexahedron> solids;
    SolidSet changed = native::make_solid_set({});
    // The first changes bring boxes alone: what parallelepipeds need is then added to what is there.
    for (int change = 0; change < 8; ++change) {
      const std::size_t first = random.below(static_cast<int>(solids.size()) + 1);
      std::vector<Hexahedron> fresh;
      for (int i = 1 + random.below(4); i > 0; --i) fresh.push_back(random_solid(random, change < 4 ? 1 : 3));
      if (random.below(2) == 0)
        native::set_solids(changed, first, native::make_solid_set(fresh));
      else
        native::set_solids(changed, first, std::span<const Hexahedron>(fresh));
      for (std::size_t i = 0; i < fresh.size(); ++i) {
        if (first + i < solids.size())
          solids[first + i] = fresh[i];
        else
          solids.push_back(fresh[i]);
      }
      SolidSet at_once = native::make_solid_set(solids);
      EXPECT_EQ(changed.kinds, at_once.kinds);
      EXPECT_EQ(changed.ordinary, at_once.ordinary);
      expect_same_bytes(changed.boxes, at_once.boxes);
      expect_same_bytes(changed.vertices, at_once.vertices);
      for (std::size_t i = 0; i < solids.size(); ++i) {
        EXPECT_EQ(changed.solids[i].size, at_once.solids[i].size);
        EXPECT_EQ(changed.solids[i].middle, at_once.solids[i].middle);
        EXPECT_EQ(changed.solids[i].hull, changed.hulls[i].get());
        EXPECT_EQ(changed.solids[i].hull->record.topology.face_count,
                  at_once.solids[i].hull->record.topology.face_count);
      }
      if (at_once.parallelepipeds.empty()) {
        // A set that has once held another solid keeps its records.
        ASSERT_TRUE(changed.parallelepipeds.empty() || changed.parallelepipeds.size() == solids.size());
        continue;
      }
      expect_same_bytes(changed.parallelepipeds, at_once.parallelepipeds);
      expect_same_bytes(changed.parallelepiped_edges, at_once.parallelepiped_edges);
    }
  }
}

// As a tool that is changed and changed back, or an arm that goes and comes.
TEST(SolidSet, ASolidThatComesBackToItsPlaceKeepsItsHull) {
  Random random(3);
  std::vector<Hexahedron> solids;
  while (solids.size() < 4)
    if (const Hexahedron solid = random_solid(random, 3); !solid.is_box() && solid.size() < 10.0)
      solids.push_back(solid);
  SolidSet set = native::make_solid_set(solids);
  const native::SolidHull* const first = set.solids[1].hull;
  native::set_solids(set, 1, std::span(solids).subspan(1, 2));
  EXPECT_EQ(set.solids[1].hull, first);
  native::set_solids(set, 1, std::span(solids).subspan(3, 1));
  EXPECT_NE(set.solids[1].hull, first);
}

/// Every list has a place for each solid, and each solid has its hull.
void expect_whole(const SolidSet& set) {
  const std::size_t solids = set.kinds.size();
  EXPECT_EQ(set.ordinary.size(), solids);
  EXPECT_EQ(set.boxes.size(), solids);
  EXPECT_EQ(set.vertices.size(), solids);
  ASSERT_EQ(set.solids.size(), solids);
  EXPECT_TRUE(set.parallelepipeds.empty() || set.parallelepipeds.size() == solids);
  EXPECT_EQ(set.parallelepiped_edges.size(), set.parallelepipeds.size());
  EXPECT_TRUE(set.radii.empty() || set.radii.size() == solids);
  ASSERT_GE(set.hulls.size(), solids);
  for (std::size_t i = 0; i < solids; ++i) {
    EXPECT_NE(set.hulls[i], nullptr);
    EXPECT_EQ(set.solids[i].hull, set.hulls[i].get());
  }
}

/// The last of so many boxes is replaced, and more are appended. @returns whether memory was enough.
bool set_with_memory_for(std::size_t allocations, std::size_t boxes, std::span<const Hexahedron> fresh,
                         bool as_set) {
  SolidSet set = native::make_solid_set(std::vector<Hexahedron>(boxes, Hexahedron::from_size({1, 1, 1})));
  SolidSet fresh_set = native::make_solid_set(fresh);
  const std::size_t first = boxes > 0 ? boxes - 1 : 0;
  bool is_enough = false;
  try {
    const FailingAllocation failing(allocations);
    if (as_set)
      native::set_solids(set, first, std::move(fresh_set));
    else
      native::set_solids(set, first, fresh);
    is_enough = true;
  } catch (const std::bad_alloc&) {
  }
  expect_whole(set);
  native::set_solids(set, first, fresh);
  expect_whole(set);
  EXPECT_EQ(set.kinds.size(), first + fresh.size());
  return is_enough;
}

TEST(SolidSet, IsWholeWhereverMemoryEnds) {
  Random random(5);
  const Hexahedron box = Hexahedron::from_size({1, 2, 3});
  const Hexahedron large = Hexahedron::from_size(Vector3(0x1p300, 0x1p300, 0x1p300));
  Hexahedron general = random_solid(random, 3);
  while (general.is_box()) general = random_solid(random, 3);
  for (const Hexahedron& other : {box, large, general, Hexahedron::sphere(0.5)})
    for (const std::size_t boxes : {0, 5, 32})  // 32 hulls stand together
      for (const bool as_set : {false, true}) {
        const std::array fresh{box, other, box};
        std::size_t allocations = 0;
        while (!set_with_memory_for(allocations, boxes, fresh, as_set)) ASSERT_LT(++allocations, 1000u);
      }
}

TEST(SolidSet, ABoxAmongBoxesTakesLessThan300Bytes) {
  std::vector<Hexahedron> boxes;
  Random random(3);
  for (int i = 0; i < 1000; ++i) boxes.push_back(random.box());
  const SolidSet set = native::make_solid_set(boxes);
  const std::size_t bytes =
      set.kinds.size() * sizeof(set.kinds[0]) + set.ordinary.size() * sizeof(set.ordinary[0]) +
      set.boxes.size() * sizeof(set.boxes[0]) + set.vertices.size() * sizeof(set.vertices[0]) +
      set.solids.size() * sizeof(set.solids[0]) +
      set.parallelepipeds.size() * sizeof(set.parallelepipeds[0]) +
      set.parallelepiped_edges.size() * sizeof(set.parallelepiped_edges[0]);
  EXPECT_LT(bytes, 300 * boxes.size());
  for (const native::SolidData& solid : set.solids) EXPECT_EQ(solid.hull, set.solids[0].hull);
}

TEST(SolidSet, EqualSolidsShareAHullAndOthersHaveTheirOwn) {
  Random random(4);
  std::vector<Hexahedron> solids;
  for (int i = 0; i < 100; ++i) solids.push_back(random_solid(random, 3));
  solids.insert(solids.end(), solids.begin(), solids.begin() + 100);
  const SolidSet set = native::make_solid_set(solids);
  for (std::size_t i = 0; i < 100; ++i) {
    const bool is_shared = set.solids[i].hull == set.solids[i + 100].hull;
    EXPECT_EQ(is_shared, set.ordinary[i] != 0) << i;
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_TRUE(set.solids[i].hull != set.solids[j].hull || solids[i].is_box()) << i << " " << j;
    const auto corner = [&](std::size_t of) { return set.solids[of].hull->vertices_S.vertex(0); };
    const bool is_box = solids[i].is_box() && set.ordinary[i] != 0;
    EXPECT_TRUE(is_box || corner(i) == solids[i].vertices()[0]) << i;
  }
}

}  // namespace
}  // namespace touchstone

#include "touchstone/examples/measures/pairs/pair_families.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/measures/accuracy/surface_measure.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"
#ifdef TOUCHSTONE_HAS_EXACT
#include "touchstone/adapters/exact/signed_distance.hpp"
#endif

namespace touchstone::measures {
namespace {

constexpr std::uint64_t kSeed = 1;

// FNV-1a over the bits of every world vertex.
std::uint64_t hash_of(const PairSet& set) {
  std::uint64_t hash = 14695981039346656037ULL;
  const auto add = [&](const WorldVertices& vertices) {
    for (const auto* coordinates : {&vertices.x, &vertices.y, &vertices.z}) {
      for (const double value : *coordinates) {
        std::uint64_t bits;
        std::memcpy(&bits, &value, sizeof bits);
        for (int i = 0; i < 8; ++i) hash = (hash ^ (bits >> (8 * i) & 0xff)) * 1099511628211ULL;
      }
    }
  };
  for (std::size_t i = 0; i < set.cases(); ++i) {
    const PosedPair posed = posed_pair(set, i);
    add(posed.a);
    add(posed.b);
  }
  return hash;
}

TEST(PairFamilies, AreTheSameOnEveryMachine) {
  std::uint64_t all = 0;
  for (const PairFamily& family : pair_families().first(11))  // those of the older reports
    all = all * 31 + hash_of(make_pair_family(family.name, kSeed, 200));
  EXPECT_EQ(all, 2478167256919359618u) << "seeds would no longer replay older reports";
}

TEST(PairFamilies, DependOnTheSeedAndTheFamily) {
  EXPECT_NE(hash_of(make_pair_family("random", 1, 10)), hash_of(make_pair_family("random", 2, 10)));
  EXPECT_NE(hash_of(make_pair_family("near_1e-3", 1, 10)), hash_of(make_pair_family("near_1e-7", 1, 10)));
}

TEST(PairFamilies, EachPairCanBeMadeAlone) {
  for (const PairFamily& family : pair_families()) {
    const PairSet all = make_pair_family(family.name, kSeed, 20);
    const PairSet one = make_family_pair(family.name, kSeed, 13);
    const PosedPair expected = posed_pair(all, 13), alone = posed_pair(one, 0);
    EXPECT_EQ(case_id(all, 13), case_id(one, 0));
    for (int v = 0; v < 8; ++v) {
      EXPECT_EQ(expected.a.vertex(v), alone.a.vertex(v)) << family.name;
      EXPECT_EQ(expected.b.vertex(v), alone.b.vertex(v)) << family.name;
    }
  }
}

TEST(PairFamilies, HaveValidPoses) {
  for (const PairFamily& family : pair_families()) {
    for (const Pose& pose : make_pair_family(family.name, kSeed, 300).poses) EXPECT_TRUE(is_valid_pose(pose));
  }
}

TEST(PairFamilies, UnknownNamesAreRefused) { EXPECT_THROW(make_pair_family("rondam", 1, 1), InputError); }

TEST(SurfaceMeasure, KnowsACube) {
  WorldVertices cube;
  world_vertices(Hexahedron::from_size({2, 2, 2}), {}, cube);
  const SurfaceMeasure surface(cube);
  ASSERT_FALSE(surface.is_flat());
  EXPECT_EQ(surface.distance({0, 0, 0}), 1.0);
  EXPECT_EQ(surface.distance({0.25, 0, 0.5}), 0.5);
  EXPECT_EQ(surface.distance({1, 0.3, -0.7}), 0.0);
  EXPECT_EQ(surface.distance({4, 5, 0.5}), 5.0);
  EXPECT_NEAR(surface.distance({2, 2, 2}), std::sqrt(3.0), 1e-15);
}

// Also where squares of doubles are none: the bounds that leave edges out know nothing there.
TEST(SurfaceMeasure, IsTheSameAtEveryScale) {
  for (const char* family : {"random", "slabs_needles", "bent"}) {
    const PairSet set = make_pair_family(family, kSeed, 10);
    for (std::size_t i = 0; i < set.cases(); ++i) {
      const PosedPair posed = posed_pair(set, i);
      const SurfaceMeasure surface(posed.a);
      for (const int power : {-530, -460, 500, 520}) {
        const double scale = std::ldexp(1.0, power);
        WorldVertices scaled = posed.a;
        for (auto* coordinates : {&scaled.x, &scaled.y, &scaled.z})
          for (double& each : *coordinates) each *= scale;
        const SurfaceMeasure there(scaled);
        for (int v = 0; v < 8; ++v)
          EXPECT_EQ(there.distance(posed.b.vertex(v) * scale), surface.distance(posed.b.vertex(v)) * scale)
              << case_id(set, i) << " by 2^" << power;
      }
    }
  }
}

// An edge whose square is no number, and a point near its inside.
TEST(SurfaceMeasure, LeavesOutNoEdgeWhoseSquareIsBeyondDoubles) {
  const double length = std::ldexp(1.0, 513), along = std::ldexp(1.0, 490);
  WorldVertices block;
  for (int v = 0; v < 8; ++v) {
    block.x[v] = (v & 4) != 0 ? 0.0 : -1.0;
    block.y[v] = (v & 2) != 0 ? 0.0 : -1.0;
    block.z[v] = (v & 1) != 0 ? length : 0.0;
  }
  EXPECT_EQ(SurfaceMeasure(block).distance({3, 4, along}), 5.0);
}

#ifdef TOUCHSTONE_HAS_EXACT

std::vector<PairTruth> truth_of(const PairSet& set) { return compute_truth(set, *make_exact_oracle(), 2); }

TEST(PairFamilies, TouchingTouchesExactly) {
  for (const PairTruth& truth : truth_of(make_pair_family("touching", kSeed, 400))) {
    EXPECT_EQ(truth.pair_class, PairClass::touching);
    EXPECT_EQ(truth.separation, 0.0);
  }
}

TEST(PairFamilies, ContainmentContains) {
  const PairSet set = make_pair_family("containment", kSeed, 200);
  const auto truth = truth_of(set);
  for (std::size_t i = 0; i < set.cases(); ++i) {
    const PosedPair posed = posed_pair(set, i);
    const double smaller = std::min(set.solids[2 * i].size(), set.solids[2 * i + 1].size());
    EXPECT_EQ(truth[i].pair_class, PairClass::penetrating);
    EXPECT_LT(truth[i].separation, 0.0);
    EXPECT_LT(smaller, posed.size);
  }
}

TEST(PairFamilies, NearTouchingIsNearOnBothSides) {
  for (const auto& [name, bound] : {std::pair{"near_1e-3", 1e-3}, {"near_1e-7", 1e-7}}) {
    const PairSet set = make_pair_family(name, kSeed, 400);
    const auto truth = truth_of(set);
    int contacts = 0;
    for (std::size_t i = 0; i < set.cases(); ++i) {
      EXPECT_LE(std::abs(truth[i].separation), bound * posed_pair(set, i).size * 1.0001) << case_id(set, i);
      contacts += truth[i].contact();
    }
    EXPECT_GT(contacts, 120);
    EXPECT_LT(contacts, 280);
  }
}

TEST(PairFamilies, RandomOnesAreApartAndOverlap) {
  for (const char* name : {"random", "sheared", "tapered", "slabs_needles", "far", "near_parallel"}) {
    int contacts = 0;
    for (const PairTruth& truth : truth_of(make_pair_family(name, kSeed, 300))) contacts += truth.contact();
    EXPECT_GT(contacts, 60) << name;
    EXPECT_LT(contacts, 240) << name;
  }
}

TEST(PairFamilies, RestingOnesTouchOrAreSlightlySunk) {
  int touching = 0;
  const PairSet set = make_pair_family("resting", kSeed, 300);
  for (const PairTruth& truth : truth_of(set)) {
    EXPECT_TRUE(truth.contact());
    EXPECT_GE(truth.separation, -0x1p-9);
    touching += truth.pair_class == PairClass::touching;
  }
  EXPECT_GT(touching, 60);
}

// The fast measures against the integers.
TEST(SurfaceMeasure, AgreesWithExact) {
  for (const PairFamily& family : pair_families()) {
    const PairSet set = make_pair_family(family.name, kSeed, 40);
    for (std::size_t i = 0; i < set.cases(); ++i) {
      const PosedPair posed = posed_pair(set, i);
      const SurfaceMeasure surface(posed.a);
      ASSERT_FALSE(surface.is_flat());
      const double bound = 0x1p-58 * posed.scale;
      for (int v = 0; v < 8; ++v) {
        const Vector3 p = posed.b.vertex(v);
        EXPECT_NEAR(surface.distance(p), exact_surface_distance(posed.a, p),
                    bound + 0x1p-52 * surface.distance(p))
            << case_id(set, i);
        EXPECT_EQ(surface.distance(posed.a.vertex(v)), 0.0);
      }
      const Vector3 n = set.poses[2 * i].R.col(0);
      EXPECT_NEAR(separation_along(posed.a, posed.b, n), exact_separation_along(posed.a, posed.b, n),
                  bound + 0x1p-52 * std::abs(separation_along(posed.a, posed.b, n)));
    }
  }
}

#endif

}  // namespace
}  // namespace touchstone::measures

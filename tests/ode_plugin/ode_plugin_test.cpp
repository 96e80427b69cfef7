#include "touchstone/adapters/ode_plugin/ode_plugin.hpp"

#include <gmock/gmock.h>
#include <ode/ode.h>

#include <array>
#include <cstring>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/ode_plugin/frustum.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/kept_pairs.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone {
namespace {

constexpr double kTolerance = 1e-14;

class OdePlugin : public testing::Test {
 protected:
  OdePlugin() {
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
  }
  ~OdePlugin() override {
    for (const dGeomID geom : geoms_) dGeomDestroy(geom);
    dCloseODE();
  }

  dGeomID place(dGeomID geom, const Pose& X) {
    const Matrix3& R = X.R;
    const dMatrix3 rows = {R(0, 0), R(0, 1), R(0, 2), 0,       R(1, 0), R(1, 1),
                           R(1, 2), 0,       R(2, 0), R(2, 1), R(2, 2), 0};
    dGeomSetPosition(geom, X.p.x(), X.p.y(), X.p.z());
    dGeomSetRotation(geom, rows);
    return geom;
  }
  dGeomID box(double x, double y, double z, const Pose& X) {
    geoms_.push_back(dCreateBox(nullptr, x, y, z));
    return place(geoms_.back(), X);
  }
  dGeomID hexahedron(const Hexahedron& solid, const Pose& X) {
    geoms_.push_back(create_ode_hexahedron(nullptr, solid));
    return place(geoms_.back(), X);
  }

  std::vector<dGeomID> geoms_;
};

std::vector<dContactGeom> collide(dGeomID a, dGeomID b, int flags = 8) {
  std::vector<dContactGeom> contacts(static_cast<std::size_t>(flags & 0xffff));
  contacts.resize(static_cast<std::size_t>(dCollide(a, b, flags, contacts.data(), sizeof(dContactGeom))));
  return contacts;
}

double depth(const std::vector<dContactGeom>& contacts) {
  double deepest = -1.0;
  for (const dContactGeom& contact : contacts) deepest = std::max(deepest, contact.depth);
  return deepest;
}

TEST_F(OdePlugin, ChecksOfAllThreadsAreCountedAlsoOfThoseThatEnded) {
  const OdeBoxOverride native;
  const dGeomID a = box(2, 2, 2, at(0, 0, 0)), b = box(1, 1, 1, at(1.25, 0, 0));
  const std::uint64_t before = ode_native_checks();
  collide(a, b);
  std::thread([&] {
    dAllocateODEDataForThread(dAllocateMaskAll);
    for (int i = 0; i < 10; ++i) collide(a, b);
    EXPECT_EQ(ode_native_checks() - before, 11u);
    dCleanupODEAllDataForThread();
  }).join();
  EXPECT_EQ(ode_native_checks() - before, 11u);
}

TEST_F(OdePlugin, TheNormalPointsIntoGeom1InEitherOrder) {
  const OdeBoxOverride native;
  const dGeomID large = box(2, 2, 2, at(0, 0, 0)), small = box(1, 1, 1, at(1.25, 0, 0));
  for (const bool swapped : {false, true}) {
    const std::uint64_t before = ode_native_checks();
    const auto contacts = swapped ? collide(small, large) : collide(large, small);
    EXPECT_EQ(ode_native_checks() - before, 1u);
    ASSERT_EQ(contacts.size(), 4u);
    for (const dContactGeom& contact : contacts) {
      EXPECT_EQ(contact.g1, swapped ? small : large);
      EXPECT_EQ(contact.g2, swapped ? large : small);
      EXPECT_NEAR(contact.normal[0], swapped ? 1.0 : -1.0, kTolerance);
      EXPECT_NEAR(contact.depth, 0.25, kTolerance);
      EXPECT_NEAR(contact.pos[0], 0.875, kTolerance);
      EXPECT_NEAR(std::abs(contact.pos[1]), 0.5, kTolerance);
    }
  }
}

TEST_F(OdePlugin, HexahedraMeetBoxesPlanesAndEachOther) {
  const OdeBoxOverride native;
  const dGeomID a = hexahedron(frustum(), at(0, 0, 0));
  const dGeomID b = hexahedron(frustum(), at(0, 0, 0.75));
  const dGeomID c = box(1, 1, 1, at(0, 0, -0.875));
  geoms_.push_back(dCreatePlane(nullptr, 0, 0, 1, -0.375));
  const dGeomID plane = geoms_.back();
  const std::vector<std::pair<dGeomID, double>> others = {{b, 0.25}, {c, 0.125}, {plane, 0.125}};
  for (const auto& [other, expected] : others) {
    for (const bool swapped : {false, true}) {
      const auto contacts = swapped ? collide(other, a) : collide(a, other);
      ASSERT_EQ(contacts.size(), 4u);
      EXPECT_NEAR(depth(contacts), expected, kTolerance);
      // From the frustum: `b` is above it, the others below.
      const double into_a = other == b ? -1.0 : 1.0;
      for (const dContactGeom& contact : contacts) {
        EXPECT_NEAR(contact.normal[2], swapped ? -into_a : into_a, kTolerance);
        EXPECT_EQ(contact.g1, swapped ? other : a);
      }
    }
  }
  dReal bounds[6];
  dGeomGetAABB(b, bounds);
  EXPECT_THAT(bounds, testing::ElementsAre(-0.5, 0.5, -0.5, 0.5, 0.25, 1.25));
}

TEST_F(OdePlugin, NoMoreContactsThanAskedForAndSkipIsTheWayBetweenThem) {
  // Boxes with eight contact points.
  const OdeBoxOverride native;
  Pose turned = at(0, 0, 0.9);
  turned.R = rotation_from_quaternion(std::cos(0.3), 0.01, 0.02, std::sin(0.3));
  const dGeomID a = box(1, 1, 1, at(0, 0, 0)), b = box(1, 1, 1, turned);
  const double deepest = depth(collide(a, b));
  struct Slot {
    dContactGeom geom;
    std::array<unsigned char, 40> guard;
  };
  // Whatever most is asked for: the deepest is among them.
  for (const unsigned unimportant : {0u, static_cast<unsigned>(CONTACTS_UNIMPORTANT)}) {
    for (int most = 1; most <= 12; ++most) {
      std::array<Slot, 13> slots;
      std::memset(slots.data(), 0x5a, sizeof(slots));
      const int flags = static_cast<int>(unimportant | static_cast<unsigned>(most));
      const int count = dCollide(a, b, flags, &slots[0].geom, sizeof(Slot));
      EXPECT_GE(count, 1);
      EXPECT_LE(count, std::min(most, 8));
      double found = 0;
      for (int i = 0; i < count; ++i) {
        EXPECT_GE(slots[i].geom.depth, 0.0);
        found = std::max(found, slots[i].geom.depth);
      }
      if (unimportant == 0) {
        EXPECT_EQ(found, deepest) << most;
      }
      // Bytes between contacts and after the last one are as they were.
      for (std::size_t i = 0; i < slots.size(); ++i) {
        EXPECT_THAT(slots[i].guard, testing::Each(0x5a));
        if (static_cast<int>(i) >= count) {
          unsigned char first;
          std::memcpy(&first, &slots[i].geom, 1);
          EXPECT_EQ(first, 0x5a) << "contact " << i << " was not to be touched";
        }
      }
    }
  }
}

TEST_F(OdePlugin, ThatIsApartIsNotTouched) {
  const OdeBoxOverride native;
  const dGeomID a = box(1, 1, 1, at(0, 0, 0)), b = box(1, 1, 1, at(1 + 0x1p-52, 0, 0));
  EXPECT_THAT(collide(a, b), testing::IsEmpty());
  const auto touching = collide(a, box(1, 1, 1, at(-1, 0, 0)));
  ASSERT_EQ(touching.size(), 4u);
  EXPECT_EQ(depth(touching), 0.0);
}

/// Bytes of what ODE answers for many pairs in both orders.
std::vector<double> answers(const std::vector<dGeomID>& geoms) {
  std::vector<double> all;
  for (const dGeomID a : geoms) {
    for (const dGeomID b : geoms) {
      if (a == b) continue;
      for (const dContactGeom& contact : collide(a, b)) {
        all.insert(all.end(), contact.pos, contact.pos + 3);
        all.insert(all.end(), contact.normal, contact.normal + 3);
        all.push_back(contact.depth);
        EXPECT_EQ(contact.g1, a);
        EXPECT_EQ(contact.g2, b);
        EXPECT_EQ(contact.side1, -1);
      }
    }
  }
  return all;
}

TEST_F(OdePlugin, WhatWasThereIsThereAgain) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> side(0.3, 1.5);
  for (int i = 0; i < 20; ++i) box(side(random), side(random), side(random), random_pose(random, 1.0));
  const auto engines = answers(geoms_);
  std::vector<double> ours;
  {
    const OdeBoxOverride outer;
    ours = answers(geoms_);
    EXPECT_NE(ours, engines);
    { const OdeBoxOverride inner; }
    EXPECT_EQ(answers(geoms_), ours);
  }
  EXPECT_EQ(answers(geoms_), engines);
  // A program's own collider, named.
  const auto users_own = [](dGeomID, dGeomID, int, dContactGeom*, int) { return 0; };
  dSetColliderOverride(dBoxClass, dBoxClass, users_own);
  EXPECT_THAT(answers(geoms_), testing::IsEmpty());
  {
    const OdeBoxOverride native({.previous = users_own});
    EXPECT_EQ(answers(geoms_), ours);
  }
  EXPECT_THAT(answers(geoms_), testing::IsEmpty());
  { const OdeBoxOverride native; }  // back to ODE's own, for the other tests
  EXPECT_EQ(answers(geoms_), engines);
}

TEST_F(OdePlugin, AnObserverIsToldOfBothChecksInOurTerms) {
  const dGeomID a = box(2, 2, 2, at(0, 0, 0)), b = box(1, 1, 1, at(1.25, 0, 0));
  const dGeomID far = box(1, 1, 1, at(9, 0, 0));
  const auto engines = collide(a, b);
  for (const EngineCheck check : {EngineCheck::own, EngineCheck::native}) {
    KeptPairs observer;
    const OdeBoxOverride native({.check = check, .observer = &observer});
    const auto contacts = collide(a, b);
    collide(a, far);
    ASSERT_EQ(observer.all.size(), 2u);
    const KeptPairs::Observation& observed = observer.all[0];
    EXPECT_EQ(observed.status, PairStatus::overlapping);
    EXPECT_NEAR(observed.geometry.separation, -0.25, kTolerance);
    ASSERT_EQ(observed.points.size(), contacts.size());
    // In whichever order ODE asks: A is where its half extents say, and n points from it to the other.
    const double from_a = observed.half_extents[0].x() == 1.0 ? 1.0 : -1.0;
    EXPECT_NEAR(observed.geometry.n_AB_W.x(), from_a, kTolerance);
    for (const ContactPoint& point : observed.points) {
      EXPECT_NEAR((from_a > 0 ? point.p_A_W : point.p_B_W).x(), 1.0, kTolerance);
      EXPECT_NEAR((from_a > 0 ? point.p_B_W : point.p_A_W).x(), 0.75, kTolerance);
    }
    EXPECT_EQ(observer.all[1].status, PairStatus::separated);
    EXPECT_TRUE(observer.all[1].points.empty());
    if (check == EngineCheck::native) continue;
    ASSERT_EQ(contacts.size(), engines.size());  // the engine goes on as it was
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      EXPECT_EQ(contacts[i].depth, engines[i].depth);
      EXPECT_EQ(contacts[i].normal[0], engines[i].normal[0]);
      EXPECT_EQ(contacts[i].g1, a);
    }
  }
}

TEST_F(OdePlugin, TheGuardKeepsOdeInitialised) {
  std::optional<OdeBoxOverride> native(std::in_place);
  dCloseODE();
  const dGeomID a = box(1, 1, 1, at(0, 0, 0)), b = box(1, 1, 1, at(0.5, 0, 0));
  EXPECT_EQ(collide(a, b).size(), 4u);
  dInitODE2(0);
}

TEST_F(OdePlugin, BoxesWithoutVolumeGoToOdeAndBadPosesHaveNoContacts) {
  const OdeBoxOverride native;
  const dGeomID a = box(1, 1, 1, at(0, 0, 0)), flat = box(1, 1, 0, at(0, 0, 0.25));
  const std::uint64_t before = ode_native_checks();
  collide(a, flat);
  EXPECT_EQ(ode_native_checks(), before);
  const dGeomID bad = box(1, 1, 1, at(0, 0, 0));
  dGeomSetPosition(bad, kInfinity, 0, 0);
  EXPECT_THAT(collide(a, bad), testing::IsEmpty());
  dGeomSetPosition(bad, 0, 0, 0);
}

TEST_F(OdePlugin, APlanesContactsAreHalfWayAndItsDeepestVerticesFirst) {
  Pose X = at(0.5, -0.25, 0.625);
  X.R = rotation_from_quaternion(std::cos(0.05), std::sin(0.05), 0, 0);
  const Hexahedron solid = frustum();
  const dGeomID geom = hexahedron(solid, X);
  geoms_.push_back(dCreatePlane(nullptr, 0, 0, 1, 0.25));
  const dGeomID plane = geoms_.back();
  std::vector<double> depths;
  for (const Vector3& vertex : solid.vertices())
    if (const double z = transform(X, vertex).z(); z <= 0.25) depths.push_back(0.25 - z);
  ASSERT_EQ(depths.size(), 4u);
  std::sort(depths.rbegin(), depths.rend());
  for (const bool swapped : {false, true}) {
    const auto contacts = swapped ? collide(plane, geom) : collide(geom, plane);
    ASSERT_EQ(contacts.size(), depths.size());
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      EXPECT_NEAR(contacts[i].depth, depths[i], kTolerance);
      EXPECT_NEAR(contacts[i].pos[2], 0.25 - 0.5 * depths[i], kTolerance);
      EXPECT_NEAR(std::abs(contacts[i].pos[0] - 0.5), 0.5, kTolerance);
    }
  }
}

TEST_F(OdePlugin, WhatNothingAnswersForIsCounted) {
  // Geoms that are flat or have no solid, beside sound ones.
  const dGeomID solid = hexahedron(frustum(), at(0, 0, 0)), flat = box(1, 1, 0, at(0, 0, 0.25));
  geoms_.push_back(dCreateGeom(ode_hexahedron_class()));
  const dGeomID empty = place(geoms_.back(), at(0, 0, -0.125));
  const dGeomID cube = box(1, 1, 1, at(0, 0, 0));
  geoms_.push_back(dCreatePlane(nullptr, 0, 0, 1, 0.5));
  const dGeomID plane = geoms_.back();
  const std::array<std::pair<dGeomID, dGeomID>, 4> pairs = {
      {{solid, flat}, {empty, solid}, {empty, cube}, {empty, plane}}};
  // Each pair is counted once, in either order.
  for (const auto& [a, b] : pairs) {
    for (const bool swapped : {false, true}) {
      const std::uint64_t before = ode_native_refusals();
      EXPECT_THAT(swapped ? collide(b, a) : collide(a, b), testing::IsEmpty());
      EXPECT_EQ(ode_native_refusals() - before, 1u);
    }
  }
  // A geom without a solid is a point.
  dReal bounds[6];
  dGeomGetAABB(empty, bounds);
  EXPECT_THAT(bounds, testing::ElementsAre(0, 0, 0, 0, -0.125, -0.125));
  // A place that is infinite counts; once it is sound again nothing does.
  const std::uint64_t before = ode_native_refusals();
  EXPECT_FALSE(collide(solid, cube).empty());
  dGeomSetPosition(cube, kInfinity, 0, 0);
  EXPECT_THAT(collide(solid, cube), testing::IsEmpty());
  dGeomSetPosition(cube, 0, 0, 0);
  EXPECT_EQ(ode_native_refusals() - before, 1u);
}

TEST_F(OdePlugin, ABoxThatChangesItsSizeIsSeen) {
  const OdeBoxOverride native;
  const dGeomID a = box(1, 1, 1, at(0, 0, 0)), b = box(1, 1, 1, at(0, 0, 0.75));
  EXPECT_NEAR(depth(collide(a, b)), 0.25, kTolerance);
  dGeomBoxSetLengths(b, 1, 1, 1.25);
  EXPECT_NEAR(depth(collide(a, b)), 0.375, kTolerance);
}

TEST_F(OdePlugin, CollidingAllocatesNothing) {
  const OdeBoxOverride native;
  std::mt19937_64 random(5);
  for (int i = 0; i < 20; ++i) {
    if (i % 2 == 0)
      box(1, 1.25, 1, random_pose(random, 1.0));
    else
      hexahedron(frustum(), random_pose(random, 1.0));
  }
  std::array<dContactGeom, 8> contacts;
  const auto collide_all = [&] {
    int count = 0;
    for (const dGeomID a : geoms_)
      for (const dGeomID b : geoms_) count += dCollide(a, b, 8, contacts.data(), sizeof(dContactGeom));
    return count;
  };
  const int count = collide_all();
  const std::size_t before = allocation_count();
  EXPECT_EQ(collide_all(), count);
  EXPECT_EQ(allocation_count() - before, 0u);
  EXPECT_GT(count, 100);
}

// Round sizes differ in the highest bits of a double only: a table of them must not mistake one for another.
TEST_F(OdePlugin, BoxesOfRoundSizesAreRememberedTogether) {
  const OdeBoxOverride native;
  const dGeomID cube = box(1, 1, 1, at(0, 0, 0));
  const std::array<double, 7> heights = {0.25, 0.5, 1.25, 1.5, 2, 3, 4};
  for (const double height : heights) box(1, 1, height, at(0, 0, 0.5 + height / 2 - 0.125));
  std::array<dContactGeom, 8> contacts;
  std::size_t allocations = 0;
  for (int round = 0; round < 10; ++round) {
    if (round == 1) allocations = allocation_count();
    for (std::size_t i = 1; i < geoms_.size(); ++i) {
      ASSERT_EQ(dCollide(cube, geoms_[i], 8, contacts.data(), sizeof(dContactGeom)), 4);
      EXPECT_NEAR(contacts[0].depth, 0.125, kTolerance) << heights[i - 1];
    }
  }
  EXPECT_EQ(allocation_count() - allocations, 0u);
}

TEST_F(OdePlugin, ThreadsWithBoxesOfManySizesGetTheirOwnAnswers) {
  const OdeBoxOverride native;
  constexpr int kThreads = 4, kSizes = 12, kRounds = 500;
  // Boxes of a size of their own in each stack.
  std::array<std::vector<dGeomID>, kThreads> stacks;
  for (int t = 0; t < kThreads; ++t) {
    for (int i = 0; i < kSizes; ++i) {
      const double height = 0.25 * (1 + i + kSizes * t);
      stacks[t].push_back(box(1, 1, height, at(0, 0, -height / 2)));
      stacks[t].push_back(box(1, 1, 1, at(0, 0, 0.5 - 1.0 / 64 * (1 + i + kSizes * t))));
    }
  }
  // Threads collide their stacks at once; each depth is its stack's.
  std::array<int, kThreads> wrong{};
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      dAllocateODEDataForThread(dAllocateMaskAll);
      std::array<dContactGeom, 8> contacts;
      for (int round = 0; round < kRounds; ++round) {
        for (int i = 0; i < kSizes; ++i) {
          const int count =
              dCollide(stacks[t][2 * i], stacks[t][2 * i + 1], 8, contacts.data(), sizeof(dContactGeom));
          const double expected = std::min(1.0 / 64 * (1 + i + kSizes * t), 0.25 * (1 + i + kSizes * t));
          wrong[t] += count == 0 || std::abs(contacts[0].depth - expected) > kTolerance;
        }
      }
      dCleanupODEAllDataForThread();
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(wrong, testing::Each(0));
}

}  // namespace
}  // namespace touchstone

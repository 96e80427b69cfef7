#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "touchstone/tests/bullet_plugin/collision_scene.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/kept_pairs.hpp"

// The solver's input: which points a manifold has, in which order, and what they remember.

namespace touchstone::test {
namespace {

TEST(TOUCHSTONE_SUITE, AContactBeginsAtTouchingAndGoesOnToTheBreakingThreshold) {
  CollisionScene scene(true);
  scene.add(make_box(1, 1, 1), at(0, 0, 0));
  btCollisionObject& b = scene.add(make_box(1, 1, 1), at(0, 0, 1.001));
  EXPECT_EQ(scene.detect().getNumContacts(), 0);
  b.setWorldTransform(to_engine(at(0, 0, 0.999)));
  EXPECT_EQ(scene.detect().getNumContacts(), 4);
  b.setWorldTransform(to_engine(at(0, 0, 1.001)));
  EXPECT_EQ(scene.detect().getNumContacts(), 4);
  EXPECT_NEAR(scene.detect().getContactPoint(0).getDistance(), 0.001, kTolerance);
  b.setWorldTransform(to_engine(at(0, 0, 1.1)));
  EXPECT_EQ(scene.detect().getNumContacts(), 0);
}

// Sums of sizes round: boxes and hulls with a margin that a program stacks to touch are apart by 1e-17 m.
TEST(TOUCHSTONE_SUITE, WhatIsPutTogetherTouchesThoughRoundingHasItApart) {
  constexpr int kCount = 40;
  for (const double margin : {0.0, 0.04}) {
    CollisionScene scene(true);
    const Hexahedron cube = Hexahedron::from_size({0.2, 0.2, 0.2});
    for (int i = 0; i < kCount; ++i) {
      const Pose X = at(0.1, 0, (0.2 + 2 * margin) * (i + 0.5));
      scene.add(margin > 0 ? std::unique_ptr<btCollisionShape>(make_hull(cube.vertices(), margin))
                           : make_box(0.2, 0.2, 0.2),
                X);
    }
    scene.detect();
    int touching = 0;
    for (int m = 0; m < scene.dispatcher.getNumManifolds(); ++m)
      touching += scene.dispatcher.getManifoldByIndexInternal(m)->getNumContacts() == 4 ? 1 : 0;
    EXPECT_EQ(touching, kCount - 1) << margin;
  }
}

// With an observer no pair ends at the face that parts it: observed runs have the same contacts.
TEST(TOUCHSTONE_SUITE, WhatWasApartTouchesWhereItTouchesObservedOrNot) {
  KeptPairs observer;
  for (PairObserver* const by :
       {static_cast<PairObserver*>(nullptr), static_cast<PairObserver*>(&observer)}) {
    CollisionScene scene(false);
    const BulletPlugin plugin(scene.dispatcher, BulletPlugin::Options{EngineCheck::native, by});
    scene.add(make_box(1, 1, 1), at(0, 0, 0));
    btCollisionObject& b = scene.add(make_box(1, 1, 1), at(0, 0, 1.001));
    ASSERT_EQ(scene.detect().getNumContacts(), 0);
    b.setWorldTransform(to_engine(at(0, 0, 1.0 + std::numeric_limits<btScalar>::epsilon())));
    EXPECT_EQ(scene.detect().getNumContacts(), 0) << (by != nullptr);
    b.setWorldTransform(to_engine(at(0, 0, 1.0)));
    EXPECT_EQ(scene.detect().getNumContacts(), 4) << (by != nullptr);
  }
}

TEST(TOUCHSTONE_SUITE, PointsThatAnotherResultPutIntoTheManifoldAreFoundAnew) {
  struct OthersResult final : btManifoldResult {
    using btManifoldResult::btManifoldResult;
  };
  CollisionScene scene(true);
  btCollisionObject& a = scene.add(make_box(1, 1, 1), at(0, 0, 0));
  btCollisionObject& b = scene.add(make_box(1, 1, 1), at(0, 0, 1.001));
  ASSERT_EQ(scene.detect().getNumContacts(), 0);
  // Somebody asks our algorithm of the pair for points of its own, into the pair's manifold.
  b.setWorldTransform(to_engine(at(0, 0, 0.999)));
  const auto wrapped = [](const btCollisionObject& object) {
    return btCollisionObjectWrapper(nullptr, object.getCollisionShape(), &object, object.getWorldTransform(),
                                    -1, -1);
  };
  const btCollisionObjectWrapper of_a = wrapped(a), of_b = wrapped(b);
  OthersResult result(&of_a, &of_b);
  scene.broadphase.getOverlappingPairCache()->getOverlappingPairArray()[0].m_algorithm->processCollision(
      &of_a, &of_b, scene.world.getDispatchInfo(), &result);
  ASSERT_EQ(scene.dispatcher.getManifoldByIndexInternal(0)->getNumContacts(), 4);
  // The step's own check has them where the boxes are now.
  b.setWorldTransform(to_engine(at(0, 0, 1.005)));
  ASSERT_EQ(scene.detect().getNumContacts(), 4);
  EXPECT_NEAR(scene.detect().getContactPoint(0).getDistance(), 0.005, kTolerance);
}

// As Bullet's restore does, which reads points of a file into the manifolds that it was shown.
TEST(TOUCHSTONE_SUITE, PointsPutIntoAManifoldThatWasShownDoNotStayInTheAir) {
  CollisionScene scene(true);
  scene.add(make_box(1, 1, 1), at(0, 0, 0));
  btCollisionObject& b = scene.add(make_box(1, 1, 1), at(0, 0, 1.005));
  ASSERT_EQ(scene.detect().getNumContacts(), 0);
  ASSERT_EQ(scene.detect().getNumContacts(), 0);  // by the face that parts them
  btManifoldArray shown;
  scene.broadphase.getOverlappingPairCache()
      ->getOverlappingPairArray()[0]
      .m_algorithm->getAllContactManifolds(shown);
  ASSERT_EQ(shown.size(), 1);
  const btVector3 up(0, 0, 1), place(to_engine(0.25), 0, to_engine(0.5));
  for (const double x : {0.25, -0.25}) {
    const btVector3 on_a(to_engine(x), 0, to_engine(0.5)), on_b(to_engine(x), 0, to_engine(-0.5));
    shown[0]->addManifoldPoint(btManifoldPoint(on_a, on_b, -up, to_engine(-0.001)));
  }
  ASSERT_EQ(shown[0]->getNumContacts(), 2);
  // A contact goes on while apart: its points are those of where the boxes are now.
  ASSERT_EQ(scene.detect().getNumContacts(), 4);
  EXPECT_NEAR(scene.detect().getContactPoint(0).getDistance(), 0.005, kTolerance);
  // Beyond the breaking threshold nothing is left.
  b.setWorldTransform(to_engine(at(0, 0, 1.03)));
  EXPECT_EQ(scene.detect().getNumContacts(), 0);
  shown[0]->addManifoldPoint(btManifoldPoint(place, -place, -up, to_engine(-0.001)));
  btManifoldArray again;
  scene.broadphase.getOverlappingPairCache()
      ->getOverlappingPairArray()[0]
      .m_algorithm->getAllContactManifolds(again);
  EXPECT_EQ(scene.detect().getNumContacts(), 0);
}

TEST(TOUCHSTONE_SUITE, PointsKeepTheirMemoryAsLongAsTheirFeaturesMeet) {
  CollisionScene scene(true);
  scene.add(make_box(2, 2, 1), at(0, 0, 0));
  btCollisionObject& b = scene.add(make_box(1, 1, 1), at(0, 0, 0.99));
  btPersistentManifold& manifold = scene.detect();
  ASSERT_EQ(manifold.getNumContacts(), 4);
  for (int k = 0; k < 4; ++k) manifold.getContactPoint(k).m_appliedImpulse = to_engine(k + 1);
  std::array<btVector3, 4> on_b;
  for (int k = 0; k < 4; ++k) on_b[k] = manifold.getContactPoint(k).m_localPointB;
  // A quarter of a metre in one step: far beyond the breaking threshold, but the same corners of B.
  b.setWorldTransform(to_engine(at(0.25, 0.25, 0.98)));
  scene.detect();
  ASSERT_EQ(manifold.getNumContacts(), 4);
  for (int k = 0; k < 4; ++k) {
    const btManifoldPoint& point = manifold.getContactPoint(k);
    const auto old = static_cast<std::size_t>(static_cast<double>(point.m_appliedImpulse)) - 1;
    ASSERT_LT(old, 4u);
    EXPECT_EQ(point.getLifeTime(), 1);
    expect_near(point.m_localPointB, on_b[old]);
    EXPECT_NEAR(point.getDistance(), -0.02, kTolerance);
  }
}

TEST(TOUCHSTONE_SUITE, TheDeepestPointComesLastAndBringsItsMemory) {
  CollisionScene scene(true);
  scene.add(make_box(2, 2, 1), at(0, 0, 0));
  btCollisionObject& b = scene.add(make_box(1, 1, 1), at(0, 0, 0.98));
  // Leaning to each side in turn, so that every corner is the deepest once.
  std::vector<std::pair<btVector3, btScalar>> impulses;  // of each corner of B
  for (const double about_x : {0.01, -0.01}) {
    for (const double about_y : {0.004, -0.004}) {
      btTransform X = to_engine(at(0, 0, 0.98));
      X.setRotation(btQuaternion(to_engine(about_y), to_engine(about_x), 0));
      b.setWorldTransform(X);
      btPersistentManifold& manifold = scene.detect();
      ASSERT_EQ(manifold.getNumContacts(), 4);
      for (int k = 1; k < 4; ++k)
        EXPECT_GT(manifold.getContactPoint(k - 1).getDistance(), manifold.getContactPoint(k).getDistance());
      for (int k = 0; k < 4; ++k) {
        btManifoldPoint& point = manifold.getContactPoint(k);
        for (const auto& [corner, impulse] : impulses) {
          if ((corner - point.m_localPointB).length() < 0.1) {
            EXPECT_EQ(point.m_appliedImpulse, impulse);
          }
        }
      }
      if (!impulses.empty()) continue;
      for (int k = 0; k < 4; ++k) {
        manifold.getContactPoint(k).m_appliedImpulse = to_engine(k + 1);
        impulses.emplace_back(manifold.getContactPoint(k).m_localPointB, to_engine(k + 1));
      }
    }
  }
}

/// A box of these sides, its hull drawn in by the margin.
std::unique_ptr<btConvexHullShape> make_box_with_margin(double x, double y, double z) {
  constexpr double kMargin = 0.04;
  std::array<Vector3, 8> corners;
  for (int i = 0; i < 8; ++i)
    corners[i] = {((i & 1) != 0 ? 1 : -1) * (x / 2 - kMargin), ((i & 2) != 0 ? 1 : -1) * (y / 2 - kMargin),
                  ((i & 4) != 0 ? 1 : -1) * (z / 2 - kMargin)};
  return make_hull(corners, kMargin);
}

/// Where the points were at first, by the impulse that each was given then.
class FirstPlaces {
 public:
  explicit FirstPlaces(btPersistentManifold& manifold) {
    for (int k = 0; k < 4; ++k) {
      corner_B_[k] = manifold.getContactPoint(k).m_localPointB;
      manifold.getContactPoint(k).m_appliedImpulse = to_engine(k + 1);
    }
  }
  /// Of the point that now is at `k`; its memory must have come with it.
  int of(btPersistentManifold& manifold, int k) const {
    const btManifoldPoint& point = manifold.getContactPoint(k);
    const int was = static_cast<int>(std::lround(static_cast<double>(point.m_appliedImpulse))) - 1;
    if (was < 0 || was > 3) return -1;
    expect_near(point.m_localPointB, corner_B_[was]);
    return was;
  }

 private:
  std::array<btVector3, 4> corner_B_;
};

TEST(TOUCHSTONE_SUITE, OfHullsWithAMarginThatLeanEachPointTakesEachPlaceInTurn) {
  CollisionScene scene(true);
  scene.add(make_box_with_margin(2, 2, 1), at(0, 0, 0));
  btTransform X = to_engine(at(0, 0, 0.98));
  X.setRotation(btQuaternion(to_engine(0.004), to_engine(0.01), 0));
  scene.add(make_box_with_margin(1, 1, 1), at(0, 0, 0.98)).setWorldTransform(X);
  btPersistentManifold& manifold = scene.detect();
  ASSERT_EQ(manifold.getNumContacts(), 4);
  const FirstPlaces first(manifold);
  int seen[4][4] = {};
  for (int step = 0; step < 8; ++step) {
    scene.detect();
    ASSERT_EQ(manifold.getNumContacts(), 4);
    for (int k = 0; k < 4; ++k) {
      const int was = first.of(manifold, k);
      ASSERT_GE(was, 0);
      ++seen[k][was];
    }
  }
  for (const auto& place : seen)
    for (const int times : place) EXPECT_EQ(times, 2);
}

TEST(TOUCHSTONE_SUITE, OfHullsWithAMarginPointsOfOneDepthKeepTheirPlaces) {
  CollisionScene scene(true);
  scene.add(make_box_with_margin(2, 2, 1), at(0, 0, 0));
  scene.add(make_box_with_margin(1, 1, 1), at(0, 0, 0.75));
  btPersistentManifold& manifold = scene.detect();
  ASSERT_EQ(manifold.getNumContacts(), 4);
  const FirstPlaces first(manifold);
  for (int step = 0; step < 4; ++step) {
    scene.detect();
    ASSERT_EQ(manifold.getNumContacts(), 4);
    for (int k = 0; k < 4; ++k) EXPECT_EQ(first.of(manifold, k), k);
  }
}

TEST(TOUCHSTONE_SUITE, WhatRoundingMakesOfTouchingIsTouchingForTheSolver) {
  const double ulp = std::numeric_limits<btScalar>::epsilon();
  for (const double ulps : {-1.0, 1.0, 2.0, -3.0}) {
    CollisionScene scene(true);
    scene.add(make_box(4, 4, 2), at(0, 0, 0));
    btCollisionObject& b = scene.add(make_box(1, 1, 1), at(0, 0, 1.25));
    scene.detect();
    b.setWorldTransform(to_engine(at(0, 0, 1.5 + ulps * ulp)));
    const Contacts contacts = scene.query(0.01);
    ASSERT_EQ(contacts.points.size(), 4u);
    EXPECT_EQ(contacts.deepest()->getDistance(), to_engine(ulps * ulp));
    b.setWorldTransform(to_engine(at(0, 0, 1.4375)));
    scene.detect();
    b.setWorldTransform(to_engine(at(0, 0, 1.5 + ulps * ulp)));
    btPersistentManifold& manifold = scene.detect();
    ASSERT_EQ(manifold.getNumContacts(), 4);
    for (int k = 0; k < 4; ++k) {
      const double expected = std::abs(ulps) * ulp <= 1.5 * ulp ? 0.0 : ulps * ulp;
      EXPECT_EQ(manifold.getContactPoint(k).getDistance(), to_engine(expected)) << ulps;
    }
  }
}

TEST(TOUCHSTONE_SUITE, FourPointsKeepTheDeepestAndHalfTheArea) {
  // The leaning box has eight corners in the other one.
  CollisionScene scene(true);
  scene.add(make_box(1, 1, 1), at(0, 0, 0));
  Pose X = at(0, 0, 0.95);  // turned by 45 degrees and leaning: eight corners of unlike depth
  const double c = std::sqrt(0.5), s = std::sin(0.02);
  X.R << c, -c, 0, c, c, 0, 0, 0, 1;
  Pose lean;
  lean.R << std::cos(0.02), 0, s, 0, 1, 0, -s, 0, std::cos(0.02);
  X = compose(X, lean);
  scene.add(make_box(1, 1, 1), X);
  btPersistentManifold& manifold = scene.detect();
  ASSERT_EQ(manifold.getNumContacts(), 4);
  // The deepest is among the four.
  double deepest = 0;
  btVector3 p[4];
  for (int k = 0; k < 4; ++k) {
    deepest = std::min(deepest, static_cast<double>(manifold.getContactPoint(k).getDistance()));
    p[k] = manifold.getContactPoint(k).getPositionWorldOnB();
  }
  EXPECT_LT(deepest, -0.05);
  // Of any two of them as a diagonal, the largest area.
  double area = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      const int k = (i == 0 && j == 1) ? 2 : (i == 0 ? 1 : 0), l = 6 - i - j - k;
      area = std::max(area, 0.5 * std::abs(static_cast<double>((p[j] - p[i]).cross(p[l] - p[k]).z())));
    }
  const double octagon = 2.0 * (std::sqrt(2.0) - 1.0);  // two unit squares at 45 degrees have this in common
  EXPECT_GT(area, 0.5 * octagon);
}

std::vector<void*>* destroyed = nullptr;

TEST(TOUCHSTONE_SUITE, UserDataGoesWithItsPointAndIsGivenBackOnce) {
  std::vector<void*> gone;
  destroyed = &gone;
  gContactDestroyedCallback = [](void* data) {
    destroyed->push_back(data);
    return true;
  };
  {
    CollisionScene scene(true);
    scene.add(make_box(2, 2, 1), at(0, 0, 0));
    btCollisionObject& b = scene.add(make_box(1, 1, 1), at(0.25, 0, 0.98));
    btPersistentManifold& manifold = scene.detect();
    std::array<int, 4> data{};
    std::array<btVector3, 4> on_b;
    for (int k = 0; k < 4; ++k) {
      manifold.getContactPoint(k).m_userPersistentData = &data[k];
      on_b[k] = manifold.getContactPoint(k).m_localPointB;
    }
    // Two corners leave the lower box, a quarter of a metre away: two points end, and two begin on its rim.
    b.setWorldTransform(to_engine(at(0.75, 0, 0.98)));
    scene.detect();
    ASSERT_EQ(manifold.getNumContacts(), 4);
    EXPECT_EQ(gone.size(), 2u);
    int kept = 0;
    for (int k = 0; k < 4; ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      if (point.m_userPersistentData == nullptr) continue;
      ++kept;
      expect_near(point.m_localPointB, on_b[static_cast<int*>(point.m_userPersistentData) - data.data()]);
    }
    EXPECT_EQ(kept, 2);
    b.setWorldTransform(to_engine(at(0.75, 0, 1.03)));
    scene.detect();
    EXPECT_EQ(manifold.getNumContacts(), 0);
    std::sort(gone.begin(), gone.end());
    EXPECT_THAT(gone, testing::ElementsAre(&data[0], &data[1], &data[2], &data[3]));
  }
  EXPECT_EQ(gone.size(), 4u);
  gContactDestroyedCallback = nullptr;
}

TEST(TOUCHSTONE_SUITE, AnAnchoredPointStaysUntilItsFrictionIsUsedUp) {
  // Four points, of which two have used up their friction.
  CollisionScene scene(true);
  btCollisionObject& a = scene.add(make_box(2, 2, 1), at(0, 0, 0));
  btCollisionObject& b = scene.add(make_box(1, 1, 1), at(0, 0, 0.98));
  a.setCollisionFlags(a.getCollisionFlags() | btCollisionObject::CF_HAS_FRICTION_ANCHOR);
  btPersistentManifold& manifold = scene.detect();
  ASSERT_EQ(manifold.getNumContacts(), 4);
  std::array<btVector3, 4> on_a;
  for (int k = 0; k < 4; ++k) {
    btManifoldPoint& point = manifold.getContactPoint(k);
    on_a[k] = point.m_localPointA;
    point.m_appliedImpulse = 8;
    point.m_appliedImpulseLateral1 = k < 2 ? 1 : 7;  // friction 0.25: the last two slide
  }
  // As the box slides by a millimetre those two go with it.
  b.setWorldTransform(to_engine(at(0.001, 0, 0.98)));
  scene.detect();
  int anchored = 0;
  for (int k = 0; k < 4; ++k) {
    const btManifoldPoint& point = manifold.getContactPoint(k);
    const bool holds = point.m_appliedImpulseLateral1 == 1;
    anchored += holds;
    EXPECT_EQ(point.getLifeTime(), 1);
    double nearest = 1.0;
    for (const btVector3& p : on_a) nearest = std::min<double>(nearest, (point.m_localPointA - p).length());
    EXPECT_NEAR(nearest, holds ? 0.0 : 0.001, kTolerance);
  }
  EXPECT_EQ(anchored, 2);
}

}  // namespace
}  // namespace touchstone::test

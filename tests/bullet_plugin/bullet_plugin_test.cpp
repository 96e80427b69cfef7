#include "touchstone/adapters/bullet_plugin/bullet_plugin.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <LinearMath/btAlignedAllocator.h>
#include <LinearMath/btPoolAllocator.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <random>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/bullet_plugin/collision_scene.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/kept_pairs.hpp"

namespace touchstone::test {
namespace {

std::array<Vector3, 8> box_vertices(double x, double y, double z) {
  return Hexahedron::from_size({x, y, z}).vertices();
}

btVector3 unit_x(double sign) { return {to_engine(sign), 0, 0}; }

TEST(TOUCHSTONE_SUITE, ThePointIsOnBAndTheNormalPointsToA) {
  for (const bool swapped : {false, true}) {
    CollisionScene scene(true);
    scene.add(make_box(2, 2, 2), at(0, 0, 0));
    scene.add(make_box(1, 1, 1), at(1.25, 0, 0));
    const Contacts contacts = scene.query(0.0, swapped);
    ASSERT_EQ(contacts.points.size(), 4u);
    for (const btManifoldPoint& point : contacts.points) {
      EXPECT_NEAR(point.getDistance(), -0.25, kTolerance);
      expect_near(point.m_normalWorldOnB, unit_x(swapped ? 1 : -1));
      // B's face, seen from inside A: at x = 0.75 if B is the small box, at x = 1 if it is the large one.
      EXPECT_NEAR(point.getPositionWorldOnB().x(), swapped ? 1.0 : 0.75, kTolerance);
      EXPECT_NEAR(point.getPositionWorldOnA().x(), swapped ? 0.75 : 1.0, kTolerance);
      EXPECT_NEAR(std::abs(point.getPositionWorldOnB().y()), 0.5, kTolerance);
    }
    EXPECT_EQ(scene.plugin->statistics().checks, 1u);
  }
}

TEST(TOUCHSTONE_SUITE, ClosestPointsOfBoxesThatAreApart) {
  CollisionScene scene(true);
  scene.add(make_box(1, 1, 1), at(0, 0, 0));
  scene.add(make_box(1, 1, 1), at(1.5, 1.5, 0));
  EXPECT_THAT(scene.query(0.5).points, testing::IsEmpty());
  const Contacts contacts = scene.query(0.75);
  ASSERT_NE(contacts.deepest(), nullptr);
  EXPECT_NEAR(contacts.deepest()->getDistance(), std::sqrt(0.5), kTolerance);
}

TEST(TOUCHSTONE_SUITE, AHullsMarginIsAroundItAndABoxsInside) {
  CollisionScene scene(true);
  scene.add(make_hull(box_vertices(1, 1, 1), 0.125), at(0, 0, 0));
  btCollisionObject& b = scene.add(make_box(1, 1, 1), at(1.0625, 0, 0));
  ASSERT_NE(scene.query().deepest(), nullptr);
  EXPECT_NEAR(scene.query().deepest()->getDistance(), -0.0625, kTolerance);
  EXPECT_NEAR(scene.query().deepest()->getPositionWorldOnA().x(), 0.625, kTolerance);
  // Over an edge the grown hull is round.
  b.setWorldTransform(to_engine(at(1.0625, 1.0625, 0)));
  EXPECT_NEAR(scene.query().deepest()->getDistance(), std::sqrt(2.0) * 0.0625 - 0.125, kTolerance);
}

struct Dispatcher : btCollisionDispatcher {
  using btCollisionDispatcher::btCollisionDispatcher;
  std::vector<btCollisionAlgorithmCreateFunc*> tables() const {
    std::vector<btCollisionAlgorithmCreateFunc*> all;
    for (int i = 0; i < MAX_BROADPHASE_COLLISION_TYPES; ++i)
      for (int k = 0; k < MAX_BROADPHASE_COLLISION_TYPES; ++k)
        all.insert(all.end(), {m_doubleDispatchContactPoints[i][k], m_doubleDispatchClosestPoints[i][k]});
    return all;
  }
};

TEST(TOUCHSTONE_SUITE, TheTablesAreAsTheyWereAfterwards) {
  btDefaultCollisionConfiguration configuration;
  Dispatcher dispatcher(&configuration);
  btCollisionAlgorithmCreateFunc users_own;
  dispatcher.registerCollisionCreateFunc(BOX_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, &users_own);
  const auto before = dispatcher.tables();
  {
    const BulletPlugin outer(dispatcher);
    const auto with_one = dispatcher.tables();
    EXPECT_NE(with_one, before);
    { const BulletPlugin inner(dispatcher); }
    EXPECT_EQ(dispatcher.tables(), with_one);
  }
  EXPECT_EQ(dispatcher.tables(), before);
}

TEST(TOUCHSTONE_SUITE, SeveralPluginsMayGoInAnyOrder) {
  const std::array<Vector3, 4> tetrahedron = {Vector3(0, 0, 0), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const std::array<int, 3>& order :
       {std::array{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}) {
    // Two boxes and a hull, and three plug-ins in the dispatcher.
    btDefaultCollisionConfiguration configuration;
    Dispatcher dispatcher(&configuration);
    const auto before = dispatcher.tables();
    btDbvtBroadphase broadphase;
    btCollisionWorld world(&dispatcher, &broadphase, &configuration);
    const auto box = make_box(1, 1, 1), small = make_box(0.5, 0.5, 0.5);
    const auto other = make_hull(tetrahedron);
    std::array<btCollisionObject, 3> objects;
    for (int i = 0; i < 3; ++i)
      objects[i].setCollisionShape(i == 2 ? static_cast<btCollisionShape*>(other.get())
                                          : (i == 0 ? box : small).get());
    std::array<std::unique_ptr<BulletPlugin>, 3> plugins;
    for (auto& plugin : plugins) plugin = std::make_unique<BulletPlugin>(dispatcher);
    // The newest that is left answers for boxes; the engine for the hull.
    for (const int first : order) {
      plugins[first].reset();
      const BulletPlugin* newest = nullptr;
      for (const auto& plugin : plugins)
        if (plugin) newest = plugin.get();
      const std::uint64_t checks = newest != nullptr ? newest->statistics().checks : 0;
      for (const int partner : {1, 2}) {
        Contacts contacts;
        world.contactPairTest(&objects[0], &objects[partner], contacts);
        EXPECT_FALSE(contacts.points.empty());
      }
      if (newest != nullptr) {
        EXPECT_EQ(newest->statistics().checks, checks + 1);
      }
    }
    EXPECT_EQ(dispatcher.tables(), before);
  }
}

TEST(TOUCHSTONE_SUITE, AnEntryThatAProgramHasWrittenSinceIsLeft) {
  btDefaultCollisionConfiguration configuration;
  Dispatcher dispatcher(&configuration);
  btCollisionAlgorithmCreateFunc users_own;
  auto expected = dispatcher.tables();
  {
    const BulletPlugin plugin(dispatcher);
    dispatcher.registerCollisionCreateFunc(BOX_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, &users_own);
  }
  ASSERT_EQ(BOX_SHAPE_PROXYTYPE, 0);
  expected[0] = &users_own;
  EXPECT_EQ(dispatcher.tables(), expected);
}

TEST(TOUCHSTONE_SUITE, AnEngineWithoutAnAlgorithmIsObserved) {
  CollisionScene scene(false);
  btCollisionAlgorithmCreateFunc none;  // creates null
  scene.dispatcher.registerCollisionCreateFunc(BOX_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, &none);
  scene.plugin.emplace(scene.dispatcher, BulletPlugin::Options{EngineCheck::own, nullptr});
  scene.add(make_box(1, 1, 1), at(0, 0, 0));
  scene.add(make_box(1, 1, 1), at(0, 0, 0.75));
  scene.world.performDiscreteCollisionDetection();
  const btBroadphasePairArray& pairs = scene.broadphase.getOverlappingPairCache()->getOverlappingPairArray();
  ASSERT_EQ(pairs.size(), 1);
  ASSERT_NE(pairs[0].m_algorithm, nullptr);
  btManifoldArray manifolds;
  pairs[0].m_algorithm->getAllContactManifolds(manifolds);
  EXPECT_EQ(manifolds.size(), 0);
}

TEST(TOUCHSTONE_SUITE, APoolWithTooSmallElementsIsRefused) {
  btPoolAllocator small(64, 16);
  btDefaultCollisionConstructionInfo info;
  info.m_collisionAlgorithmPool = &small;
  btDefaultCollisionConfiguration configuration(info);
  btCollisionDispatcher dispatcher(&configuration);
  EXPECT_THROW(BulletPlugin{dispatcher}, InputError);
}

TEST(TOUCHSTONE_SUITE, APoolThatRunsOutIsNoMatter) {
  btDefaultCollisionConstructionInfo info;
  info.m_defaultMaxCollisionAlgorithmPoolSize = 2;
  btDefaultCollisionConfiguration configuration(info);
  btCollisionDispatcher dispatcher(&configuration);
  const BulletPlugin plugin(dispatcher);
  btDbvtBroadphase broadphase;
  btCollisionWorld world(&dispatcher, &broadphase, &configuration);
  const auto shape = make_box(1, 1, 1);
  std::vector<btCollisionObject> objects(6);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    objects[i].setCollisionShape(shape.get());
    objects[i].setWorldTransform(to_engine(at(0.1 * static_cast<double>(i), 0, 0)));
    world.addCollisionObject(&objects[i]);
  }
  world.performDiscreteCollisionDetection();
  EXPECT_EQ(dispatcher.getNumManifolds(), 15);
  for (btCollisionObject& object : objects) world.removeCollisionObject(&object);
}

TEST(TOUCHSTONE_SUITE, HullsThatAreNoHexahedraGoToTheEngine) {
  const std::array<Vector3, 4> tetrahedron = {Vector3(0, 0, 0), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::array<Vector3, 8> antiprism;  // two squares turned by 45 degrees: ten faces
  for (int i = 0; i < 8; ++i) {
    const double angle = (i * 45.0) * 3.141592653589793 / 180.0;
    antiprism[i] = {std::cos(angle), std::sin(angle), i % 2 ? 0.5 : -0.5};
  }
  for (const std::span<const Vector3> points : {std::span<const Vector3>(tetrahedron), {antiprism}}) {
    CollisionScene scene(true);
    scene.add(make_hull(points), at(0, 0, 0));
    scene.add(make_box(1, 1, 1), at(0, 0, 0.75));
    EXPECT_FALSE(scene.query().points.empty());
    EXPECT_GT(scene.detect().getNumContacts(), 0);
    EXPECT_EQ(scene.plugin->statistics().checks, 0u);
  }
}

TEST(TOUCHSTONE_SUITE, AShapeThatIsScaledIsSeen) {
  CollisionScene scene(true);
  scene.add(make_box(1, 1, 1), at(0, 0, 0));
  scene.add(make_hull(box_vertices(1, 1, 1)), at(0, 0, 0.75));
  EXPECT_NEAR(scene.detect().getContactPoint(0).getDistance(), -0.25, kTolerance);
  scene.shapes[0]->setLocalScaling({1, 1, to_engine(1.25)});
  EXPECT_NEAR(scene.detect().getContactPoint(0).getDistance(), -0.375, kTolerance);
  scene.shapes[1]->setLocalScaling({1, 1, to_engine(0.75)});
  EXPECT_NEAR(scene.detect().getContactPoint(0).getDistance(), -0.25, kTolerance);
  scene.shapes[1]->setLocalScaling({1, 1, 0});
  EXPECT_EQ(scene.detect().getNumContacts(), 0);
  EXPECT_EQ(scene.plugin->statistics().refused, 1u);
}

TEST(TOUCHSTONE_SUITE, APairOutlivesThePlugin) {
  CollisionScene scene(true);
  scene.add(make_box(1, 1, 1), at(0, 0, 0));
  scene.add(make_box(1, 1, 1), at(0, 0, 0.75));
  EXPECT_EQ(scene.detect().getNumContacts(), 4);
  scene.plugin.reset();
  EXPECT_EQ(scene.detect().getNumContacts(), 4);
}

TEST(TOUCHSTONE_SUITE, APoseThatIsNotFiniteHasNoContacts) {
  CollisionScene scene(true);
  scene.add(make_box(1, 1, 1), at(0, 0, 0));
  btCollisionObject& b = scene.add(make_box(1, 1, 1), at(0, 0, 0.75));
  b.getWorldTransform().setOrigin({0, 0, std::numeric_limits<btScalar>::quiet_NaN()});
  EXPECT_TRUE(scene.query().points.empty());
  EXPECT_EQ(scene.plugin->statistics().refused, 1u);
  b.setWorldTransform(to_engine(at(0, 0, 0.75)));
}

TEST(TOUCHSTONE_SUITE, ACompoundsChildrenAreChecked) {
  CollisionScene scene(true);
  const auto child = make_box(1, 1, 1);
  auto compound = std::make_unique<btCompoundShape>();
  compound->addChildShape(to_engine(at(-2, 0, 0)), child.get());
  compound->addChildShape(to_engine(at(2, 0, 0)), child.get());
  scene.add(std::move(compound), at(0, 0, 0));
  scene.add(make_box(1, 1, 1), at(2, 0, 0.75));
  scene.world.performDiscreteCollisionDetection();
  int points = 0;
  for (int i = 0; i < scene.dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *scene.dispatcher.getManifoldByIndexInternal(i);
    for (int k = 0; k < manifold.getNumContacts(); ++k, ++points) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      EXPECT_NEAR(point.getDistance(), -0.25, kTolerance);
      const bool first = manifold.getBody0() == scene.objects[0].get();
      EXPECT_EQ(first ? point.m_index0 : point.m_index1, 1);
      EXPECT_NEAR((first ? point.m_localPointA : point.m_localPointB).z(), 0.5, kTolerance);
    }
  }
  EXPECT_EQ(points, 4);
  EXPECT_GE(scene.plugin->statistics().checks, 1u);
}

TEST(TOUCHSTONE_SUITE, AnObserverIsToldOfBothChecksInOurTerms) {
  for (const EngineCheck check : {EngineCheck::own, EngineCheck::native}) {
    for (const double margin : {0.0, 0.0625}) {
      KeptPairs observer;
      CollisionScene scene(false);
      scene.plugin.emplace(scene.dispatcher, BulletPlugin::Options{check, &observer});
      scene.add(make_hull(box_vertices(2, 2, 2), margin), at(0, 0, 0));
      btCollisionObject& b = scene.add(make_hull(box_vertices(1, 1, 1), margin), at(1.25, 0, 0));
      scene.detect();
      ASSERT_EQ(observer.all.size(), 1u);
      EXPECT_EQ(observer.all[0].status, PairStatus::overlapping);
      // The engine's GJK and EPA are right to 1e-3 m in single precision, 1e-6 m in double.
      const double tolerance = check == EngineCheck::native ? kTolerance : (kDouble ? 1e-5 : 1e-3);
      const PairGeometry& geometry = observer.all[0].geometry;
      EXPECT_NEAR(geometry.separation, -0.25, tolerance) << margin;
      EXPECT_NEAR(geometry.n_AB_W.x(), 1.0, tolerance);
      EXPECT_NEAR(geometry.p_A_W.x(), 1.0, tolerance);
      EXPECT_NEAR(geometry.p_B_W.x(), 0.75, tolerance);
      ASSERT_FALSE(observer.all[0].points.empty());
      b.setWorldTransform(to_engine(at(1.8, 0, 0)));
      scene.world.performDiscreteCollisionDetection();
      for (std::size_t i = 1; i < observer.all.size(); ++i) {
        EXPECT_EQ(observer.all[i].status, PairStatus::separated);
      }
      scene.plugin.reset();
      b.setWorldTransform(to_engine(at(1.25, 0, 0)));
      const std::size_t before = observer.all.size();
      scene.detect();
      EXPECT_EQ(observer.all.size(), before);
    }
  }
}

struct CallbackCount {
  int started = 0, ended = 0, processed = 0, added = 0;
};
CallbackCount* counts = nullptr;

TEST(TOUCHSTONE_SUITE, ContactCallbacksAreTheEngines) {
  // Callbacks that count.
  CallbackCount count;
  counts = &count;
  gContactStartedCallback = [](btPersistentManifold* const&) { ++counts->started; };
  gContactEndedCallback = [](btPersistentManifold* const&) { ++counts->ended; };
  gContactProcessedCallback = [](btManifoldPoint&, void*, void*) {
    ++counts->processed;
    return true;
  };
  gContactAddedCallback = [](btManifoldPoint&, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) {
    ++counts->added;
    return true;
  };
  // Contact starts; points are told of on request; contact ends.
  {
    CollisionScene scene(true);
    btCollisionObject& a = scene.add(make_box(1, 1, 1), at(0, 0, 0));
    btCollisionObject& b = scene.add(make_box(1, 1, 1), at(0, 0, 0.75));
    scene.detect();
    EXPECT_EQ(count.started, 1);
    EXPECT_EQ(count.added, 0);
    a.setCollisionFlags(a.getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
    b.setWorldTransform(to_engine(at(0.25, 0, 0.75)));
    scene.detect();
    EXPECT_EQ(count.added, 4);
    EXPECT_EQ(count.processed, 8);
    b.setWorldTransform(to_engine(at(5, 0, 0)));
    scene.world.performDiscreteCollisionDetection();
    EXPECT_EQ(count.started, 1);
    EXPECT_EQ(count.ended, 1);
  }
  gContactStartedCallback = nullptr, gContactEndedCallback = nullptr;
  gContactProcessedCallback = nullptr, gContactAddedCallback = nullptr;
}

std::atomic<std::size_t> bullet_allocations{0};
void* counted_for_bullet(size_t size) {
  ++bullet_allocations;
  return std::malloc(size);
}

TEST(TOUCHSTONE_SUITE, StepsWithoutNewPairsAllocateNothing) {
  btAlignedAllocSetCustom(counted_for_bullet, std::free);
  {
    // A stack of boxes and hulls that shakes a little.
    CollisionScene scene(true);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> size(0.8, 1.2);
    for (int i = 0; i < 10; ++i) {
      if (i % 2 == 0)
        scene.add(make_box(size(random), size(random), 1), at(0, 0, 0.9 * i));
      else
        scene.add(make_hull(box_vertices(size(random), size(random), 1)), at(0, 0, 0.9 * i));
    }
    const auto step = [&](int i) {
      for (std::size_t k = 0; k < scene.objects.size(); k += 2) {
        btTransform& X = scene.objects[k]->getWorldTransform();
        X.getOrigin().setX(to_engine(0.001 * (i % 5)));
      }
      scene.world.performDiscreteCollisionDetection();
    };
    // Once warm, nothing is allocated, and each step checks its nine pairs.
    for (int i = 0; i < 5; ++i) step(i);
    const std::size_t before = allocation_count() + bullet_allocations;
    for (int i = 0; i < 20; ++i) step(i);
    EXPECT_EQ(allocation_count() + bullet_allocations - before, 0u);
    EXPECT_EQ(scene.plugin->statistics().checks, 9u * 25u);
  }
  btAlignedAllocSetCustom(nullptr, nullptr);
}

}  // namespace
}  // namespace touchstone::test

// BulletPlugin::Options::middle_first: what rests creeps less with few iterations.

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include "touchstone/adapters/bullet_plugin/bullet_plugin.hpp"
#include "touchstone/tests/bullet_plugin/collision_scene.hpp"
#include "touchstone/tests/support/ask.hpp"

namespace touchstone {
namespace {

struct Stack {
  int count;
  double size;  // [m]
  int iterations;
  double rate;  // [Hz]
};

enum class Check { own, corners, middle };

std::unique_ptr<btConvexHullShape> cube(double size) {
  auto hull = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < 8; ++i) {
    const auto side = [&](int bit) { return btScalar((i & bit) != 0 ? 0.5 : -0.5) * btScalar(size); };
    hull->addPoint(btVector3(side(4), side(2), side(1)), false);
  }
  hull->recalcLocalAabb();
  return hull;
}

/// How far the worst cube of hulls with Bullet's usual margin comes in 5 s [m].
double creep(const Stack& stack, Check check, unsigned start) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  std::optional<BulletPlugin> plugin;
  if (check != Check::own)
    plugin.emplace(dispatcher, BulletPlugin::Options{EngineCheck::native, nullptr, check == Check::middle});
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity(btVector3(0, 0, btScalar(-9.81)));
  world.getSolverInfo().m_numIterations = stack.iterations;
  const auto hull = cube(stack.size);
  btBoxShape slab(btVector3(10, 10, 1) * btScalar(stack.size));
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<btVector3> places;
  std::mt19937 random(start);
  const auto draw = [&] { return 2.0 * static_cast<double>(random()) / 0x1p32 - 1.0; };
  const auto add = [&](btScalar mass, btCollisionShape* shape, const btVector3& p) {
    const btScalar moment = mass * btScalar(stack.size * stack.size / 6.0);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, btVector3(moment, moment, moment));
    info.m_startWorldTransform.setIdentity();
    info.m_startWorldTransform.setOrigin(p);
    info.m_friction = btScalar(std::sqrt(0.5));  // Bullet multiplies the two
    bodies.push_back(std::make_unique<btRigidBody>(info));
    bodies.back()->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(bodies.back().get());
    places.push_back(p);
  };
  add(0, &slab, btVector3(0, 0, btScalar(-stack.size)));
  for (int i = 0; i < stack.count; ++i)
    add(btScalar(1000.0 * stack.size * stack.size * stack.size), hull.get(),
        btVector3(btScalar(1e-3 * stack.size * draw()), btScalar(1e-3 * stack.size * draw()),
                  btScalar(stack.size * (i + 0.5)) + hull->getMargin() * btScalar(2 * i + 1)));
  const auto step = btScalar(1.0 / stack.rate);
  for (int i = 0; i < static_cast<int>(5.0 * stack.rate); ++i) world.stepSimulation(step, 0, step);
  double most = 0.0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const btVector3 way = bodies[i]->getWorldTransform().getOrigin() - places[i];
    most = std::max(most, std::hypot(static_cast<double>(way.x()), static_cast<double>(way.y())));
  }
  for (const auto& body : bodies) world.removeRigidBody(body.get());
  return most;
}

double median_creep(const Stack& stack, Check check) {
  std::vector<double> all;
  for (unsigned start = 1; start <= 15; ++start) all.push_back(creep(stack, check, start));
  std::sort(all.begin(), all.end());
  return all[all.size() / 2];
}

TEST(TOUCHSTONE_SUITE, TheMiddleFirstCreepsLessWithFewIterations) {
  for (const Stack& stack : {Stack{3, 0.2, 10, 60}, {5, 0.5, 4, 60}, {8, 0.2, 10, 240}}) {
    const double own = median_creep(stack, Check::own), corners = median_creep(stack, Check::corners),
                 middle = median_creep(stack, Check::middle);
    std::printf("%d cubes of %.1f m, %d iterations, %.0f Hz: own %.1e, corners %.1e, middle %.1e m\n",
                stack.count, stack.size, stack.iterations, stack.rate, own, corners, middle);
    // In single precision rounding is what is left.
    EXPECT_LT(middle, corners / (sizeof(btScalar) == sizeof(double) ? 10.0 : 1.0));
    EXPECT_LT(middle, own / 2.0);
  }
}

/// Impulses at a manifold's last three points whose centre is `place` [m, in the world]; false where that is
/// not between them.
bool press_at(const btVector3& place, btPersistentManifold& manifold) {
  const auto at = [&](int k) { return manifold.getContactPoint(k).m_positionWorldOnB; };
  const auto area = [](const btVector3& p, const btVector3& q, const btVector3& r) {
    return (q - p).cross(r - p).z();
  };
  manifold.getContactPoint(0).m_appliedImpulse = 0;
  const btScalar whole = area(at(1), at(2), at(3));
  const std::array<btScalar, 3> parts = {area(place, at(2), at(3)), area(at(1), place, at(3)),
                                         area(at(1), at(2), place)};
  for (int k = 0; k < 3; ++k) {
    manifold.getContactPoint(k + 1).m_appliedImpulse = parts[k] / whole;
    if (!(parts[k] / whole >= 0)) return false;
  }
  return true;
}

// Of this face the corner farthest from one is not across from it.
TEST(TOUCHSTONE_SUITE, TheMiddleGoesToWhereTheImpulsesActOnFacesOfAnyShape) {
  const std::array<btVector3, 4> face = {btVector3(0, 0, 0), btVector3(10, 0, 0), btVector3(6, 3, 0),
                                         btVector3(0, 3, 0)};
  int pressed = 0;
  for (std::size_t begin = 0; begin < face.size(); ++begin) {  // whichever is found first
    test::CollisionScene scene(false);
    const BulletPlugin plugin(scene.dispatcher, BulletPlugin::Options{EngineCheck::native, nullptr, true});
    // A prism over this face on a slab.
    std::vector<Vector3> corners;
    for (const double z : {0.0, 1.0})
      for (std::size_t i = 0; i < face.size(); ++i) {
        const btVector3& corner = face[(begin + i) % face.size()];
        corners.emplace_back(static_cast<double>(corner.x()), static_cast<double>(corner.y()), z);
      }
    scene.add(test::make_box(40, 40, 1), at(0, 0, -0.5));
    scene.add(test::make_hull(corners), at(0, 0, 0));
    btPersistentManifold& manifold = scene.detect();
    ASSERT_EQ(manifold.getNumContacts(), 4);
    // Impulses about one place draw the first point to it.
    const btVector3 target(4, test::to_engine(2.8), 0);
    if (!press_at(target, manifold)) continue;
    ++pressed;
    for (int round = 0; round < 20; ++round) {
      ASSERT_TRUE(press_at(target, manifold)) << round;
      scene.detect();
    }
    EXPECT_LT((manifold.getContactPoint(0).m_positionWorldOnB - target).length(), 1e-3) << begin;
  }
  EXPECT_GT(pressed, 0);
}

// Faces that rock under few iterations would push what rests on them to one side.
TEST(TOUCHSTONE_SUITE, TheMiddleKeepsItsNormalWhileTheFacesHardlyTurn) {
  test::CollisionScene scene(false);
  const BulletPlugin plugin(scene.dispatcher, BulletPlugin::Options{EngineCheck::native, nullptr, true});
  scene.add(test::make_box(4, 4, 1), at(0, 0, -0.5));
  btCollisionObject& cube = scene.add(test::make_box(1, 1, 1), at(0, 0, 0.5));
  btCollisionObject& plate = *scene.objects[0];
  /// Of both turned about the place where they touch (the plate's face has it), the cube `x` along the face.
  const auto normal_at = [&](double turn, double x) {
    const auto put = [&](btCollisionObject& object, double along, double up) {
      btTransform X(btQuaternion(btVector3(0, 1, 0), test::to_engine(turn)));
      X.setOrigin(X.getBasis() * btVector3(test::to_engine(along), 0, test::to_engine(up)));
      object.setWorldTransform(X);
    };
    put(plate, 0, -0.5), put(cube, x, 0.4999);
    return scene.detect().getContactPoint(0).m_normalWorldOnB;
  };
  const btVector3 level = normal_at(0, 0);
  EXPECT_EQ(normal_at(1e-5, 0), level);
  // It is the faces' of what slides, and where they turn by more than moves a corner by 0.2 mm.
  EXPECT_NE(normal_at(1e-5, 0.01), level);
  const btVector3 turned = normal_at(1e-3, 0.01);
  EXPECT_NEAR(std::abs(static_cast<double>(turned.x())), 1e-3, 1e-5);
}

}  // namespace
}  // namespace touchstone

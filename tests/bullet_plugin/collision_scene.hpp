#pragma once

#include <btBulletCollisionCommon.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "touchstone/adapters/bullet/engine.hpp"
#include "touchstone/adapters/bullet_plugin/bullet_plugin.hpp"
#include "touchstone/contact_core/geometry/hexahedron.hpp"

// A collision world with the engine's own check or with ours.

namespace touchstone::test {

using namespace TOUCHSTONE_BULLET_NAMESPACE;

inline constexpr double kTolerance = 8.0 * std::numeric_limits<btScalar>::epsilon();

inline void expect_near(const btVector3& p, const btVector3& q) { EXPECT_LE((p - q).length(), kTolerance); }

inline std::unique_ptr<btBoxShape> make_box(double x, double y, double z) {
  return std::make_unique<btBoxShape>(btVector3(to_engine(x / 2), to_engine(y / 2), to_engine(z / 2)));
}

inline std::unique_ptr<btConvexHullShape> make_hull(std::span<const Vector3> points, double margin = 0.0) {
  auto hull = std::make_unique<btConvexHullShape>();
  for (const Vector3& v : points) hull->addPoint(to_engine(v), false);
  hull->setMargin(to_engine(margin));
  hull->recalcLocalAabb();
  return hull;
}

/// Keeps what a query reports.
struct Contacts final : btCollisionWorld::ContactResultCallback {
  std::vector<btManifoldPoint> points;

  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                           const btCollisionObjectWrapper*, int, int) override {
    points.push_back(point);
    return 0;
  }
  /// Null when there is none.
  const btManifoldPoint* deepest() const {
    const btManifoldPoint* best = nullptr;
    for (const btManifoldPoint& point : points)
      if (best == nullptr || point.getDistance() < best->getDistance()) best = &point;
    return best;
  }
};

class CollisionScene {
 public:
  explicit CollisionScene(bool native) {
    if (native) plugin.emplace(dispatcher);
  }
  ~CollisionScene() {
    for (const auto& object : objects) world.removeCollisionObject(object.get());
  }
  CollisionScene(const CollisionScene&) = delete;
  CollisionScene& operator=(const CollisionScene&) = delete;

  btCollisionObject& add(std::unique_ptr<btCollisionShape> shape, const Pose& X_WS) {
    objects.push_back(std::make_unique<btCollisionObject>());
    objects.back()->setCollisionShape(shape.get());
    objects.back()->setWorldTransform(to_engine(X_WS));
    world.addCollisionObject(objects.back().get());
    shapes.push_back(std::move(shape));
    return *objects.back();
  }

  /// contactPairTest of the first two objects, or of the second and the first.
  Contacts query(double closer_than = 0.0, bool swapped = false) {
    Contacts contacts;
    contacts.m_closestDistanceThreshold = to_engine(closer_than);
    world.contactPairTest(objects[swapped ? 1 : 0].get(), objects[swapped ? 0 : 1].get(), contacts);
    return contacts;
  }

  /// A step's collision detection; the only manifold.
  btPersistentManifold& detect() {
    world.performDiscreteCollisionDetection();
    return *dispatcher.getManifoldByIndexInternal(0);
  }

  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  std::optional<BulletPlugin> plugin;
  btDbvtBroadphase broadphase;
  btCollisionWorld world{&dispatcher, &broadphase, &configuration};
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btCollisionObject>> objects;
};

}  // namespace touchstone::test

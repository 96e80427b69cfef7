#include "touchstone/adapters/bullet_dynamics/bullet_shapes.hpp"

#include <btBulletCollisionCommon.h>

namespace touchstone::physics::bullet_dynamics {

using namespace TOUCHSTONE_BULLET_NAMESPACE;

btCollisionShape* Shapes::keep(std::unique_ptr<btCollisionShape> shape) {
  shapes_.push_back(std::move(shape));
  return shapes_.back().get();
}

btCollisionShape* Shapes::box(const Vector3& half) {
  for (const Box& each : boxes_)
    if (each.half == half) return each.shape;
  boxes_.push_back({half, keep(std::make_unique<btBoxShape>(to_engine(half)))});
  return boxes_.back().shape;
}

btCollisionShape* Shapes::hull(const Hexahedron& solid, const Pose& X_BS) {
  auto hull = std::make_unique<btConvexHullShape>();
  for (const Vector3& v : solid.vertices())
    hull->addPoint(to_engine(is_same(X_BS, {}) ? v : transform(X_BS, v)), false);
  hull->setMargin(0);
  hull->recalcLocalAabb();
  hull->initializePolyhedralFeatures();
  return keep(std::move(hull));
}

btCollisionShape* Shapes::make(const EngineScene& scene, std::size_t index) {
  const EngineScene::Body& body = scene.bodies()[index];
  const auto solid_of = [&](SolidIndex i) -> const EngineScene::Solid& { return scene.solids()[i]; };
  if (body.solids.size() == 1) {
    const EngineScene::Solid& only = solid_of(body.solids[0]);
    if (!only.solid->is_box()) return hull(*only.solid, only.X_BS);
    if (is_same(only.X_BS, {})) return box(only.solid->half_extents());
  }
  auto compound = std::make_unique<btCompoundShape>(true, static_cast<int>(body.solids.size()));
  for (const SolidIndex i : body.solids) {
    const EngineScene::Solid& each = solid_of(i);
    if (each.solid->is_box())
      compound->addChildShape(to_engine(each.X_BS), box(each.solid->half_extents()));
    else
      compound->addChildShape(btTransform::getIdentity(), hull(*each.solid, each.X_BS));
  }
  return keep(std::move(compound));
}

}  // namespace touchstone::physics::bullet_dynamics

#pragma once

#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <memory>
#include <vector>

#include "touchstone/adapters/bullet/engine.hpp"
#include "touchstone/physics/engine/engine_scene.hpp"

namespace touchstone::physics::bullet_dynamics {

/// Shapes of a world. Equal boxes share one.
class Shapes {
 public:
  /// Of all solids of a body, in its frame. A compound's children are in the order of Body::solids.
  btCollisionShape* make(const EngineScene& scene, std::size_t body);

 private:
  btCollisionShape* box(const Vector3& half);
  btCollisionShape* hull(const Hexahedron& solid, const Pose& X_BS);
  btCollisionShape* keep(std::unique_ptr<btCollisionShape> shape);

  struct Box {
    Vector3 half;
    btCollisionShape* shape;
  };
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<Box> boxes_;
};

}  // namespace touchstone::physics::bullet_dynamics

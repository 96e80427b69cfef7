#pragma once

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <LinearMath/btTransform.h>

#include <cstdint>

#include "touchstone/adapters/bullet/engine.hpp"

// Most pairs that a broadphase lists do not touch, and a plane along a face of one of them says so.

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {

/// The face whose plane parted two boxes last, tried first the next time.
class PartingFace {
 public:
  /// Whether the plane of a face parts the boxes, by more than all that is rounded here. False is no answer;
  /// so for matrices that are no rotations within kRotationTolerance, whose solids are others, and for boxes
  /// that have become flat.
  bool parts(const btTransform& X_WA, const btVector3& half_a, const btTransform& X_WB,
             const btVector3& half_b);

 private:
  std::uint8_t last_ = 0;  ///< 0 to 2: of A, 3 to 5: of B
};

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE

#pragma once

#include <BulletCollision/CollisionShapes/btConvexShape.h>
#include <LinearMath/btTransform.h>

#include "touchstone/contact_core/geometry/pose.hpp"

// Which of the two builds of Bullet these sources are compiled against. Everything of ours lives in an inline
// namespace named for it.

#ifdef BT_USE_DOUBLE_PRECISION
#define TOUCHSTONE_BULLET_NAMESPACE bullet_double
#else
#define TOUCHSTONE_BULLET_NAMESPACE bullet_single
#endif

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {

inline constexpr bool kDouble = sizeof(btScalar) == sizeof(double);

inline btScalar to_engine(double value) { return static_cast<btScalar>(value); }
inline btVector3 to_engine(const Vector3& v) {
  return {to_engine(v.x()), to_engine(v.y()), to_engine(v.z())};
}
inline Vector3 from_engine(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

inline Pose from_engine(const btTransform& X) {
  Pose out;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) out.R(i, k) = X.getBasis()[i][k];
  out.p = from_engine(X.getOrigin());
  return out;
}

inline btTransform to_engine(const Pose& X) {
  const Matrix3& R = X.R;
  return btTransform(btMatrix3x3(to_engine(R(0, 0)), to_engine(R(0, 1)), to_engine(R(0, 2)),  //
                                 to_engine(R(1, 0)), to_engine(R(1, 1)), to_engine(R(1, 2)),  //
                                 to_engine(R(2, 0)), to_engine(R(2, 1)), to_engine(R(2, 2))),
                     to_engine(X.p));
}

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE

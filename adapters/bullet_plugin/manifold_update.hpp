#pragma once

#include <BulletCollision/CollisionDispatch/btManifoldResult.h>

#include <array>
#include <cstdint>
#include <span>

#include "touchstone/adapters/bullet/engine.hpp"

// A persistent manifold made equal to what the check found, with the memory of its points kept.

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {

/// A contact point in Bullet's terms.
struct FoundPoint {
  btVector3 normal_on_B;  ///< unit, on B toward A
  btVector3 point_on_B;
  btScalar distance;  ///< < 0 penetrating
  std::uint32_t feature_id;
};

/// The features that made the points of a manifold, in its order.
struct ManifoldFeatures {
  static constexpr int kUnknown = -1;

  int count = 0;            ///< kUnknown where somebody else may have put points in
  std::uint32_t turns = 0;  ///< of the points' order
  std::array<std::uint32_t, MANIFOLD_CACHE_SIZE> ids{};
};

/// Two objects as the algorithm was called with them; `a` is the manifold's body 0.
struct ObjectPair {
  const btCollisionObjectWrapper& a;
  const btCollisionObjectWrapper& b;
};

/// Afterwards the manifold holds `points` and nothing else. Calls the engine's contact callbacks as the
/// engine does: added for each point where a body asks for it, started, processed, destroyed, ended.
/// @param by_middle of four points one in their midst, first, and three of them: BulletPlugin::Options.
/// @pre no more points than MANIFOLD_CACHE_SIZE, none beyond the breaking threshold, all of one normal
void update_manifold(const ObjectPair& objects, std::span<const FoundPoint> points,
                     btPersistentManifold& manifold, ManifoldFeatures& features, bool by_middle);

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE

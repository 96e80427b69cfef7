#pragma once

#include <BulletCollision/NarrowPhaseCollision/btDiscreteCollisionDetectorInterface.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include "touchstone/adapters/bullet/shapes.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

// The engine's two checks of one posed pair, and how fine each of them is.

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {

/// One contact as Bullet reports it: point on B, normal on B (from B to A), distance < 0 penetrating.
struct EngineContact {
  btVector3 normal_on_B;
  btVector3 point_on_B;
  btScalar distance;
};

/// Takes what a detector reports, in its order.
class ContactCollector final : public btDiscreteCollisionDetectorInterface::Result {
 public:
  void setShapeIdentifiersA(int, int) override {}
  void setShapeIdentifiersB(int, int) override {}
  void addContactPoint(const btVector3& normal_on_B, const btVector3& point_on_B,
                       btScalar distance) override {
    if (count_ < kMaxManifoldPoints) contacts_[count_++] = {normal_on_B, point_on_B, distance};
  }

  void clear() { count_ = 0; }
  std::span<const EngineContact> contacts() const { return {contacts_, static_cast<std::size_t>(count_)}; }

 private:
  EngineContact contacts_[kMaxManifoldPoints];
  int count_ = 0;
};

/// A thread's solvers.
struct Solvers {
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver penetration;
  ContactCollector collector;
  btDiscreteCollisionDetectorInterface::ClosestPointInput input;
};

enum class EngineAnswer : std::uint8_t {
  contacts,  ///< in the collector
  apart,     ///< nothing reported: further apart than the engine was asked to look
  none,      ///< the engine came to no result
};

/// btBoxBoxDetector. `contacts` only when the boxes overlap as far as it can tell.
/// @pre both are boxes
EngineAnswer check_boxes(const Shape& a, const Shape& b, const btTransform& X_WA, const btTransform& X_WB,
                         Solvers& solvers);

/// btGjkPairDetector with EPA, as btConvexConvexAlgorithm runs it. `contacts` (one) when closer than
/// max_distance [m].
EngineAnswer check_convex(const Shape& a, const Shape& b, const btTransform& X_WA, const btTransform& X_WB,
                          double max_distance, Solvers& solvers);

/// Resolution: a part that grows with the pair's size, and one with its place in the world.
struct CheckResolution {
  double absolute;  ///< [m]
  double of_size;   ///< per metre of the larger solid
  double of_place;  ///< per metre of the larger |world coordinate|, or size
};
CheckResolution box_resolution();
CheckResolution convex_resolution();

/// btBoxBoxDetector keeps a face normal unless an edge's depth is smaller by its fudge_factor 1.05.
inline constexpr double kBoxDepthOverestimate = 0.05;
/// EPA stops short of the least depth for about one deep pair in 10 000; the worst measured was 6 %
/// (packaged 3.24).
inline constexpr double kConvexDepthOverestimate = 0.1;

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE

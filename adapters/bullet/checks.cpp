#include "touchstone/adapters/bullet/checks.hpp"

#include <BulletCollision/CollisionDispatch/btBoxBoxDetector.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>

#include <algorithm>
#include <limits>

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {
namespace {

constexpr double kEpsilon = std::numeric_limits<btScalar>::epsilon();

// btBoxBoxDetector adds fudge2 = 1e-5 to the direction cosines of its edge tests: an edge's gap or depth is
// off by 1e-5
// * (four half-extents) / sin(angle between the edges). Measured, per metre of size: 6e-5 on random boxes
// near touching, 2.4e-4 with edges 1e-6 to 0.1 rad apart. Not a bound: a smaller sine makes it larger, up to
// where a face normal is preferred, about sqrt(1e-5).
constexpr double kBoxFudge = 1e-3;

// btGjkPairDetector.cpp, m_lastUsedMethod: 1 GJK, 3 and 8 EPA, 5 and 6 the second GJK. 2 and 9 leave nothing
// valid.
bool has_result(int last_used_method) {
  return last_used_method == 1 || last_used_method == 3 || last_used_method == 5 || last_used_method == 6 ||
         last_used_method == 8 || last_used_method == 10;
}

btScalar squared(double max_distance) {
  constexpr double kLargest = std::numeric_limits<btScalar>::max();
  return to_engine(std::min(max_distance * max_distance, kLargest));
}

}  // namespace

EngineAnswer check_boxes(const Shape& a, const Shape& b, const btTransform& X_WA, const btTransform& X_WB,
                         Solvers& solvers) {
  btBoxBoxDetector detector(static_cast<const btBoxShape*>(a.shape.get()),
                            static_cast<const btBoxShape*>(b.shape.get()));
  solvers.collector.clear();
  solvers.input.m_transformA = X_WA;
  solvers.input.m_transformB = X_WB;
  detector.getClosestPoints(solvers.input, solvers.collector, nullptr);
  return solvers.collector.contacts().empty() ? EngineAnswer::apart : EngineAnswer::contacts;
}

EngineAnswer check_convex(const Shape& a, const Shape& b, const btTransform& X_WA, const btTransform& X_WB,
                          double max_distance, Solvers& solvers) {
  btGjkPairDetector detector(a.shape.get(), b.shape.get(), &solvers.simplex, &solvers.penetration);
  solvers.collector.clear();
  solvers.input.m_transformA = X_WA;
  solvers.input.m_transformB = X_WB;
  solvers.input.m_maximumDistanceSquared = squared(max_distance);
  detector.getClosestPointsNonVirtual(solvers.input, solvers.collector, nullptr);
  if (!solvers.collector.contacts().empty()) return EngineAnswer::contacts;
  return has_result(detector.m_lastUsedMethod) ? EngineAnswer::apart : EngineAnswer::none;
}

CheckResolution box_resolution() { return {0.0, kBoxFudge, 8 * kEpsilon}; }

// sqrt(REL_ERROR2), which btGjkPairDetector uses as an absolute length as well, and relative to the distance.
CheckResolution convex_resolution() { return {kDouble ? 1e-6 : 1e-3, 0.0, 8 * kEpsilon}; }

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE

// Bullet's sweeps, in double precision, without margins; but btGjkConvexCast gives up where a step lands on
// touch, and has the margins within its boxes that setSafeMargin() gives.

#include "touchstone/tests/benchmarks/motion/impact_method.hpp"

#ifdef TOUCHSTONE_BENCHMARK_BULLET_DYNAMICS
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/NarrowPhaseCollision/btContinuousConvexCollision.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btSubSimplexConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include <algorithm>

namespace touchstone::impact {
namespace {

btVector3 to_engine(const Vector3& p) { return {p.x(), p.y(), p.z()}; }

btTransform to_engine(const Pose& X) {
  const btMatrix3x3 R(X.R(0, 0), X.R(0, 1), X.R(0, 2), X.R(1, 0), X.R(1, 1), X.R(1, 2), X.R(2, 0), X.R(2, 1),
                      X.R(2, 2));
  return btTransform(R, to_engine(X.p));
}

std::unique_ptr<btConvexShape> make_shape(const Hexahedron& solid, bool has_margin) {
  std::unique_ptr<btConvexInternalShape> shape;
  if (solid.is_box()) {
    const Vector3 half = solid.half_extents();
    shape = std::make_unique<btBoxShape>(to_engine(half));
    shape->setMargin(has_margin ? std::min(0.04, 0.1 * half.minCoeff()) : 0.0);
  } else {
    auto hull = std::make_unique<btConvexHullShape>();
    for (const Vector3& vertex : solid.vertices()) hull->addPoint(to_engine(vertex), false);
    hull->setMargin(0.0);
    hull->recalcLocalAabb();
    shape = std::move(hull);
  }
  return shape;
}

enum class Kind { gjk, subsimplex, continuous };

class BulletCast final : public Method {
 public:
  explicit BulletCast(Kind kind) : kind_(kind) {}
  std::string_view name() const override {
    switch (kind_) {
      case Kind::gjk:
        return "btGjkConvexCast";
      case Kind::subsimplex:
        return "btSubsimplexConvexCast";
      case Kind::continuous:
        break;
    }
    return "btContinuousConvexCollision";
  }
  bool turns() const override { return kind_ == Kind::continuous; }

  void set(const Motion& motion) override {
    const bool has_margin = kind_ == Kind::gjk;
    a_ = make_shape(motion.a, has_margin), b_ = make_shape(motion.b, has_margin);
    from_a_ = to_engine(motion.path_a.from()), to_a_ = to_engine(motion.path_a.to());
    from_b_ = to_engine(motion.path_b.from()), to_b_ = to_engine(motion.path_b.to());
  }

  std::optional<double> impact() override {
    simplex_.reset();
    btConvexCast::CastResult result;
    result.m_fraction = 1.0;
    bool hits = false;
    if (kind_ == Kind::gjk)
      hits = btGjkConvexCast(a_.get(), b_.get(), &simplex_)
                 .calcTimeOfImpact(from_a_, to_a_, from_b_, to_b_, result);
    if (kind_ == Kind::subsimplex)
      hits = btSubsimplexConvexCast(a_.get(), b_.get(), &simplex_)
                 .calcTimeOfImpact(from_a_, to_a_, from_b_, to_b_, result);
    if (kind_ == Kind::continuous)
      hits = btContinuousConvexCollision(a_.get(), b_.get(), &simplex_, &depth_)
                 .calcTimeOfImpact(from_a_, to_a_, from_b_, to_b_, result);
    return hits ? std::optional(static_cast<double>(result.m_fraction)) : std::nullopt;
  }

 private:
  Kind kind_;
  std::unique_ptr<btConvexShape> a_, b_;
  btTransform from_a_, to_a_, from_b_, to_b_;
  btVoronoiSimplexSolver simplex_;
  btGjkEpaPenetrationDepthSolver depth_;
};

}  // namespace

std::unique_ptr<Method> make_bullet_gjk_cast() { return std::make_unique<BulletCast>(Kind::gjk); }
std::unique_ptr<Method> make_bullet_subsimplex_cast() {
  return std::make_unique<BulletCast>(Kind::subsimplex);
}
std::unique_ptr<Method> make_bullet_continuous() { return std::make_unique<BulletCast>(Kind::continuous); }

}  // namespace touchstone::impact
#else
namespace touchstone::impact {
std::unique_ptr<Method> make_bullet_gjk_cast() { return nullptr; }
std::unique_ptr<Method> make_bullet_subsimplex_cast() { return nullptr; }
std::unique_ptr<Method> make_bullet_continuous() { return nullptr; }
}  // namespace touchstone::impact
#endif

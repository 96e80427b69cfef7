#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/NarrowPhaseCollision/btContinuousConvexCollision.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btSubSimplexConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <LinearMath/btTransformUtil.h>

#include <array>
#include <utility>

#include "touchstone/adapters/bullet/backends.hpp"
#include "touchstone/adapters/bullet/shapes.hpp"

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {
namespace {

class BulletSweep final : public Sweep {
 public:
  explicit BulletSweep(SweepMethod method) : method_(method) {}

  /// btTransformUtil::integrateTransform() cuts turns to ANGULAR_MOTION_THRESHOLD.
  double most_turn() const noexcept override {
    return method_ == SweepMethod::continuous ? static_cast<double>(ANGULAR_MOTION_THRESHOLD) : 0.0;
  }

  void set(const Hexahedron& a, const RigidPath& path_a, const Hexahedron& b,
           const RigidPath& path_b) override {
    const std::array<Hexahedron, 2> solids = {a, b};
    std::vector<Shape> shapes = make_shapes(solids);
    if (method_ == SweepMethod::gjk)
      for (std::size_t i = 0; i < 2; ++i) restore_margin(shapes[i], solids[i]);
    shapes_ = std::move(shapes);
    from_ = {to_engine(path_a.from()), to_engine(path_b.from())};
    to_ = {to_engine(path_a.to()), to_engine(path_b.to())};
  }

  std::optional<double> impact() override {
    simplex_.reset();
    const btConvexShape *a = shapes_[0].shape.get(), *b = shapes_[1].shape.get();
    switch (method_) {
      case SweepMethod::gjk:
        return time_of(btGjkConvexCast(a, b, &simplex_));
      case SweepMethod::subsimplex:
        return time_of(btSubsimplexConvexCast(a, b, &simplex_));
      case SweepMethod::continuous:
        break;
    }
    return time_of(btContinuousConvexCollision(a, b, &simplex_, &penetration_));
  }

 private:
  /// The margin within its box that setSafeMargin() gives, as btBoxShape has it by itself.
  static void restore_margin(Shape& shape, const Hexahedron& solid) {
    if (!shape.is_box) return;
    const Vector3 half_extents = solid.half_extents();
    shape.shape = std::make_unique<btBoxShape>(to_engine(half_extents));
  }

  std::optional<double> time_of(btConvexCast&& cast) const {
    btConvexCast::CastResult result;
    result.m_fraction = btScalar(1);
    if (!cast.calcTimeOfImpact(from_[0], to_[0], from_[1], to_[1], result)) return std::nullopt;
    return static_cast<double>(result.m_fraction);
  }

  SweepMethod method_;
  std::vector<Shape> shapes_;
  std::array<btTransform, 2> from_, to_;
  btVoronoiSimplexSolver simplex_;
  btGjkEpaPenetrationDepthSolver penetration_;
};

}  // namespace

std::unique_ptr<Sweep> make_sweep(SweepMethod method) { return std::make_unique<BulletSweep>(method); }

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE

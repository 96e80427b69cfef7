#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>

#include "touchstone/adapters/bullet/backends.hpp"
#include "touchstone/adapters/bullet/checks.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {
namespace {

class BulletRawCheck final : public RawCheck {
 public:
  explicit BulletRawCheck(Method method) : method_(method) {}

  void build(std::span<const Hexahedron> solids) override { shapes_ = make_shapes(solids); }

  /// Distance under `bullet` would time a box detector that does not answer it.
  bool supports(QueryKind kind) const noexcept override {
    return kind != QueryKind::distance || method_ == Method::gjk;
  }

  void set_poses(std::span<const Pose> poses) override {
    transforms_.clear();
    for (const Pose& X_WS : poses) transforms_.push_back(to_engine(X_WS));
  }

  std::size_t run(std::span<const SolidPair> pairs, QueryKind kind) noexcept override {
    std::size_t in_contact = 0;
    for (const SolidPair& pair : pairs) in_contact += in_touch(pair, kind) ? 1 : 0;
    return in_contact;
  }

 private:
  bool in_touch(const SolidPair& pair, QueryKind kind) noexcept {
    const Shape &a = shapes_[pair.a], &b = shapes_[pair.b];
    const btTransform &X_WA = transforms_[pair.a], &X_WB = transforms_[pair.b];
    if (method_ == Method::box_and_convex && a.is_box && b.is_box) {
      check_boxes(a, b, X_WA, X_WB, solvers_);
    } else if (kind == QueryKind::overlap) {
      // GJK alone, less than half the price of btGjkPairDetector: that one goes on to EPA for every overlap.
      btGjkEpaSolver2::sResults results;
      return !btGjkEpaSolver2::Distance(a.shape.get(), X_WA, b.shape.get(), X_WB,
                                        X_WB.getOrigin() - X_WA.getOrigin(), results);
    } else {
      // Manifolds are asked of contacts only: what is apart by more than is distinguished from contact ends
      // early.
      const double looked_at = kind == QueryKind::distance ? kInfinity : convex_resolution().absolute;
      check_convex(a, b, X_WA, X_WB, looked_at, solvers_);
    }
    bool touching = false;
    for (const EngineContact& contact : solvers_.collector.contacts())
      touching = touching || contact.distance <= 0;
    return touching;
  }

  Method method_;
  std::vector<Shape> shapes_;
  std::vector<btTransform> transforms_;
  Solvers solvers_;
};

}  // namespace

std::unique_ptr<RawCheck> make_raw_check(Method method) { return std::make_unique<BulletRawCheck>(method); }

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE

#include "adapters/bullet/backends.hpp"
#include "adapters/bullet/checks.hpp"

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
    // Asked up to 0, GJK stops at the first axis that separates.
    const double max_distance = kind == QueryKind::overlap ? 0.0 : std::numeric_limits<double>::infinity();
    std::size_t in_contact = 0;
    for (const SolidPair& pair : pairs) {
      const Shape& a = shapes_[pair.a];
      const Shape& b = shapes_[pair.b];
      if (method_ == Method::box_and_convex && a.is_box && b.is_box)
        check_boxes(a, b, transforms_[pair.a], transforms_[pair.b], solvers_);
      else
        check_convex(a, b, transforms_[pair.a], transforms_[pair.b], max_distance, solvers_);
      bool touching = false;
      for (const EngineContact& contact : solvers_.collector.contacts())
        touching = touching || contact.distance <= 0;
      in_contact += touching ? 1 : 0;
    }
    return in_contact;
  }

 private:
  Method method_;
  std::vector<Shape> shapes_;
  std::vector<btTransform> transforms_;
  Solvers solvers_;
};

}  // namespace

std::unique_ptr<RawCheck> make_raw_check(Method method) { return std::make_unique<BulletRawCheck>(method); }

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE

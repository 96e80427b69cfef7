#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "touchstone/adapters/bullet/backends.hpp"
#include "touchstone/adapters/bullet/checks.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/narrowphase/validate.hpp"

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {
namespace {

struct BulletWorkspace final : Narrowphase::Workspace {
  Solvers solvers;
};

double largest_coordinate(const Shape& shape, const Pose& X) { return norm_inf(X.p) + shape.reach; }

// The engine squares differences of positions.
constexpr double kLargestCoordinate = kDouble ? 1e150 : 1e18;

bool is_finite(const EngineContact& contact) {
  return std::isfinite(contact.distance) && touchstone::is_finite(from_engine(contact.normal_on_B)) &&
         touchstone::is_finite(from_engine(contact.point_on_B));
}

// The engine's own signs: ours is the opposite normal; the point on A lies `distance` along the engine's
// normal.
ContactPoint to_contact_point(const EngineContact& contact) {
  const double separation = contact.distance;
  const Vector3 p_B_W = from_engine(contact.point_on_B);
  return {p_B_W + separation * from_engine(contact.normal_on_B), p_B_W, separation, 0};
}

const EngineContact& deepest_of(std::span<const EngineContact> contacts) {
  return *std::min_element(
      contacts.begin(), contacts.end(),
      [](const EngineContact& x, const EngineContact& y) { return x.distance < y.distance; });
}

/// Those within the limit, deepest first, ties in the engine's order; as many as fit.
std::int32_t write_points(std::span<const EngineContact> contacts, double limit,
                          std::span<ContactPoint> points) {
  std::size_t count = 0;
  for (const EngineContact& contact : contacts) {
    const ContactPoint point = to_contact_point(contact);
    if (point.separation > limit) continue;
    std::size_t at = count;
    while (at > 0 && point.separation < points[at - 1].separation) --at;
    if (at == points.size()) continue;
    count = std::min(count + 1, points.size());
    std::move_backward(points.begin() + at, points.begin() + count - 1, points.begin() + count);
    points[at] = point;
  }
  return static_cast<std::int32_t>(count);
}

class BulletNarrowphase final : public Narrowphase {
 public:
  BulletNarrowphase(std::string name, Method method) : name_(std::move(name)), method_(method) {
    capabilities_.distance = method == Method::gjk;
    capabilities_.penetration = true;
    capabilities_.manifold = true;
    capabilities_.scalar_bits = 8 * sizeof(btScalar);
    const CheckResolution convex = convex_resolution();
    capabilities_.resolution = {convex.absolute, convex.of_size + convex.of_place, 0.0};
    capabilities_.resolution.of_depth = std::max(kBoxDepthOverestimate, kConvexDepthOverestimate);
    if (method == Method::gjk) return;
    const CheckResolution box = box_resolution();
    capabilities_.resolution.relative =
        std::max(capabilities_.resolution.relative, box.of_size + box.of_place);
  }

  std::string_view name() const noexcept override { return name_; }
  const Capabilities& capabilities() const noexcept override { return capabilities_; }

  void build(std::span<const Hexahedron> solids) override {
    std::vector<Shape> shapes = make_shapes(solids);
    double largest_size = 0.0;
    for (const Shape& shape : shapes) largest_size = std::max(largest_size, shape.size);
    shapes_ = std::move(shapes);
    capabilities_.resolution.absolute = resolution_at_size(convex_resolution(), largest_size);
    capabilities_.resolution.relative = convex_resolution().of_place;
    if (method_ == Method::gjk) return;
    capabilities_.resolution.absolute =
        std::max(capabilities_.resolution.absolute, resolution_at_size(box_resolution(), largest_size));
    capabilities_.resolution.relative =
        std::max(capabilities_.resolution.relative, box_resolution().of_place);
  }

  std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<BulletWorkspace>(); }

  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    assert(fits(input, output, shapes_.size()));
    Solvers& solvers = static_cast<BulletWorkspace&>(workspace).solvers;
    for (std::size_t i = 0; i < input.pairs.size(); ++i) {
      PairGeometry unused;
      output.status[i] = evaluate_pair(input.pairs[i], input.poses, input.query, solvers,
                                       output.geometry.empty() ? unused : output.geometry[i],
                                       output.points_of(i, input.query));
    }
  }

 private:
  static double resolution_at_size(const CheckResolution& resolution, double size) {
    return resolution.absolute + resolution.of_size * size;
  }

  static double pair_resolution(const CheckResolution& resolution, const Shape& a, const Shape& b,
                                const Pose& X_WA, const Pose& X_WB) {
    const double size = std::max(a.size, b.size);
    const double place = std::max({largest_coordinate(a, X_WA), largest_coordinate(b, X_WB), size});
    return resolution_at_size(resolution, size) + resolution.of_place * place;
  }

  PairStatus evaluate_pair(SolidPair pair, std::span<const Pose> poses, const Query& query, Solvers& solvers,
                           PairGeometry& geometry, std::span<ContactPoint> points) const noexcept {
    const Shape& a = shapes_[pair.a];
    const Shape& b = shapes_[pair.b];
    const btTransform X_WA = to_engine(poses[pair.a]);
    const btTransform X_WB = to_engine(poses[pair.b]);
    geometry = no_geometry();
    if (!has_finite_poses(pair, poses) || largest_coordinate(a, poses[pair.a]) > kLargestCoordinate ||
        largest_coordinate(b, poses[pair.b]) > kLargestCoordinate)
      return PairStatus::failed;

    // The engine's answer, asked as far as the query and the resolution look.
    const bool boxes = method_ == Method::box_and_convex && a.is_box && b.is_box;
    const double resolution =
        pair_resolution(boxes ? box_resolution() : convex_resolution(), a, b, poses[pair.a], poses[pair.b]);
    const double looked_at =
        query.kind == QueryKind::overlap ? resolution : std::max(query.max_separation, resolution);
    const EngineAnswer answer =
        boxes ? check_boxes(a, b, X_WA, X_WB, solvers) : check_convex(a, b, X_WA, X_WB, looked_at, solvers);
    if (answer == EngineAnswer::none) return PairStatus::failed;
    if (answer == EngineAnswer::apart) return apart(boxes, query, geometry);

    const std::span<const EngineContact> contacts = solvers.collector.contacts();
    for (const EngineContact& contact : contacts)
      if (!is_finite(contact)) return PairStatus::failed;
    // The deepest contact decides, and is the witness.
    const EngineContact& deepest = deepest_of(contacts);
    const double separation = deepest.distance;
    const bool is_near = std::abs(separation) < resolution;
    if (!is_near && separation > query.max_separation) {
      geometry = no_geometry(kInfinity);
      return PairStatus::separated;
    }
    if (query.kind != QueryKind::overlap) {
      const ContactPoint witness = to_contact_point(deepest);
      geometry = {separation, -from_engine(deepest.normal_on_B), witness.p_A_W, witness.p_B_W, 0};
      if (query.kind == QueryKind::manifold)
        geometry.point_count = write_points(contacts, point_limit(query, separation), points);
    }
    if (is_near) return PairStatus::undecided;
    return separation > 0.0 ? PairStatus::separated : PairStatus::overlapping;
  }

  /// Nothing reported. GJK was asked up to max_separation, so that much is known; the box detector knows only
  /// "apart".
  static PairStatus apart(bool boxes, const Query& query, PairGeometry& geometry) {
    if (query.kind == QueryKind::overlap) return PairStatus::separated;
    if (!boxes || query.max_separation <= 0.0) {
      geometry = no_geometry(kInfinity);
      return PairStatus::separated;
    }
    return query.kind == QueryKind::distance ? PairStatus::unsupported : PairStatus::separated;
  }

  std::string name_;
  Method method_;
  Capabilities capabilities_;
  std::vector<Shape> shapes_;
};

}  // namespace

std::unique_ptr<Narrowphase> make_narrowphase(std::string name, Method method) {
  return std::make_unique<BulletNarrowphase>(std::move(name), method);
}

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE

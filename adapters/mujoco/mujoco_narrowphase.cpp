#include "touchstone/adapters/mujoco/mujoco_narrowphase.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "touchstone/adapters/mujoco/solid_geoms.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/narrowphase/points_within.hpp"
#include "touchstone/contact_core/narrowphase/validate.hpp"

namespace touchstone::mujoco {
namespace {

/// mjOption.mpr_tolerance, by default.
constexpr double kMprTolerance = 1e-6;
/// Of poses, sizes and what is computed from them: doubles.
constexpr double kRelative = 16 * std::numeric_limits<double>::epsilon();
/// Products of four coordinates are taken; beyond this, and for what is not finite, no answer is trusted.
constexpr double kLargestCoordinate = 1e75;

using Contacts = std::array<EngineContact, mjMAXCONPAIR>;

struct MujocoWorkspace final : Narrowphase::Workspace {
  /// Nothing is done for those that it was made for already.
  void follow(const std::shared_ptr<const SolidGeoms>& now) {
    if (geoms == now) return;
    geoms = now;
    data = now->make_data();
  }

  std::shared_ptr<const SolidGeoms> geoms;
  DataHandle data;
  Contacts contacts;
};

Vector3 engine_normal(const EngineContact& contact) {
  const auto& n_12_W = normal_of(contact);
  return {n_12_W[0], n_12_W[1], n_12_W[2]};
}

bool is_usable(const EngineContact& contact) {
  const Vector3 n = engine_normal(contact);
  return std::isfinite(contact.dist) && std::isfinite(contact.pos[0]) && std::isfinite(contact.pos[1]) &&
         std::isfinite(contact.pos[2]) && is_finite(n) && norm(n) > 0.5;  // a unit vector, or zero
}

/// MuJoCo's normal points from its geom 1 to its geom 2, its `pos` is half-way.
Vector3 normal_AB(const EngineContact& contact, bool is_swapped) {
  const Vector3 n_12_W = engine_normal(contact);
  return is_swapped ? Vector3(-n_12_W) : n_12_W;
}
ContactPoint to_contact_point(const EngineContact& contact, const Vector3& n_AB_W) {
  const Vector3 middle(contact.pos[0], contact.pos[1], contact.pos[2]);
  const Vector3 half = 0.5 * contact.dist * n_AB_W;
  return {middle - half, middle + half, contact.dist, 0};
}

class MujocoNarrowphase final : public Narrowphase {
 public:
  MujocoNarrowphase() : geoms_(std::make_shared<const SolidGeoms>(std::span<const Hexahedron>{})) {
    capabilities_.penetration = capabilities_.manifold = true;
    capabilities_.overlap_complete = false;  // pairs that just touch are missed
    capabilities_.resolution = {kMprTolerance, kRelative, kInfinity};
  }

  std::string_view name() const noexcept override { return "mujoco"; }
  const Capabilities& capabilities() const noexcept override { return capabilities_; }

  void build(std::span<const Hexahedron> solids) override {
    geoms_ = std::make_shared<const SolidGeoms>(solids);
    capabilities_.resolution.absolute = geoms_->has_meshes() ? kMprTolerance + 2.0 * geoms_->rounding() : 0.0;
  }
  std::unique_ptr<Workspace> make_workspace() const override {
    auto workspace = std::make_unique<MujocoWorkspace>();
    workspace->follow(geoms_);
    return workspace;
  }

  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    assert(fits(input, output, geoms_->solid_count()));
    auto& scratch = static_cast<MujocoWorkspace&>(workspace);
    scratch.follow(geoms_);
    for (std::size_t i = 0; i < input.pairs.size(); ++i) {
      PairGeometry unused;
      PairGeometry& geometry = output.geometry.empty() ? unused : output.geometry[i];
      geometry = no_geometry();
      output.status[i] = evaluate_pair(input.pairs[i], input.poses, input.query, scratch, geometry,
                                       output.points_of(i, input.query));
    }
  }

 private:
  PairStatus evaluate_pair(SolidPair pair, std::span<const Pose> poses, const Query& query,
                           MujocoWorkspace& scratch, PairGeometry& geometry,
                           std::span<ContactPoint> points) const {
    if (!geoms_->has(pair.a) || !geoms_->has(pair.b)) return PairStatus::unsupported;
    const Pose &X_WA = poses[pair.a], &X_WB = poses[pair.b];
    const double scale = std::max(std::max(geoms_->reach(pair.a), geoms_->reach(pair.b)),
                                  std::max(norm_inf(X_WA.p), norm_inf(X_WB.p)));
    if (!(scale <= kLargestCoordinate) || !has_finite_poses(pair, poses)) return PairStatus::failed;
    geoms_->place(pair.a, X_WA, *scratch.data);
    geoms_->place(pair.b, X_WB, *scratch.data);
    const auto [count, is_swapped] = geoms_->collide(pair, *scratch.data, scratch.contacts);
    const std::span found(scratch.contacts.data(), static_cast<std::size_t>(count));
    const bool in_contact = std::any_of(found.begin(), found.end(),
                                        [](const EngineContact& contact) { return contact.dist <= 0.0; });
    if (query.kind == QueryKind::overlap) return in_contact ? PairStatus::overlapping : PairStatus::separated;
    if (in_contact) return report(found, is_swapped, scale, query, geometry, points);
    if (query.max_separation > 0.0) return PairStatus::unsupported;
    geometry = no_geometry(kInfinity);
    return PairStatus::separated;
  }

  /// Deepest first, ties in MuJoCo's order; as many as fit.
  PairStatus report(std::span<const EngineContact> found, bool is_swapped, double scale, const Query& query,
                    PairGeometry& geometry, std::span<ContactPoint> points) const {
    if (!std::all_of(found.begin(), found.end(), &is_usable)) return PairStatus::failed;
    std::array<std::size_t, mjMAXCONPAIR> order;
    std::iota(order.begin(), order.begin() + found.size(), std::size_t{0});
    std::sort(order.begin(), order.begin() + found.size(), [&](std::size_t i, std::size_t k) {
      return std::pair(found[i].dist, i) < std::pair(found[k].dist, k);
    });
    const Vector3 n_AB_W = normal_AB(found[order[0]], is_swapped);
    const ContactPoint deepest = to_contact_point(found[order[0]], n_AB_W);
    geometry = {deepest.separation, n_AB_W, deepest.p_A_W, deepest.p_B_W, 0};
    const std::size_t count = std::min(points.size(), found.size());
    for (std::size_t k = 0; k < count; ++k) points[k] = to_contact_point(found[order[k]], n_AB_W);
    geometry.point_count = keep_within(points.first(count), point_limit(query, deepest.separation));
    return -deepest.separation < capabilities_.resolution.at(scale) ? PairStatus::undecided
                                                                    : PairStatus::overlapping;
  }

  Capabilities capabilities_;
  std::shared_ptr<const SolidGeoms> geoms_;
};

class MujocoRawCheck final : public RawCheck {
 public:
  void build(std::span<const Hexahedron> solids) override {
    geoms_ = std::make_unique<SolidGeoms>(solids);
    data_ = geoms_->make_data();
  }
  bool supports(QueryKind kind) const noexcept override { return kind != QueryKind::distance; }
  void set_poses(std::span<const Pose> poses) override {
    for (SolidIndex i = 0; i < poses.size(); ++i)
      if (geoms_->has(i)) geoms_->place(i, poses[i], *data_);
  }
  std::size_t run(std::span<const SolidPair> pairs, QueryKind) noexcept override {
    std::size_t in_contact = 0;
    for (const SolidPair& pair : pairs)
      if (geoms_->has(pair.a) && geoms_->has(pair.b))
        in_contact += geoms_->collide(pair, *data_, contacts_).count > 0;
    return in_contact;
  }

 private:
  std::unique_ptr<const SolidGeoms> geoms_;
  DataHandle data_;
  Contacts contacts_;
};

}  // namespace

std::unique_ptr<Narrowphase> make_narrowphase() { return std::make_unique<MujocoNarrowphase>(); }
std::unique_ptr<RawCheck> make_raw_check() { return std::make_unique<MujocoRawCheck>(); }

}  // namespace touchstone::mujoco

#include "touchstone/adapters/fcl/fcl_narrowphase.hpp"

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>
#include <cassert>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "touchstone/adapters/fcl/shapes.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/geometry/reach.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/narrowphase/points_within.hpp"
#include "touchstone/contact_core/narrowphase/validate.hpp"

namespace touchstone::fcl_adapter {
namespace {

/// Of FCL's requests, by default.
constexpr double kTolerance = 1e-6;

fcl::GJKSolverType gjk_of(Solver solver) {
  return solver == Solver::libccd ? fcl::GST_LIBCCD : fcl::GST_INDEP;
}

struct FclWorkspace final : Narrowphase::Workspace {
  fcl::CollisionResultd collision;
  std::vector<fcl::Contactd> contacts;
};

struct PosedPair {
  const fcl::CollisionGeometryd &a, &b;
  fcl::Transform3d X_WA, X_WB;
};

/// The engine's calls. They may throw.
class Engine {
 public:
  explicit Engine(Solver solver) : solver_(solver) {}

  bool supports(QueryKind kind) const { return kind != QueryKind::manifold || solver_ == Solver::libccd; }

  bool overlap(const PosedPair& pair, fcl::CollisionResultd& result) const {
    const fcl::CollisionRequestd request(1, false, 1, false, true, gjk_of(solver_));
    return collide(pair, request, result);
  }
  /// Deepest first.
  bool contacts(const PosedPair& pair, FclWorkspace& workspace) const {
    const fcl::CollisionRequestd request(kMaxManifoldPoints, true, 1, false, true, gjk_of(solver_));
    workspace.contacts.clear();
    if (!collide(pair, request, workspace.collision)) return false;
    workspace.collision.getContacts(workspace.contacts);
    std::stable_sort(workspace.contacts.begin(), workspace.contacts.end(),
                     [](const auto& p, const auto& q) { return p.penetration_depth > q.penetration_depth; });
    return true;
  }
  /// Below 0 for pairs that are not apart, whatever their depth.
  double distance(const PosedPair& pair, Vector3& p_A_W, Vector3& p_B_W) const {
    const fcl::DistanceRequestd request(true, false, 0.0, 0.0, kTolerance, gjk_of(solver_));
    fcl::DistanceResultd result;
    fcl::distance(&pair.a, pair.X_WA, &pair.b, pair.X_WB, request, result);
    p_A_W = result.nearest_points[0], p_B_W = result.nearest_points[1];
    return result.min_distance;
  }

 private:
  static bool collide(const PosedPair& pair, const fcl::CollisionRequestd& request,
                      fcl::CollisionResultd& result) {
    result.clear();
    fcl::collide(&pair.a, pair.X_WA, &pair.b, pair.X_WB, request, result);
    return result.isCollision();
  }

  Solver solver_;
};

/// Products of four coordinates are taken; where they overflow, an assertion of the engine's ends the
/// process.
constexpr double kLargestCoordinate = 1e75;

/// @param reach of the solid: reach_of()
bool may_be_asked(double reach, const Pose& X) {
  return std::max(reach, norm_inf(X.p)) <= kLargestCoordinate && is_finite(X);
}

ContactPoint to_contact_point(const fcl::Contactd& contact) {
  const Vector3 half = 0.5 * contact.penetration_depth * contact.normal;
  return {contact.pos + half, contact.pos - half, -contact.penetration_depth, 0};
}

bool is_usable(const fcl::Contactd& contact) {
  return std::isfinite(contact.penetration_depth) && is_finite(contact.pos) && is_finite(contact.normal) &&
         norm(contact.normal) > 0.5;  // a unit vector, or zero
}

struct Entry {
  Shape shape;
  double reach;
};

std::vector<Entry> make_entries(std::span<const Hexahedron> solids) {
  refuse_rounded(solids, "fcl");
  std::vector<Entry> entries;
  entries.reserve(solids.size());
  for (const Hexahedron& solid : solids) entries.push_back({make_shape(solid), reach_of(solid)});
  return entries;
}

class FclNarrowphase final : public Narrowphase {
 public:
  explicit FclNarrowphase(Solver solver) : solver_(solver), engine_(solver) {
    capabilities_.distance = true;
    capabilities_.penetration = capabilities_.manifold = solver == Solver::libccd;
    capabilities_.overlap_complete = false;  // pairs that just touch are missed
    // Twice the largest errors of distances that were measured; of depths nothing is claimed.
    capabilities_.resolution = {kTolerance, solver == Solver::libccd ? 8e-4 : 1.6e-2, kInfinity};
  }

  std::string_view name() const noexcept override { return solver_ == Solver::libccd ? "fcl" : "fcl_indep"; }
  const Capabilities& capabilities() const noexcept override { return capabilities_; }

  void build(std::span<const Hexahedron> solids) override { entries_ = make_entries(solids); }
  std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<FclWorkspace>(); }

  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    assert(fits(input, output, entries_.size()));
    auto& scratch = static_cast<FclWorkspace&>(workspace);
    for (std::size_t i = 0; i < input.pairs.size(); ++i) {
      PairGeometry unused;
      PairGeometry& geometry = output.geometry.empty() ? unused : output.geometry[i];
      geometry = no_geometry();
      try {
        output.status[i] = evaluate_pair(input.pairs[i], input.poses, input.query, scratch, geometry,
                                         output.points_of(i, input.query));
      } catch (const std::exception&) {
        geometry = no_geometry();
        output.status[i] = PairStatus::failed;
      }
    }
  }

 private:
  PairStatus evaluate_pair(SolidPair pair, std::span<const Pose> poses, const Query& query,
                           FclWorkspace& scratch, PairGeometry& geometry,
                           std::span<ContactPoint> points) const {
    const Entry &a = entries_[pair.a], &b = entries_[pair.b];
    const Pose &X_WA = poses[pair.a], &X_WB = poses[pair.b];
    const double scale = std::max(std::max(a.reach, b.reach), std::max(norm_inf(X_WA.p), norm_inf(X_WB.p)));
    if (!may_be_asked(a.reach, X_WA) || !may_be_asked(b.reach, X_WB)) return PairStatus::failed;
    const PosedPair posed{*a.shape, *b.shape, to_engine(X_WA), to_engine(X_WB)};
    if (!engine_.supports(query.kind)) return PairStatus::unsupported;
    if (query.kind == QueryKind::overlap)
      return engine_.overlap(posed, scratch.collision) ? PairStatus::overlapping : PairStatus::separated;
    const double near = kTolerance * (1.0 + scale);
    Vector3 p_A_W, p_B_W;
    const double apart = engine_.distance(posed, p_A_W, p_B_W);
    if (!(apart > 0.0) && solver_ == Solver::indep) return PairStatus::unsupported;
    if (!(apart > 0.0)) return report_contacts(posed, near, query, scratch, geometry, points);
    if (apart > query.max_separation && apart >= near) {
      geometry = no_geometry(kInfinity);
      return PairStatus::separated;
    }
    return report_points(apart, p_A_W, p_B_W, near, geometry, points);
  }

  /// The two nearest points of a pair that is apart.
  static PairStatus report_points(double separation, const Vector3& p_A_W, const Vector3& p_B_W, double near,
                                  PairGeometry& geometry, std::span<ContactPoint> points) {
    const Vector3 offset = p_B_W - p_A_W;
    const double length = norm(offset);
    if (!(length > 0.0) || !std::isfinite(length) || !std::isfinite(separation)) return PairStatus::failed;
    geometry = {separation, offset / length, p_A_W, p_B_W, 0};
    if (!points.empty()) {
      points[0] = {p_A_W, p_B_W, separation, 0};
      geometry.point_count = 1;
    }
    return separation < near ? PairStatus::undecided : PairStatus::separated;
  }

  PairStatus report_contacts(const PosedPair& posed, double near, const Query& query, FclWorkspace& scratch,
                             PairGeometry& geometry, std::span<ContactPoint> points) const {
    if (!engine_.contacts(posed, scratch)) return PairStatus::failed;  // neither apart nor in contact
    if (!std::all_of(scratch.contacts.begin(), scratch.contacts.end(), &is_usable)) return PairStatus::failed;
    const ContactPoint deepest = to_contact_point(scratch.contacts[0]);
    geometry = {deepest.separation, scratch.contacts[0].normal, deepest.p_A_W, deepest.p_B_W, 0};
    const std::size_t count = std::min(points.size(), scratch.contacts.size());
    for (std::size_t k = 0; k < count; ++k) points[k] = to_contact_point(scratch.contacts[k]);
    geometry.point_count = keep_within(points.first(count), point_limit(query, deepest.separation));
    return -deepest.separation < near ? PairStatus::undecided : PairStatus::overlapping;
  }

  Solver solver_;
  Engine engine_;
  Capabilities capabilities_;
  std::vector<Entry> entries_;
};

class FclRawCheck final : public RawCheck {
 public:
  explicit FclRawCheck(Solver solver) : engine_(solver) {}

  void build(std::span<const Hexahedron> solids) override { solids_ = make_entries(solids); }
  bool supports(QueryKind kind) const noexcept override { return engine_.supports(kind); }
  // One pose a solid, in build()'s order.
  void set_poses(std::span<const Pose> poses) override {
    poses_.clear();
    for (std::size_t i = 0; i < solids_.size(); ++i)
      poses_.push_back({to_engine(poses[i]), may_be_asked(solids_[i].reach, poses[i])});
  }
  std::size_t run(std::span<const SolidPair> pairs, QueryKind kind) noexcept override {
    std::size_t in_contact = 0;
    for (const auto [a, b] : pairs) {
      if (!poses_[a].may_be_asked || !poses_[b].may_be_asked) continue;
      try {
        const PosedPair posed{*solids_[a].shape, *solids_[b].shape, poses_[a].X_WS, poses_[b].X_WS};
        Vector3 p_A_W, p_B_W;
        in_contact += kind == QueryKind::overlap    ? engine_.overlap(posed, scratch_.collision)
                      : kind == QueryKind::distance ? engine_.distance(posed, p_A_W, p_B_W) <= 0.0
                                                    : engine_.contacts(posed, scratch_);
      } catch (const std::exception&) {  // it has said nothing
      }
    }
    return in_contact;
  }

 private:
  struct Placed {
    fcl::Transform3d X_WS;
    bool may_be_asked;
  };

  Engine engine_;
  FclWorkspace scratch_;
  std::vector<Entry> solids_;
  std::vector<Placed> poses_;
};

}  // namespace

std::unique_ptr<Narrowphase> make_narrowphase(Solver solver) {
  return std::make_unique<FclNarrowphase>(solver);
}
std::unique_ptr<RawCheck> make_raw_check(Solver solver) { return std::make_unique<FclRawCheck>(solver); }

}  // namespace touchstone::fcl_adapter

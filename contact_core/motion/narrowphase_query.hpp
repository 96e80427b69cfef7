#pragma once

#include <memory>
#include <span>
#include <vector>

#include "contact_core/motion/impact.hpp"

namespace touchstone {

/// Trial poses for a narrowphase that was built over many solids: only the pair in question is placed,
/// nothing of it is kept. One a thread.
class NarrowphaseQuery final : public SeparationQuery {
 public:
  /// Keeps a reference. @param solids as many as `narrowphase` was built with.
  NarrowphaseQuery(const Narrowphase& narrowphase, std::size_t solids)
      : narrowphase_(&narrowphase), workspace_(narrowphase.make_workspace()), poses_(solids) {}

  /// The pair that the next calls ask about, a < b.
  void set_pair(const SolidPair& pair) { pair_ = pair; }

  PairStatus separation(const Pose& X_WA, const Pose& X_WB, PairGeometry& out) noexcept override {
    poses_[pair_.a] = X_WA;
    poses_[pair_.b] = X_WB;
    PairStatus status = PairStatus::failed;
    Query query;
    query.kind = QueryKind::distance;
    narrowphase_->evaluate({{&pair_, 1}, poses_, query}, {{&status, 1}, {&out, 1}, {}}, *workspace_);
    ++calls_;
    return status;
  }

  /// The pair's contact points too, where the narrowphase has them; else the witness points as one.
  /// @param max_separation pairs further apart get a separation of +inf and no points [m].
  PairStatus manifold(const Pose& X_WA, const Pose& X_WB, double max_separation, PairGeometry& out,
                      std::span<ContactPoint, kMaxManifoldPoints> points) noexcept {
    poses_[pair_.a] = X_WA;
    poses_[pair_.b] = X_WB;
    PairStatus status = PairStatus::failed;
    const bool has_points = narrowphase_->capabilities().manifold;
    Query query;
    query.kind = has_points ? QueryKind::manifold : QueryKind::distance;
    query.max_separation = max_separation;
    narrowphase_->evaluate({{&pair_, 1}, poses_, query}, {{&status, 1}, {&out, 1}, points}, *workspace_);
    ++calls_;
    if (!has_points) {
      out.point_count = out.separation <= max_separation ? 1 : 0;
      points[0] = {out.p_A_W, out.p_B_W, out.separation, 0};
    }
    return status;
  }

  std::uint64_t calls() const { return calls_; }

 private:
  const Narrowphase* narrowphase_;
  std::unique_ptr<Narrowphase::Workspace> workspace_;
  std::vector<Pose> poses_;
  SolidPair pair_{0, 1};
  std::uint64_t calls_ = 0;
};

}  // namespace touchstone

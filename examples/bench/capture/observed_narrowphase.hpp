#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "touchstone/contact_core/narrowphase/pair_observer.hpp"

namespace touchstone {

/// A narrowphase that tells an observer the pairs it was asked about, once each was answered; answers are the
/// inner one's. Pairs with a rounded solid or a pose that is not finite are not reported. Allocates as the
/// observer does.
class ObservedNarrowphase final : public Narrowphase {
 public:
  /// @param observer outlives it.
  ObservedNarrowphase(std::unique_ptr<Narrowphase> inner, PairObserver& observer)
      : inner_(std::move(inner)), observer_(observer) {}

  std::string_view name() const noexcept override { return inner_->name(); }
  const Capabilities& capabilities() const noexcept override { return inner_->capabilities(); }
  void build(std::span<const Hexahedron> solids) override {
    inner_->build(solids);
    solids_.assign(solids.begin(), solids.end());
  }
  bool set_solids(SolidIndex first, std::span<const Hexahedron> solids) override {
    if (!inner_->set_solids(first, solids)) return false;
    for (std::size_t i = 0; i < solids.size(); ++i) {
      if (first + i < solids_.size())
        solids_[first + i] = solids[i];
      else
        solids_.push_back(solids[i]);
    }
    return true;
  }
  std::unique_ptr<Workspace> make_workspace() const override { return inner_->make_workspace(); }
  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    inner_->evaluate(input, output, workspace);
    for (std::size_t i = 0; i < input.pairs.size(); ++i) {
      const SolidPair pair = input.pairs[i];
      if (!is_told(pair.a, input.poses) || !is_told(pair.b, input.poses)) continue;
      observer_.observe({{&solids_[pair.a], &solids_[pair.b]},
                         {input.poses[pair.a], input.poses[pair.b]},
                         PairStatus::separated,  // the answer is not kept
                         {},
                         {},
                         inner_->name()});
    }
  }

 private:
  bool is_told(SolidIndex solid, std::span<const Pose> poses) const noexcept {
    return solids_[solid].radius() == 0.0 && is_finite(poses[solid]);
  }

  std::unique_ptr<Narrowphase> inner_;
  PairObserver& observer_;
  std::vector<Hexahedron> solids_;
};

}  // namespace touchstone

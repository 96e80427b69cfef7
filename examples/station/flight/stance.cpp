#include "touchstone/examples/station/flight/stance.hpp"

#include <cmath>

namespace touchstone::station {

using training::Arm;
using training::kNone;

Stance::Stance(const StationScene& scene) : scene_(&scene) {
  if (scene.holds.empty()) return;
  held_by_.assign(scene.tips.size(), kNone);
  for (const HoldOption& option : scene.holds)
    if (option.at_start) held_by_[base_ = option.tip] = option.fixture;
}

std::uint32_t Stance::flown(std::uint32_t chosen) const {
  if (!walks() || is_locked()) return chosen;
  return is_held(0) ? 1 : 0;
}

std::uint32_t Stance::within_reach(std::uint32_t tip, std::span<const Pose> X_WO) const noexcept {
  const Pose X_WT = compose(X_WO[scene_->tips[tip].object], scene_->tips[tip].X_HT);
  std::uint32_t nearest = kNone;
  double least = kReach;
  for (const HoldOption& option : scene_->holds) {
    if (option.tip != tip || option.fixture == fixture_of(1 - tip)) continue;
    const Pose& X_WF = X_WO[option.fixture];
    const double away = norm(X_WT.p - X_WF.p);
    if (!is_over(X_WT, X_WF) || away > least) continue;
    least = away;
    nearest = option.fixture;
  }
  return nearest;
}

bool Stance::is_over(const Pose& X_WT, const Pose& X_WF) noexcept {
  // The mouth looks down on the plate: its axis is opposite to the probe's.
  const bool is_aligned = -dot(X_WT.R.col(0), X_WF.R.col(2)) >= std::cos(kTurn);
  return is_aligned && norm(X_WT.p - X_WF.p) <= kReach;
}

std::unique_ptr<const Arm> Stance::stand_without(std::uint32_t tip, std::span<const Pose> X_WO,
                                                 std::span<const double> joints) const {
  if (tip != base_) return nullptr;
  const std::uint32_t other = 1 - tip;
  const Tip& stands_on = scene_->tips[other];
  const Arm& now = *arm();
  return std::make_unique<const Arm>(held_by(now, now.link_of_object[stands_on.object - now.first_object],
                                             X_WO[stands_on.object], scene_->tips[tip].link, joints));
}

void Stance::let_go(std::uint32_t tip, std::unique_ptr<const Arm> walked) {
  held_by_[tip] = kNone;
  if (!walked) return;
  base_ = 1 - tip;
  walked_ = std::move(walked);
}

}  // namespace touchstone::station

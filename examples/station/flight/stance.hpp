#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "touchstone/examples/station/flight/station_scene.hpp"

namespace touchstone::station {

/// Where a method's arm stands: which of its ends are held, by what, and which of them is its base. An arm of
/// a scene without holds stands on its base for ever.
class Stance {
 public:
  /// Keeps a reference.
  explicit Stance(const StationScene& scene);

  /// As its base holds it; null: a free object is flown.
  const training::Arm* arm() const { return walked_ ? walked_.get() : scene_->arm(); }
  bool walks() const { return !held_by_.empty(); }
  /// The fixture that holds a tip; training::kNone: it is free, or the arm does not walk.
  std::uint32_t fixture_of(std::uint32_t tip) const { return walks() ? held_by_[tip] : training::kNone; }
  bool is_held(std::uint32_t tip) const { return fixture_of(tip) != training::kNone; }
  /// Held by both ends: it cannot move.
  bool is_locked() const { return walks() && is_held(0) && is_held(1); }
  /// The tip that a hand flies which asks for `chosen`: the free one of an arm that walks.
  std::uint32_t flown(std::uint32_t chosen) const;

  /// The fixture that a free tip is over, nearest first; training::kNone: none is within reach.
  std::uint32_t within_reach(std::uint32_t tip, std::span<const Pose> X_WO) const noexcept;
  void hold(std::uint32_t tip, std::uint32_t fixture) { held_by_[tip] = fixture; }
  /// Lets go of a tip of a locked arm. Returns the arm as it stands from now on, on its other end where that
  /// is; null: the base stays. @param joints the arm's values.
  std::unique_ptr<const training::Arm> stand_without(std::uint32_t tip, std::span<const Pose> X_WO,
                                                     std::span<const double> joints) const;
  /// The result of stand_without(), or null.
  void let_go(std::uint32_t tip, std::unique_ptr<const training::Arm> walked);

  /// A fixture holds an end whose mouth's middle is this near to its own frame's origin [m], and whose axis
  /// this near to its probe's [rad]; assumed.
  static constexpr double kReach = 0.1, kTurn = 0.17453292519943295;
  /// @param X_WT of a tip. @param X_WF of a fixture.
  static bool is_over(const Pose& X_WT, const Pose& X_WF) noexcept;

 private:
  const StationScene* scene_;
  std::vector<std::uint32_t> held_by_;  // by tip; empty: no walk
  std::uint32_t base_ = training::kNone;
  std::unique_ptr<const training::Arm> walked_;  // null: as the scene has it
};

}  // namespace touchstone::station

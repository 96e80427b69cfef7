#pragma once

#include <memory>
#include <span>
#include <vector>

#include "touchstone/adapters/scene_files/script_file.hpp"
#include "touchstone/contact_core/mechanism/resolved_rate.hpp"
#include "touchstone/contact_core/motion/path.hpp"
#include "touchstone/examples/training_run/setting/setting.hpp"

namespace touchstone::training {

/// Where rates that are held for a frame lead from X_WO.
RigidPath flown(const Pose& X_WO, const HandRates& rates, double duration);

/// Figures of an arm's control over a flight; zeros for a free object.
struct HandFigures {
  bool is_arm = false;
  std::size_t limited_frames = 0;  ///< a joint's rate or position limit scaled the step
  std::size_t damped_frames = 0;   ///< near a singularity
  /// Between where the hand asked the flown link to be at a frame's end and where the commanded joint values
  /// put it [m], turns as lengths at 1 m; frames at a limit left out.
  double largest_residual = 0.0;
};

/// Turns what a hand controller asks of an arm's link into joint values at the frame's end: resolved rates
/// (ResolvedRate), repeated from where they lead until that gains nothing, so that the link is at a frame's
/// end where the hand asked it to be. Within the frame all joints go evenly, and the link strays from the
/// straight line.
class ArmHand {
 public:
  /// Keeps a reference.
  explicit ArmHand(const Arm& arm) : ArmHand(arm, arm.flown_link) {}
  /// Flies another link of it. @throws InputError: one that no joint moves but those held.
  ArmHand(const Arm& arm, std::uint32_t link);

  /// Where something else has moved the arm: goes on from there, and holds nothing of before. No allocation.
  void start_from(std::span<const double> q) noexcept;

  /// @param q the actual joint values. @param next where they are to go. No allocation.
  void command(std::span<const double> q, const HandRates& rates, double duration,
               std::span<double> next) noexcept;
  const HandFigures& figures() const { return figures_; }

 private:
  Pose pose_at(std::span<const double> q) noexcept;
  /// Motion that is impossible is not accumulated, except against a contact that the hand holds on to.
  void aim_from(std::span<const double> q, const HandRates& rates) noexcept;
  void resolve(std::span<const double> q, const HandRates& rates, double duration,
               std::span<double> next) noexcept;
  /// Shortens the step from q to what rates and positions of all joints allow. True: it was too long.
  bool limit(std::span<const double> q, double duration, std::span<double> next) const noexcept;

  const Arm* arm_;
  std::uint32_t link_;
  ResolvedRate control_;
  std::vector<double> commanded_, best_, rates_;
  std::vector<Pose> X_WL_;
  Pose target_;  // where the hand asks the link to be
  HandFigures figures_;
};

}  // namespace touchstone::training

#pragma once

#include <memory>
#include <vector>

#include "adapters/scene_files/script_file.hpp"
#include "contact_core/mechanism/resolved_rate.hpp"
#include "contact_core/motion/path.hpp"

namespace touchstone::training {

/// What an arm's control did over a flight; zeros for a free object.
struct HandFigures {
  bool is_arm = false;
  std::size_t limited_frames = 0;  ///< a joint's rate or position limit scaled the step
  std::size_t damped_frames = 0;   ///< near a singularity
  double largest_residual = 0.0;   ///< between an executed pose and the arm's [m], turns as ways on 1 m
};

/// Turns what a hand controller asks for into where its object is to go in a frame.
class Hand {
 public:
  virtual ~Hand() = default;
  /// @param X_WO the object's actual pose. @param duration of the frame [s]. No allocation.
  virtual RigidPath command(const Pose& X_WO, const HandRates& rates, double duration) noexcept = 0;
  /// After the frame: where the object was let go.
  virtual void follow(const Pose& X_WO, double duration) noexcept = 0;
  virtual HandFigures figures() const noexcept { return {}; }
};

/// The object itself is flown: rates times the frame's duration.
class FreeHand final : public Hand {
 public:
  RigidPath command(const Pose& X_WO, const HandRates& rates, double duration) noexcept override;
  void follow(const Pose&, double) noexcept override {}
};

/// An arm holds the object; joint rates are resolved so that it goes where the hand asks (ResolvedRate), the
/// arm's joints following what the world let it do. The object is flown on the straight way to where the arm
/// would hold it at the frame's end; the arm's own hexahedra are not in the scene.
class ArmHand final : public Hand {
 public:
  /// @throws InputError: an unknown model or link, joint values that do not fit, or out of limits.
  ArmHand(const ArmScript& script, const Pose& X_WO);

  RigidPath command(const Pose& X_WO, const HandRates& rates, double duration) noexcept override;
  void follow(const Pose& X_WO, double duration) noexcept override;
  HandFigures figures() const noexcept override { return figures_; }

  std::span<const double> joints() const { return q_; }
  /// Where the arm at these joint values holds the object.
  Pose held_pose(std::span<const double> q) noexcept;

 private:
  /// A step of the joints towards holding the object at X_WO; into next_.
  void step_towards(const Pose& X_WO, double duration) noexcept;

  Mechanism arm_;
  ResolvedRate control_;
  Pose X_LO_;
  Pose X_WB_;
  std::vector<double> q_, next_, rates_;
  std::vector<Pose> X_WL_;
  Pose target_;     // where the hand asks the object to be
  Pose commanded_;  // where next_ holds it
  HandFigures figures_;
};

std::unique_ptr<Hand> make_hand(const HandScript& script, const Pose& X_WO);

}  // namespace touchstone::training

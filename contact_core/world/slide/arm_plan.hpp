#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/world/slide/slider.hpp"

namespace touchstone {

/// The obstacles of an arm, requested as its plan proceeds: a plan changes the pairs that come near, and they
/// the plan.
class ArmObstacles {
 public:
  virtual ~ArmObstacles() = default;

  /// All that were taken up in this plan; the planner chooses their planes. NearPair::link is the arm's,
  /// other_link what that is seen from: the obstacle's link, or the base.
  virtual std::span<NearPair> near() = 0;
  /// Takes up what is not known to be apart where the arm stands, and forgets what was before.
  virtual void take_up_standing() = 0;
  /// Takes up what held the last sub-step. @returns whether there is any that was not near already.
  virtual bool take_up_held() = 0;
  /// Takes up what the path that the arm has laid could bring near. @returns as before.
  virtual bool take_up_on_path() = 0;
  /// The plan may look at no more.
  virtual bool is_over() const = 0;
};

/// An arm's motion in one sub-step of a slide: the path that it has laid.
struct ArmPlan {
  bool moves = false;
  bool is_near_end = false;                                       ///< see Slider
  std::uint64_t work = 0;                                         ///< adds to Slider::work
  int held_by = 0;                                                ///< rows that hold it back
  std::array<int, kMostSlideJoints> active{};                     ///< these, among its rows
  Vector3 force_W = Vector3::Zero(), moment_W = Vector3::Zero();  ///< HandFeel's, where a hand holds the arm

  std::span<const int> active_rows() const {
    return std::span(active).first(static_cast<std::size_t>(held_by));
  }
};

/// As plan_rigid_slide(), in joint values. Rows of what the plan could meet only: with the others it would be
/// the same. Once the slider's work is spent it ends with the plan that it has.
/// @param rows, joint_rows room; then the plan's.
ArmPlan plan_arm_slide(const Slider& slider, ArmObstacles& obstacles, std::vector<SlideRow>& rows,
                       std::vector<JointRow>& joint_rows);

/// Before the first sub-step: bounds on how far links come from their joints.
void begin_arm_slide(const Slider& slider);

}  // namespace touchstone

#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/motion/mass_metric.hpp"
#include "touchstone/contact_core/motion/slide_rows.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/contact_core/world/objects/mechanism_mover.hpp"

namespace touchstone {

/// A sub-step that brings no slider closer to its goal by this share of its distance at first is the last.
inline constexpr double kLeastGain = 0x1p-10;
/// Except for kMostPoorSteps sub-steps of a slide that has gained less than this share so far, and whose plan
/// does not end it (Slider::is_near_end). An arm's that gain at least half as much as the one before do not
/// count: gains that shrink no faster come to as much again.
inline constexpr double kHardlyBegun = 0x1p-6;
inline constexpr int kMostPoorSteps = 4;
/// A plan is executed where it gains at least this share of the initial distance.
inline constexpr double kWorthwhile = 0x1p-30;

/// One mover that goes on along what stopped it. Poses X_WR are its root's, as it stands.
struct Slider {
  std::uint32_t root;    ///< slot
  std::uint32_t leader;  ///< the slider that it goes along with, by root; its own root: none
  double stop;           ///< s at which its commanded path ended
  MechanismMover* arm;   ///< null: one rigid body
  Pose goal;             ///< of the root: the commanded pose; an arm's is its commanded joint values
  MassMoments moments;   ///< of all that moves with it, but for what is too far out, in the root's frame
  MassMetric metric;     ///< its centre is the tool's, and J is divided by the hand's least stiffness [m2]
  Matrix3 K_W = Matrix3::Identity();  ///< the hand's stiffness against translation, the least being 1
  bool is_even = true;                ///< K_W is the identity
  double stiffness = 1.0;             ///< the least [N/m]
  Vector3 force_W = Vector3::Zero(), moment_W = Vector3::Zero();  ///< HandFeel's
  double start_distance;  ///< to the goal, when the slide began [m]; an arm's in its joint weights' metric
  double distance;        ///< now [m]
  int poor_steps = 0;     ///< that gained less than kLeastGain, and less than half of the one before
  double last_gain = kInfinity;  ///< of an arm's last sub-step [m]
  double trust = 1.0;            ///< share of what is left that the next sub-step plans for
  bool pivots = false;           ///< it only advances: see pivot_path()
  bool done = false;
  bool shoves = false;       ///< it goes on along its commanded path, with what it met: see shove.hpp
  bool follows = false;      ///< goes along with its leader
  bool is_near_end = false;  ///< where the sub-step is gone to its end, another one would not gain
                             ///< kLeastGain, or of an arm little beside this one
  Twist remaining;           ///< what is left of the commanded path while it shoves
  Vector3 remaining_centre_O = Vector3::Zero();  ///< about which that turns
  bool is_cut_off = false;                       ///< the budget ended it
  bool goes_on = true;                           ///< another sub-step may gain enough
  std::uint64_t work = 0;                        ///< of this frame so far: see SlideBudget::mover_work
  std::uint64_t most_work = std::numeric_limits<std::uint64_t>::max();  ///< the budget's

  bool has_spent(std::uint64_t more = 0) const { return work + more > most_work; }

  /// No turn of a rigid body is longer than this for each metre of distance in the metric [rad/m].
  double turn_rate() const;
};

/// The sliders of a frame, by root.
struct Sliders {
  std::vector<Slider> list;             ///< ascending roots
  GrowingList<std::uint32_t> index_of;  ///< by slot: into list, or kNoIndex

  /// Null: the root does not slide.
  Slider* find(std::uint32_t root) { return index_of[root] == kNoIndex ? nullptr : &list[index_of[root]]; }
  const Slider* find(std::uint32_t root) const {
    return index_of[root] == kNoIndex ? nullptr : &list[index_of[root]];
  }
  /// The slider that the root goes along with: its leader, or itself.
  std::uint32_t leader_of(std::uint32_t root) const {
    return index_of[root] == kNoIndex ? root : list[index_of[root]].leader;
  }
  bool is_one_arm() const { return list.size() == 1 && list[0].arm != nullptr; }
};

/// The twist that leads a rigid slider from X_WR to its goal.
Twist twist_to_goal(const Slider& slider, const Pose& X_WR);
/// The metric of its twists at X_WR. J turns with the body: a turn about the axis of the remaining turn does
/// not change w . J w. K keeps the axes of the command.
TwistMetric metric_at(const Slider& slider, const Pose& X_WR);
double distance_to_goal(const Slider& slider, const Pose& X_WR);
/// The same of a rigid slider, or of an arm's joint values.
double distance_left(const Slider& slider, const Pose& X_WR);
JointVector joints_left(const MechanismMover& arm);

/// Gives a rigid slider its metric, in its root's frame: its hand's, or, with none, its moments'.
/// @pre goal and moments are set, moments.volume > 0.
void weigh_by_hand(Slider& slider, const std::optional<HandStiffness>& hand);

/// A slider's share of the room between it and another one, 0 to 1: by the speed of each if it went straight
/// to its goal. @param n_W from the other one to the slider. Arms share evenly.
double share_between(const Slider& slider, const Pose& X_WR, const Slider& other, const Pose& X_WR_other,
                     const NearPair& near);
/// Whether one of the pairs is with another slider, so that each of the two plans for a share of the room
/// only.
bool shares_room(std::span<const NearPair> near);

/// Whether a plan that left so much of the square of the distance for its bends leaves no more to gain than
/// kLeastGain: with the rows raised by less in the next sub-step, that is what it would come down by.
bool leaves_little(const Slider& slider, double left_over);

}  // namespace touchstone

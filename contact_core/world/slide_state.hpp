#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "touchstone/contact_core/motion/mass_metric.hpp"
#include "touchstone/contact_core/motion/slide_rows.hpp"
#include "touchstone/contact_core/world/frame_pairs.hpp"
#include "touchstone/contact_core/world/mechanism_mover.hpp"

namespace touchstone {

inline constexpr int kSlidePlaneRounds = 3;
/// A sub-step that brings no slider closer to its goal by this share of its distance at first is the last.
inline constexpr double kLeastGain = 0x1p-10;

/// One mover that goes on along what stopped it.
struct Slider {
  std::uint32_t root;   ///< slot
  double stop;          ///< s at which its commanded path ended
  MechanismMover* arm;  ///< null: one rigid body
  Pose goal;            ///< of the root: the commanded pose; an arm's is its commanded joint values
  MassMoments moments;  ///< of all that moves with it, but for what is too far out, in the root's frame
  MassMetric metric;    ///< its centre is the tool's, and J is divided by the hand's least stiffness [m2]
  Matrix3 K_W = Matrix3::Identity();  ///< the hand's stiffness against translation, the least being 1
  bool is_even = true;                ///< K_W is the identity
  double stiffness = 1.0;             ///< the least [N/m]
  Vector3 force_W = Vector3::Zero(), moment_W = Vector3::Zero();  ///< HandFeel's
  double start_distance;  ///< to the goal, when the slide began [m]; an arm's in its joint weights' metric
  double distance;        ///< now [m]
  double trust = 1.0;     ///< share of what is left that the next sub-step plans for
  bool pivots = false;    ///< it only advances: see world_pivot.cpp
  bool done = false;

  /// No turn of a rigid body is longer than this for each metre of distance in the metric [rad/m].
  double turn_rate() const { return 1.0 / std::sqrt(least_inertia(metric.J)); }
};

/// Whether a plan that left so much of the square of the distance for its bends leaves no more to gain than
/// kLeastGain: with the rows raised by less in the next sub-step, that is what it would come down by.
bool leaves_little(const Slider& slider, double left_over);

/// What a mover did in one part of a frame: the commanded path is part 0, each sub-step of slides another.
struct ExecutedPart {
  std::uint32_t root;
  std::uint32_t part;
  CarriedPath path;
  double stop;
  std::uint32_t joints;  ///< an arm's joint values at both ends: SlideState::joints from here on
};

/// What held an arm back in its last sub-step.
struct HeldPair {
  std::uint32_t root;
  std::uint32_t source;  ///< index into SlideState::pairs
};

/// An object's share in what moves as one.
struct CarriedMoments {
  std::uint32_t root;
  MassMoments moments;

  /// Of one root by values alone: sums round alike in whichever order the objects were registered.
  friend bool operator<(const CarriedMoments& a, const CarriedMoments& b) {
    if (a.root != b.root) return a.root < b.root;
    if (a.moments.volume != b.moments.volume) return a.moments.volume < b.moments.volume;
    for (int i = 0; i < 3; ++i)
      if (a.moments.first[i] != b.moments.first[i]) return a.moments.first[i] < b.moments.first[i];
    for (int i = 0; i < 9; ++i)
      if (a.moments.second(i / 3, i % 3) != b.moments.second(i / 3, i % 3))
        return a.moments.second(i / 3, i % 3) < b.moments.second(i / 3, i % 3);
    return false;
  }
};

/// Memory of the slides within one frame.
struct SlideState {
  static constexpr std::uint32_t kNone = 0xffffffff;

  struct Hand {
    ObjectHandle object;  // or it is of one that has gone
    std::optional<HandStiffness> hand;
  };
  std::optional<HandStiffness> default_hand = HandStiffness{};
  std::vector<Hand> hands;     // by slot
  std::vector<HandFeel> felt;  // what FrameReport shows
  SlideBudget budget;
  SlideMeter meter;
  std::vector<ObjectHandle> cut_off;  // what FrameReport shows

  std::vector<std::uint8_t> may_slide;                // by slot: what stopped it last lets it slide
  std::vector<std::uint8_t> may_pivot;                // by slot: or lets it advance
  std::vector<std::uint8_t> translation_only;         // by slot
  std::vector<std::uint8_t> translation_only_before;  // the same, as the part at hand began
  std::vector<MassMoments> moments;                   // by solid, in its object
  std::vector<CarriedMoments> carried;                // of the sliders' objects, sorted
  std::vector<Slider> sliders;
  std::vector<std::uint32_t> slider_of;  // by slot: index into sliders, or kNone
  std::vector<FramePair> pairs;          // those of the watched pairs that had to be looked at
  std::vector<std::uint32_t> met;        // watched pairs of which a slider is part, by index
  std::vector<std::uint32_t> pair_of;    // by watched pair: index into pairs, or kNone
  std::vector<std::uint8_t> is_near;     // by watched pair: in `near`, within one plan
  std::vector<std::pair<std::uint32_t, std::uint32_t>> by_root;  // (slider's slot, watched pair), sorted
  std::vector<HeldPair> held;                                    // by slider, in the order in which rows held
  std::vector<NearPair> near;
  std::vector<SlideRow> rows;
  std::vector<JointRow> joint_rows;  // of an arm: rows[i] in its joint values
  std::vector<ExecutedPart> parts;   // by part
  std::vector<double> joints;        // of the parts
  std::uint32_t part_count = 0;

  /// Null: the root does not slide.
  Slider* find(std::uint32_t root) { return slider_of[root] == kNone ? nullptr : &sliders[slider_of[root]]; }

  /// @param as_well another pair stopped the mover at the same s.
  void note_stop(std::uint32_t root, const EffectiveRule& rule, bool as_well) {
    const bool slides = rule.policy == ContactPolicy::slide;
    may_slide[root] = slides && (!as_well || may_slide[root]);
    may_pivot[root] = rule.policy != ContactPolicy::hold && (!as_well || may_pivot[root]);
    if (slides && rule.translation_only) translation_only[root] = 1;
  }
};

}  // namespace touchstone

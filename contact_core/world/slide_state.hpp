#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "touchstone/contact_core/motion/mass_metric.hpp"
#include "touchstone/contact_core/motion/slide_rows.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
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
  bool shoves = false;       ///< it goes on along its commanded path, with what it met: see world_shove.cpp
  bool follows = false;      ///< goes along with its leader
  bool is_near_end = false;  ///< where the sub-step is gone to its end, another one would not gain kLeastGain
  Twist way;                 ///< what is left of the commanded path while it shoves
  Vector3 way_centre_O = Vector3::Zero();  ///< about which that turns
  bool is_cut_off = false;                 ///< the budget ended it

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
  ObjectHandle object;   ///< the root's: whoever gets its slot next did none of this
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

/// Pairs that slides have looked at in a frame, against the world's budget. Only those count that are near,
/// so that neither what is remembered nor who comes first shows.
class SlideMeter {
 public:
  void begin(const SlideBudget& budget) {
    budget_ = budget;
    is_timed_ = budget.seconds < std::numeric_limits<double>::infinity();
    seen_ = 0;
    if (is_timed_) start_ = Clock::now();
  }
  /// A sub-step, of which each of so many plans may take an equal share of what is left.
  void begin_step(std::size_t plans) {
    pair_share_ = (budget_.pairs - std::min(seen_, budget_.pairs)) / plans;
    time_share_ = std::max(budget_.seconds - elapsed(), 0.0) / static_cast<double>(plans);
  }
  void begin_plan() { open(seen_ + pair_share_, elapsed() + time_share_); }
  /// Of paths, which may take all that is left.
  void begin_checks() { open(budget_.pairs, budget_.seconds); }

  /// One that turned out to be near.
  void add_pair() { ++seen_; }
  /// Before the next pair.
  bool may_go_on() {
    is_late_ = is_late_ || (is_timed_ && elapsed() >= until_);
    return !is_over();
  }
  /// The plan, or the checks, look at more than they may: in whichever order pairs come.
  bool is_over() const { return is_late_ || seen_ > limit_; }
  /// Of what is over: what it may.
  void clip() { seen_ = std::min(seen_, limit_); }
  bool has_left() const { return seen_ < budget_.pairs && elapsed() < budget_.seconds; }
  std::uint64_t seen() const { return seen_; }

 private:
  using Clock = std::chrono::steady_clock;

  void open(std::uint64_t limit, double until) { limit_ = limit, until_ = until, is_late_ = false; }
  double elapsed() const {
    return is_timed_ ? std::chrono::duration<double>(Clock::now() - start_).count() : 0.0;
  }

  SlideBudget budget_;
  Clock::time_point start_;
  std::uint64_t seen_ = 0, limit_ = 0, pair_share_ = 0;
  double until_ = 0.0, time_share_ = 0.0;
  bool is_timed_ = false, is_late_ = false;
};

/// Who goes along with whom in a frame.
struct ShoveState {
  std::vector<std::uint32_t> leader_of;   // by slot; SlideState::kNone: it goes by itself, or not at all
  std::vector<std::uint32_t> followers;   // roots, in the order in which they were taken along
  std::vector<std::uint32_t> claim_of;    // by slot: whom it is to go along with
  std::vector<std::uint32_t> claimed;     // slots
  std::vector<std::uint8_t> is_told;      // by slot: commanded in this frame, or goes along
  std::vector<std::uint8_t> is_disputed;  // by slot: two leaders want it
  std::vector<std::uint8_t> is_blocked;   // by slot: a leader that was stopped by what does not go along
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

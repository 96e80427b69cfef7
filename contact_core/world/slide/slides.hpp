#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/world/frame/frame_scope.hpp"
#include "touchstone/contact_core/world/frame/stop_permits.hpp"
#include "touchstone/contact_core/world/slide/hands.hpp"
#include "touchstone/contact_core/world/slide/slide_pairs.hpp"

namespace touchstone {

/// The slide policy: movers that were stopped by slide pairs go on towards their commanded poses in
/// sub-steps. In a sub-step all movers are planned from the same poses, each by itself (a pair of two sliders
/// shares its slack), and then move together as on any path, so that the order of registration does not
/// matter. This class leads through the sub-steps: SlidePairs finds the pairs that are near,
/// plan_rigid_slide() and plan_arm_slide() plan, and stops and execution are those of any path.
class Slides {
 public:
  Hands hands;
  SlideBudget budget;

  /// @param anew there are no slides under way, and all solids' moments are computed.
  void take_room(const WorldModel& model, std::size_t watched, std::size_t lanes, bool anew);
  /// The slot's object is new.
  void begin_object(const WorldModel& model, std::uint32_t slot);

  /// A frame begins, in which nothing has stopped these roots yet.
  void begin_frame(std::span<const std::uint32_t> roots) { permits_.forget(roots); }
  /// Notes a stop of a part.
  StopPermits& permits() { return permits_; }

  /// Once the commanded paths are executed, as part 0. @param pairs the frame's: what slides met and is not
  /// known to be apart at their end is added. @param report gets the figures of slides.
  void run(const FrameScope& scope, GrowingList<FramePair>& pairs, FrameReport& report);

 private:
  class ObstaclesOfArm;
  /// An object's share in what moves as one.
  struct CarriedMoments {
    std::uint32_t root;
    MassMoments moments;

    /// Orders a root's parts by their values alone, so that sums do not depend on the order of registration.
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

  /// Buffers in which a lane plans.
  struct PlanRoom {
    std::vector<NearPair> near;
    std::vector<SlideRow> rows;
  };
  /// A slider's plan but for its path.
  struct PlanResult {
    std::uint32_t near = 0;  ///< pairs that were near
  };

  bool begin(const FrameScope& scope);
  void add_follower_sliders(const FrameScope& scope);
  void weigh(const WorldModel& model);
  void find_touching(const WorldModel& model, std::span<const FramePair> pairs);
  SlidePairs::Scope pair_scope(const FrameScope& scope);
  void find_pairs(const FrameScope& scope);
  void gather_pairs(const FrameScope& scope);
  void take_up_pairs(const FrameScope& scope);
  void end_spent();
  bool plan(const FrameScope& scope, FrameReport& report);
  void plan_in_turn(const FrameScope& scope);
  bool may_plan_in_lanes(std::size_t sharers) const;
  void plan_in_lanes(const FrameScope& scope);
  RigidPath plan_rigid(const FrameScope& scope, Slider& slider);
  RigidPath leading_path(const FrameScope& scope, NarrowphaseQuery& query, const Slider& slider) const;
  bool plan_arm(const FrameScope& scope, Slider& slider);
  void go(const FrameScope& scope, std::uint32_t step);
  bool finish_step(const FrameScope& scope);
  void drop_step(const FrameScope& scope);
  void cut_off_all();
  void report_feel(const WorldModel& model, FrameReport& report);

  StopPermits permits_;
  GrowingList<MassMoments> moments_;     // by solid, in its object
  std::vector<CarriedMoments> carried_;  // of the sliders' objects, sorted
  Sliders sliders_;
  SlidePairs pairs_;
  SlideMeter meter_;
  /// By root: pairs that stopped it on its commanded path, and where each root's are.
  GrowingList<FramePair> touching_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> touching_of_;  // (root, index into the frame's pairs)
  std::vector<SlideRow> rows_;                                        // of one plan
  std::vector<JointRow> joint_rows_;  // of an arm: rows_[i] in its joint values

  std::vector<PlanRoom> rooms_;      // by lane
  std::vector<PlanResult> results_;  // by slider, of plan_in_lanes()
  std::vector<std::uint8_t> plans_;  // the same: it plans with rows

  std::vector<HandFeel> felt_;         // what FrameReport shows
  std::vector<ObjectHandle> cut_off_;  // the same
};

/// Parts that are further out than this from a mover's origin do not count in its metric: a pose that turns
/// about their centre of mass would round by 8 u of that, more than a sixteenth of the gap. [m]
double longest_lever(double gap);

}  // namespace touchstone

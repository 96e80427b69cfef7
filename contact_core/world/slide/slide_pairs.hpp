#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/motion/slide_rows.hpp"
#include "touchstone/contact_core/world/frame/nearest_impacts.hpp"
#include "touchstone/contact_core/world/model/frame_lanes.hpp"
#include "touchstone/contact_core/world/model/world_model.hpp"
#include "touchstone/contact_core/world/pairs/pair_watch.hpp"
#include "touchstone/contact_core/world/slide/slide_meter.hpp"
#include "touchstone/contact_core/world/slide/slider.hpp"

namespace touchstone {

/// The pairs that the slides of one frame have to look at: those of the watched pairs that are not known to
/// stay apart. A pair that a plan leaves out stops no motion too late: every sub-step's path is checked
/// against all of them.
///
/// Each call is given what it reads. `model` and `watched` are written where distances were learnt: how long
/// a pair stays clear, and along which axis. Does not allocate beyond reserve().
class SlidePairs {
 public:
  /// The input of the calls below.
  struct Scope {
    WorldModel& model;
    PairWatch& watched;
    NarrowphaseQuery& query;
    const Sliders& sliders;
    SlideMeter& meter;
    FrameLanes& lanes;  ///< whose first query is `query`
  };

  void reserve(std::size_t slots, std::size_t solids, std::size_t mechanisms);
  /// @param watched the most pairs
  void reserve_watched(std::size_t watched);

  /// A frame's slides begin. Notes how far around rigid bodies pairs have to be watched: a body's distance to
  /// its goal never grows, so that it goes no further than to the goal and as far again.
  /// @returns the slots of objects for which too few pairs are watched.
  std::span<const std::uint32_t> begin(WorldModel& model, const Sliders& sliders);
  /// Which of the watched pairs have a slider as part. Of an arm alone they are looked through as they are
  /// watched (PairWatch::for_each_of_arms_beyond()).
  void gather(const WorldModel& model, const PairWatch& watched, const Sliders& sliders, FrameLanes& lanes);
  /// Updates the indices of watched pairs, which may have changed. Before gather().
  void renumber(const PairWatch& watched);

  /// Finds when each pair stops its movers on the paths that are laid. @returns how many were stopped for
  /// want of iterations.
  std::uint32_t find_impacts(const Scope& scope);

  /// Adds the number of these looks to the work of the pairs' sliders.
  void add_looks(const WorldModel& model, Sliders& sliders) const;

  /// Finds the pairs that a slider plans with, for near(): all that a rigid body could reach, or all of an
  /// arm that are not known to be separated at its pose.
  void find_near(const Scope& scope, const Slider& slider);
  /// The same of many sliders in lanes, in two steps. First all that rigid sliders could reach is taken in,
  /// in the order in which find_near() would. @param plans by index into the sliders' list: it plans with
  /// rows.
  void take_in_reached(const Scope& scope, std::span<const std::uint8_t> plans);
  /// Then each finds its pairs, whoever is beside it: nothing here is written. @param out cleared first.
  void find_near_taken_in(const Scope& scope, NarrowphaseQuery& query, const Slider& slider,
                          std::vector<NearPair>& out) const;
  /// For an arm that slides alone: takes up the pairs that its plan, once measured, could bring together.
  /// @returns whether one of them was not near already.
  bool add_on_path(const Scope& scope, const Slider& slider);
  /// The same with the pairs that held the arm back in its last sub-step.
  bool add_held(const Scope& scope, const Slider& slider);
  void forget_held(const Slider& slider);
  /// @param source of a near pair of which a row held; more than once is as once.
  void note_held(const Slider& slider, std::uint32_t source);

  std::span<NearPair> near() { return near_; }
  std::span<FramePair> pairs() { return pairs_; }
  FramePair& operator[](std::uint32_t source) { return pairs_[source]; }
  const FramePair& operator[](std::uint32_t source) const { return pairs_[source]; }
  void nothing_is_active();

 private:
  /// A pair that held an arm back in its last sub-step.
  struct HeldPair {
    std::uint32_t root;
    std::uint32_t source;  ///< index into pairs_
  };
  /// A slider's pairs in met_; by solids, where it plans with them.
  struct Range {
    std::uint32_t root, begin, end;
  };

  void forget_watches();
  std::uint32_t take_in(const WorldModel& model, const PairWatch& watched, std::uint32_t watch);
  void find_close(const Scope& scope);
  void take_in_all(const Scope& scope, std::span<const GatheredPair> found);
  void put_in(SolidPair pair, std::uint32_t watch);
  void fill_in(const Scope& scope, std::size_t before);
  void keep_unclear(const Scope& scope);
  static bool is_near_on_path(const WorldModel& model, const FramePair& pair);
  bool make_near(const Scope& scope, NarrowphaseQuery& query, const Slider& slider, std::uint32_t source,
                 NearPair& near) const;
  void add_near(const Scope& scope, const Slider& slider, std::uint32_t source);
  bool stays_apart(const Scope& scope, std::uint32_t watch, double approach);
  void gather_on_path(const Scope& scope, const Slider& slider);
  /// Calls visit(watch) for each of a slider's pairs, by solids.
  template <class Visit>
  void for_each_of(const Slider& slider, Visit visit) const;
  /// The same of those of an arm that may come nearer than they are known to be clear, in no order.
  /// @param gone as in PairWatch::for_each_of_arms_beyond().
  template <class Gone, class Visit>
  static void for_each_beyond(const Scope& scope, const Slider& arm, Gone gone, Visit visit);

  GrowingList<FramePair> pairs_;          // those of the watched pairs that had to be looked at
  std::vector<std::uint32_t> met_;        // watched pairs of which a slider is part, by index; of two, twice
  GrowingList<std::uint32_t> pair_of_;    // by watched pair: index into pairs_, or kNoIndex
  GrowingList<std::uint8_t> is_near_;     // by watched pair: in near_, within one plan
  GrowingList<std::uint64_t> passed_on_;  // by watched pair: it stays apart on an arm's path of this number
  NearestImpacts impacts_;
  GrowingList<Range> ranges_;           // by root: each slider's in met_
  std::vector<std::uint8_t> taken_in_;  // within take_in_all(); by place in met_, within take_in_reached()
  std::vector<HeldPair> held_;
  std::vector<NearPair> near_;
  std::vector<std::uint32_t> close_;           // indices into pairs_ of those that are asked about next
  std::vector<SolidPair> ahead_;               // pairs that are asked about in one call
  std::vector<GatheredPair> unclear_;          // of met_, within one call
  std::vector<std::uint32_t> open_;            // of close_, those of find_impacts() that are asked about
  std::vector<std::uint32_t> watches_;         // within keep_unclear(): of close_
  std::vector<std::uint32_t> short_of_pairs_;  // slots, of begin()
  bool has_noted_needs_ = false;               // Travels::needed has some, of a slide
};

/// Takes up in a frame's pairs, which are sorted by solids, what slides looked at and is not known to be
/// apart at their end. @param contacts as the frame began, sorted.
void merge_slide_pairs(WorldModel& model, PairWatch& watched, std::span<const ContactState> contacts,
                       std::span<FramePair> met_pairs, GrowingList<FramePair>& pairs);

}  // namespace touchstone

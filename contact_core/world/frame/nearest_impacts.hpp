#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"
#include "touchstone/contact_core/world/model/frame_lanes.hpp"
#include "touchstone/contact_core/world/model/world_model.hpp"
#include "touchstone/contact_core/world/pairs/frame_pairs.hpp"
#include "touchstone/contact_core/world/pairs/pair_watch.hpp"

namespace touchstone {

/// Whether both move, and not as one.
inline bool are_two_movers(const WorldModel& model, const SolidPair& pair) {
  const std::uint32_t a = model.root_of(pair.a), b = model.root_of(pair.b);
  return a != b && model.in_motion[a] && model.in_motion[b];
}

/// When pairs meet on the paths that are laid, the nearest of each mover first: where one stops its mover,
/// the mover's others need only be clear up to there. Equally near ones do not bound each other, so that
/// their order does not show. Movers do not depend on each other: lanes take them in any order.
class NearestImpacts {
 public:
  struct Scope {
    WorldModel& model;
    FrameLanes& lanes;
    PairWatch& watched;  ///< what is learnt of distances is noted
  };

  void take_room(std::size_t slots, std::size_t solids);
  /// @param watched the most pairs.
  void take_room_for_pairs(std::size_t watched) { reserve_more(ahead_, watched); }

  /// Clears all stops; to be called before the first find() on new paths, and once more after the last one.
  void forget(std::span<const std::uint32_t> roots) {
    for (const std::uint32_t root : roots) stop_bounds_[root] = 1.0;
  }
  /// How far along its path a mover gets, by what is known so far.
  double stop_bound(std::uint32_t root) const { return stop_bounds_[root]; }
  /// How far a pair's path matters. Of two movers in motion one may be stopped before the other.
  double matters_until(const WorldModel& model, const SolidPair& pair) const;

  /// Fills in the impacts of pairs[i] for each i in `open`, which are switched on. @pre vertices are placed,
  /// or the pairs' solids stand as the model has them.
  void find(const Scope& scope, std::span<FramePair> pairs, std::span<const std::uint32_t> open);
  /// The same on one thread. @param may_go_on called with each pair once it is known; false: it was the last.
  template <class MayGoOn>
  void find_in_turn(const Scope& scope, std::span<FramePair> pairs, std::span<const std::uint32_t> open,
                    MayGoOn may_go_on);

 private:
  static constexpr std::uint32_t kNotAsked = kNoIndex;

  /// A pair that has to be asked about: by mover, the nearest first.
  struct Opened {
    std::uint32_t mover;  ///< see mover_of()
    std::uint32_t index;  ///< into the pairs, which are by solids
    std::uint32_t start;  ///< index into answers_, or kNotAsked
    double start_separation = 0.0;

    friend bool operator<(const Opened& a, const Opened& b) {
      if (a.mover != b.mover) return a.mover < b.mover;
      return a.start_separation != b.start_separation ? a.start_separation < b.start_separation
                                                      : a.index < b.index;
    }
  };

  void measure(const Scope& scope, std::span<FramePair> pairs, std::span<const std::uint32_t> open);
  std::span<const Opened> group(std::size_t i) const;
  template <class MayGoOn>
  bool find_of_mover(const Scope& scope, NarrowphaseQuery& asking, std::span<const Opened> among,
                     std::span<FramePair> pairs, MayGoOn may_go_on);
  void bound_stops(const WorldModel& model, const FramePair& pair);

  GrowingList<double> stop_bounds_;  // by slot; a root's: it goes no further; 1 between calls

  // Memory of one call.
  GrowingList<Opened> opened_;
  GrowingList<std::uint32_t> groups_;            // where each mover's begin
  GrowingList<SolidPair> ahead_;                 // what is asked about next
  GrowingList<SeparationMemo::Answer> answers_;  // to those
};

template <class MayGoOn>
void NearestImpacts::find_in_turn(const Scope& scope, std::span<FramePair> pairs,
                                  std::span<const std::uint32_t> open, MayGoOn may_go_on) {
  measure(scope, pairs, open);
  for (std::size_t i = 0; i < groups_.size(); ++i)
    if (!find_of_mover(scope, scope.lanes.first(), group(i), pairs, may_go_on)) return;
}

template <class MayGoOn>
bool NearestImpacts::find_of_mover(const Scope& scope, NarrowphaseQuery& asking,
                                   std::span<const Opened> among, std::span<FramePair> pairs,
                                   MayGoOn may_go_on) {
  const WorldModel& model = scope.model;
  std::size_t bounded = 0;
  for (std::size_t i = 0; i < among.size(); ++i) {
    if (among[i].start_separation > among[bounded].start_separation) {
      for (; bounded < i; ++bounded) bound_stops(model, pairs[among[bounded].index]);
    }
    FramePair& pair = pairs[among[i].index];
    find_impact_of(model, asking, scope.watched[pair.watch], pair,
                   among[i].start == kNotAsked ? nullptr : &answers_[among[i].start],
                   matters_until(model, pair.solids));
    if (pair.impact.status == ImpactStatus::clear) pair.impact.lo = 1.0;  // what is beyond a stop is not gone
    if (!may_go_on(pair)) return false;
  }
  for (; bounded < among.size(); ++bounded) bound_stops(model, pairs[among[bounded].index]);
  return true;
}

}  // namespace touchstone

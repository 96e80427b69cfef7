#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/world/frame/movers.hpp"
#include "touchstone/contact_core/world/frame/watched_pairs.hpp"
#include "touchstone/contact_core/world/model/frame_lanes.hpp"
#include "touchstone/contact_core/world/model/world_model.hpp"
#include "touchstone/contact_core/world/pairs/frame_pairs.hpp"

namespace touchstone {

/// Which of the watched pairs matter in a frame, and when they meet: axes, then separations where the solids
/// stand, then conservative advancement. Pairs of one mover depend on each other, as what stops it bounds how
/// far all others matter; movers do not: lanes take them in any order.
class PairFinder {
 public:
  struct Scope {
    WorldModel& model;  ///< vertices are written
    FrameLanes& lanes;
    WatchedPairs& watched;  ///< as found on the paths that are laid; what is learnt of distances is noted
    const Movers& movers;
  };
  struct Counts {
    std::uint32_t candidates = 0;  ///< looked at
    std::uint32_t iteration_limits = 0;
  };

  /// @param watched the most pairs.
  void take_room(std::size_t slots, std::size_t solids, std::size_t watched, bool anew);

  /// Fills `pairs`, by solids, with those that are not known to stay apart, and their impacts.
  /// @param contacts as the frame begins, by solids: they come first, as they stop movers soonest.
  Counts find(const Scope& scope, std::span<const ContactState> contacts, std::vector<FramePair>& pairs);
  /// Once a frame is executed: adds what find() left out as its path leads far away, where that path was not
  /// gone to its end, and what was in contact before: it may be near yet.
  /// @param contacts as the frame began, by solids.
  void add_left_out(const Scope& scope, std::span<const ContactState> contacts,
                    std::vector<FramePair>& pairs);

 private:
  /// How far a pair came that is examined.
  enum class Stage : std::uint8_t {
    apart,  ///< by an axis, wherever its movers are stopped
    open,   ///< it has to be asked about
  };
  static constexpr std::uint32_t kNotAsked = 0xffffffff;

  /// By pair.
  struct Examined {
    Stage stage;
    std::uint32_t start;  ///< index into answers_, or kNotAsked
  };
  /// A pair that has to be asked about: by mover, the nearest first.
  struct Opened {
    std::uint32_t mover;  ///< see mover_of()
    std::uint32_t index;  ///< into the frame's pairs, which are by solids
    double start_separation = 0.0;

    friend bool operator<(const Opened& a, const Opened& b) {
      if (a.mover != b.mover) return a.mover < b.mover;
      return a.start_separation != b.start_separation ? a.start_separation < b.start_separation
                                                      : a.index < b.index;
    }
  };

  void examine(const Scope& scope, std::span<const std::uint32_t> watches, std::vector<FramePair>& pairs,
               Counts& counts);
  void examine_touching(const Scope& scope, std::span<const ContactState> contacts,
                        std::vector<FramePair>& pairs, Counts& counts);
  Stage open_pair(const Scope& scope, std::uint32_t watch, FramePair& entry) const;
  void measure_opened(const Scope& scope, std::span<FramePair> pairs);
  void find_impacts_of_opened(const Scope& scope, std::span<FramePair> pairs);
  void find_impacts_of_mover(const Scope& scope, NarrowphaseQuery& asking, std::span<const Opened> among,
                             std::span<FramePair> pairs);
  void bound_stops(const WorldModel& model, const FramePair& pair);
  double matters_until(const WorldModel& model, const SolidPair& pair) const;
  bool is_clear_to_bounds(const WorldModel& model, const WatchedPair& watch) const;
  std::size_t gather_left_out(const Scope& scope, std::span<const ContactState> contacts,
                              std::span<const FramePair> known);
  void add_unclear_left_out(const Scope& scope, std::span<const ContactState> contacts,
                            std::vector<FramePair>& pairs);

  std::vector<double> stop_bounds_;  // by slot; a root's: it goes no further; 1 between calls

  // Memory of one call.
  std::vector<std::uint32_t> touching_, close_, deferred_;  // watched pairs by index
  std::vector<Examined> examined_;                          // by pair
  std::vector<Opened> opened_;
  std::vector<std::uint32_t> opened_groups_;     // where each mover's begin
  std::vector<SolidPair> ahead_;                 // what is asked about next
  std::vector<SeparationMemo::Answer> answers_;  // to those
  std::vector<GatheredPair> left_out_;
};

}  // namespace touchstone

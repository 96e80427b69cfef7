#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/world/frame/movers.hpp"
#include "touchstone/contact_core/world/frame/nearest_impacts.hpp"
#include "touchstone/contact_core/world/frame/watched_pairs.hpp"
#include "touchstone/contact_core/world/model/frame_lanes.hpp"
#include "touchstone/contact_core/world/model/world_model.hpp"
#include "touchstone/contact_core/world/pairs/frame_pairs.hpp"

namespace touchstone {

/// Finds the watched pairs that matter in a frame, and when they meet: first by axes, then by separations at
/// the current poses, then by conservative advancement. Pairs of one mover depend on each other, since the
/// pair that stops it limits how far the others matter. Movers do not, so lanes take them in any order.
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
  void take_room(std::size_t slots, std::size_t solids, std::size_t watched);

  /// Fills `pairs`, by solids, with those that are not known to stay apart, and their impacts.
  /// @param contacts as the frame begins, by solids: they come first, as they stop movers soonest.
  Counts find(const Scope& scope, std::span<const ContactState> contacts, GrowingList<FramePair>& pairs);
  /// After a frame is executed: adds pairs that find() left out because their path led far away, where that
  /// path was not executed to its end, and pairs that were in contact before: both may still be near.
  /// @param contacts as the frame began, by solids.
  void add_left_out(const Scope& scope, std::span<const ContactState> contacts,
                    GrowingList<FramePair>& pairs);

 private:
  /// The stages that an examined pair goes through.
  enum class Stage : std::uint8_t {
    apart,  ///< by an axis, wherever its movers are stopped
    open,   ///< it has to be asked about
  };
  void examine(const Scope& scope, std::span<const std::uint32_t> watches, GrowingList<FramePair>& pairs,
               Counts& counts);
  void examine_touching(const Scope& scope, std::span<const ContactState> contacts,
                        GrowingList<FramePair>& pairs, Counts& counts);
  Stage open_pair(const Scope& scope, std::uint32_t watch, FramePair& entry) const;
  bool is_clear_to_bounds(const WorldModel& model, const WatchedPair& watch) const;
  std::size_t gather_left_out(const Scope& scope, std::span<const ContactState> contacts,
                              std::span<const FramePair> known);
  void add_unclear_left_out(const Scope& scope, std::span<const ContactState> contacts,
                            GrowingList<FramePair>& pairs);

  NearestImpacts impacts_;

  // Memory of one call.
  GrowingList<std::uint32_t> touching_, close_, deferred_;  // watched pairs by index
  GrowingList<Stage> examined_;                             // by pair
  GrowingList<std::uint32_t> opened_;                       // indices of pairs that have to be asked about
  GrowingList<GatheredPair> left_out_;
};

}  // namespace touchstone

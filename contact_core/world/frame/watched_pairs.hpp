#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "touchstone/contact_core/broadphase/broadphase.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/world/frame/movers.hpp"
#include "touchstone/contact_core/world/model/frame_lanes.hpp"
#include "touchstone/contact_core/world/model/world_model.hpp"
#include "touchstone/contact_core/world/pairs/pair_watch.hpp"

namespace touchstone {

/// The pairs that could come near, and how far each object may go before the broadphase has to be asked
/// again, which is not in every frame.
///
/// Set-up tells which objects came, went or have to be watched further out; a frame lays its paths, updates
/// the pairs and gathers those that may not be clear on the paths. `model` is written where travels are
/// counted.
class WatchedPairs {
 public:
  // Set-up. An object's slot and its solids are laid out in the model, and place_in_body() is done.

  /// @param anew as if nothing had happened yet. Pairs of solids that stay keep what is known of them.
  void take_room(const WorldModel& model, bool anew);
  /// Begins at the model's poses: nothing has moved, and no pair is known.
  /// @param within pairs of the default rule that are no further apart matter [m].
  /// @returns false: the broadphase knows no paths.
  bool begin(const WorldModel& model, Broadphase& broadphase, double within);
  /// The slot's object is new, or gone.
  void begin_object(const WorldModel& model, std::uint32_t slot);
  /// Its pairs are forgotten; watch_anew(): and found again with the next frame.
  void forget(const WorldModel& model, std::uint32_t slot);
  void watch_anew(const WorldModel& model, std::uint32_t slot);
  /// A rule may now report what is within `warn` of the object [m].
  /// @returns false: too many wait for their objects to be laid out, so all has to be set up anew.
  bool raise_reach(const WorldModel& model, std::uint32_t slot, double warn);
  /// From now on pairs of the default rule matter that are up to `by` further apart, no more than `within`
  /// [m].
  void look_further(const WorldModel& model, double by, double within);
  /// For those that are laid out by now.
  void take_up_early_reaches(const ObjectTable& objects);

  // A frame.

  /// Once paths are known, before they are laid: sums of travels that overflowed are counted anew, and what
  /// has not moved for some frames counts as at rest.
  void begin_frame(WorldModel& model);
  /// Counts how far the paths of these roots may take each solid. @param roots ascending.
  void lay_paths(WorldModel& model, std::span<const std::uint32_t> roots);
  /// Takes back the travels beyond a mover's stop.
  void take_back(WorldModel& model, std::uint32_t root) const;
  /// Objects in motion on the paths that were laid last, slots ascending.
  std::span<const std::uint32_t> moved() const { return moved_; }

  /// Notes that the slot's object may go further than its pairs are known for.
  void note_due(std::uint32_t slot);
  bool is_due() const { return needs_watch_ || !due_.empty(); }
  /// Asks the broadphase for the pairs of those that are due, or of all.
  void update(WorldModel& model, Broadphase& broadphase);

  /// Solids of objects with levels that are watched with nothing any more are closed from now on. Up to here
  /// frames place them: events are reported of pairs that are no longer watched.
  void end_frame(WorldModel& model);

  /// Gathers the pairs that may not be clear on the laid paths.
  /// @param close not known to be clear at the start, and switched on; by solids. @param deferred clear
  /// there: once it is known how far paths matter, most of them are clear, and keep_checked() is for the
  /// others.
  void gather(WorldModel& model, const Movers& movers, FrameLanes& lanes, GrowingList<std::uint32_t>& close,
              GrowingList<std::uint32_t>& deferred);
  /// Keeps those that are switched on, by solids.
  void keep_checked(const WorldModel& model, FrameLanes& lanes, GrowingList<std::uint32_t>& indices);

  /// Lists of pairs have room for this many.
  std::size_t room() const { return room_; }

  PairWatch& pairs() { return pairs_; }
  const PairWatch& pairs() const { return pairs_; }

 private:
  double beyond_margin(std::uint32_t slot) const { return half_beyond_ + reaches_[slot]; }
  void place(const WorldModel& model, std::uint32_t slot);
  void place_object(const WorldModel& model, std::uint32_t slot);
  void lay_travels(WorldModel& model, std::uint32_t root);
  void lay_object_travel(WorldModel& model, std::uint32_t slot, const BodyState& start);
  void lay_travel(WorldModel& model, SolidIndex solid, const BodyState& start);
  void add_travel(WorldModel& model, SolidIndex solid);
  void note_goes(std::uint32_t slot, SolidIndex solid);
  void note_those_at_rest(const WorldModel& model);
  void lay_link_travels(WorldModel& model, const MechanismMover& mover);
  void set_region(WorldModel& model, std::uint32_t slot);
  void set_region_of_object(WorldModel& model, std::uint32_t slot);
  bool update_due(WorldModel& model, Broadphase& broadphase);
  bool find_partners(const WorldModel& model, Broadphase& broadphase, std::uint32_t slot, SolidIndex proxy);
  void search_levels(const WorldModel& model, SolidIndex a, SolidIndex b);
  bool update_object_partners(WorldModel& model, Broadphase& broadphase, std::uint32_t slot);
  void update_partners(WorldModel& model, SolidIndex solid);
  void open(WorldModel& model, SolidIndex solid);
  void note_idle(std::uint32_t slot);
  void close_idle(WorldModel& model, std::uint32_t slot);
  void update_all(WorldModel& model, Broadphase& broadphase);
  void watch_again(WorldModel& model, const SolidPair& pair);
  void add(const WorldModel& model, const WatchedPair& pair);
  void find_looked_at(const WorldModel& model, const Movers& movers);

  PairWatch pairs_, pairs_before_;
  std::size_t room_ = 0;
  bool needs_watch_ = true;
  bool is_overflown_ = false;         // Travels knows nothing any more
  GrowingList<std::uint32_t> moved_;  // slots
  // Solids of no arm that move, or have in the last kRestFrames frames.
  GrowingList<std::uint8_t> goes_;         // by solid
  GrowingList<std::uint64_t> last_frame_;  // by slot: in which it moved; 0: it does not go
  GrowingList<std::uint32_t> going_;       // slots with a last_frame_
  std::uint64_t frame_ = 1;
  GrowingList<std::uint32_t> due_;           // slots of objects whose pairs are to be found anew
  GrowingList<std::uint8_t> is_noted_due_;   // by slot
  std::vector<std::uint32_t> idle_;          // slots with levels whose pairs were found anew in this frame
  GrowingList<std::uint8_t> is_noted_idle_;  // by slot
  std::vector<double>
      reaches_;                 // by slot: so much further than the default rule's warn distance it looks [m]
  double half_beyond_ = 0.0;    // half of what all look further than the broadphase's margin [m]
  bool is_beyond_new_ = false;  // since the pairs of all were found
  std::vector<std::pair<ObjectHandle, double>> early_reaches_;  // of objects that are not laid out yet
  GrowingList<std::uint32_t> unclear_;  // by index: all that may not be clear, of what rests

  // For the broadphase: where solids stand, and how far from there they may be.
  GrowingList<Pose> stands_;         // by proxy
  GrowingList<double> regions_;      // by proxy [m]
  GrowingList<Pose> objects_stand_;  // by slot: of those with levels the object's own pose then

  // Memory of one call.
  GrowingList<std::uint32_t> movable_;  // slots, of update_all()
  std::vector<SolidIndex> proxies_;     // of find_partners()
  std::vector<SolidPair> found_;        // of search_levels()
  std::vector<SolidIndex> partners_;    // of update_partners()
  GrowingList<std::uint64_t> marks_;    // the same, by solid
  std::uint64_t last_mark_ = 0;
  GrowingList<GatheredPair> gathered_;      // of keep_checked(): those that are on
  GrowingList<std::uint32_t> taken_;        // of gather(): not clear
  std::vector<std::uint32_t> looked_at_;    // the same: roots
  GrowingList<std::uint8_t> is_looked_at_;  // the same, by slot
  GrowingList<std::uint8_t> is_taken_;      // the same, by index
};

}  // namespace touchstone

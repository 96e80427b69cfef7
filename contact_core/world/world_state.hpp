#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "touchstone/contact_core/threads/thread_team.hpp"
#include "touchstone/contact_core/world/executed_parts.hpp"
#include "touchstone/contact_core/world/frame_lanes.hpp"
#include "touchstone/contact_core/world/pair_watch.hpp"
#include "touchstone/contact_core/world/slide/followers.hpp"
#include "touchstone/contact_core/world/slide/slide_state.hpp"
#include "touchstone/contact_core/world/stop_queue.hpp"
#include "touchstone/contact_core/world/world_model.hpp"

namespace touchstone {

/// What a contact world keeps beside its model: what frames remember, and the memory of one. Its functions
/// stand in contact_world.cpp, world_frame.cpp, world_examine.cpp, world_changes.cpp, world_mechanism.cpp,
/// world_stops.cpp, world_travel.cpp, world_slide.cpp, world_shove.cpp, world_hand.cpp and world_events.cpp.
struct ContactWorld::State : WorldModel {
  std::unique_ptr<Broadphase> broadphase;
  SelectionQueue queue;
  bool needs_layout = true;

  // Taken up by prepare().
  std::unique_ptr<ThreadTeam> team;  // set_threads()'s; null: none
  FrameLanes lanes;
  NarrowphaseQuery* query = nullptr;  // lanes.first()

  // One frame.
  std::uint64_t frame = 0;
  std::vector<SelectionChange> changes, refused_changes;
  std::vector<SelectionRecord> record;
  std::size_t record_room = 0;
  std::uint64_t left_out = 0;              // of the record, for want of room
  const Pose* poses_in_body = nullptr;     // where paths look for them
  std::vector<std::uint32_t> movers;       // roots in motion, by slot
  std::vector<std::uint32_t> told;         // roots that were told to move, of which more than rest is known
  std::vector<std::uint32_t> told_before;  // the same, one frame ago
  std::vector<double> stop_bounds;         // by slot; a root's: it goes no further, within find_pairs
  std::vector<std::uint8_t> is_restopped;  // by slot; a root's, within resolve_stops
  std::vector<std::uint8_t> is_held;       // by slot; a root's: a pair that holds took it back to its start
  StopQueue stop_queue;                    // within resolve_stops
  std::vector<std::uint32_t> restopped;    // the same: roots to look at again
  bool took_back = false;                  // a pair that holds did, in these rounds
  std::vector<std::uint8_t> is_short;      // by slot; a root's: its commanded path was stopped in this frame
  std::vector<Pose> to;                    // by solid
  std::vector<double> bulges;              // by solid
  std::vector<std::uint32_t> moved;        // objects on their way on the path that was laid last, by slot
  std::vector<std::uint32_t> member_root;  // by slot: its root in members, or kNone
  bool is_overflown = false;               // Travels knows nothing any more
  std::vector<double> reaches;  // by slot: so much further than the default rule's warn distance it looks
  std::vector<std::pair<ObjectHandle, double>> early_reaches;  // of objects that are not laid out yet
  PairWatch watched, watched_before;
  std::vector<std::uint32_t> due;          // objects whose watched pairs are to be found anew, by slot
  std::vector<std::uint8_t> is_noted_due;  // by slot
  std::vector<std::uint32_t> movable;      // objects by slot, within watch_all
  std::vector<SolidIndex> partners;        // of a solid, within watch_due
  std::vector<std::pair<SolidIndex, std::uint32_t>>
      known_partners;                      // the same: partners watched so far and their index
  std::vector<std::uint32_t> unclear;      // watched pairs by index: all that may not be clear, of what rests
  std::vector<GatheredPair> gathered;      // of the watched pairs, those that are to be looked at
  std::vector<std::uint32_t> off;          // the same: those that are switched off
  std::vector<std::uint32_t> looked_at;    // roots, within gather_unclear
  std::vector<std::uint8_t> is_looked_at;  // by slot, the same
  std::vector<std::uint8_t> is_taken;      // by watched pair, the same
  std::vector<std::uint32_t> close, deferred;   // watched pairs by index, within find_pairs
  std::vector<SolidPair> ahead;                 // what is asked about next
  std::vector<SeparationMemo::Answer> answers;  // to what is asked ahead
  std::vector<ExaminedPair> examined;           // within examine: by pair
  std::vector<OpenedPair> opened;               // the same: of those that are open
  std::vector<std::uint32_t> opened_groups;     // the same: where each mover's begin
  std::vector<std::uint32_t> lively;  // of the watched pairs, by index: those that soon may come near
  bool needs_watch = true, needs_lively = true;
  std::vector<FramePair> pairs;
  std::vector<Moment> moments;
  std::vector<ContactState> contacts, contacts_before;
  std::vector<ContactEvent> left_contacts;  // ended with the removal of an object
  std::vector<ContactEvent> events;
  SlideState slides;
  Followers followers;
  ExecutedParts parts;

  // Set-up, in world_changes.cpp.
  void build_all();
  void take_room(bool anew);
  void place_solids(std::uint32_t slot);
  bool take_up_changes();
  bool replace_object(std::uint32_t slot);
  void begin_object(std::uint32_t slot);
  void change_body(std::uint32_t slot);
  void lay_resting_paths();
  void watch_anew(std::uint32_t slot);
  void drop_watched(std::uint32_t slot);
  void raise_reach(std::uint32_t slot, double warn);
  void raise_reach_of_group(std::uint32_t first, std::uint32_t second);

  void forget_motion();
  void take_selection();
  void accept(std::span<const MotionCommand> commands);
  void take_movers();
  void lay_paths();
  void lay_travels(std::uint32_t root);
  void lay_travel(SolidIndex solid, const BodyState& start);
  void lay_own_travels(std::uint32_t root);
  void restart_travels();
  bool is_watch_due() const { return needs_watch || !due.empty(); }
  void note_due(std::uint32_t slot);
  void watch_pairs();
  bool watch_due();
  void watch_all();
  void set_region(std::uint32_t slot);
  bool may_be_watched(const SolidPair& pair) const;
  bool watch_partners(SolidIndex solid);
  void gather_unclear();
  void sort_gathered(std::size_t count);
  void choose_lively();
  bool is_clear_before(const WatchedPair& watch) const;
  bool is_clear_to_bounds(const WatchedPair& watch) const;
  void take_back_travels(std::uint32_t root);
  void execute();

  // Which pairs matter and when they meet, in world_examine.cpp.
  void find_pairs(FrameReport& report);
  void examine(std::span<const std::uint32_t> watches, FrameReport& report);
  double matters_until(const SolidPair& pair) const;
  PairStage open_pair(std::uint32_t watch, FramePair& entry);
  void measure_opened();
  void find_impacts_of_opened();
  void find_impacts_of_mover(NarrowphaseQuery& asking, std::span<const OpenedPair> among);
  bool is_of_interest(const FramePair& pair) const;
  void bound_stops(const FramePair& pair);

  // Stops, in world_stops.cpp.
  void resolve_stops(std::span<FramePair> among, std::uint32_t part);
  void queue_open(std::span<const FramePair> among);
  bool settle(std::span<FramePair> among, double least, std::uint32_t part);
  bool stop_movers(const FramePair& pair);
  void stop_together(std::uint32_t root, double target);
  void recheck(std::uint32_t root, std::span<FramePair> among);
  void begin_again(std::span<FramePair> among);
  std::uint32_t add_moment(const FramePair& pair, std::uint32_t part, double s);
  void note_moments(std::span<FramePair> among, std::uint32_t part);
  void note_touch(FramePair& pair, std::uint32_t part);
  void note_active(std::uint32_t part);

  // What is reported, in world_events.cpp.
  void report_pairs();
  void add_left_out_pairs();
  void add_left_out();
  SeparationMemo::Answer answer_now(const SolidPair& pair);
  void end_unchecked(const ContactState& contact);
  void keep_contacts(const Layout& next);
  void end_contacts_of(std::span<const std::uint32_t> slots);
  ContactEvent removed_event(const ContactState& contact) const;
  void report_pair(const FramePair& pair, bool was_in_contact, const PairGeometry& at_end);
  ContactEvent pair_event(EventKind kind, const SolidPair& pair, const Moment& at,
                          const PairGeometry& at_end) const;
  bool is_in_contact(const FramePair& pair, double separation, bool has_been);

  // Mechanisms, in world_mechanism.cpp.
  void accept_joints(std::span<const JointCommand> commands);
  void reset_mechanisms();
  void list_exempt_pairs(Layout& out) const;
  void place_in_body(std::uint32_t slot);
  void place_solids_in_bodies();
  void take_room_for_travels(bool anew);
  void number_own_pairs();
  Pose executed_link_pose(std::uint32_t slot, std::size_t part, double s) const;

  // Sliding, in world_slide.cpp: from part to part (slide/).
  class ObstaclesOfArm;
  void prepare_slides();
  void take_room_for_slides(bool anew);
  void slide(FrameReport& report);
  void record_parts(std::uint32_t part);
  void cut_off_all();
  void drop_step();
  bool begin_slides();
  bool may_pivot(std::uint32_t root) const;
  void add_follower_sliders();
  double longest_lever() const;
  void weigh_sliders();
  SlidePairs::Scope slide_scope();
  void find_slide_pairs();
  void gather_slide_pairs();
  void take_up_slide_pairs();
  bool plan_slides(FrameReport& report);
  void find_touching();
  RigidPath plan_of(Slider& slider);
  RigidPath rigid_path(Slider& slider);
  bool plan_arm(Slider& slider);
  bool finish_step();
  void rest(std::uint32_t root);
  void report_slides(FrameReport& report);

  // What goes along with movers, in world_shove.cpp.
  bool is_passive(std::uint32_t root) const;
  void go_along(std::uint32_t leader, std::uint32_t root);
  bool settle_claims();
  void take_loads();
  bool shove(std::span<const FramePair> among);
};

/// An event of a command, which concerns one object at most.
ContactEvent command_event(EventKind kind, ObjectHandle object);

}  // namespace touchstone

#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/contact_core/world/frame_pairs.hpp"
#include "touchstone/contact_core/world/mechanism_mover.hpp"
#include "touchstone/contact_core/world/object_table.hpp"
#include "touchstone/contact_core/world/pair_rules.hpp"
#include "touchstone/contact_core/world/pair_watch.hpp"
#include "touchstone/contact_core/world/selection_state.hpp"
#include "touchstone/contact_core/world/slide_state.hpp"
#include "touchstone/contact_core/world/stop_queue.hpp"
#include "touchstone/contact_core/world/travels.hpp"

namespace touchstone {

/// What a contact world is made of; its functions stand in contact_world.cpp, world_frame.cpp,
/// world_changes.cpp, world_mechanism.cpp, world_stops.cpp, world_travel.cpp, world_slide.cpp,
/// world_slide_pairs.cpp, world_pivot.cpp, world_shove.cpp, world_hand.cpp, world_joint_slide.cpp and
/// world_events.cpp.
struct ContactWorld::State {
  std::unique_ptr<Narrowphase> narrowphase;
  std::unique_ptr<Narrowphase> planner;  // native: plans slides, and motion where the narrowphase only judges
  std::unique_ptr<Broadphase> broadphase;
  double gap;

  ObjectTable objects;
  MechanismTable mechanisms;
  PairRules rules;
  SelectionQueue queue;
  Selection selection;
  bool needs_layout = true;

  // Taken up by prepare().
  Layout layout;
  std::unique_ptr<NarrowphaseQuery> query;

  // One frame.
  std::uint64_t frame = 0;
  std::vector<SelectionChange> changes, refused_changes;
  std::vector<SelectionRecord> record;
  std::size_t record_room = 0;
  std::uint64_t left_out = 0;              // of the record, for want of room
  std::vector<CarriedPath> paths;          // by slot; a root's
  const Pose* poses_in_body = nullptr;     // where paths look for them
  std::vector<std::uint32_t> movers;       // roots in motion, by slot
  std::vector<std::uint32_t> told;         // roots that were told to move, of which more than rest is known
  std::vector<std::uint32_t> told_before;  // the same, one frame ago
  std::vector<double> stops;               // by slot; a root's
  std::vector<double> stop_bounds;         // by slot; a root's: it goes no further, within find_pairs
  std::vector<std::uint8_t> in_motion;     // by slot; a root's
  std::vector<std::uint8_t> is_restopped;  // by slot; a root's, within resolve_stops
  std::vector<std::uint8_t> is_held;       // by slot; a root's: a pair that holds took it back to its start
  StopQueue stop_queue;                    // within resolve_stops
  std::vector<std::uint32_t> restopped;    // the same: roots to look at again
  bool took_back = false;                  // a pair that holds did, in these rounds
  std::vector<std::uint8_t> is_short;      // by slot; a root's: its commanded path was stopped in this frame
  std::vector<Pose> from, to;              // by solid
  std::vector<double> bulges;              // by solid
  std::vector<Pose> X_BS;                  // by solid, in its body; of mechanisms' solids
  std::vector<std::uint32_t> moved;        // objects on their way on the path that was laid last, by slot
  std::vector<std::pair<std::uint32_t, std::uint32_t>> members;  // (root, object by slot), sorted
  std::vector<std::uint32_t> member_root;                        // by slot: its root in members, or kNone
  Travels travels;
  bool is_overflown = false;    // Travels knows nothing any more
  std::vector<double> reaches;  // by slot: so much further than the default rule's warn distance it looks
  std::vector<std::pair<ObjectHandle, double>> early_reaches;  // of objects that are not laid out yet
  PairWatch watched, watched_before;
  std::vector<std::uint32_t> due;          // objects whose watched pairs are to be found anew, by slot
  std::vector<std::uint8_t> is_noted_due;  // by slot
  std::vector<std::uint32_t> movable;      // objects by slot, within watch_all
  std::vector<SolidIndex> partners;        // of a solid, within watch_due
  std::vector<std::pair<SolidIndex, std::uint32_t>>
      known_partners;                  // the same: partners watched so far and their index
  std::vector<std::uint32_t> unclear;  // watched pairs by index: all that may not be clear, of what rests
  std::vector<std::uint32_t> seen_at;  // by watched pair: the look at which it came up last
  std::uint32_t look = 0;
  std::vector<std::uint32_t> close, deferred;  // watched pairs by index, within find_pairs
  std::vector<SolidPair> ahead;                // what is asked about next
  std::vector<std::uint32_t> lively;  // of the watched pairs, by index: those that soon may come near
  bool needs_watch = true, needs_lively = true;
  std::vector<FramePair> pairs;
  std::vector<Moment> moments;
  std::vector<ContactState> contacts, contacts_before;
  std::vector<ContactEvent> left_contacts;  // ended with the removal of an object
  std::vector<ContactEvent> events;
  SlideState slides;
  ShoveState shoves;

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
  BodyState state_at(std::uint32_t slot, double s) const;
  void lay_travels(std::uint32_t root);
  void lay_travel(SolidIndex solid, const BodyState& start);
  void lay_own_travels(std::uint32_t root);
  void restart_travels();
  double travel_on(const MechanismMover& mover, SolidIndex solid) const;
  void measure_own_travels(const MechanismMover& mover, std::vector<double>& out) const;
  bool is_watch_due() const { return needs_watch || !due.empty(); }
  void note_due(std::uint32_t slot);
  void watch_pairs();
  bool watch_due();
  void watch_all();
  void set_region(std::uint32_t slot);
  bool may_be_watched(const SolidPair& pair) const;
  bool watch_partners(SolidIndex solid);
  void gather_unclear();
  /// Calls visit(slot) for each object that moves with the root.
  template <class Visit>
  void for_each_member(std::uint32_t root, Visit visit) const {
    const std::pair<std::uint32_t, std::uint32_t> first{root, 0};
    for (auto member = std::lower_bound(members.begin(), members.end(), first);
         member != members.end() && member->first == root; ++member)
      visit(member->second);
  }
  void choose_lively();
  double travelled(const SolidPair& pair, std::uint32_t own) const {
    return own != kNotOwn ? travels.of_own[own] : travels.of_solid[pair.a] + travels.of_solid[pair.b];
  }
  double last_travel(const SolidPair& pair, std::uint32_t own) const {
    return own != kNotOwn ? travels.last_own[own] : travels.last_solid[pair.a] + travels.last_solid[pair.b];
  }
  std::uint32_t own_index(const SolidPair& pair) const;
  void find_pairs(FrameReport& report);
  bool is_clear_before(const WatchedPair& watch) const;
  bool is_clear_to_bounds(const WatchedPair& watch) const;
  void bound_stops(std::span<const FramePair> among);
  void order_by_separation(std::span<FramePair> among);
  const WorldVertices& vertices_of(SolidIndex solid);
  double apart_at_least(const WatchedPair& watch);
  bool is_apart_by_axis(WatchedPair& watch, const FramePair& pair, double standing, double way);
  void take_back_travels(std::uint32_t root);
  bool is_checked(const SolidPair& pair) const;
  FramePair frame_pair(const SolidPair& pair) const;
  double matters_until(const SolidPair& pair) const;
  void examine(std::span<const std::uint32_t> watches, FrameReport& report);
  void open_pair(std::uint32_t watch, FrameReport& report);
  bool is_of_interest(FramePair& pair, FrameReport& report);
  MovingSolid moving_solid(SolidIndex solid) const;
  MovingSolid seen_from(std::uint32_t link, SolidIndex solid) const;
  Impact impact_of(FramePair& pair, double until = 1.0);
  void execute();

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
  void add_left_out(std::uint32_t index, SolidIndex solid, std::size_t known);
  bool is_among(const SolidPair& pair, std::size_t known) const;
  PairGeometry geometry_now(const SolidPair& pair);
  void end_unchecked(const ContactState& contact);
  void keep_contacts(const Layout& next);
  void end_contacts_of(std::span<const std::uint32_t> slots);
  ContactEvent removed_event(const ContactState& contact) const;
  void report_pair(const FramePair& pair, bool was_in_contact);
  ContactEvent pair_event(EventKind kind, const SolidPair& pair, const Moment& at,
                          const PairGeometry& at_end) const;
  double gap_of(const SolidPair& pair) const;
  bool is_sampled() const { return !gives_signed_distance(*narrowphase); }
  /// Whose separations the motion goes by.
  const Narrowphase& separations() const { return is_sampled() ? *planner : *narrowphase; }
  bool is_in_contact(const FramePair& pair, double separation, bool has_been);

  // Mechanisms, in world_mechanism.cpp.
  void accept_joints(std::span<const JointCommand> commands);
  void reset_mechanisms();
  void list_exempt_pairs(Layout& out) const;
  void place_in_body(std::uint32_t slot);
  void place_solids_in_bodies();
  void take_room_for_travels(bool anew);
  void number_own_pairs();
  /// The mechanism that the object is a link of or is carried by, or null.
  MechanismMover* mechanism_of(std::uint32_t slot) const {
    const ObjectRecord& body = objects[objects[slot].body];
    return body.is_link() ? mechanisms.at(body.mechanism) : nullptr;
  }
  bool moves(std::uint32_t slot) const;
  struct Executed {
    const ExecutedPart* part;  ///< null: it stood still
    double s;                  ///< within it
  };
  Executed executed_part(std::uint32_t root, std::size_t part, double s) const;
  double executed_value(const Executed& executed, std::uint32_t value) const;
  Pose executed_link_pose(std::uint32_t slot, std::size_t part, double s) const;

  // Sliding, in world_slide.cpp.
  void prepare_slides();
  void take_room_for_slides(bool anew);
  void reserve_slide_pairs();
  void slide(FrameReport& report);
  void record_parts(std::uint32_t part);
  void cut_off_all();
  void drop_step();
  bool begin_slides();
  double longest_lever() const;
  void weigh_sliders();
  void weigh_by_hand(Slider& slider) const;
  void feel(Slider& slider, const Twist& left, const TwistMetric& metric_W, const ActiveRows& active) const;
  void report_feel(FrameReport& report);
  bool plan_slides(FrameReport& report);
  double distance_of(const Slider& slider) const;
  double share_of_pair(const Slider& slider, const Slider& other, const NearPair& near) const;
  /// The mover's solid, then the obstacle's; of an arm's own pair b counts as the mover's.
  std::pair<SolidIndex, SolidIndex> mover_first(const SolidPair& pair, std::uint32_t root) const {
    return root_of(pair.b) == root ? std::pair{pair.b, pair.a} : std::pair{pair.a, pair.b};
  }
  bool shares_room() const;
  void order_near_rows(bool all);
  void mark_active(std::uint32_t row);
  RigidPath plan_of(Slider& slider);
  RigidPath rigid_path(Slider& slider);
  bool finish_step();
  bool may_pivot(std::uint32_t root) const;
  const Moment* pivot_of(const Slider& slider, Vector3& p_W) const;
  RigidPath pivot_path(const Slider& slider) const;
  void rest(std::uint32_t root);

  // What goes along with movers, in world_shove.cpp.
  bool is_passive(std::uint32_t root) const;
  /// The root by whose motion this one goes: its own, unless it goes along.
  std::uint32_t leader_of(std::uint32_t root) const {
    return shoves.leader_of[root] == SlideState::kNone ? root : shoves.leader_of[root];
  }
  CarriedPath path_along(std::uint32_t leader, std::uint32_t root) const;
  void take_along(std::uint32_t leader, std::uint32_t root);
  void claim(std::uint32_t leader, std::uint32_t root);
  bool settle_claims();
  void take_loads();
  bool shove(std::span<const FramePair> among);
  void add_follower_sliders();
  bool is_followed(std::uint32_t root) const;
  void begin_shove(Slider& slider, double stop) const;
  bool go_on_shoving(Slider& slider, double stop) const;
  RigidPath shoving_path(const Slider& slider) const;

  // What slides may meet, in world_slide_pairs.cpp.
  void find_slide_pairs();
  void need_watch_of(const Slider& slider);
  void gather_slide_pairs();
  void take_up_slide_pairs();
  void watch_slide_pairs();
  bool is_clear(const WatchedPair& watch) const {
    return travelled({watch.a, watch.b}, watch.own) <= watch.clear_until;
  }
  std::uint32_t take_in(std::uint32_t watch);
  void find_slide_impacts(FrameReport& report);
  Vector3 slide_centre(const Slider& slider, SolidIndex solid) const;
  double slide_reach(const Slider& slider, SolidIndex solid, SolidIndex other) const;
  double reach_of_pair(const Slider& slider, const SolidPair& pair);
  void add_near_pair(const Slider& slider, std::uint32_t source);
  void find_near_pairs(const Slider& slider);
  double other_reach(const Slider& slider, const SolidPair& pair);
  bool stays_apart(std::uint32_t watch, double way);
  bool is_passed_by(const Slider& slider, const FramePair& pair);
  bool add_pairs_in_way(const Slider& slider);
  bool was_in_contact(const SolidPair& pair) const;
  void merge_slide_pairs();

  // Of mechanisms, in world_joint_slide.cpp.
  void begin_joint_slide(Slider& slider);
  void measure_plan(const Slider& slider);
  std::uint32_t other_link(const Slider& slider, SolidIndex other) const;
  Twist joint_twist(const Slider& slider, const JointVector& dq, const NearPair& near) const;
  void add_joint_rows(const Slider& slider);
  void note_held_pairs(const Slider& slider, const JointSlidePlan& plan);
  bool add_held_pairs(const Slider& slider);
  bool plan_joints(Slider& slider);

  std::uint32_t root_of(SolidIndex solid) const { return objects[layout.slot_of[solid]].root; }
  std::uint32_t body_of(SolidIndex solid) const { return objects[layout.slot_of[solid]].body; }
};

/// An event of a command, which concerns one object at most.
ContactEvent command_event(EventKind kind, ObjectHandle object);

}  // namespace touchstone

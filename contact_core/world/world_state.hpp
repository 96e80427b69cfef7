#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "contact_core/motion/narrowphase_query.hpp"
#include "contact_core/world/contact_world.hpp"
#include "contact_core/world/frame_pairs.hpp"
#include "contact_core/world/object_table.hpp"
#include "contact_core/world/pair_rules.hpp"
#include "contact_core/world/slide_state.hpp"

namespace touchstone {

/// What a contact world is made of; its functions stand in contact_world.cpp and world_slide.cpp.
struct ContactWorld::State {
  std::unique_ptr<Narrowphase> narrowphase;
  std::unique_ptr<Narrowphase> planner;  // native: plans slides, and motion where the narrowphase only judges
  std::unique_ptr<Broadphase> broadphase;
  double gap;

  ObjectTable objects;
  PairRules rules;
  SelectionQueue queue;
  Selection selection;
  bool needs_layout = true;

  // Taken up by prepare().
  Layout layout;
  std::unique_ptr<NarrowphaseQuery> query;

  // One frame.
  std::uint64_t frame = 0;
  std::vector<SelectionChange> changes;
  std::vector<SelectionRecord> record;
  std::vector<CarriedPath> paths;                  // by slot; a root's
  std::vector<double> stops;                       // by slot; a root's
  std::vector<std::uint8_t> in_motion;             // by slot; a root's
  std::vector<std::uint8_t> is_restopped;          // by slot; a root's, within resolve_stops
  std::vector<Pose> from, to;                      // by solid
  std::vector<double> bulges;                      // by solid
  std::vector<std::uint32_t> moved, moved_before;  // objects by layout index
  std::vector<FramePair> pairs;
  std::vector<ContactState> contacts, contacts_before;
  std::vector<ContactEvent> events;
  SlideState slides;

  void take_selection();
  void accept(std::span<const MotionCommand> commands);
  void lay_paths();
  void find_pairs(FrameReport& report);
  bool is_checked(const SolidPair& pair) const;
  FramePair frame_pair(const SolidPair& pair) const;
  void examine(const SolidPair& pair, FrameReport& report);
  MovingSolid moving_solid(SolidIndex solid) const;
  Impact impact_of(const FramePair& pair);
  void resolve_stops(std::vector<FramePair>& among);
  void stop_movers(const FramePair& pair);
  void recheck(std::uint32_t root, std::vector<FramePair>& among);
  void execute();
  void report_pairs();
  void report_pair(const FramePair& pair, bool was_in_contact);
  void add_event(EventKind kind, const SolidPair& pair, double s, const PairGeometry& geometry);
  double gap_of(const SolidPair& pair) const;
  bool is_sampled() const { return !gives_signed_distance(*narrowphase); }
  /// Whose separations the motion goes by.
  const Narrowphase& separations() const { return is_sampled() ? *planner : *narrowphase; }
  bool is_in_contact(const FramePair& pair, double separation, bool was_in_contact);

  // Sliding, in world_slide.cpp.
  void prepare_slides();
  void slide(FrameReport& report);
  void record_parts(std::uint32_t part);
  bool begin_slides();
  void weigh_sliders();
  void find_slide_pairs();
  bool plan_slides(FrameReport& report);
  RigidPath plan_of(Slider& slider);
  void add_near_pair(const Slider& slider, const FramePair& pair, std::uint32_t source);
  bool finish_step();
  void merge_slide_pairs();
  void rest(std::uint32_t root);

  std::uint32_t root_of(SolidIndex solid) const { return objects[layout.slot_of[solid]].root; }
};

}  // namespace touchstone

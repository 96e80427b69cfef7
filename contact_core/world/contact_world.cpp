#include "touchstone/contact_core/world/contact_world.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/world/world_state.hpp"

namespace touchstone {

ContactWorld::ContactWorld(std::unique_ptr<Narrowphase> narrowphase, std::unique_ptr<Broadphase> broadphase,
                           double gap)
    : state_(std::make_unique<State>()) {
  if (!std::isfinite(gap) || !(gap > 0.0))
    throw InputError("contact world: the gap is " + std::to_string(gap) + " m, not a length above 0");
  state_->gap = gap;
  begin_selection_record();
  set_narrowphase(std::move(narrowphase));
  set_broadphase(std::move(broadphase));
}

ContactWorld::~ContactWorld() = default;

void ContactWorld::set_narrowphase(std::unique_ptr<Narrowphase> narrowphase) {
  if (!narrowphase) throw InputError("contact world: no narrowphase");
  state_->narrowphase = std::move(narrowphase);
  state_->needs_layout = true;
}

void ContactWorld::set_broadphase(std::unique_ptr<Broadphase> broadphase) {
  if (!broadphase) throw InputError("contact world: no broadphase");
  state_->broadphase = std::move(broadphase);
  state_->needs_layout = true;
}

ObjectHandle ContactWorld::add(ObjectDescription description) {
  const ObjectHandle handle = state_->objects.add(std::move(description));
  state_->needs_layout = true;
  return handle;
}

void ContactWorld::remove(ObjectHandle object) {
  const std::uint32_t slot = state_->objects.slot_of(object);
  state_->objects.remove(object);
  state_->rules.forget(slot);
  state_->selection.forget(slot);
  state_->needs_layout = true;
}

ObjectHandle ContactWorld::find(std::string_view name) const { return state_->objects.find(name); }
bool ContactWorld::is_alive(ObjectHandle object) const { return state_->objects.is_alive(object); }
std::string_view ContactWorld::name_of(ObjectHandle object) const {
  return state_->objects[state_->objects.slot_of(object)].name();
}

void ContactWorld::set_default_rule(const PairRule& rule) {
  state_->rules.set_default(rule);
  state_->needs_layout = true;
}

void ContactWorld::set_group_rule(std::string_view first, std::string_view second, const PairRule& rule) {
  PairRules::check(rule);
  const std::array names{std::string(first), std::string(second)};
  const std::vector<std::uint32_t> groups = state_->objects.groups(names);
  state_->rules.set_for_groups(groups[0], groups[1], rule);
  state_->needs_layout = true;
}

void ContactWorld::set_pair_rule(ObjectHandle a, ObjectHandle b, const PairRule& rule) {
  const std::uint32_t slot_a = state_->objects.slot_of(a), slot_b = state_->objects.slot_of(b);
  if (slot_a == slot_b)
    throw InputError("object '" + std::string(name_of(a)) +
                     "': a rule is of a pair, and this is one object twice");
  state_->rules.set_for_pair(slot_a, slot_b, rule);
  state_->needs_layout = true;
}

EffectiveRule ContactWorld::rule_of(ObjectHandle a, ObjectHandle b) const {
  return state_->rules.find(state_->objects, state_->objects.slot_of(a), state_->objects.slot_of(b));
}

void ContactWorld::exempt(const Exemption& pair) {
  state_->objects.exempt(pair);
  state_->take_up_latches();
}

void ContactWorld::unexempt(const Exemption& pair) {
  state_->objects.unexempt(pair);
  state_->take_up_latches();
}

void ContactWorld::latch(ObjectHandle carrier, ObjectHandle carried, const std::vector<Exemption>& allowed) {
  state_->objects.latch(carrier, carried, allowed);
  state_->take_up_latches();
}

void ContactWorld::unlatch(ObjectHandle carried) {
  state_->objects.unlatch(carried);
  state_->take_up_latches();
}

/// Objects and solids keep their numbers: what is not checked, and what moves as one, is found anew.
void ContactWorld::State::take_up_latches() {
  if (needs_layout) return;
  list_exempt_pairs(layout);
  place_solids_in_bodies();
}

WorldCapabilities ContactWorld::capabilities() const {
  return {state_->narrowphase->name(), state_->broadphase->name(),
          state_->is_sampled() ? MotionCheck::sampled : MotionCheck::proven};
}

void ContactWorld::prepare() {
  State& s = *state_;
  if (!s.needs_layout) return;
  Layout layout = make_layout(s.objects);
  s.list_exempt_pairs(layout);
  s.narrowphase->build(layout.solids);
  BroadphaseInput input;
  input.trees = layout.trees;
  input.margin = std::max(2.0 * s.gap, s.rules.largest_warn_distance());
  input.is_static = layout.is_static;
  s.broadphase->build(input);
  if (!s.planner) s.planner = make_native();
  s.planner->build(layout.solids);
  s.query = std::make_unique<NarrowphaseQuery>(*s.narrowphase, *s.planner, layout.solids.size());
  s.query->remember();
  s.keep_contacts(layout);
  s.layout = std::move(layout);
  const std::size_t slots = s.objects.size(), solids = s.layout.solids.size();
  s.paths.assign(slots, CarriedPath(RigidPath(), s.objects.poses_in_body()));
  s.stops.assign(slots, 1.0), s.stop_bounds.assign(slots, 1.0);
  s.in_motion.assign(slots, 0);
  s.is_restopped.assign(slots, 0), s.is_held.assign(slots, 0), s.is_short.assign(slots, 0);
  s.from.resize(solids), s.to.resize(solids), s.bulges.assign(solids, 0.0);
  s.moved.reserve(slots);
  s.moved.clear();  // objects have new indices
  s.pairs.reserve(64 + 16 * solids);
  s.contacts.reserve(64 + 16 * solids), s.contacts_before.reserve(64 + 16 * solids);
  s.moments.reserve(128 + 32 * solids);
  s.prepare_travels();
  s.place_solids_in_bodies();
  s.events.reserve(256 + 16 * solids);
  s.queue.reserve(1024), s.changes.reserve(1024), s.refused_changes.reserve(1024);
  s.selection.reserve(slots);
  for (SolidIndex i = 0; i < solids; ++i)
    s.from[i] = s.to[i] = compose(s.objects[s.layout.slot_of[i]].X_WO, s.layout.X_OS[i]);
  if (!s.broadphase->update_paths({s.from, s.to, s.bulges}, {}))
    throw InputError("contact world: broadphase '" + std::string(s.broadphase->name()) +
                     "' knows poses, no paths");
  s.prepare_slides();
  s.needs_layout = false;
}

void ContactWorld::reset() {
  state_->objects.reset();
  state_->reset_mechanisms();
  state_->queue.clear();
  state_->contacts.clear();
  state_->left_contacts.clear();
  state_->selection.select_all();
  state_->needs_layout = true;
}

void ContactWorld::select(const SelectionChange& change) { state_->queue.push(change); }

std::span<const SelectionRecord> ContactWorld::selection_record() const { return state_->record; }

std::uint64_t ContactWorld::selections_left_out() const { return state_->left_out; }

void ContactWorld::begin_selection_record(std::size_t room) {
  std::vector<SelectionRecord> record;
  record.reserve(room);
  state_->record.swap(record);
  state_->record_room = room;
  state_->left_out = 0;
}

MotionCommand ContactWorld::go_to(ObjectHandle object, const Pose& X_WO) const {
  return {object, RigidPath::between(actual_pose(object), X_WO)};
}

MotionCommand ContactWorld::move_by(ObjectHandle object, const Vector3& displacement_W,
                                    const Vector3& turn_W) const {
  return {object, RigidPath::by(actual_pose(object), displacement_W, turn_W)};
}

FrameReport ContactWorld::frame(std::span<const MotionCommand> commands,
                                std::span<const JointCommand> joint_commands) {
  prepare();
  State& s = *state_;
  FrameReport report;
  report.frame = s.frame;
  report.check = capabilities().check;
  s.events.clear(), s.moments.clear();
  const std::uint64_t calls = s.query->calls();
  s.take_selection();
  s.accept(commands);
  s.accept_joints(joint_commands);
  s.take_movers();
  s.restart_travels();
  s.lay_paths();
  s.find_pairs(report);
  s.resolve_stops(s.pairs, 0);
  std::fill(s.is_short.begin(), s.is_short.end(), std::uint8_t{0});
  for (const std::uint32_t slot : s.movers)
    if (s.stops[slot] < 1.0) s.is_short[slot] = 1, ++report.blocked_movers;
  s.execute();
  s.note_moments(s.pairs, 0);
  s.slide(report);
  s.report_pairs();
  report.queries = s.query->calls() - calls;
  report.events = s.events;
  report.selections = s.changes;
  report.refused_selections = s.refused_changes;
  ++s.frame;
  return report;
}

const Pose& ContactWorld::actual_pose(ObjectHandle object) const {
  return state_->objects[state_->objects.slot_of(object)].X_WO;
}

const Pose& ContactWorld::commanded_pose(ObjectHandle object) const {
  return state_->objects[state_->objects.slot_of(object)].commanded;
}

std::span<const Pose> ContactWorld::solid_poses(ObjectHandle object) const {
  const std::uint32_t slot = state_->objects.slot_of(object);
  if (state_->needs_layout) return {};
  const std::uint32_t index = state_->layout.index_of_slot(slot);
  const SolidIndex first = state_->layout.first_solid[index];
  return std::span(state_->from).subspan(first, state_->layout.first_solid[index + 1] - first);
}

double ContactWorld::gap() const { return state_->gap; }

std::size_t ContactWorld::executed_parts() const { return state_->slides.part_count; }

ContactWorld::State::Executed ContactWorld::State::executed_part(std::uint32_t root, std::size_t part,
                                                                 double s) const {
  const ExecutedPart* last = nullptr;
  for (const ExecutedPart& entry : slides.parts) {
    if (entry.root != root) continue;
    if (entry.part > part) break;
    last = &entry;
  }
  if (last == nullptr) return {nullptr, s};
  return {last, last->part == part ? std::min(s, last->stop) : last->stop};
}

Pose ContactWorld::executed_pose(ObjectHandle object, std::size_t part, double s) const {
  const std::uint32_t slot = state_->objects.slot_of(object);
  if (state_->mechanism_of(slot) != nullptr) return state_->executed_link_pose(slot, part, s);
  const State::Executed executed = state_->executed_part(state_->objects[slot].root, part, s);
  if (executed.part == nullptr) return state_->objects[slot].X_WO;
  return executed.part->path.at(slot, executed.s).X_WO;
}

}  // namespace touchstone

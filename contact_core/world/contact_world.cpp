#include "touchstone/contact_core/world/contact_world.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/world/frame/execution.hpp"
#include "touchstone/contact_core/world/set_up/world_state.hpp"
#include "touchstone/contact_core/world/slide/shove.hpp"

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
  if (description.tree) state_->check_takes(*description.tree);
  return state_->objects.add(std::move(description));
}

void ContactWorld::remove(ObjectHandle object) {
  const std::uint32_t slot = state_->objects.slot_of(object);
  state_->objects.remove(object);
  state_->selection.forget(slot);
}

ObjectHandle ContactWorld::find(std::string_view name) const { return state_->objects.find(name); }
bool ContactWorld::is_alive(ObjectHandle object) const { return state_->objects.is_alive(object); }
std::string_view ContactWorld::name_of(ObjectHandle object) const {
  return state_->objects[state_->objects.slot_of(object)].name();
}

// Every frame asks for the rules of its pairs, so a new policy needs nothing more. Warn distances decide
// which pairs are looked at: where one may have grown, the setter has these pairs found anew. After
// set_default_rule() take_up_set_up() does that.

void ContactWorld::set_default_rule(const PairRule& rule) { state_->rules.set_default(rule); }

void ContactWorld::set_group_rule(std::string_view first, std::string_view second, const PairRule& rule) {
  PairRules::check(rule);
  const auto [a, b] = state_->objects.groups_of(first, second);
  const PairRule before = state_->rules.rule_of_groups(a, b);
  state_->rules.set_for_groups(state_->objects, a, b, rule);
  if (before.warn_distance || rule.warn_distance) state_->raise_reach_of_group(a, b);
}

void ContactWorld::set_pair_rule(ObjectHandle a, ObjectHandle b, const PairRule& rule) {
  const std::uint32_t slot_a = state_->objects.slot_of(a), slot_b = state_->objects.slot_of(b);
  if (slot_a == slot_b)
    throw InputError("object '" + std::string(name_of(a)) +
                     "': a rule is of a pair, and this is one object twice");
  const double before = state_->rules.find(state_->objects, slot_a, slot_b).warn_distance;
  state_->rules.set_for_pair(state_->objects, a, b, rule);
  const double after = state_->rules.find(state_->objects, slot_a, slot_b).warn_distance;
  if (after > before) state_->raise_reach(slot_a, after);
}

EffectiveRule ContactWorld::rule_of(ObjectHandle a, ObjectHandle b) const {
  return state_->rules.find(state_->objects, state_->objects.slot_of(a), state_->objects.slot_of(b));
}

void ContactWorld::exempt(const Exemption& pair) { state_->objects.exempt(pair); }

void ContactWorld::unexempt(const Exemption& pair) { state_->objects.unexempt(pair); }

void ContactWorld::latch(ObjectHandle carrier, ObjectHandle carried, const std::vector<Exemption>& allowed) {
  state_->objects.latch(carrier, carried, allowed);
}

void ContactWorld::unlatch(ObjectHandle carried) { state_->objects.unlatch(carried); }

void ContactWorld::set_slide_budget(const SlideBudget& budget) {
  if (!(budget.seconds >= 0.0))
    throw InputError("contact world: a slide budget of " + std::to_string(budget.seconds) +
                     " s is no time of 0 or more");
  state_->slides.budget = budget;
}

const SlideBudget& ContactWorld::slide_budget() const { return state_->slides.budget; }

void ContactWorld::set_threads(std::size_t count) {
  if (count == 0 || count > FrameLanes::kMost)
    throw InputError("contact world: " + std::to_string(count) + " threads are not 1 to " +
                     std::to_string(FrameLanes::kMost));
  std::unique_ptr<ThreadTeam> team = count > 1 ? std::make_unique<ThreadTeam>(count) : nullptr;
  set_task_runner(team.get());
  state_->team = std::move(team);
}

void ContactWorld::set_task_runner(TaskRunner* runner) {
  state_->lanes.set_runner(runner);
  state_->needs_layout = true;
}

WorldCapabilities ContactWorld::capabilities() const {
  return {state_->narrowphase->name(), state_->broadphase->name(),
          state_->is_sampled() ? MotionCheck::sampled : MotionCheck::proven};
}

void ContactWorld::prepare() {
  State& s = *state_;
  s.is_fresh = s.is_fresh || s.needs_layout || s.was_reset || !s.objects.changes().empty();
  s.take_up_set_up();
}

void ContactWorld::reset() {
  State& s = *state_;
  s.objects.reset();
  for (std::uint32_t i = 0; i < s.mechanisms.size(); ++i)
    if (MechanismMover* mover = s.mechanisms.at(i)) mover->reset();
  s.selections.forget_queued();
  s.contact_log.clear();
  s.selection.select_all();
  s.was_reset = true;
}

void ContactWorld::select(const SelectionChange& change) { state_->selections.push(change); }

std::span<const SelectionRecord> ContactWorld::selection_record() const {
  return state_->selections.record();
}

std::uint64_t ContactWorld::selections_left_out() const { return state_->selections.left_out(); }

void ContactWorld::begin_selection_record(std::size_t room) { state_->selections.begin_record(room); }

MotionCommand ContactWorld::go_to(ObjectHandle object, const Pose& X_WO) const {
  return {object, RigidPath::between(actual_pose(object), X_WO)};
}

MotionCommand ContactWorld::move_by(ObjectHandle object, const Vector3& displacement_W,
                                    const Vector3& turn_W) const {
  return {object, RigidPath::by(actual_pose(object), displacement_W, turn_W)};
}

void ContactWorld::State::take_loads() {
  const bool may_touch = is_fresh || !selections.applied().empty();
  const bool may_carry = rules.moves_passive() && !movers.roots.empty();
  if (may_touch && may_carry && watched.is_due()) watched.update(*this, *broadphase);
  const StandingContacts contacts{contact_log.now(), may_touch, lanes.first(), watched.pairs()};
  touchstone::take_loads(*this, contacts, movers, followers);
}

FrameReport ContactWorld::frame(std::span<const MotionCommand> commands,
                                std::span<const JointCommand> joint_commands) {
  prepare();
  State& s = *state_;
  WorldModel& model = s;
  FrameReport report;
  report.frame = s.frame;
  report.check = capabilities().check;
  const std::uint64_t calls = s.lanes.calls();
  s.events.clear(), s.moments.clear(), s.parts.clear();

  // The commands become paths.
  s.selections.take(model, s.frame);
  begin_frame(model, s.movers);
  s.slides.begin_frame(s.movers.commanded_before);
  accept(model, commands, s.movers, s.events);
  accept(model, joint_commands, s.movers, s.events);
  order_movers(model, s.movers);
  s.watched.begin_frame(model);
  s.take_loads();

  // The pairs that may meet on them are found, and when they do.
  s.watched.lay_paths(model, s.movers.roots);
  if (s.watched.is_due()) s.watched.update(model, *s.broadphase);
  const PairFinder::Scope finding{model, s.lanes, s.watched, s.movers};
  const PairFinder::Counts counts = s.finder.find(finding, s.contact_log.now(), s.pairs);
  report.candidate_pairs = counts.candidates, report.iteration_limits = counts.iteration_limits;

  // Stops are resolved, and the paths are executed up to them.
  const FrameScope scope = s.scope();
  s.stop_resolver.resolve({model, scope.query(), s.movers.roots, s.followers, s.slides.permits(), s.moments},
                          s.pairs, 0);
  report.blocked_movers = note_short(model, s.movers);
  execute(model, s.watched, s.movers, s.lanes);
  s.moments.note_executed(model, scope.query(), scope.contacts, s.pairs, 0);
  record_part(model, s.movers, 0, s.parts);

  // Slides go on in further parts; then events are reported.
  s.slides.run(scope, s.pairs, report);
  place_closed(model, scope.contacts);
  s.finder.add_left_out(finding, scope.contacts, s.pairs);
  s.contact_log.report(model, s.lanes, s.pairs, s.moments, s.parts.count() - 1, s.events);
  s.watched.end_frame(model);
  // The report is completed.
  s.is_fresh = false;
  report.queries = s.lanes.calls() - calls;
  report.events = s.events;
  report.selections = s.selections.applied(), report.refused_selections = s.selections.refused();
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
  const Layout& layout = state_->layout;
  if (state_->needs_layout || state_->was_reset || slot >= layout.slots() || layout.handles[slot] != object)
    return {};
  const SolidIndex first = layout.first_solid[slot], end = layout.first_solid[slot + 1];
  if (layout.levels[slot] == nullptr) return std::span(state_->from).subspan(first, end - first);
  // Frames place those that are open only, and `from` is theirs.
  for (SolidIndex solid = first; solid < end; ++solid)
    state_->answered_poses[solid] = compose(state_->objects[slot].X_WO, layout.X_OS[solid]);
  return std::span(state_->answered_poses).subspan(first, end - first);
}

double ContactWorld::gap() const { return state_->gap; }

std::size_t ContactWorld::executed_parts() const { return state_->parts.count(); }

Pose ContactWorld::executed_pose(ObjectHandle object, std::size_t part, double s) const {
  return touchstone::executed_pose(*state_, state_->parts, state_->objects.slot_of(object), part, s);
}

}  // namespace touchstone

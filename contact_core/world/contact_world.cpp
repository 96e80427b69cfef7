#include "contact_core/world/contact_world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "contact_core/input_error.hpp"
#include "contact_core/world/world_state.hpp"

namespace touchstone {
namespace {

constexpr std::size_t kBlock = 256;

bool is_finite(const RigidPath& path) { return is_valid_pose(path.from()) && is_valid_pose(path.to()); }

/// How far a point of a body that turns by `turn` about `centre` strays from its chord: |p''| / 8, and never
/// more than the circle's diameter.
double bulge(const Vector3& turn_W, const Vector3& offset_W) {
  const double angle = norm(turn_W);
  if (angle == 0.0) return 0.0;
  const double radius = norm(cross(turn_W, offset_W)) / angle;
  return radius * std::min(2.0, angle * angle / 8.0) * (1.0 + 0x1p-40);
}

ContactEvent refused_event(ObjectHandle object) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  ContactEvent event{EventKind::refused, object, {}, {0, 0}, 0.0, {}};
  event.geometry.separation = kNaN;
  event.geometry.n_AB_W = event.geometry.p_A_W = event.geometry.p_B_W = Vector3::Constant(kNaN);
  return event;
}

}  // namespace

std::string_view to_string(EventKind kind) {
  constexpr std::array<std::string_view, 7> kNames{
      "near", "began", "persists", "ended", "penetrating_at_start", "blocked", "refused"};
  return kNames[static_cast<std::size_t>(kind)];
}

ContactWorld::ContactWorld(std::unique_ptr<Narrowphase> narrowphase, std::unique_ptr<Broadphase> broadphase,
                           double gap)
    : state_(std::make_unique<State>()) {
  if (!std::isfinite(gap) || !(gap > 0.0))
    throw InputError("contact world: the gap is " + std::to_string(gap) + " m, not a length above 0");
  state_->gap = gap;
  set_narrowphase(std::move(narrowphase));
  set_broadphase(std::move(broadphase));
}

ContactWorld::~ContactWorld() = default;

void ContactWorld::set_narrowphase(std::unique_ptr<Narrowphase> narrowphase) {
  if (!narrowphase) throw InputError("contact world: no narrowphase");
  const Capabilities& can = narrowphase->capabilities();
  if (!can.distance || !can.penetration)
    throw InputError("contact world: narrowphase '" + std::string(narrowphase->name()) +
                     "' gives no signed distance");
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
  state_->rules.set_for_groups(state_->objects.group(first), state_->objects.group(second), rule);
  state_->needs_layout = true;
}

void ContactWorld::set_pair_rule(ObjectHandle a, ObjectHandle b, const PairRule& rule) {
  state_->rules.set_for_pair(state_->objects.slot_of(a), state_->objects.slot_of(b), rule);
  state_->needs_layout = true;
}

void ContactWorld::exempt(ObjectHandle a, std::string_view first, ObjectHandle b, std::string_view second) {
  state_->objects.exempt(a, first, b, second);
  state_->needs_layout = true;
}

void ContactWorld::latch(ObjectHandle carrier, ObjectHandle carried) {
  state_->objects.latch(carrier, carried);
}
void ContactWorld::unlatch(ObjectHandle carried) { state_->objects.unlatch(carried); }

void ContactWorld::prepare() {
  State& s = *state_;
  if (!s.needs_layout) return;
  Layout layout = make_layout(s.objects);
  s.narrowphase->build(layout.solids);
  BroadphaseInput input;
  input.trees = layout.trees;
  input.margin = std::max(2.0 * s.gap, s.rules.largest_warn_distance());
  input.is_static = layout.is_static;
  s.broadphase->build(input);
  s.query = std::make_unique<NarrowphaseQuery>(*s.narrowphase, layout.solids.size());
  s.layout = std::move(layout);
  const std::size_t slots = s.objects.size(), solids = s.layout.solids.size();
  s.paths.assign(slots, CarriedPath(RigidPath(), s.objects.poses_in_root()));
  s.stops.assign(slots, 1.0);
  s.in_motion.assign(slots, 0);
  s.is_restopped.assign(slots, 0);
  s.from.resize(solids), s.to.resize(solids), s.bulges.assign(solids, 0.0);
  s.moved.reserve(2 * slots), s.moved_before.reserve(2 * slots);  // find_pairs() joins the two
  s.pairs.reserve(64 + 16 * solids);
  s.contacts.reserve(64 + 16 * solids), s.contacts_before.reserve(64 + 16 * solids);
  s.contacts.clear();  // solids have new numbers
  s.events.reserve(256 + 16 * solids);
  s.queue.reserve(1024), s.changes.reserve(1024);
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
  state_->selection.select_all();
  state_->needs_layout = true;
}

void ContactWorld::select(const SelectionChange& change) { state_->queue.push(change); }

std::span<const SelectionRecord> ContactWorld::selection_record() const { return state_->record; }

MotionCommand ContactWorld::go_to(ObjectHandle object, const Pose& X_WO) const {
  return {object, RigidPath::between(actual_pose(object), X_WO)};
}

MotionCommand ContactWorld::move_by(ObjectHandle object, const Vector3& displacement_W,
                                    const Vector3& turn_W) const {
  return {object, RigidPath::by(actual_pose(object), displacement_W, turn_W)};
}

FrameReport ContactWorld::frame(std::span<const MotionCommand> commands) {
  prepare();
  State& s = *state_;
  FrameReport report;
  report.frame = s.frame;
  s.events.clear();
  const std::uint64_t calls = s.query->calls();
  s.take_selection();
  s.accept(commands);
  s.lay_paths();
  s.find_pairs(report);
  s.resolve_stops(s.pairs);
  for (const std::uint32_t slot : s.layout.slots)
    if (s.in_motion[slot] && s.stops[slot] < 1.0) ++report.blocked_movers;
  s.execute();
  s.slide(report);
  s.report_pairs();
  report.queries = s.query->calls() - calls;
  report.events = s.events;
  ++s.frame;
  return report;
}

void ContactWorld::State::take_selection() {
  queue.take(changes);
  for (const SelectionChange& change : changes) {
    selection.apply(change);
    record.push_back({frame, change});
  }
}

void ContactWorld::State::accept(std::span<const MotionCommand> commands) {
  for (std::uint32_t slot = 0; slot < objects.size(); ++slot) {
    in_motion[slot] = slides.may_slide[slot] = slides.translation_only[slot] = 0;
    stops[slot] = 1.0;
    if (objects[slot].alive && objects[slot].is_root(slot))
      paths[slot] = CarriedPath(RigidPath(objects[slot].X_WO), objects.poses_in_root());
  }
  for (const MotionCommand& command : commands) {
    if (!objects.may_move(command.object) || !is_finite(command.path)) {
      events.push_back(refused_event(command.object));
      continue;
    }
    const std::uint32_t slot = command.object.slot;
    paths[slot] = CarriedPath(command.path, objects.poses_in_root());
    in_motion[slot] = !command.path.at_rest();
    objects[slot].commanded = command.path.to();
  }
}

void ContactWorld::State::lay_paths() {
  moved_before.swap(moved);
  moved.clear();
  for (std::uint32_t i = 0; i < layout.slots.size(); ++i) {
    const std::uint32_t slot = layout.slots[i], root = objects[slot].root;
    const bool is_moving = in_motion[root];
    if (is_moving) moved.push_back(i);
    // One that moved in the frame before has a new resting path, one point.
    if (!is_moving && !std::binary_search(moved_before.begin(), moved_before.end(), i)) continue;
    const CarriedPath& path = paths[root];
    const BodyState start = path.at(slot, 0.0), end = path.at(slot, 1.0);
    for (SolidIndex solid = layout.first_solid[i]; solid < layout.first_solid[i + 1]; ++solid) {
      from[solid] = compose(start.X_WO, layout.X_OS[solid]);
      to[solid] = compose(end.X_WO, layout.X_OS[solid]);
      const Vector3 centre_W = transform(from[solid], layout.solids[solid].bounding_sphere().centre);
      bulges[solid] = bulge(start.angular_velocity_W, centre_W - start.centre_W);
    }
  }
}

double ContactWorld::State::gap_of(const SolidPair& pair) const {
  const Resolution& resolution = narrowphase->capabilities().resolution;
  const auto reach = [&](SolidIndex i) {
    const Sphere& sphere = layout.solids[i].bounding_sphere();
    return from[i].p.cwiseAbs().maxCoeff() + norm(sphere.centre) + 2.0 * sphere.radius;
  };
  return std::max(gap, 4.0 * resolution.at(std::max(reach(pair.a), reach(pair.b))));
}

MovingSolid ContactWorld::State::moving_solid(SolidIndex solid) const {
  const std::uint32_t slot = layout.slot_of[solid], root = objects[slot].root;
  return {&layout.solids[solid], layout.X_OS[solid], &paths[root], slot, in_motion[root] ? stops[root] : 0.0};
}

Impact ContactWorld::State::impact_of(const FramePair& pair) {
  query->set_pair(pair.solids);
  return find_impact(moving_solid(pair.solids.a), moving_solid(pair.solids.b), {pair.gap}, *query,
                     pair.interest);
}

void ContactWorld::State::find_pairs(FrameReport& report) {
  // What moves now and what came to rest: both have new paths.
  std::array<SolidPair, kBlock> block;
  moved_before.insert(moved_before.end(), moved.begin(), moved.end());
  std::sort(moved_before.begin(), moved_before.end());
  moved_before.erase(std::unique(moved_before.begin(), moved_before.end()), moved_before.end());
  broadphase->update_paths({from, to, bulges}, moved_before);
  pairs.clear();
  PairCursor cursor;
  while (!cursor.done) {
    const std::size_t count = broadphase->find_pairs(cursor, block);
    for (std::size_t i = 0; i < count; ++i) examine(block[i], report);
  }
}

bool ContactWorld::State::is_checked(const SolidPair& pair) const {
  const std::uint32_t a = layout.slot_of[pair.a], b = layout.slot_of[pair.b];
  if (objects[a].root == objects[b].root || (objects[a].is_static() && objects[b].is_static())) return false;
  return selection.is_on(objects, a, b) && !layout.is_exempt(pair);
}

FramePair ContactWorld::State::frame_pair(const SolidPair& pair) const {
  FramePair entry;
  entry.solids = pair;
  entry.rule = rules.find(objects, layout.slot_of[pair.a], layout.slot_of[pair.b]);
  entry.gap = gap_of(pair);
  entry.interest = std::max(2.0 * entry.gap, entry.rule.warn_distance);
  return entry;
}

void ContactWorld::State::examine(const SolidPair& pair, FrameReport& report) {
  if (!is_checked(pair)) return;
  ++report.candidate_pairs;
  FramePair entry = frame_pair(pair);
  entry.impact = impact_of(entry);
  if (entry.impact.status == ImpactStatus::iteration_limit) ++report.iteration_limits;
  // With both in motion, one may be stopped before the other: such a pair is looked at again.
  const bool both = in_motion[root_of(pair.a)] && in_motion[root_of(pair.b)];
  if (both || !entry.impact.is_far) pairs.push_back(entry);
}

void ContactWorld::State::stop_movers(const FramePair& pair) {
  const double target = pair.rule.policy == ContactPolicy::hold ? 0.0 : pair.impact.lo;
  for (const SolidIndex solid : {pair.solids.a, pair.solids.b}) {
    const std::uint32_t root = root_of(solid);
    if (!in_motion[root] || stops[root] < target) continue;
    slides.note_stop(root, pair.rule, stops[root] == target && stops[root] < 1.0);
    if (stops[root] == target) continue;
    stops[root] = target;
    is_restopped[root] = 1;
  }
}

void ContactWorld::State::recheck(std::uint32_t root, std::vector<FramePair>& among) {
  for (FramePair& pair : among) {
    const std::uint32_t a = root_of(pair.solids.a), b = root_of(pair.solids.b);
    if (a != root && b != root) continue;
    const std::uint32_t other = a == root ? b : a;
    if (in_motion[other]) {
      pair.impact = impact_of(pair);
      pair.is_settled = false;
    } else if (pair.impact.lo >= stops[root]) {
      pair.impact.status = ImpactStatus::clear;  // the path now ends before
    }
  }
}

void ContactWorld::State::resolve_stops(std::vector<FramePair>& among) {
  // Each round takes the pairs with the least s, all of them (those already in contact at 0, say), stops
  // their movers, and only then looks again at what these could meet: no order of pairs shows. The cap is a
  // safeguard: then nothing moves, which is allowed.
  const std::size_t most = 16 + 8 * layout.slots.size();
  for (std::size_t round = 0; round < most; ++round) {
    const auto is_open = [](const FramePair& pair) { return pair.stops_movers() && !pair.is_settled; };
    double least = std::numeric_limits<double>::infinity();
    for (const FramePair& pair : among)
      if (is_open(pair)) least = std::min(least, pair.impact.lo);
    if (least == std::numeric_limits<double>::infinity()) return;
    for (FramePair& pair : among) {
      if (!is_open(pair) || pair.impact.lo != least) continue;
      pair.is_settled = true;
      if (!pair.has_blocked) pair.blocked_at = least;
      pair.has_blocked = true;
      stop_movers(pair);
    }
    for (const std::uint32_t slot : layout.slots) {
      if (is_restopped[slot]) recheck(slot, among);
      is_restopped[slot] = 0;
    }
  }
  std::fill(stops.begin(), stops.end(), 0.0);
}

void ContactWorld::State::execute() {
  for (std::uint32_t i = 0; i < layout.slots.size(); ++i) {
    const std::uint32_t slot = layout.slots[i], root = objects[slot].root;
    if (!in_motion[root]) continue;
    objects[slot].X_WO = paths[root].at(slot, stops[root]).X_WO;
    for (SolidIndex solid = layout.first_solid[i]; solid < layout.first_solid[i + 1]; ++solid)
      from[solid] = to[solid] = compose(objects[slot].X_WO, layout.X_OS[solid]);
  }
}

void ContactWorld::State::add_event(EventKind kind, const SolidPair& pair, double s,
                                    const PairGeometry& geometry) {
  const auto within = [&](SolidIndex solid) { return solid - layout.first_solid_of(solid); };
  events.push_back({kind,
                    objects.handle(layout.slot_of[pair.a]),
                    objects.handle(layout.slot_of[pair.b]),
                    {within(pair.a), within(pair.b)},
                    s,
                    geometry});
}

void ContactWorld::State::report_pair(const FramePair& pair, bool was_in_contact) {
  PairGeometry geometry = pair.impact.geometry;
  query->set_pair(pair.solids);
  query->separation(from[pair.solids.a], from[pair.solids.b], geometry);
  const bool at_start = !was_in_contact && pair.impact.start_separation < 0.0;
  const bool in_contact = geometry.separation <= (was_in_contact ? 2.0 * pair.gap : pair.gap);
  if (at_start) add_event(EventKind::penetrating_at_start, pair.solids, 0.0, geometry);
  if (pair.has_blocked) add_event(EventKind::blocked, pair.solids, pair.blocked_at, geometry);
  if (in_contact) {
    const double s = pair.has_blocked ? pair.blocked_at : pair.impact.lo;
    add_event(was_in_contact ? EventKind::persists : EventKind::began, pair.solids, was_in_contact ? 1.0 : s,
              geometry);
    contacts.push_back({pair.solids, geometry});
  } else if (was_in_contact) {
    add_event(EventKind::ended, pair.solids, 1.0, geometry);
  } else if (geometry.separation <= pair.rule.warn_distance) {
    add_event(EventKind::near, pair.solids, 1.0, geometry);
  }
}

void ContactWorld::State::report_pairs() {
  contacts_before.swap(contacts);
  contacts.clear();
  auto before = contacts_before.begin();
  const auto end_those_before = [&](const SolidPair& limit) {
    for (; before != contacts_before.end() && before->solids < limit; ++before)
      add_event(EventKind::ended, before->solids, 1.0, before->geometry);
  };
  for (const FramePair& pair : pairs) {
    end_those_before(pair.solids);
    const bool was_in_contact = before != contacts_before.end() && before->solids == pair.solids;
    if (was_in_contact) ++before;
    if (!pair.impact.is_far || was_in_contact || pair.has_blocked) report_pair(pair, was_in_contact);
  }
  end_those_before({std::numeric_limits<SolidIndex>::max(), 0});
}

const Pose& ContactWorld::actual_pose(ObjectHandle object) const {
  return state_->objects[state_->objects.slot_of(object)].X_WO;
}

const Pose& ContactWorld::commanded_pose(ObjectHandle object) const {
  return state_->objects[state_->objects.slot_of(object)].commanded;
}

std::span<const Pose> ContactWorld::solid_poses(ObjectHandle object) const {
  const std::uint32_t index = state_->layout.index_of_slot(state_->objects.slot_of(object));
  const SolidIndex first = state_->layout.first_solid[index];
  return std::span(state_->from).subspan(first, state_->layout.first_solid[index + 1] - first);
}

double ContactWorld::gap() const { return state_->gap; }

std::size_t ContactWorld::executed_parts() const { return state_->slides.part_count; }

Pose ContactWorld::executed_pose(ObjectHandle object, std::size_t part, double s) const {
  const std::uint32_t slot = state_->objects.slot_of(object), root = state_->objects[slot].root;
  const ExecutedPart* last = nullptr;
  for (const ExecutedPart& entry : state_->slides.parts) {
    if (entry.root != root) continue;
    if (entry.part > part) break;
    last = &entry;
  }
  if (last == nullptr) return state_->objects[slot].X_WO;
  return last->path.at(slot, last->part == part ? std::min(s, last->stop) : last->stop).X_WO;
}

}  // namespace touchstone

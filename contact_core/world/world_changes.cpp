#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/world/world_state.hpp"

// How set-up is taken up: all of it (build_all), or what changed since the last time (take_up_changes) where
// the backends take objects one by one. Either way solids count through the slots in order, and a frame
// answers alike.

namespace touchstone {
namespace {

/// Of objects replaced at once more than a quarter, and some, cost less when all is built anew.
constexpr std::size_t kBuildAnew = 64;

template <class T>
void reserve_more(std::vector<T>& list, std::size_t count) {
  if (count > list.capacity()) list.reserve(std::max(count, 2 * list.capacity()));
}

}  // namespace

void ContactWorld::State::build_all() {
  Layout next = make_layout(objects);
  list_exempt_pairs(next);
  narrowphase->build(next.solids);
  if (!planner) planner = make_native();
  planner->build(next.solids);
  BroadphaseInput input;
  input.trees = next.trees;
  input.margin = margin = std::max(2.0 * gap, rules.default_rule().warn_distance.value_or(0.0));
  input.is_static = next.is_static;
  input.threads = lanes.runner();
  broadphase->build(input);
  for (std::uint32_t slot = 0; slot < next.slots(); ++slot)
    if (!next.is_alive(slot)) broadphase->set_object(slot, nullptr, false);
  lanes.build(*narrowphase, *planner, next.solids.size());
  query = &lanes.first();
  keep_contacts(next);
  layout = std::move(next);
  take_room(true);
  reaches.assign(layout.slots(), 0.0);
  rules.find_reaches(objects, reaches);
  early_reaches.clear();
  moved.clear(), movers.clear(), told.clear(), told_before.clear(), due.clear();
  poses_in_body = objects.poses_in_body().data();
  place_solids_in_bodies();
  furthest = largest_extent = 0.0;
  for (std::uint32_t slot = 0; slot < layout.slots(); ++slot) place_solids(slot);
  if (!broadphase->update_paths({from, to, bulges}, {}))
    throw InputError("contact world: broadphase '" + std::string(broadphase->name()) +
                     "' knows poses, no paths");
  prepare_slides();
  objects.forget_changes();
  needs_layout = false;
}

/// For all objects and solids of the layout; what frames fill is made so large that they need not allocate.
/// @param anew everything as nothing had happened yet, else what there was stays.
void ContactWorld::State::take_room(bool anew) {
  const std::size_t slots = layout.slots(), solids = layout.solids.size();
  const auto size = [&](auto& list, std::size_t count, const auto& value) {
    if (anew) list.clear();
    list.resize(count, value);
  };
  size(paths, slots, CarriedPath(RigidPath(), objects.poses_in_body()));
  for (std::vector<double>* values : {&stops, &stop_bounds}) size(*values, slots, 1.0);
  for (std::vector<std::uint8_t>* flags : {&in_motion, &is_restopped, &is_held, &is_short, &is_noted_due})
    size(*flags, slots, std::uint8_t{0});
  size(reaches, slots, 0.0);
  looked_at.reserve(slots), size(is_looked_at, slots, std::uint8_t{0});
  size(member_root, slots, PairWatch::kNone);
  from.resize(solids), to.resize(solids), X_BS.resize(solids), root_of_solid.resize(solids);
  size(bulges, solids, 0.0);
  moved.reserve(slots);
  reserve_more(pairs, 64 + 16 * solids);
  reserve_more(examined, 64 + 16 * solids), reserve_more(answers, 64 + 16 * solids);
  reserve_more(opened, 64 + 16 * solids), reserve_more(opened_groups, 64 + 16 * solids);
  travels.unplaced.reserve(solids);
  reserve_more(contacts, 64 + 16 * solids), reserve_more(contacts_before, 64 + 16 * solids);
  reserve_more(moments, 128 + 32 * solids), reserve_more(events, 256 + 16 * solids);
  stop_queue.reserve(64 + 16 * solids), restopped.reserve(slots);
  queue.reserve(1024), changes.reserve(1024), refused_changes.reserve(1024);
  selection.reserve(slots);
  take_room_for_travels(anew);
}

/// Where the slot's object stands, at rest. @pre place_in_body().
void ContactWorld::State::place_solids(std::uint32_t slot) {
  for (SolidIndex i = layout.first_solid[slot]; i < layout.first_solid[slot + 1]; ++i) {
    const Sphere& sphere = layout.solids[i].bounding_sphere();
    largest_extent =
        std::max(largest_extent, norm(layout.X_OS[i].p) + norm(sphere.centre) + 2.0 * sphere.radius);
    from[i] = to[i] = compose(objects[slot].X_WO, layout.X_OS[i]);
    bulges[i] = reaches[slot] + contact_reach(i, 0.0);
    travels.has_vertices[i] = 0;
  }
  note_place(slot);
}

/// @returns whether it did; else all is to be built anew.
bool ContactWorld::State::take_up_changes() {
  const TableChanges& changed = objects.changes();
  if (changed.empty()) return true;
  if (changed.all || 4 * changed.replaced.size() > layout.slots() + kBuildAnew) return false;
  std::vector<std::uint32_t> slots = changed.replaced;
  std::sort(slots.begin(), slots.end());
  if (!slots.empty()) end_contacts_of(slots);
  for (const std::uint32_t slot : slots)
    if (!replace_object(slot)) return false;
  if (!slots.empty()) {
    lanes.take_up(layout.solids.size());
    take_room(false);
    for (const std::uint32_t slot : slots) begin_object(slot);
    for (const auto& [object, warn] : early_reaches)
      if (objects.is_alive(object)) reaches[object.slot] = std::max(reaches[object.slot], warn);
    early_reaches.clear();
  }
  for (const TableChanges::ExemptionChange& change : changed.exemptions) {
    const std::vector<SolidPair> named = exempt_pairs(layout, change.exemption);
    change.is_on ? layout.add_exempt(named) : layout.remove_exempt(named);
    if (!change.is_on) watch_anew(change.exemption.a.slot);
  }
  for (const std::uint32_t slot : changed.rebodied)
    if (layout.is_alive(slot)) change_body(slot);
  if (objects.poses_in_body().data() != poses_in_body) lay_resting_paths();
  objects.forget_changes();
  return true;
}

/// In the layout and the backends. @returns false where one of them has to be built anew.
bool ContactWorld::State::replace_object(std::uint32_t slot) {
  const bool is_new = slot == layout.slots();
  if (!is_new) drop_watched(slot);
  needs_layout = true;  // should a backend throw
  layout.put(objects, slot);
  const bool is_alive = layout.is_alive(slot);
  if (is_alive || is_new) {
    const auto solids = layout.solids_of(slot);
    if (!narrowphase->set_solids(layout.first_solid[slot], solids)) return false;
    if (!planner->set_solids(layout.first_solid[slot], solids)) return false;
    if (!broadphase->set_object(slot, layout.trees[slot], layout.is_static[slot] != 0)) return false;
  }
  if (!is_alive && !broadphase->set_object(slot, nullptr, false)) return false;
  needs_layout = false;
  return true;
}

/// All that is kept by slot or solid, as of an object that has not moved yet, or of none.
void ContactWorld::State::begin_object(std::uint32_t slot) {
  stops[slot] = stop_bounds[slot] = 1.0;
  in_motion[slot] = is_restopped[slot] = is_held[slot] = is_short[slot] = 0;
  reaches[slot] = layout.is_alive(slot) ? rules.reach_of(objects, slot) : 0.0;
  for (SolidIndex i = layout.first_solid[slot]; i < layout.first_solid[slot + 1]; ++i) {
    for (std::vector<double>* values : {&travels.of_solid, &travels.solid_limit, &travels.lively_solid,
                                        &travels.last_solid, &travels.planned_solid, &travels.needed})
      (*values)[i] = 0.0;
    slides.moments[i] = transform(layout.X_OS[i], mass_moments(layout.solids[i]));
  }
  change_body(slot);
  place_solids(slot);
}

void ContactWorld::State::change_body(std::uint32_t slot) {
  const auto leave = std::pair{member_root[slot], slot};
  const auto place = std::lower_bound(members.begin(), members.end(), leave);
  if (place != members.end() && *place == leave) members.erase(place);
  member_root[slot] = PairWatch::kNone;
  if (!layout.is_alive(slot)) return;
  const auto join = std::pair{member_root[slot] = objects[slot].root, slot};
  members.insert(std::lower_bound(members.begin(), members.end(), join), join);
  place_in_body(slot);
  watch_anew(slot);
}

void ContactWorld::State::lay_resting_paths() {
  poses_in_body = objects.poses_in_body().data();
  for (std::uint32_t slot = 0; slot < layout.slots(); ++slot)
    paths[slot] = CarriedPath(RigidPath(objects[slot].X_WO), objects.poses_in_body());
}

/// Nothing is known of the pairs of an object any more, nor which they are.
void ContactWorld::State::watch_anew(std::uint32_t slot) {
  drop_watched(slot);
  note_due(slot);
}

void ContactWorld::State::drop_watched(std::uint32_t slot) {
  for (SolidIndex i = layout.first_solid[slot]; i < layout.first_solid[slot + 1]; ++i)
    watched.for_each_of(i, [&](std::uint32_t index) { watched.remove(index); });
  needs_lively = true;
}

/// @param warn within this of the object a rule may now report [m].
void ContactWorld::State::raise_reach(std::uint32_t slot, double warn) {
  if (needs_layout) return;
  if (slot >= layout.slots() ||
      layout.handles[slot] != objects.handle(slot)) {  // it comes with the next frame
    early_reaches.push_back({objects.handle(slot), warn});
    needs_layout = early_reaches.size() > TableChanges::kMostExemptions;
    return;
  }
  reaches[slot] = std::max(reaches[slot], warn);
  watch_anew(slot);
}

/// Of those that bear the rule of two groups.
void ContactWorld::State::raise_reach_of_group(std::uint32_t first, std::uint32_t second) {
  const double warn = rules.largest_group_warn_distance();
  for (const ObjectHandle& object : objects.members_of_group(rules.bearer_of(first, second)))
    if (objects.is_alive(object)) raise_reach(object.slot, warn);
}

}  // namespace touchstone

#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/world/model/world_layout.hpp"
#include "touchstone/contact_core/world/set_up/world_state.hpp"

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
  list_exempt_pairs(*this, next);
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
  contact_log.renumber(layout, next);
  layout = std::move(next);
  take_room(true);
  poses_in_body = objects.poses_in_body().data();
  place_all(*this);
  if (!watched.begin(*this, *broadphase))
    throw InputError("contact world: broadphase '" + std::string(broadphase->name()) +
                     "' knows poses, no paths");
  objects.forget_changes();
  needs_layout = false;
}

/// For all objects and solids of the layout; what frames fill is made so large that they need not allocate.
/// @param anew everything as if nothing had happened yet, else what there was stays.
void ContactWorld::State::take_room(bool anew) {
  const std::size_t slots = layout.slots(), solids = layout.solids.size();
  touchstone::take_room(*this, anew);
  selections.take_room();
  movers.take_room(slots, anew);
  followers.take_room(slots, anew);
  watched.take_room(*this, anew);
  finder.take_room(slots, solids, watched.pairs().capacity(), anew);
  stop_resolver.take_room(slots, solids, anew);
  slides.take_room(*this, watched.pairs().capacity(), lanes.count(), anew);
  contact_log.take_room(solids);
  std::size_t values = 0;
  for (std::uint32_t i = 0; i < mechanisms.size(); ++i)
    if (const MechanismMover* mover = mechanisms.at(i)) values += mover->actual.size();
  parts.reserve((kMostSlideSteps + 1) * slots, (kMostSlideSteps + 1) * 2 * values);
  moments.reserve(128 + 32 * solids);
  reserve_more(pairs, 64 + 16 * solids), reserve_more(events, 256 + 16 * solids);
}

/// @returns whether it did; else all is to be built anew.
bool ContactWorld::State::take_up_changes() {
  const TableChanges& changed = objects.changes();
  if (changed.empty()) return true;
  if (changed.all || 4 * changed.replaced.size() > layout.slots() + kBuildAnew) return false;
  std::vector<std::uint32_t> slots = changed.replaced;
  std::sort(slots.begin(), slots.end());
  if (!slots.empty()) contact_log.end_of(layout, slots);
  for (const std::uint32_t slot : slots)
    if (!replace_object(slot)) return false;
  if (!slots.empty()) {
    lanes.take_up(layout.solids.size());
    take_room(false);
    for (const std::uint32_t slot : slots) {
      begin_object(*this, slot);
      movers.is_short[slot] = 0;
      slides.begin_object(*this, slot);
      watched.begin_object(*this, slot);
    }
    watched.take_up_early_reaches(objects);
  }
  for (const TableChanges::ExemptionChange& change : changed.exemptions) {
    const std::vector<SolidPair> named = exempt_pairs(layout, change.exemption);
    change.is_on ? layout.add_exempt(named) : layout.remove_exempt(named);
    if (!change.is_on) watched.watch_anew(*this, change.exemption.a.slot);
  }
  for (const std::uint32_t slot : changed.rebodied) {
    if (!layout.is_alive(slot)) continue;
    change_body(*this, slot);
    watched.watch_anew(*this, slot);
  }
  if (objects.poses_in_body().data() != poses_in_body) {
    poses_in_body = objects.poses_in_body().data();
    lay_resting_paths(*this);
  }
  objects.forget_changes();
  return true;
}

/// In the layout and the backends. @returns false where one of them has to be built anew.
bool ContactWorld::State::replace_object(std::uint32_t slot) {
  const bool is_new = slot == layout.slots();
  if (!is_new) watched.forget(*this, slot);
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

/// @param warn within this of the object a rule may now report [m].
void ContactWorld::State::raise_reach(std::uint32_t slot, double warn) {
  if (!needs_layout && !watched.raise_reach(*this, slot, warn)) needs_layout = true;
}

/// Of those that bear the rule of two groups.
void ContactWorld::State::raise_reach_of_group(std::uint32_t first, std::uint32_t second) {
  const double warn = rules.largest_group_warn_distance();
  for (const ObjectHandle& object : objects.members_of_group(rules.bearer_of(first, second)))
    if (objects.is_alive(object)) raise_reach(object.slot, warn);
}

}  // namespace touchstone

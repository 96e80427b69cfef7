#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"
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

bool is_among(const std::vector<std::uint32_t>& sorted, std::uint32_t slot) {
  return std::binary_search(sorted.begin(), sorted.end(), slot);
}

}  // namespace

void ContactWorld::State::check_takes(const HexahedronTree& tree) const {
  if (narrowphase->capabilities().rounded_solids) return;
  refuse_rounded(tree, "backend '" + std::string(narrowphase->name()) + "'");
}

void ContactWorld::State::build_all() {
  // The new layout is made and checked before anything is replaced.
  Layout next = make_layout(objects);
  for (const HexahedronTree* tree : next.trees)
    if (tree != nullptr) check_takes(*tree);
  list_exempt_pairs(*this, next);
  // The backends are built from it.
  narrowphase->build(next.solids);
  if (is_native(*narrowphase))
    planner.reset();
  else if (!planner)
    planner = make_native();
  if (planner) planner->build(next.solids);
  build_broadphase(next);
  // The world takes over the new layout and makes room for it.
  lanes.build(*narrowphase, planner ? *planner : *narrowphase, next.solids.size());
  contact_log.renumber(layout, next);
  layout = std::move(next);
  begin_anew();
  objects.forget_changes();
  needs_layout = false;
}

void ContactWorld::State::build_broadphase(const Layout& laid_out) {
  BroadphaseInput input;
  input.trees = laid_out.proxy_trees;
  input.margin = margin = wanted_margin();
  input.is_static = laid_out.is_static;
  input.threads = lanes.runner();
  broadphase->build(input);
  // Slots that hold no object are emptied.
  for (std::uint32_t slot = 0; slot < laid_out.slots(); ++slot)
    if (!laid_out.is_alive(slot)) broadphase->set_object(slot, nullptr, false);
}

/// What the broadphase has to find at least [m].
double ContactWorld::State::wanted_margin() const {
  return std::max(2.0 * gap, rules.default_rule().warn_distance.value_or(0.0));
}

/// Makes room, places all objects, at rest, and watches them as if nothing had happened yet.
void ContactWorld::State::begin_anew() {
  take_room(true);
  place_all(*this);
  noted_margin = wanted_margin();
  if (!watched.begin(*this, *broadphase, noted_margin))
    throw InputError("contact world: broadphase '" + std::string(broadphase->name()) +
                     "' knows poses, no paths");
  needs_places = false;
}

void ContactWorld::State::take_up_set_up() {
  if (!needs_layout && !take_up_changes()) needs_layout = true;
  if (needs_layout) {
    build_all();
  } else if (needs_places) {
    begin_anew();
  } else {
    const double wanted = wanted_margin();
    if (wanted > noted_margin) watched.look_further(*this, wanted - noted_margin, wanted);
    noted_margin = wanted;
  }
  was_reset = false;
}

/// For all objects and solids of the layout; what frames fill is made so large that they need not allocate.
/// @param anew everything as if nothing had happened yet, else what there was stays.
void ContactWorld::State::take_room(bool anew) {
  const std::size_t slots = layout.slots(), solids = layout.solids.size();
  touchstone::take_room(*this, anew);
  resize_more(answered_poses, solids);
  selections.take_room();
  movers.take_room(slots, anew);
  followers.take_room(slots, anew);
  watched.take_room(*this, anew);
  finder.take_room(slots, solids, watched.room());
  stop_resolver.take_room(slots, solids, anew);
  slides.take_room(*this, watched.room(), lanes.count(), anew);
  contact_log.take_room(solids);
  std::size_t values = 0;
  for (std::uint32_t i = 0; i < mechanisms.size(); ++i)
    if (const MechanismMover* mover = mechanisms.at(i)) values += mover->actual.size();
  parts.reserve((kMostSlideSteps + 1) * slots, (kMostSlideSteps + 1) * 2 * values);
  moments.reserve(128 + 32 * solids);
  reserve_more(pairs, 64 + 16 * solids), reserve_more(events, 256 + 16 * solids);
}

/// @returns whether it did; else all is to be built anew, as where it throws.
bool ContactWorld::State::take_up_changes() {
  const TableChanges& changed = objects.changes();
  if (changed.empty()) return true;
  // Where many objects changed, building anew is cheaper.
  if (changed.all || 4 * changed.replaced.size() > layout.slots() + kBuildAnew) return false;
  // What follows cannot be repeated: where memory ends in it, or a backend throws, all is built anew.
  needs_layout = true;
  // Contacts of replaced objects end before their solids change.
  std::vector<std::uint32_t> slots = changed.replaced;
  std::sort(slots.begin(), slots.end());
  if (!slots.empty()) contact_log.end_of(layout, slots);
  for (const std::uint32_t slot : slots)
    if (!replace_object(slot)) return false;
  // Such objects begin anew, once there is room for them.
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
    for (std::uint32_t i = 0; i < mechanisms.size(); ++i)
      if (MechanismMover* mover = mechanisms.at(i); mover != nullptr && !mover->is_laid_out)
        lay_out(*this, *mover);
  }
  // Exemptions change the list of pairs that are not checked.
  for (const TableChanges::ExemptionChange& change : changed.exemptions) {
    const std::vector<SolidPair> named = exempt_pairs(layout, change.exemption);
    change.is_on ? layout.add_exempt(named) : layout.remove_exempt(named);
    if (!change.is_on) watched.watch_anew(*this, change.exemption.a.slot);
  }
  // Objects that were put back begin anew as well; of many all do.
  needs_places = needs_places || 4 * changed.moved.size() > layout.slots() + kBuildAnew;
  for (const std::uint32_t slot : changed.moved)
    if (!needs_places && !is_among(slots, slot)) begin_object(*this, slot), watched.begin_object(*this, slot);
  // Objects that now move with another body, or with none, are watched anew.
  for (const std::uint32_t slot : changed.rebodied) {
    if (!layout.is_alive(slot) || is_among(slots, slot)) continue;
    change_body(*this, slot);
    watched.watch_anew(*this, slot);
  }
  objects.forget_changes();
  needs_layout = false;
  return true;
}

/// In the layout and the backends. @returns false where one of them has to be built anew.
bool ContactWorld::State::replace_object(std::uint32_t slot) {
  const bool is_new = slot == layout.slots();
  if (!is_new) watched.forget(*this, slot);
  layout.put(objects, slot);
  const bool is_alive = layout.is_alive(slot);
  if (is_alive || is_new) {
    const auto solids = layout.solids_of(slot);
    if (!narrowphase->set_solids(layout.first_solid[slot], solids)) return false;
    if (planner && !planner->set_solids(layout.first_solid[slot], solids)) return false;
    if (!broadphase->set_object(slot, layout.proxy_trees[slot], layout.is_static[slot] != 0)) return false;
  }
  return is_alive || broadphase->set_object(slot, nullptr, false);
}

/// @param warn within this of the object a rule may now report [m].
void ContactWorld::State::raise_reach(std::uint32_t slot, double warn) {
  if (needs_layout) return;
  needs_layout = true;  // should memory end
  needs_layout = !watched.raise_reach(*this, slot, warn);
}

/// Of those that bear the rule of two groups.
void ContactWorld::State::raise_reach_of_group(std::uint32_t first, std::uint32_t second) {
  const double warn = rules.largest_group_warn_distance();
  for (const ObjectHandle& object : objects.members_of_group(rules.bearer_of(first, second)))
    if (objects.is_alive(object)) raise_reach(object.slot, warn);
}

}  // namespace touchstone

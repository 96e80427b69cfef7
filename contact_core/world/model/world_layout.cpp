#include "touchstone/contact_core/world/model/world_layout.hpp"

#include <algorithm>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {
namespace {

/// Each two links of a mechanism have a place in Travels::of_link_pair, these from `first` on. They have not
/// moved yet.
void put_own_pairs(WorldModel& model, MechanismMover& mover, std::uint32_t first) {
  Travels& travels = model.travels;
  const std::size_t end = std::size_t{first} + mover.link_pairs();
  for (std::vector<double>* values :
       {&travels.of_link_pair, &travels.last_link_pair, &travels.planned_link_pair}) {
    if (values->size() < end) resize_more(*values, end, 0.0);
    std::fill_n(values->begin() + first, mover.link_pairs(), 0.0);
  }
  mover.first_link_pair = first;
}

/// The first place that is large enough, beside those of the mechanisms that are laid out.
std::uint32_t place_for_own_pairs(const WorldModel& model, const MechanismMover& mover) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> taken;
  for (std::uint32_t i = 0; i < model.mechanisms.size(); ++i)
    if (const MechanismMover* other = model.mechanisms.at(i); other != nullptr && other->is_laid_out)
      taken.emplace_back(other->first_link_pair, other->first_link_pair + other->link_pairs());
  std::sort(taken.begin(), taken.end());
  std::uint32_t first = 0;
  for (const auto& [begin, end] : taken) {
    if (first + mover.link_pairs() <= begin) break;
    first = end;
  }
  return first;
}

/// Of all mechanisms, one after the other.
void put_all_own_pairs(WorldModel& model) {
  std::uint32_t first = 0;
  for (std::uint32_t i = 0; i < model.mechanisms.size(); ++i) {
    MechanismMover* mover = model.mechanisms.at(i);
    if (mover == nullptr) continue;
    put_own_pairs(model, *mover, first);
    first += mover->link_pairs();
    mover->is_laid_out = true;
  }
}

/// Where the slot's solids stand in its body, whom it moves with, and that it rests.
void place_in_body(WorldModel& model, std::uint32_t slot) {
  const ObjectTable& objects = model.objects;
  const Layout& layout = model.layout;
  MechanismMover* mover = model.mechanism_of(slot);
  const std::uint32_t body = objects[slot].body;
  for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid) {
    const Pose& X_OS = layout.X_OS[solid];
    model.X_BS[solid] = body == slot ? X_OS : compose(objects.poses_in_body()[slot], X_OS);
    model.root_of_solid[solid] = objects[slot].root;
    const Sphere& sphere = layout.solids[solid].bounding_sphere();
    model.sphere_B[solid] = {transform(model.X_BS[solid], sphere.centre), sphere.radius};
    if (mover == nullptr) continue;
    double& radius = mover->radius_of_link[objects[body].link];
    radius = std::max(radius, norm(model.sphere_B[solid].centre) + sphere.radius);
  }
  model.paths[slot] = CarriedPath(RigidPath(objects[slot].X_WO), objects.poses_in_body());
  if (const std::uint32_t root = objects[slot].root; root != slot)  // whose path is to know this slot, too
    model.paths[root] = CarriedPath(RigidPath(objects[root].X_WO), objects.poses_in_body());
}

}  // namespace

std::vector<SolidPair> exempt_pairs(const Layout& layout, const MechanismMover& mover) {
  const Mechanism& mechanism = *mover.mechanism;
  const auto index_of = [&](std::uint32_t solid) {
    const std::uint32_t link = mechanism.link_of(solid);
    return layout.first_solid[mover.slot_of_link[link]] + (solid - mechanism.links()[link].first_solid);
  };
  std::vector<SolidPair> out;
  for (std::uint32_t a = 0; a < mechanism.solids().size(); ++a)
    for (std::uint32_t b = a + 1; b < mechanism.solids().size(); ++b) {
      if (mechanism.link_of(a) == mechanism.link_of(b) || !mechanism.is_exempt(a, b)) continue;
      const SolidIndex first = index_of(a), second = index_of(b);
      out.push_back(first < second ? SolidPair{first, second} : SolidPair{second, first});
    }
  std::sort(out.begin(), out.end());
  return out;
}

void list_exempt_pairs(const WorldModel& model, Layout& out) {
  out.exempt.clear();
  for (const SolidExemption& exemption : model.objects.exemptions())
    for (const SolidPair& pair : exempt_pairs(out, exemption)) out.exempt.push_back(pair);
  for (std::uint32_t i = 0; i < model.mechanisms.size(); ++i)
    if (const MechanismMover* mover = model.mechanisms.at(i))
      for (const SolidPair& pair : exempt_pairs(out, *mover)) out.exempt.push_back(pair);
  std::sort(out.exempt.begin(), out.exempt.end());
}

void lay_out(WorldModel& model, MechanismMover& mover) {
  put_own_pairs(model, mover, place_for_own_pairs(model, mover));
  model.layout.add_exempt(exempt_pairs(model.layout, mover));
  mover.is_laid_out = true;
}

void take_room(WorldModel& model, bool anew) {
  const std::size_t slots = model.layout.slots(), solids = model.layout.solids.size();
  const auto size = [&](auto& list, std::size_t count, const auto& value) {
    if (anew) list.clear();
    resize_more(list, count, value);
  };
  // A place for each object.
  size(model.paths, slots, CarriedPath(RigidPath(), model.objects.poses_in_body()));
  size(model.stops, slots, 1.0), size(model.in_motion, slots, std::uint8_t{0});
  size(model.member_root, slots, kNoIndex);
  model.rides.take_room(slots, anew);
  reserve_more(model.members, slots);
  // A place for each solid, and both for how far each travels.
  resize_more(model.from, solids), resize_more(model.X_BS, solids), resize_more(model.sphere_B, solids);
  resize_more(model.root_of_solid, solids);
  Travels& travels = model.travels;
  for (GrowingList<double>* values : {&travels.of_solid, &travels.solid_limit, &travels.last_solid,
                                      &travels.planned_solid, &travels.needed})
    size(*values, solids, 0.0);
  for (GrowingList<double>* values :
       {&travels.of_object, &travels.last_object, &travels.object_limit, &travels.needed_object})
    size(*values, slots, 0.0);
  model.open.take_room(slots, solids, anew);
  resize_more(travels.vertices, solids), resize_more(travels.has_vertices, solids);
  reserve_more(travels.unplaced, solids);
  // Numbers of pairs depend on these sizes, so they come last.
  if (anew) put_all_own_pairs(model);
  model.selection.reserve(slots);
}

void place_all(WorldModel& model) {
  model.members.clear();
  model.member_root.assign(model.layout.slots(), kNoIndex);
  model.furthest = model.largest_extent = 0.0;
  for (std::uint32_t slot = 0; slot < model.layout.slots(); ++slot) {
    if (!model.layout.is_alive(slot)) continue;
    model.members.emplace_back(model.member_root[slot] = model.objects[slot].root, slot);
    place_in_body(model, slot);
  }
  std::sort(model.members.begin(), model.members.end());
  for (std::uint32_t slot = 0; slot < model.layout.slots(); ++slot) place_solids(model, slot);
}

void change_body(WorldModel& model, std::uint32_t slot) {
  auto& members = model.members;
  const auto leave = std::pair{model.member_root[slot], slot};
  const auto place = std::lower_bound(members.begin(), members.end(), leave);
  if (place != members.end() && *place == leave) members.erase(place);
  model.member_root[slot] = kNoIndex;
  if (!model.layout.is_alive(slot)) return;
  const auto join = std::pair{model.member_root[slot] = model.objects[slot].root, slot};
  members.insert(std::lower_bound(members.begin(), members.end(), join), join);
  model.rides.forget(slot);
  place_in_body(model, slot);
}

void place_solids(WorldModel& model, std::uint32_t slot) {
  const Layout& layout = model.layout;
  for (SolidIndex i = layout.first_solid[slot]; i < layout.first_solid[slot + 1]; ++i) {
    const Sphere& sphere = layout.solids[i].bounding_sphere();
    model.largest_extent =
        std::max(model.largest_extent, norm(layout.X_OS[i].p) + norm(sphere.centre) + 2.0 * sphere.radius);
    model.from[i] = compose(model.objects[slot].X_WO, layout.X_OS[i]);
    model.travels.has_vertices[i] = 0;
  }
  model.note_place(slot);
}

void begin_object(WorldModel& model, std::uint32_t slot) {
  model.stops[slot] = 1.0;
  model.in_motion[slot] = 0;
  Travels& travels = model.travels;
  for (GrowingList<double>* values :
       {&travels.of_object, &travels.last_object, &travels.object_limit, &travels.needed_object})
    (*values)[slot] = 0.0;
  model.open.close_idle(slot, model.layout.first_solid[slot], [](SolidIndex) { return true; });
  for (SolidIndex i = model.layout.first_solid[slot]; i < model.layout.first_solid[slot + 1]; ++i) {
    for (GrowingList<double>* values : {&travels.of_solid, &travels.solid_limit, &travels.last_solid,
                                        &travels.planned_solid, &travels.needed})
      (*values)[i] = 0.0;
  }
  change_body(model, slot);
  place_solids(model, slot);
}

}  // namespace touchstone

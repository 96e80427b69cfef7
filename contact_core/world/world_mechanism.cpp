#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/world/world_state.hpp"

// Mechanisms as movers: one object a link, one path for all of them.

namespace touchstone {
namespace {

constexpr std::uint32_t kNone = Mechanism::kNone;

/// No joint between the base and the link moves.
bool stands_still(const Mechanism& mechanism, std::uint32_t link) {
  const auto chain = mechanism.chain(link);
  return std::all_of(chain.begin(), chain.end(),
                     [&](std::uint32_t joint) { return mechanism.joints()[joint].value == kNone; });
}

bool are_finite(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

}  // namespace

MechanismHandle ContactWorld::add_mechanism(MechanismPlacement placement) {
  const std::vector<std::string> groups = placement.groups;
  auto mover = std::make_unique<MechanismMover>(std::move(placement));
  const Mechanism& mechanism = *mover->mechanism;
  if (mechanism.solids().empty())
    throw InputError("contact world: mechanism '" + mechanism.name() + "' has no hexahedra");
  MechanismMover& added = *mover;
  state_->needs_layout = true;
  const MechanismHandle handle = state_->mechanisms.add(std::move(mover));
  std::vector<ObjectHandle> objects;
  try {
    for (std::uint32_t link = 0; link < mechanism.links().size(); ++link) {
      const auto& tree = mechanism.links()[link].tree;
      if (!tree) continue;
      objects.push_back(add({tree, added.X_WL[link], stands_still(mechanism, link), groups}));
      added.slot_of_link[link] = objects.back().slot;
      added.lead = objects.front().slot;
      state_->objects.make_link(objects.back(), handle.index, link, added.lead);
    }
  } catch (...) {
    for (const ObjectHandle object : objects) state_->objects.remove_link(object);
    state_->mechanisms.remove(handle);
    throw;
  }
  return handle;
}

void ContactWorld::remove_mechanism(MechanismHandle handle) {
  const MechanismMover& mover = state_->mechanisms.get(handle);
  for (const std::uint32_t slot : mover.slot_of_link)
    if (slot != kNone) state_->objects.check_removable(state_->objects.handle(slot));
  for (const std::uint32_t slot : mover.slot_of_link) {
    if (slot == kNone) continue;
    state_->objects.remove_link(state_->objects.handle(slot));
    state_->selection.forget(slot);
  }
  state_->mechanisms.remove(handle);
  state_->needs_layout = true;
}

bool ContactWorld::is_alive(MechanismHandle mechanism) const {
  return state_->mechanisms.is_alive(mechanism);
}

ObjectHandle ContactWorld::link(MechanismHandle mechanism, std::string_view name) const {
  const MechanismMover& mover = state_->mechanisms.get(mechanism);
  const std::uint32_t slot = mover.slot_of_link[mover.mechanism->find_link(name)];
  if (slot == kNone)
    throw InputError("mechanism '" + mover.mechanism->name() + "': link '" + std::string(name) +
                     "' has no hexahedra, so it is no object");
  return state_->objects.handle(slot);
}

std::span<const double> ContactWorld::joint_values(MechanismHandle mechanism) const {
  return state_->mechanisms.get(mechanism).actual;
}

std::span<const double> ContactWorld::commanded_joints(MechanismHandle mechanism) const {
  return state_->mechanisms.get(mechanism).commanded;
}

std::span<const Pose> ContactWorld::link_poses(MechanismHandle mechanism) const {
  return state_->mechanisms.get(mechanism).X_WL;
}

void ContactWorld::State::accept_joints(std::span<const JointCommand> commands) {
  for (const JointCommand& command : commands) {
    if (!mechanisms.is_alive(command.mechanism)) {
      events.push_back(command_event(EventKind::refused, {}));
      continue;
    }
    MechanismMover& mover = mechanisms.get(command.mechanism);
    if (command.values.size() != mover.actual.size() || !are_finite(command.values)) {
      events.push_back(command_event(EventKind::refused, objects.handle(mover.lead)));
      continue;
    }
    std::copy(command.values.begin(), command.values.end(), mover.commanded.begin());
    for (const Mechanism::Joint& joint : mover.mechanism->joints()) {
      if (joint.value == kNone) continue;
      double& q = mover.commanded[joint.value];
      const double wanted = q;
      q = std::clamp(wanted, joint.lower, joint.upper);
      if (q == wanted) continue;
      const std::uint32_t slot = mover.slot_of_link[joint.outer];
      events.push_back(command_event(EventKind::at_limit, objects.handle(slot == kNone ? mover.lead : slot)));
    }
    in_motion[mover.lead] = mover.commanded != mover.actual;
    if (in_motion[mover.lead]) mover.go(mover.commanded);
    movers.push_back(mover.lead), told.push_back(mover.lead);
  }
  for (std::uint32_t i = 0; i < mechanisms.size(); ++i)
    if (MechanismMover* mover = mechanisms.at(i); mover != nullptr && !in_motion[mover->lead]) mover->rest();
}

void ContactWorld::State::reset_mechanisms() {
  for (std::uint32_t i = 0; i < mechanisms.size(); ++i) {
    MechanismMover* mover = mechanisms.at(i);
    if (mover != nullptr) mover->reset();
  }
}

void ContactWorld::State::list_exempt_pairs(Layout& out) const {
  out.exempt.clear();
  for (const SolidExemption& exemption : objects.exemptions())
    for (const SolidPair& pair : exempt_pairs(out, exemption)) out.exempt.push_back(pair);
  for (std::uint32_t i = 0; i < mechanisms.size(); ++i) {
    const MechanismMover* mover = mechanisms.at(i);
    if (mover == nullptr) continue;
    const Mechanism& mechanism = *mover->mechanism;
    const auto index_of = [&](std::uint32_t solid) {
      const std::uint32_t link = mechanism.link_of(solid);
      return out.first_solid[mover->slot_of_link[link]] + (solid - mechanism.links()[link].first_solid);
    };
    for (std::uint32_t a = 0; a < mechanism.solids().size(); ++a)
      for (std::uint32_t b = a + 1; b < mechanism.solids().size(); ++b) {
        if (mechanism.link_of(a) == mechanism.link_of(b) || !mechanism.is_exempt(a, b)) continue;
        const SolidIndex first = index_of(a), second = index_of(b);
        out.exempt.push_back(first < second ? SolidPair{first, second} : SolidPair{second, first});
      }
  }
  std::sort(out.exempt.begin(), out.exempt.end());
}

/// Where the slot's solids stand in its body, whom it moves with, and that it rests.
void ContactWorld::State::place_in_body(std::uint32_t slot) {
  MechanismMover* mover = mechanism_of(slot);
  const std::uint32_t body = objects[slot].body;
  for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid) {
    const Pose& X_OS = layout.X_OS[solid];
    X_BS[solid] = body == slot ? X_OS : compose(objects.poses_in_body()[slot], X_OS);
    root_of_solid[solid] = objects[slot].root;
    if (mover == nullptr) continue;
    const Sphere& sphere = layout.solids[solid].bounding_sphere();
    double& radius = mover->radius_of_link[objects[body].link];
    radius = std::max(radius, norm(transform(X_BS[solid], sphere.centre)) + sphere.radius);
  }
  paths[slot] = CarriedPath(RigidPath(objects[slot].X_WO), objects.poses_in_body());
  if (const std::uint32_t root = objects[slot].root; root != slot)  // whose path is to know this slot, too
    paths[root] = CarriedPath(RigidPath(objects[root].X_WO), objects.poses_in_body());
}

void ContactWorld::State::place_solids_in_bodies() {
  X_BS.resize(layout.solids.size()), root_of_solid.resize(layout.solids.size());
  members.clear();
  member_root.assign(layout.slots(), kNone);
  for (std::uint32_t slot = 0; slot < layout.slots(); ++slot) {
    if (!layout.is_alive(slot)) continue;
    members.emplace_back(member_root[slot] = objects[slot].root, slot);
    place_in_body(slot);
  }
  std::sort(members.begin(), members.end());
  watched.clear();
  watched.set_solids(layout.solids.size());
  needs_watch = true;
}

void ContactWorld::State::take_room_for_travels(bool anew) {
  const std::size_t slots = layout.slots(), solids = layout.solids.size();
  const auto reserve_more = [](auto& list, std::size_t count) {
    if (count > list.capacity()) list.reserve(std::max(count, 2 * list.capacity()));
  };
  reserve_more(movers, 2 * slots + 64), reserve_more(told, 2 * slots + 64);
  reserve_more(told_before, 2 * slots + 64);
  reserve_more(members, slots), reserve_more(due, slots), reserve_more(moved, slots);
  reserve_more(movable, slots);
  for (std::vector<double>* values : {&travels.of_solid, &travels.solid_limit, &travels.lively_solid,
                                      &travels.last_solid, &travels.planned_solid, &travels.needed}) {
    if (anew) values->clear();
    values->resize(solids, 0.0);
  }
  if (anew) number_own_pairs();
  if (watched.capacity() < 256 + 64 * solids) {
    const std::size_t room = std::max(256 + 64 * solids, anew ? 0 : 2 * watched.capacity());
    watched.reserve(room), watched_before.reserve(room);
    for (std::vector<std::uint32_t>* watches : {&lively, &close, &deferred, &unclear}) watches->reserve(room);
    ahead.reserve(room);
    gathered.reserve(4 * room), off.reserve(4 * room), is_taken.reserve(room);
    slides.pairs.reserve_watched(watched.capacity());
  }
  watched.set_solids(solids), watched_before.set_solids(solids);
  reserve_more(partners, solids), reserve_more(known_partners, solids);
  travels.vertices.resize(solids), travels.has_vertices.resize(solids, 0);
  take_room_for_slides(anew);
}

/// Each two links of a mechanism have a place in Travels::of_own.
void ContactWorld::State::number_own_pairs() {
  std::uint32_t own = 0;
  for (std::uint32_t i = 0; i < mechanisms.size(); ++i) {
    MechanismMover* mover = mechanisms.at(i);
    if (mover == nullptr) continue;
    mover->first_own = own;
    own += static_cast<std::uint32_t>(mover->X_WL.size() * mover->X_WL.size());
  }
  for (std::vector<double>* values :
       {&travels.of_own, &travels.lively_own, &travels.last_own, &travels.planned_own})
    values->assign(own, 0.0);
}

Pose ContactWorld::State::executed_link_pose(std::uint32_t slot, std::size_t part, double s) const {
  const ObjectRecord& body = objects[objects[slot].body];
  const Mechanism& mechanism = *mechanisms.at(body.mechanism)->mechanism;
  const std::uint32_t root = objects[slot].root;
  const ExecutedParts::At executed = parts.find(objects.handle(root), part, s);
  const std::size_t values = mechanism_of(root)->actual.size();
  if (executed.part == nullptr) return objects[slot].X_WO;
  Pose X = mechanisms.at(body.mechanism)->path.X_WB();
  for (const std::uint32_t j : mechanism.chain(body.link)) {
    const Mechanism::Joint& joint = mechanism.joints()[j];
    X = Mechanism::across(joint, X,
                          joint.value == kNone ? 0.0 : parts.joint_value(executed, joint.value, values));
  }
  return objects[slot].body == slot ? X : compose(X, objects.poses_in_body()[slot]);
}

void ContactWorld::executed_joints(MechanismHandle mechanism, std::size_t part, double s,
                                   std::span<double> out) const {
  const MechanismMover& mover = state_->mechanisms.get(mechanism);
  if (out.size() != mover.actual.size())
    throw InputError("mechanism '" + mover.mechanism->name() + "': room for " + std::to_string(out.size()) +
                     " joint values, not " + std::to_string(mover.actual.size()));
  const ExecutedParts& parts = state_->parts;
  const ExecutedParts::At executed = parts.find(state_->objects.handle(mover.lead), part, s);
  for (std::uint32_t k = 0; k < out.size(); ++k)
    out[k] = executed.part == nullptr ? mover.actual[k] : parts.joint_value(executed, k, out.size());
}

}  // namespace touchstone

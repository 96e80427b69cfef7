#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/world/model/world_layout.hpp"
#include "touchstone/contact_core/world/set_up/world_state.hpp"

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

}  // namespace

MechanismHandle ContactWorld::add_mechanism(MechanismPlacement placement) {
  const std::vector<std::string> groups = placement.groups;
  auto mover = std::make_unique<MechanismMover>(std::move(placement));
  const Mechanism& mechanism = *mover->mechanism;
  // A mechanism that has no solids, or that a backend cannot take, is refused before anything is added.
  if (mechanism.solids().empty())
    throw InputError("contact world: mechanism '" + mechanism.name() + "' has no hexahedra");
  for (const Mechanism::Link& link : mechanism.links())
    if (link.tree) state_->check_takes(*link.tree);
  // The mechanism is registered, then each link that has solids becomes an object.
  MechanismMover& added = *mover;
  const std::size_t known_groups = state_->objects.group_count();
  std::vector<ObjectHandle> objects;
  objects.reserve(mechanism.links().size());
  const MechanismHandle handle = state_->mechanisms.add(std::move(mover));
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
    // If a link is refused, or memory ends, nothing of the mechanism stays.
    for (const ObjectHandle object : objects) state_->objects.remove_link(object);
    state_->mechanisms.remove(handle);
    state_->objects.forget_groups_from(known_groups);
    throw;
  }
  return handle;
}

void ContactWorld::remove_mechanism(MechanismHandle handle) {
  State& s = *state_;
  const MechanismMover& mover = s.mechanisms.get(handle);
  for (const std::uint32_t slot : mover.slot_of_link)
    if (slot != kNone) s.objects.check_removable(s.objects.handle(slot));
  // Memory may end here, where nothing is gone yet: then all is built anew.
  const bool needed_layout = s.needs_layout;
  s.needs_layout = true;
  if (!needed_layout && mover.is_laid_out) s.layout.remove_exempt(exempt_pairs(s.layout, mover));
  // What follows takes no memory.
  for (const std::uint32_t slot : mover.slot_of_link) {
    if (slot == kNone) continue;
    s.objects.remove_link(s.objects.handle(slot));
    s.selection.forget(slot);
  }
  s.mechanisms.remove(handle);
  s.needs_layout = needed_layout;
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

// What contacts join goes through the step together, the rest by clocks of their own.

#include <algorithm>

#include "touchstone/physics/dynamics_world.hpp"

namespace touchstone::physics {

std::uint32_t DynamicsWorld::leader_of(std::uint32_t unit) {
  while (leader_[unit] != unit) unit = leader_[unit] = leader_[leader_[unit]];
  return unit;
}

void DynamicsWorld::join(std::uint32_t a, std::uint32_t b) { leader_[leader_of(b)] = leader_of(a); }

/// Groups come in the order of their first contact, then mechanisms that touch nothing. Bodies that touch
/// nothing are loose; contacts that move nothing, or sleepers alone, belong nowhere.
void DynamicsWorld::find_groups(std::span<const Contact> contacts) {
  const auto units = static_cast<std::uint32_t>(bodies_.size() + mechanisms_.size());
  leader_.resize(units);
  for (std::uint32_t i = 0; i < units; ++i) leader_[i] = i;
  const auto awake_unit_of = [&](const Mover& mover) {
    const std::uint32_t unit = unit_of(mover);
    return unit < bodies_.size() && bodies_[unit].is_asleep ? kNone : unit;
  };
  group_of_contact_.resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const std::uint32_t a = awake_unit_of(contacts[i].a), b = awake_unit_of(contacts[i].b);
    if (a != kNone && b != kNone) join(a, b);
    group_of_contact_[i] = a != kNone ? a : b;  // a unit of it, for now
  }
  std::uint32_t groups = 0;
  group_of_unit_.assign(units, kNone);
  const auto group_of = [&](std::uint32_t unit) {
    std::uint32_t& group = group_of_unit_[leader_of(unit)];
    if (group == kNone) group = groups++;
    return group;
  };
  for (std::uint32_t& group : group_of_contact_)
    if (group != kNone) group = group_of(group);
  for (std::size_t i = bodies_.size(); i < units; ++i)
    group_of_unit_[i] = group_of(static_cast<std::uint32_t>(i));
  loose_.clear();
  for (std::uint32_t i = 0; i < bodies_.size(); ++i) {
    group_of_unit_[i] = group_of_unit_[leader_of(i)];
    if (group_of_unit_[i] == kNone && !bodies_[i].is_kinematic && !bodies_[i].is_asleep) loose_.push_back(i);
  }
  sort_by_group(contacts, groups);
}

/// Each group's contacts, bodies and mechanisms in a row, in their own order.
void DynamicsWorld::sort_by_group(std::span<const Contact> contacts, std::uint32_t groups) {
  groups_.assign(groups, {});
  const auto sort = [&](std::size_t count, auto group_of, std::vector<std::uint32_t>& order, auto member) {
    fill_.assign(groups + 1, 0);
    for (std::size_t i = 0; i < count; ++i)
      if (group_of(i) != kNone) ++fill_[group_of(i) + 1];
    for (std::uint32_t g = 0; g < groups; ++g) fill_[g + 1] += fill_[g];
    order.resize(fill_[groups]);
    for (std::uint32_t g = 0; g < groups; ++g)
      groups_[g].*member = std::span(order).subspan(fill_[g], fill_[g + 1] - fill_[g]);
    for (std::size_t i = 0; i < count; ++i)
      if (group_of(i) != kNone) order[fill_[group_of(i)]++] = static_cast<std::uint32_t>(i);
  };
  const std::size_t bodies = bodies_.size();
  sort(
      contacts.size(), [&](std::size_t i) { return group_of_contact_[i]; }, contact_order_, &Group::contacts);
  sort(
      bodies, [&](std::size_t i) { return group_of_unit_[i]; }, body_order_, &Group::bodies);
  sort(
      mechanisms_.size(), [&](std::size_t i) { return group_of_unit_[bodies + i]; }, mechanism_order_,
      &Group::mechanisms);
}

}  // namespace touchstone::physics

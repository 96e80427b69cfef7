#include "touchstone/physics/world/groups/contact_groups.hpp"
#include "touchstone/physics/solver/reserved.hpp"

namespace touchstone::physics::stepping {

void ContactGroups::reserve(std::size_t contacts, std::size_t units, std::size_t joints) {
  for (auto* vector : {&group_of_joint_, &joint_order_}) reserve_written(*vector, joints);
  sets_.reserve(units);
  for (auto* vector : {&group_of_contact_, &contact_order_}) reserve_written(*vector, contacts);
  for (auto* vector : {&group_of_unit_, &body_order_, &mechanism_order_, &loose_})
    reserve_written(*vector, units);
  reserve_written(fill_, units + 1);
  reserve_written(groups_, units);
}

void ContactGroups::find(std::span<const Contact> contacts, const Movers& movers) {
  const std::vector<Body>& bodies = movers.bodies;
  const auto units = static_cast<std::uint32_t>(movers.unit_count());
  // Join the units of each contact.
  sets_.resize(units);
  for (std::uint32_t i = 0; i < units; ++i) sets_.single(i);
  const auto awake_unit_of = [&](const Mover& mover) {
    const std::uint32_t unit = movers.unit_of(mover);
    return unit < bodies.size() && bodies[unit].is_asleep ? kNoUnit : unit;
  };
  group_of_contact_.resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const std::uint32_t a = awake_unit_of(contacts[i].a), b = awake_unit_of(contacts[i].b);
    if (a != kNoUnit && b != kNoUnit) sets_.join(a, b);
    group_of_contact_[i] = a != kNoUnit ? a : b;  // a unit of it, for now
  }
  // Join the units of each joint that holds.
  group_of_joint_.resize(movers.joints.size());
  for (std::size_t i = 0; i < movers.joints.size(); ++i) {
    group_of_joint_[i] = kNoUnit;
    const WorldJoint& joint = movers.joints[i].joint;
    if (!movers.holds(movers.joints[i])) continue;
    const std::uint32_t a = awake_unit_of(joint.a), b = awake_unit_of(joint.b);
    if (a != kNoUnit && b != kNoUnit) sets_.join(a, b);
    group_of_joint_[i] = a != kNoUnit ? a : b;
  }
  // Number the groups by their first contact, then by their first mechanism.
  std::uint32_t groups = 0;
  group_of_unit_.assign(units, kNoUnit);
  const auto group_of = [&](std::uint32_t unit) {
    std::uint32_t& group = group_of_unit_[sets_.least_of(unit)];
    if (group == kNoUnit) group = groups++;
    return group;
  };
  for (std::uint32_t& group : group_of_contact_)
    if (group != kNoUnit) group = group_of(group);
  for (std::uint32_t& group : group_of_joint_)
    if (group != kNoUnit) group = group_of(group);
  for (std::size_t i = bodies.size(); i < units; ++i)
    group_of_unit_[i] = group_of(static_cast<std::uint32_t>(i));
  // List the free bodies that are awake and in no group.
  loose_.clear();
  for (std::uint32_t i = 0; i < bodies.size(); ++i) {
    group_of_unit_[i] = group_of_unit_[sets_.least_of(i)];
    if (group_of_unit_[i] == kNoUnit && !bodies[i].is_kinematic && !bodies[i].is_asleep) loose_.push_back(i);
  }
  sort_by_group(contacts, movers, groups);
}

/// Each group's contacts, bodies and mechanisms in a row, in their own order.
void ContactGroups::sort_by_group(std::span<const Contact> contacts, const Movers& movers,
                                  std::uint32_t groups) {
  groups_.assign(groups, {});
  const auto sort = [&](std::size_t count, auto group_of, std::vector<std::uint32_t>& order, auto member) {
    fill_.assign(groups + 1, 0);
    for (std::size_t i = 0; i < count; ++i)
      if (group_of(i) != kNoUnit) ++fill_[group_of(i) + 1];
    for (std::uint32_t g = 0; g < groups; ++g) fill_[g + 1] += fill_[g];
    order.resize(fill_[groups]);
    for (std::uint32_t g = 0; g < groups; ++g)
      groups_[g].*member = std::span(order).subspan(fill_[g], fill_[g + 1] - fill_[g]);
    for (std::size_t i = 0; i < count; ++i)
      if (group_of(i) != kNoUnit) order[fill_[group_of(i)]++] = static_cast<std::uint32_t>(i);
  };
  const std::size_t bodies = movers.bodies.size();
  sort(
      contacts.size(), [&](std::size_t i) { return group_of_contact_[i]; }, contact_order_, &Group::contacts);
  sort(
      bodies, [&](std::size_t i) { return group_of_unit_[i]; }, body_order_, &Group::bodies);
  sort(
      movers.arms.size(), [&](std::size_t i) { return group_of_unit_[bodies + i]; }, mechanism_order_,
      &Group::mechanisms);
  sort(
      movers.joints.size(), [&](std::size_t i) { return group_of_joint_[i]; }, joint_order_, &Group::joints);
}

}  // namespace touchstone::physics::stepping

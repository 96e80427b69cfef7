#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/disjoint_sets.hpp"
#include "touchstone/physics/world/groups/movers.hpp"

// Groups: bodies and mechanisms that contacts join go through a step together, the rest by themselves.

namespace touchstone::physics::stepping {

/// Bodies and mechanisms that contacts or joints join, touching or near, directly or through others: a group
/// goes through the step by a clock of its own, and nothing of it is seen by the rest.
struct Group {
  std::span<const std::uint32_t> contacts, bodies, mechanisms, joints;
};

/// Finds a step's groups. No allocation once as many contacts and units as reserved for have been seen.
class ContactGroups {
 public:
  void reserve(std::size_t contacts, std::size_t units, std::size_t joints);
  /// Groups come in the order of their first contact, then of joints, then mechanisms that touch nothing.
  void find(std::span<const Contact> contacts, const Movers& movers);

  std::span<const Group> groups() const { return groups_; }
  /// Free bodies awake that touch nothing.
  std::span<const std::uint32_t> loose() const { return loose_; }
  /// False for contacts that move nothing, or sleepers alone.
  bool is_grouped(std::size_t contact) const { return group_of_contact_[contact] != kNoUnit; }

 private:
  void sort_by_group(std::span<const Contact> contacts, const Movers& movers, std::uint32_t groups);

  DisjointSets sets_;
  std::vector<std::uint32_t> group_of_unit_, group_of_contact_, group_of_joint_;
  std::vector<std::uint32_t> contact_order_, body_order_, mechanism_order_, joint_order_, loose_, fill_;
  std::vector<Group> groups_;
};

}  // namespace touchstone::physics::stepping

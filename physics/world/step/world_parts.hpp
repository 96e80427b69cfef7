#pragma once

#include <vector>

#include "touchstone/physics/world/groups/contact_groups.hpp"
#include "touchstone/physics/world/groups/group_state.hpp"
#include "touchstone/physics/world/groups/movers.hpp"
#include "touchstone/physics/world/groups/warm_start.hpp"
#include "touchstone/physics/world/islands/island_solver.hpp"
#include "touchstone/physics/world/rows/contact_rows.hpp"

namespace touchstone::physics::stepping {

/// The inside of a DynamicsWorld: the state of its movers, what a step leaves to the next, and memory that
/// steps use again. Data goes from contacts to groups, points, rows, islands and impulses; world_step.cpp
/// puts the parts together.
struct WorldParts {
  explicit WorldParts(const DynamicsWorld::Settings& given) : settings(given), solver(given.solver) {}

  DynamicsWorld::Settings settings;
  Movers movers;
  WarmStart warm;
  ContactGroups groups;
  GroupState group;  // that is being stepped
  ContactRows rows;  // of that group
  IslandSolver solver;
  std::vector<ContactForce> forces;  // by contact, of the step in progress
};

/// DynamicsWorld::step().
StepReport take_step(double h, std::span<const Contact> contacts, std::span<ContactForce> forces,
                     WorldParts& world);

}  // namespace touchstone::physics::stepping

namespace touchstone::physics {

/// The parts of a world: private to it.
struct DynamicsWorld::Parts : stepping::WorldParts {
  using WorldParts::WorldParts;
};

}  // namespace touchstone::physics

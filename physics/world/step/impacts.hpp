#pragma once

#include "touchstone/physics/world/islands/island_solver.hpp"

// Instantaneous impacts.

namespace touchstone::physics::stepping {

/// Whether a touching point of the group approaches, or a joint moves into its end stop.
bool needs_impact(const GroupState& group, const Movers& movers, const DynamicsWorld::Settings& settings);
/// Newton's restitution and Coulomb's cone for all touching points at once. Positions stay.
void impact(GroupState& group, StepContext& step, Movers& movers, ContactRows& rows, IslandSolver& solver);

}  // namespace touchstone::physics::stepping

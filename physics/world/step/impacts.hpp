#pragma once

#include "touchstone/physics/world/islands/island_solver.hpp"

// Instantaneous impacts.

namespace touchstone::physics::stepping {

/// Whether something of the group touches and approaches: a point, or a joint its end stop.
bool needs_impact(const GroupState& group, const Movers& movers, const DynamicsWorld::Settings& settings);
/// Newton's restitution and Coulomb's cone for all touching points at once. Positions stay.
void impact(GroupState& group, StepContext& step, Movers& movers, ContactRows& rows, IslandSolver& solver);

}  // namespace touchstone::physics::stepping

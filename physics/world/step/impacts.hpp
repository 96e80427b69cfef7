#pragma once

#include "touchstone/physics/world/islands/island_solver.hpp"

// Instantaneous impacts.

namespace touchstone::physics::stepping {

/// Whether a touching point of the group approaches, or a joint moves into its end stop. Where work is
/// bounded a point that approaches by less than the contact gap in the step, and slower than the bounce
/// speed, does not count: forces stop it.
bool needs_impact(const GroupState& group, const Movers& movers, const StepContext& step);
/// Newton's restitution and Coulomb's cone for all touching points at once. Positions stay.
void impact(GroupState& group, StepContext& step, Movers& movers, ContactRows& rows, IslandSolver& solver);

}  // namespace touchstone::physics::stepping

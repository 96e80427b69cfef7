#pragma once

#include "touchstone/physics/world/islands/island_solver.hpp"

// Overlap is taken back at a step's end by moving bodies apart, not by impulses: they get no momentum by it.

namespace touchstone::physics::stepping {

/// Whether it overlaps, at the step's start, by what takes steps on end to part.
bool is_deep(const GroupState& group, const DynamicsWorld::Settings& settings);
/// Moves the group where it overlaps by more than its points allow (GroupPoint::allowed_depth), by the least
/// motion, weighed by mass, that does, against friction: the contact problem once more, in velocities that
/// last for the step alone.
void part(GroupState& group, StepContext& step, Movers& movers, ContactRows& rows, IslandSolver& solver);

}  // namespace touchstone::physics::stepping

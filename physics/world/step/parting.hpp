#pragma once

#include "touchstone/physics/world/islands/island_solver.hpp"

// Removes overlap at a step's end by moving bodies apart, without impulses, so that they get no momentum.

namespace touchstone::physics::stepping {

/// Whether the group overlaps at the step's start by so much that parting it takes several steps.
bool is_deep(const GroupState& group, const DynamicsWorld::Settings& settings);
/// Whether anything overlaps by so much that it is parted.
bool overlaps(const GroupState& group, const DynamicsWorld::Settings& settings);
/// Moves the group where it overlaps by more than its points allow (GroupPoint::allowed_depth), by the least
/// motion, weighed by mass, that does, against friction: the contact problem once more, in velocities that
/// last for the step alone.
void part(GroupState& group, StepContext& step, Movers& movers, ContactRows& rows, IslandSolver& solver);

}  // namespace touchstone::physics::stepping

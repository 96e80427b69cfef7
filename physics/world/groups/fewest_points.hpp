#pragma once

#include "touchstone/physics/world/groups/group_state.hpp"

// Fewer contact points for groups whose bodies overlap deeply.

namespace touchstone::physics::stepping {

/// Leaves four points at most of each manifold (a run of points between the same movers along one normal):
/// the deepest, that farthest from it, and those farthest from the line through both to either side, as
/// engines keep them (Bullet's btPersistentManifold, say). The others go to GroupState::spare.
void keep_fewest(GroupState& group);

}  // namespace touchstone::physics::stepping

#pragma once

#include <cstdint>
#include <vector>

#include "touchstone/tests/proof/hash/result_hash.hpp"

namespace touchstone::proof {

/// One hash a run over every bit of what a contact world shows, frame by frame: actual poses, joint values,
/// events with their geometry, counts. Free bodies that tumble into each other under `hold`, `advance` and
/// `slide`, one with a latched load; the SSRMS-type arm that slides among blocks; its hand led by resolved
/// rates. @param frames of each run.
std::vector<FamilyHash> world_hashes(std::size_t frames);

/// The same for dynamics, step by step: poses, velocities, forces, joint values, counts of the solver. A
/// stack that settles, blocks that slide and spin to rest, a driven arm that pushes a block and latches
/// another.
/// @param steps of each run.
std::vector<FamilyHash> dynamics_hashes(std::size_t steps);

/// One hash a rotation of paths with random ends (RigidPath::between), each at a random s.
std::vector<std::uint64_t> path_rotation_hashes(std::size_t count);

}  // namespace touchstone::proof

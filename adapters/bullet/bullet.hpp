#pragma once

#include <vector>

#include "touchstone/contact_core/motion/sweep.hpp"
#include "touchstone/contact_core/registry.hpp"

/// @file
/// Bullet in double precision (library touchstone::bullet). The single-precision build
/// (touchstone::bullet_single) has the same symbols inside, so one process holds one of the two: linking both
/// is an error, at configure time with CMake and at link time without.

namespace touchstone {

/// Narrowphase `bullet`: btBoxBoxDetector for two boxes, else what btConvexConvexAlgorithm runs:
/// btGjkPairDetector on convex hulls. The box detector gives no answer for boxes that are apart: such a pair
/// is `separated` under overlap, `separated` with NaN geometry and no points under manifold, and
/// `unsupported` under distance (unless max_separation <= 0, which answers it). Up to 4 manifold points for
/// boxes (the detector culls to 4), 1 for hulls. It prefers faces over edges, so a depth may be too large by
/// 5 % of itself (Resolution::of_depth), and adds an absolute 1e-5 to direction cosines in its edge tests, so
/// that it reports contact across gaps.
///
/// Narrowphase `bullet_gjk`: btGjkPairDetector with btVoronoiSimplexSolver and btGjkEpaPenetrationDepthSolver
/// for every pair: signed distance, one manifold point. Near touching it is good to 1e-6 m whatever the size;
/// deep pairs are rarely (1 in 10 000) too deep by up to 6 % of the depth.
///
/// Broadphase `bullet`: a btDbvt over the world bounding boxes of the solids or of their whole paths.
///
/// Collision margins are 0 for every shape: sizes are exact and corners sharp. Poses are given as they are,
/// in world. Contacts that the engine reports are filtered by their distance: `overlapping` at <= 0,
/// `undecided` closer to 0 than what pair and place resolve, `failed` when the engine gave no answer or none
/// that is finite. Capabilities::resolution gets tighter with build(): what grows with size becomes absolute,
/// for the largest solid.
void register_bullet(BackendRegistry& registry);

/// Its sweeps, with margin 0: `bullet_continuous` (btContinuousConvexCollision, which cuts what turns further
/// to 45 degrees) and, without turning, `bullet_subsimplex_cast` and `bullet_gjk_cast`. The last has boxes
/// with the margins within them that btBoxShape gives: without, a step that lands on touch ends it.
std::vector<SweepEntry> bullet_sweeps();

}  // namespace touchstone

#pragma once

#include "contact_core/registry.hpp"

// FCL, the Flexible Collision Library, double precision, as narrowphases `fcl` (its default solver, on
// libccd) and `fcl_indep` (the solver of its own). Boxes are fcl::Box, other hexahedra fcl::Convex with the
// six quads as faces; poses are given as they are, and each request has FCL's default tolerances (1e-6).
//
//  * overlap: fcl::collide. Two boxes meet in a separating-axis test, other pairs in MPR (`fcl`) or in GJK
//  and
//    EPA (`fcl_indep`).
//  * distance: fcl::distance; where that says "not apart", `fcl` asks it for the signed distance (EPA), and
//    `fcl_indep`, whose nearest points are not on the surfaces then, takes fcl::collide's deepest contact.
//  * manifold: fcl::collide's contacts, up to 8 of two boxes, one of other pairs; of pairs apart the nearest
//    points. A contact's `pos` is taken to be half-way between the surfaces; feature_id is 0.
//  * The normal of pairs apart, and of signed distances, is along the two nearest points: where these
//  coincide
//    there is none, and the pair is `failed`. So it is where FCL throws, which it does where its assumptions
//    fail. Closer to touching than the resolution: `undecided`.
//
// Memory: FCL and libccd allocate in most calls. Threads: any, each with its own workspace.

namespace touchstone {

/// Adds narrowphases `fcl` and `fcl_indep`.
/// @throws InputError when a name is taken.
void register_fcl(BackendRegistry& registry);

}  // namespace touchstone

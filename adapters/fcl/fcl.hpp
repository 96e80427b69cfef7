#pragma once

#include <vector>

#include "touchstone/contact_core/motion/sweep.hpp"
#include "touchstone/contact_core/registry.hpp"

/// @file
/// FCL, the Flexible Collision Library, double precision, as narrowphases `fcl` (its default solver, on
/// libccd) and `fcl_indep` (the solver of its own). Boxes are fcl::Box, other hexahedra fcl::Convex with the
/// six quads as faces; poses are given as they are, and each request has FCL's default tolerances (1e-6).
///
///  * overlap: fcl::collide. Two boxes meet in a separating-axis test, other pairs in MPR (`fcl`) or in GJK
///    and EPA (`fcl_indep`).
///  * distance: fcl::distance where the pair is apart, the deepest of fcl::collide's contacts otherwise.
///    FCL's signed distance is not asked for: an assertion in the packaged library's EPA ends the process on
///    boxes that rest on each other (0.7.0, ComputeVisiblePatch).
///  * manifold: fcl::collide's contacts, up to 8 of two boxes, one of other pairs; of pairs apart the nearest
///    points. A contact's `pos` is taken to be half-way between the surfaces; feature_id is 0.
///  * Depths carry no claim (Resolution::of_depth is infinite): two boxes prefer faces, MPR takes the
///    depth where a ray from an inner point leaves. Those of `fcl_indep` are `unsupported`, and with them its
///    manifolds: its EPA gave 0.125 and 0.488 for one pair in its two orders.
///  * Distances are within the declared resolution as measured (pair families, and pairs captured in engines:
///    up to 3.7e-4 S off, `fcl_indep` 7.9e-3), not as proven.
///  * The normal of a pair apart is along its two nearest points: where these coincide there is none, and the
///    pair is `failed`. It also is where FCL throws, where it reports neither apart nor in contact, and with
///    coordinates beyond 1e75. Closer to touching than 1e-6 (1 + S), the pair is `undecided` where geometry
///    is asked.
///
/// Memory: FCL and libccd allocate in most calls. Threads: any, each with its own workspace.

namespace touchstone {

/// Adds narrowphases `fcl` and `fcl_indep`.
/// @throws InputError when a name is taken.
void register_fcl(BackendRegistry& registry);

/// Its continuous collision of the same shapes: conservative advancement with either GJK (`fcl_ca`,
/// `fcl_indep_ca`), and `fcl_naive`, its default, which looks at ten poses evenly spaced. Of `fcl_indep`,
/// beside which they are asked: `fcl` may end the process.
std::vector<SweepEntry> fcl_sweeps();

}  // namespace touchstone

#pragma once

#include "contact_core/registry.hpp"

// libccd, double precision, as narrowphases `libccd_gjk` (GJK, with EPA for depths) and `libccd_mpr`
// (Minkowski Portal Refinement). Both see convex hulls of eight vertices through a support function, boxes
// among them; the vertices are the solid's world vertices, the inner point that MPR starts from is their
// mean. Tolerances are the library's defaults (1e-4), at most 100 iterations, as in its documentation's
// example.
//
//  * No distances: a pair that is apart is `separated` for QueryKind::overlap and `unsupported` for
//    QueryKind::distance, unless max_separation <= 0, where "apart" is all that was asked.
//  * One point a contact, no manifold: QueryKind::manifold is `unsupported`.
//  * Depth and direction: EPA's are the minimal translation but for its tolerance; MPR takes the depth where
//    a ray from an inner point leaves, which need not be near the minimum. Witness points: the library's
//    point, moved by half the depth either way (assumed, not known, to be on the surfaces).
//  * A search that ends at the iteration limit has said nothing: `undecided` for overlap, `failed` where
//    geometry was asked. A depth that is not finite, or has no direction (exact touch), is `failed`.
//
// Memory: ccdGJKPenetration takes its polytope from malloc, in every call; the rest allocates nothing.
// Threads: any, each with its own workspace.

namespace touchstone {

/// Adds narrowphases `libccd_gjk` and `libccd_mpr`.
/// @throws InputError when a name is taken.
void register_libccd(BackendRegistry& registry);

}  // namespace touchstone

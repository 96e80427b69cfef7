#pragma once

#include "touchstone/contact_core/registry.hpp"

/// @file
/// libccd, double precision, as narrowphases `libccd_gjk` (GJK) and `libccd_mpr` (Minkowski Portal
/// Refinement). Both see convex hulls of eight vertices through a support function, boxes among them; the
/// vertices are the solid's world vertices, the inner point that MPR starts from is their mean. Tolerances
/// are the library's defaults (1e-4), at most 100 iterations, as in its documentation's example.
///
///  * No distances: a pair that is apart is `separated` for QueryKind::overlap and `unsupported` for
///    QueryKind::distance, unless max_separation <= 0, where "apart" is all that was asked.
///  * No depths from `libccd_gjk` (`unsupported`): ccdGJKPenetration's EPA ends at once where GJK's last
///    simplex has the origin on its boundary, and gives 0 for boxes that are 0.125 deep (tests/libccd).
///  * One point a contact, no manifold: QueryKind::manifold is `unsupported`.
///  * MPR takes the depth where a ray from an inner point leaves, which need not be near the minimum:
///    depths carry no claim (Resolution::of_depth is infinite). Witness points: the library's point, moved by
///    half the depth in both directions (assumed to be on the surfaces).
///  * A search that ends at the iteration limit, without contact, gives `undecided`. A depth that
///    is not converged, not finite or has no direction (exact touch) is `failed`; so are coordinates beyond
///    1e75.
///
/// Memory: nothing is allocated. Threads: any, each with its own workspace.

namespace touchstone {

/// Adds narrowphases `libccd_gjk` and `libccd_mpr`.
/// @throws InputError when a name is taken.
void register_libccd(BackendRegistry& registry);

}  // namespace touchstone

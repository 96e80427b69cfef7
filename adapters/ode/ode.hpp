#pragma once

#include "touchstone/contact_core/registry.hpp"

/// @file
/// The Open Dynamics Engine, double precision, as narrowphase `ode` and broadphase `ode`.
///
/// Narrowphase. Two boxes meet in dBoxTouchesBox (overlap) or dBoxBox; any pair with another hexahedron in
/// dCollide on a dConvex geom, which the packaged library hands to libccd's MPR. Poses are world poses as
/// given; a dConvex must hold its origin, so its points are taken relative to the mean of the eight vertices.
///  * ODE has no distance query. A pair that is apart is `separated` for QueryKind::overlap; for distance and
///    manifold it is `unsupported` (separation unknown: NaN), unless max_separation <= 0, where "apart" is
///    all that was asked: `separated`, +inf.
///  * Depth and normal are those of the deepest contact. ODE's contact normal points into geom 1: n_AB_W =
///    -normal. The depth is no minimal translation: dBoxBox prefers a face to an edge pair by a factor of
///    1.05, MPR takes the depth where a ray from an inner point leaves, which need not be near the minimum.
///  * Witness points. Face contacts of dBoxBox: `pos` lies on the incident box, the other point is it moved
///    by the depth. Edge contacts and MPR: `pos` is half-way between the two bodies, both points are it moved
///    by half the depth (for MPR the two points are thereby assumed, not known, to be on the surfaces).
///  * dCollide on convexes gives one contact, dBoxBox up to eight. feature_id is 0 (unknown).
///  * MPR's contact at exact touch may have a zero normal: `overlapping` for overlap, `failed` where a normal
///    is asked.
///  * Warped and collapsed hexahedra are convexes like any other: MPR reads vertices only.
///
/// Broadphase. dSAPSpace over axis-aligned box geoms that enclose each solid's world vertices, or its swept
/// sphere where paths are given, grown by half the margin and by the rounding of the space's single-precision
/// sort.
///
/// ODE is initialised (dInitODE2) while an instance lives; the library counts, so a user's own
/// dInitODE/dCloseODE may come before, between or after. Each thread that evaluates gets ODE's thread data on
/// the first call with a workspace.

namespace touchstone {

/// Adds narrowphase `ode` and broadphase `ode`.
/// @throws InputError when a name is taken, or when the library loaded at run time is not double precision.
void register_ode(BackendRegistry& registry);

}  // namespace touchstone

#pragma once

#include "touchstone/contact_core/motion/impact.hpp"

/// @file
/// Motion under a backend without separations: it judges the poses that conservative advancement, led by
/// native's separations, visits. Nothing is proven between these poses.

namespace touchstone {

/// Like find_impact(), with `sampled` answers:
///  * At each step the backend's status decides: `separated` goes on, all else stops at the pose before,
///    bracketed by bisection to within the gap of motion.
///  * Where the separations would stop the pair and the backend's status is `separated`, the motion goes on
///    in steps of the gap, twice and four times it, up to the depth reached or 1/64 of the path: a blind spot
///    lets solids merge, and that is the backend's answer.
///  * A pair that the backend does not call `separated` at the start is held where it is by the separations:
///    none grows smaller, until it is called so.
/// @pre query.judges_poses().
Impact find_sampled_impact(const MovingSolid& a, const MovingSolid& b, const GapRule& rule,
                           SeparationQuery& query, double interest) noexcept;

}  // namespace touchstone

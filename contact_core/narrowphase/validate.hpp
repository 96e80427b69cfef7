#pragma once

#include <cstddef>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

/// @file
/// The preconditions of Narrowphase::evaluate(), checked.

namespace touchstone {

/// Returns whether a backend would stay within the spans: checks the pairs' indices and the spans' sizes, not
/// poses and numbers. Cheap: backends assert it.
bool fits(const NarrowphaseInput& input, const NarrowphaseOutput& output, std::size_t solid_count) noexcept;

/// Checks every precondition of evaluate(), and max_separation and the poses of the pairs' solids beyond it:
/// a pair is a < b < solid_count, as many poses as solids, a cache of no or as many entries as pairs, a slot
/// of each kind that the query asks for, max_points 1 to kMaxManifoldPoints, max_separation neither NaN nor
/// below 0, poses valid (is_valid_pose: finite ones too that are no rotations).
/// @param solid_count how many solids build() was given.
/// @throws InputError naming the first broken one, with its index and figure.
void validate(const NarrowphaseInput& input, const NarrowphaseOutput& output, std::size_t solid_count);

}  // namespace touchstone

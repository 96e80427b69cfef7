#pragma once

#include <string>
#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/tests/proof/pairs/posed_solids.hpp"

namespace touchstone::proof {

/// Of separation, and of the exact separation along the normal, over S = max(size, largest |world
/// coordinate|): the floor that the table of tests/backend_suite is to hold for every family.
inline constexpr double kSeparationBound = 1e-14;
/// The least positive double, where bounds over S would fall below it.
inline constexpr double kLeast = 0x1p-1074;

struct CheckedPair {
  std::vector<std::string> failures;  ///< one line each, what was promised first; empty: all promises kept
  double separation_error = 0.0;      ///< over S
  double normal_error = 0.0;          ///< over S
  double witness_error = 0.0;         ///< over S: the farther witness point's distance to its solid's surface
};

/// The promises of `native` about a pair, held against `exact`: status in all three queries, separation and
/// its sign, unit normal and the separation along it, p_B = p_A + separation n, (b,a) against (a,b), one pair
/// a call against batches and a cache, max_separation, max_points.
/// @param narrowphase `native`, or what is to be caught lying; its build() is called.
CheckedPair check_against_exact(const PosedSolids& solids, Narrowphase& narrowphase);

}  // namespace touchstone::proof

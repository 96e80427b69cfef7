#pragma once

#include <cstddef>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/measures/pairs/pair_set.hpp"

namespace touchstone::measures {

/// Changes of the answers to a distance query (overlap, of a backend without separations) when only the
/// way of asking did.
struct Change {
  std::size_t cases = 0;
  std::size_t classes = 0;  ///< cases whose status differs
  std::size_t bits = 0;     ///< cases in which a bit of status, separation or normal differs
  /// Cases whose class is not compared, as rounding alone may change it.
  std::size_t left_out = 0;
  /// Largest change of the separation over S; +inf: only one of the two has one; NaN: none was ever given.
  double worst = kNaN;

  Change& operator+=(const Change& more);
};

/// The same pairs, asked differently; a right answer does not depend on that.
struct Consistency {
  Change swapped;   ///< (b, a) for (a, b), the normal negated
  Change moved;     ///< both solids moved by one rotation and translation; bits are not compared
  Change repeated;  ///< a second time, in reverse order, one pair a call, with the same workspace
  Change threads;   ///< on several threads
};

/// Pairs whose exact separation is closer to 0 than this times S may change class when moved, by rounding
/// alone: composing and applying a pose errs by less than 16 eps S a vertex, twice a pair. Without exact
/// separations in the set no pair is left out.
inline constexpr double kMovedResolution = 32 * 0x1p-52;
inline constexpr std::size_t kConsistencyCases = 2000;  ///< the first of a set

/// @param set of one frame, already given to narrowphase.build().
/// @param threads at least 2 are taken; a backend that is not thread safe is not asked and has no cases
/// there.
/// @param most of the set's first cases.
Consistency check_consistency(const Narrowphase& narrowphase, const PairSet& set, int threads,
                              std::size_t most = kConsistencyCases);

}  // namespace touchstone::measures

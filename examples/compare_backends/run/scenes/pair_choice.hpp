#pragma once

#include <cstddef>
#include <vector>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/pairs/pair_set.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"

namespace touchstone::comparison {

/// The pairs that a motion needs, ascending indices into set.pairs: every pair that comes within `reach` [m]
/// in some frame, and for every frame one that is the closest, or the deepest. No other pair decides whether
/// a frame is in contact, or its least separation. The same for any number of threads.
std::vector<std::size_t> pairs_that_decide(const PairSet& set, double reach, const Oracle& oracle,
                                           int threads);

}  // namespace touchstone::comparison
